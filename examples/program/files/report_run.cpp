#include "touchstone/examples/program/files/report_run.hpp"

#include <algorithm>
#include <exception>

#include "touchstone/examples/program/terminal/program.hpp"

namespace touchstone::program {
namespace {

constexpr const char* kLogName = "engines.log";

std::filesystem::path checked(std::filesystem::path folder, std::span<const std::string> names) {
  std::vector<std::string> all(names.begin(), names.end());
  all.push_back(kLogName);
  check_report_folder(folder, all);
  return folder;
}

}  // namespace

ReportRun::ReportRun(std::filesystem::path folder, std::span<const std::string> names)
    : folder_(checked(std::move(folder), names)),
      exceptions_(std::uncaught_exceptions()),
      on_interrupt_([this] { return "interrupted: " + write_partial(); }) {}

ReportRun::~ReportRun() {
  if (finished_ || std::uncaught_exceptions() == exceptions_) return;
  const auto hold = hold_interrupts();
  try {
    if (!files_.empty()) say(write_partial() + "\n");
  } catch (const std::exception& error) {
    say(std::string(error.what()) + "\n");
  }
}

std::string ReportRun::write_partial() {
  if (finished_) return "at its end";
  if (files_.empty()) return "no report was written, as nothing was measured yet";
  put_log();
  return "what was measured so far is a partial report: " + place_report(folder_, files_, false).string();
}

void ReportRun::put_log() {
  const std::size_t lines = engine_log_lines();
  if (lines == 0) return;
  put({{kLogName, log_.text()}});
  print_now(std::to_string(lines) + " lines that engines wrote: " + (folder_ / kLogName).string() + "\n");
}

void ReportRun::put(std::vector<ReportFile> files) {
  const auto hold = hold_interrupts();
  for (ReportFile& file : files) {
    const auto same = std::find_if(files_.begin(), files_.end(),
                                   [&](const ReportFile& each) { return each.first == file.first; });
    if (same != files_.end())
      same->second = std::move(file.second);
    else
      files_.push_back(std::move(file));
  }
}

void ReportRun::finish(std::vector<ReportFile> files) {
  const auto hold = hold_interrupts();
  put(std::move(files));
  put_log();
  // From here on the files are marked complete: no destructor writes them as partial ones.
  finished_ = true;
  const std::filesystem::path place = place_report(folder_, files_, true);
  if (place != folder_)
    throw std::runtime_error("while this ran, somebody wrote to " + folder_.string() +
                             " what the report would have replaced; it is complete and in " + place.string());
}

}  // namespace touchstone::program
