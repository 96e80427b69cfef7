#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "touchstone/examples/program/files/report_files.hpp"
#include "touchstone/examples/program/terminal/engine_log.hpp"
#include "touchstone/examples/program/terminal/interruption.hpp"

namespace touchstone::program {

/// A report while it is measured, and the log of what engines print meanwhile: engines.log, where they print.
/// A signal, or an exception that leaves the run, writes what there is so far as a partial report: see
/// place_report().
class ReportRun {
 public:
  /// @param names of all files that may be written. @throws InputError as check_report_folder().
  ReportRun(std::filesystem::path folder, std::span<const std::string> names);
  ~ReportRun();
  ReportRun(const ReportRun&) = delete;
  ReportRun& operator=(const ReportRun&) = delete;

  /// Takes files of what is measured so far; those of the same name are replaced.
  void put(std::vector<ReportFile> files);

  /// Writes the complete report: what was put before, with these files.
  /// @throws std::runtime_error when it cannot be written, or had to be written elsewhere, which it names.
  void finish(std::vector<ReportFile> files);

 private:
  std::string write_partial();
  /// Adds the log to the files.
  void put_log();

  std::filesystem::path folder_;
  std::vector<ReportFile> files_;
  EngineLog log_;
  bool finished_ = false;
  int exceptions_;
  OnInterrupt on_interrupt_;  // last: it may be called as soon as it is there
};

}  // namespace touchstone::program
