#pragma once

#include <string>
#include <vector>

#include "touchstone/examples/dynamics_run/results.hpp"
#include "touchstone/examples/program/files/report_run.hpp"

namespace touchstone::dynamics {

/// The report as it grows: results, series, contacts and plots of what is done so far.
class LiveReport {
 public:
  /// @param scenes, backends in the order of the run. @throws InputError as ReportRun, and for a scene given
  /// twice.
  LiveReport(const std::string& folder, std::vector<std::string> scenes, std::vector<std::string> backends);

  /// Takes the newest run of a scene that is not done yet; its verdict is left open.
  void see_run(const SceneResult& so_far);
  void see_scene(SceneResult result);
  /// Over all scenes so far; empty of less than two: the scene's own stands for it.
  std::string verdict() const;
  /// Writes the complete report. @throws std::runtime_error as ReportRun::finish().
  void finish();

 private:
  std::vector<std::string> not_measured(const SceneResult* current) const;
  void put_tables(const std::vector<std::string>& not_measured);

  std::vector<std::string> scenes_, backends_;
  std::vector<SceneResult> results_;
  program::ReportRun report_;
};

}  // namespace touchstone::dynamics
