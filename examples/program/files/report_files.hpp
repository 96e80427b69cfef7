#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "touchstone/examples/program/terminal/interruption.hpp"

// A report's files in a folder that may hold other people's. Nothing of theirs is replaced, moved or removed,
// and no folder is: see report_manifest.hpp.

namespace touchstone::program {

/// Relative path and content.
using ReportFile = std::pair<std::string, std::string>;

/// Looks, before anything is measured, whether files of these names can be written into the folder; it need
/// not exist. What an earlier run left there is no obstacle while it is unchanged.
/// @throws InputError naming the file that stands in the way, or why the folder cannot be written to.
void check_report_folder(const std::filesystem::path& folder, std::span<const std::string> names);

/// Thrown where a file that is not ours stands at a name of ours.
struct ReportCollision : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Writes the files and the manifest, each under a temporary name beside it; when all of them are on the disk
/// they are renamed one by one, the manifest last. Unchanged files of an earlier run that this one does not
/// write are removed.
/// @param complete false: of a run that ended early.
/// @param keeps_earlier files that this run does not write stay, and stay known: a report of several runs.
/// @throws ReportCollision; std::runtime_error when the system refuses. Nothing has changed then.
void write_report_folder(const std::filesystem::path& folder, std::span<const ReportFile> files,
                         bool complete = true, bool keeps_earlier = false);

/// As write_report_folder, and never in vain: a partial report does not replace a complete one but goes into
/// the folder `partial` within, and where a file came in between since check_report_folder the report goes
/// into a new folder `unplaced_N` within.
/// @return the folder that was written to.
std::filesystem::path place_report(const std::filesystem::path& folder, std::span<const ReportFile> files,
                                   bool complete, bool keeps_earlier = false);

/// Whether what stands there takes what is written to it and keeps nothing that could be lost: a device, a
/// pipe, a socket, or a link to one.
bool is_receiver(const std::filesystem::path& path);

/// A file that a library writes by itself, one of several in a folder: under a temporary name first. It goes
/// away unless it is kept, on a signal too.
class StreamedFile {
 public:
  /// @param option of the folder, for errors. @throws InputError naming the file that stands in the way.
  static void check(const std::string& option, const std::filesystem::path& folder,
                    std::span<const std::string> names);

  StreamedFile(std::filesystem::path folder, std::string name);
  ~StreamedFile();
  StreamedFile(const StreamedFile&) = delete;
  StreamedFile& operator=(const StreamedFile&) = delete;

  /// Where to write. A receiver is written to directly.
  const std::filesystem::path& path() const { return path_; }
  /// Gives it its name, and a place in the folder's manifest. @return why that failed; empty: it did not.
  std::string keep();

 private:
  std::filesystem::path folder_;
  std::string name_;
  std::filesystem::path path_;
  std::optional<OnInterrupt> on_interrupt_;
};

}  // namespace touchstone::program
