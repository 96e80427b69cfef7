#include "touchstone/examples/program/files/report_files.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <set>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/files/report_manifest.hpp"

namespace touchstone::program {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse_by_system(const fs::path& path, int error) {
  throw std::runtime_error(path.string() + ": " + std::strerror(error));
}

bool is_of_another(const std::optional<Manifest>& manifest) {
  return manifest && manifest->program != program_invocation_short_name;
}

/// Says why a name is taken; empty: it is free, or ours.
std::string obstacle(const fs::path& folder, const std::optional<Manifest>& manifest,
                     const std::string& name) {
  const std::string path = (folder / name).string();
  for (fs::path part = fs::path(name).parent_path(); !part.empty(); part = part.parent_path()) {
    std::error_code error;
    const fs::file_status status = fs::status(folder / part, error);
    const bool is_dangling = fs::is_symlink(fs::symlink_status(folder / part, error)) && !fs::exists(status);
    if (is_dangling || (fs::exists(status) && !fs::is_directory(status)))
      return (folder / part).string() + " is no folder";
  }
  switch (owner_of(folder, manifest, name)) {
    case FileOwner::free:
    case FileOwner::ours:
      return "";
    case FileOwner::changed:
      return path + " has changed since an earlier run wrote it";
    case FileOwner::foreign:
      return path + " is there and no earlier run wrote it";
  }
  return "";
}

/// Opens a new file beside the target that nobody else has.
int open_new(const fs::path& target, fs::path& path) {
  for (int i = 0;; ++i) {
    path = target;
    path += ".touchstone-" + std::to_string(getpid()) + "-" + std::to_string(i);
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0) return descriptor;
    if (errno != EEXIST) refuse_by_system(target, errno);
  }
}

/// A new file that nobody else has, and what it becomes. It goes away unless it was renamed.
class TemporaryFile {
 public:
  TemporaryFile(fs::path target, std::string_view content) : target_(std::move(target)) {
    const int descriptor = open_new(target_, path_);
    int error = 0;
    for (std::size_t done = 0; done < content.size() && error == 0;) {
      const ssize_t count = ::write(descriptor, content.data() + done, content.size() - done);
      if (count >= 0)
        done += static_cast<std::size_t>(count);
      else if (errno != EINTR)
        error = errno;
    }
    // Some systems report only here that the disk is full.
    if (::close(descriptor) != 0 && error == 0) error = errno;
    if (error == 0) return;
    unlink(path_.c_str());
    refuse_by_system(target_, error);
  }
  TemporaryFile(TemporaryFile&& other) noexcept
      : target_(std::move(other.target_)), path_(std::exchange(other.path_, {})) {}
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (!path_.empty()) unlink(path_.c_str());
  }

  /// @param replaces what stands there, else nothing may: somebody can have been faster. Not every file
  /// system can refuse that in one go.
  void rename(bool replaces) {
    int result =
        renameat2(AT_FDCWD, path_.c_str(), AT_FDCWD, target_.c_str(), replaces ? 0 : RENAME_NOREPLACE);
    if (result != 0 && (errno == EINVAL || errno == ENOSYS))
      result = ::rename(path_.c_str(), target_.c_str());
    if (result != 0 && errno == EEXIST)
      throw ReportCollision(target_.string() + " was written by somebody else");
    if (result != 0) refuse_by_system(target_, errno);
    path_.clear();
  }

 private:
  fs::path target_, path_;
};

/// The folders made here, which go away again, as far as they are empty, unless they are kept.
class NewFolders {
 public:
  NewFolders() = default;
  NewFolders(const NewFolders&) = delete;
  NewFolders& operator=(const NewFolders&) = delete;
  ~NewFolders() {
    for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) rmdir(folder->c_str());
  }

  void make(const fs::path& folder) {
    std::error_code error;
    std::vector<fs::path> lacking;
    for (fs::path path = folder; !fs::exists(path, error) && path.has_relative_path();
         path = path.parent_path())
      lacking.push_back(path);
    for (auto path = lacking.rbegin(); path != lacking.rend(); ++path) {
      if (mkdir(path->c_str(), 0777) == 0)
        made_.push_back(*path);
      else if (errno != EEXIST || !fs::is_directory(*path, error))
        refuse_by_system(*path, errno);
    }
  }
  void keep() { made_.clear(); }

 private:
  std::vector<fs::path> made_;
};

/// Other runs that write into the folder wait; a system that has no such locks does without.
class FolderLock {
 public:
  explicit FolderLock(const fs::path& folder)
      : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (descriptor_ >= 0) flock(descriptor_, LOCK_EX);
  }
  ~FolderLock() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

/// Removes what only the earlier run wrote. What somebody changed, or made a folder of, stays.
void remove_stale(const fs::path& folder, const std::optional<Manifest>& before, const Manifest& now) {
  if (!before) return;
  std::set<std::string> kept;
  for (const ManifestEntry& file : now.files) kept.insert(file.name);
  for (const ManifestEntry& file : before->files)
    if (!kept.contains(file.name) && owner_of(folder, before, file.name) == FileOwner::ours)
      unlink((folder / file.name).c_str());
}

/// Earlier files of other names, as far as they stand.
void add_earlier(Manifest& now, const fs::path& folder, const Manifest& before) {
  std::set<std::string> written;
  for (const ManifestEntry& file : now.files) written.insert(file.name);
  for (const ManifestEntry& file : before.files)
    if (!written.contains(file.name) && owner_of(folder, before, file.name) != FileOwner::free)
      now.files.push_back(file);
}

Manifest united(const std::optional<Manifest>& before, const Manifest& now) {
  Manifest both = now;
  both.complete = false;
  if (before) both.files.insert(both.files.end(), before->files.begin(), before->files.end());
  return both;
}

}  // namespace

void check_report_folder(const fs::path& folder, std::span<const std::string> names) {
  const auto refuse = [&](const std::string& why) {
    return InputError("--output " + folder.string() + ": " + why);
  };
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (!fs::exists(status) && fs::is_symlink(fs::symlink_status(folder, error)))
    throw refuse("is a link to nothing");
  if (fs::exists(status) && !fs::is_directory(status)) throw refuse("is not a folder");
  // Access rights do not tell whether anything can be written (a root may write anywhere and yet not in
  // /proc): it is tried, and what was made goes away again.
  try {
    NewFolders folders;
    folders.make(folder);
    const TemporaryFile probe(folder / kManifestName, "");
  } catch (const std::runtime_error& failure) {
    throw refuse(std::string("cannot be written to: ") + failure.what());
  }
  const std::optional<Manifest> manifest = read_manifest(folder);
  if (is_of_another(manifest))
    throw refuse("holds a report of " + manifest->program + "; name another folder");
  for (const std::string& name : names) {
    if (!stays_inside(name)) throw refuse("'" + name + "' leads out of it");
    const std::string taken = obstacle(folder, manifest, name);
    if (!taken.empty()) throw refuse(taken + "; move it away or name another folder");
  }
}

void write_report_folder(const fs::path& folder, std::span<const ReportFile> files, bool complete,
                         bool keeps_earlier) {
  NewFolders folders;
  folders.make(folder);
  const FolderLock lock(folder);
  const std::optional<Manifest> before = read_manifest(folder);
  if (is_of_another(before)) throw ReportCollision(folder.string() + " holds a report of " + before->program);
  Manifest now{program_invocation_short_name, complete, {}};
  for (const auto& [name, content] : files) {
    const std::string taken = obstacle(folder, before, name);
    if (!taken.empty()) throw ReportCollision(taken);
    now.files.push_back(manifest_entry(name, content));
  }
  if (keeps_earlier && before) add_earlier(now, folder, *before);
  // Everything is on the disk before the first name changes: a disk that is full leaves what was there.
  std::vector<std::pair<TemporaryFile, bool>> written;  // and whether it replaces one of ours
  for (const auto& [name, content] : files) {
    const fs::path path = folder / name;
    folders.make(path.parent_path());
    written.emplace_back(TemporaryFile(path, content), owner_of(folder, before, name) == FileOwner::ours);
  }
  TemporaryFile both(folder / kManifestName, manifest_text(united(before, now)));
  TemporaryFile last(folder / kManifestName, manifest_text(now));
  both.rename(before.has_value());
  folders.keep();
  for (auto& [file, replaces] : written) file.rename(replaces);
  remove_stale(folder, before, now);
  last.rename(true);
}

bool is_receiver(const fs::path& path) {
  std::error_code error;
  const fs::file_type type = fs::status(path, error).type();
  return type == fs::file_type::character || type == fs::file_type::block || type == fs::file_type::fifo ||
         type == fs::file_type::socket;
}

void StreamedFile::check(const std::string& option, const fs::path& folder,
                         std::span<const std::string> names) {
  const std::optional<Manifest> manifest = read_manifest(folder, kRecordsManifestName);
  for (const std::string& name : names) {
    if (is_receiver(folder / name)) continue;
    const std::string taken = obstacle(folder, manifest, name);
    if (!taken.empty())
      throw InputError(option + " " + folder.string() + ": " + taken +
                       "; move it away or name another folder");
  }
}

StreamedFile::StreamedFile(fs::path folder, std::string name)
    : folder_(std::move(folder)), name_(std::move(name)), path_(folder_ / name_) {
  if (is_receiver(path_)) return;
  ::close(open_new(folder_ / name_, path_));
  on_interrupt_.emplace([this] {
    unlink(path_.c_str());
    return std::string();
  });
}

StreamedFile::~StreamedFile() {
  if (on_interrupt_) unlink(path_.c_str());
}

std::string StreamedFile::keep() try {
  if (!on_interrupt_) return "";
  const auto hold = hold_interrupts();
  const FolderLock lock(folder_);
  const std::optional<Manifest> before = read_manifest(folder_, kRecordsManifestName);
  const FileOwner stands = owner_of(folder_, before, name_);
  if (stands == FileOwner::changed || stands == FileOwner::foreign) return obstacle(folder_, before, name_);
  std::ifstream stream(path_, std::ios::binary);
  const std::string content(std::istreambuf_iterator<char>(stream), {});
  Manifest now = before.value_or(Manifest{program_invocation_short_name, true, {}});
  std::erase_if(now.files, [&](const ManifestEntry& file) { return file.name == name_; });
  now.files.push_back(manifest_entry(name_, content));
  TemporaryFile both(folder_ / kRecordsManifestName, manifest_text(united(before, now)));
  TemporaryFile last(folder_ / kRecordsManifestName, manifest_text(now));
  both.rename(before.has_value());
  if (::rename(path_.c_str(), (folder_ / name_).c_str()) != 0) refuse_by_system(folder_ / name_, errno);
  on_interrupt_.reset();
  last.rename(true);
  return "";
} catch (const std::exception& error) {
  return error.what();
}

fs::path place_report(const fs::path& folder, std::span<const ReportFile> files, bool complete,
                      bool keeps_earlier) {
  fs::path place = folder;
  if (!complete) {
    const std::optional<Manifest> before = read_manifest(folder);
    if (before && before->complete) place /= "partial";
  }
  try {
    write_report_folder(place, files, complete, keeps_earlier);
  } catch (const ReportCollision&) {
    std::error_code error;
    int number = 1;
    while (fs::exists(fs::symlink_status(folder / ("unplaced_" + std::to_string(number)), error))) ++number;
    place = folder / ("unplaced_" + std::to_string(number));
    write_report_folder(place, files, complete, keeps_earlier);
  }
  return place;
}

}  // namespace touchstone::program
