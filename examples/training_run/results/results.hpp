#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/examples/measures/common/quantiles.hpp"
#include "touchstone/examples/training_run/results/judge.hpp"
#include "touchstone/examples/training_run/results/outputs.hpp"

namespace touchstone::training {

/// One script flown by one method.
struct MethodResult {
  std::string method;
  std::string backend;
  MotionCheck check = MotionCheck::proven;  ///< of the contact world
  std::string not_flown;                    ///< why; empty: it was
  Verdict verdict;
  measures::StepTimes times;                 ///< by the clock on the wall
  measures::StepTimes cpu_times;             ///< of the thread
  std::optional<std::uint64_t> allocations;  ///< in all frames; none where they cannot be counted
  std::uint64_t queries = 0, iteration_limits = 0;
  std::vector<HandFigures> hands;
  std::vector<SeparationPoint> separations;  ///< around the first contact; of some
  std::vector<OutputFigures> outputs;
};

struct ScriptResult {
  std::string file;  ///< the script's name without .yaml
  std::shared_ptr<const Setting> setting;
  std::vector<MethodResult> methods;
};

/// `object/hexahedron` of both.
std::string pair_name(const Setting& setting, const SolidPair& pair);

/// The whole run as JSON: figures in SI units; what was not measured is null.
/// @param not_measured scripts that a run which ended early did not come to the end of; empty: complete.
std::string results_json(const std::vector<ScriptResult>& results,
                         const std::vector<std::string>& not_measured = {});
/// One row a script, method and backend; the last column tells a partial run.
std::string results_csv(const std::vector<ScriptResult>& results,
                        const std::vector<std::string>& not_measured = {});
/// Tables for a terminal of 120 columns.
std::string terminal_text(const ScriptResult& result);
/// One row a method and backend: sums over all scripts that it flew.
std::string summary_text(const std::vector<ScriptResult>& results);
/// Separation over time for the methods that have it; empty without any.
std::string separation_plot(const ScriptResult& result);

}  // namespace touchstone::training
