#pragma once

#include <string>
#include <vector>

#include "touchstone/examples/program/files/report_run.hpp"
#include "touchstone/examples/training_run/results/results.hpp"

namespace touchstone::training {

/// The report as it grows: results and plots of what is flown so far.
class LiveReport {
 public:
  /// @param scripts in the order of the run. @throws InputError as ReportRun, and for a script given twice.
  LiveReport(const std::string& folder, std::vector<std::string> scripts);

  /// Takes a script that is not flown by every method yet.
  void see_method(const ScriptResult& so_far);
  void see_script(ScriptResult result);
  /// Writes the complete report. @throws std::runtime_error as ReportRun::finish().
  void finish();

  const std::vector<ScriptResult>& results() const { return results_; }

 private:
  /// @param done how many of the scripts are flown by every method.
  void put_tables(std::size_t done);

  std::vector<std::string> scripts_;
  std::vector<ScriptResult> results_;
  program::ReportRun report_;
};

}  // namespace touchstone::training
