#include "touchstone/examples/compare_backends/judge/dynamics_drift.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

bool touches(const Drift& drift, const std::string& scene) {
  return std::any_of(drift.scenes.begin(), drift.scenes.end(),
                     [&](const DriftScene& each) { return each.name == scene && each.touches; });
}

void add(DriftStanding& standing, const DriftRun& run) {
  ++standing.scenes;
  standing.within += run.is_within() ? 1 : 0;
  if (!run.is_within() && standing.failure.empty()) {
    std::string misses = run.gap;
    for (const std::string& miss : run.misses) misses += (misses.empty() ? "" : ", ") + miss;
    standing.failure = run.scene + " (" + misses + ")";
  }
  if (!run.gap.empty()) return;
  const auto worst = [](double& of, double value) {
    if (!(of >= value)) of = value;  // also in place of NaN, which stands for none so far
  };
  worst(standing.pose_error, run.pose_error);
  worst(standing.momentum, run.momentum);
  worst(standing.energy_made, run.energy_made);
  worst(standing.deepest, run.deepest);
  worst(standing.p999_ns, run.p999_ns);
  worst(standing.allocations, run.allocations);
}

// Over the runs that went through; NaN of none.
double mean_step(const Drift& drift, const std::string& backend) {
  double sum = 0;
  int count = 0;
  for (const DriftRun& run : drift.runs) {
    if (run.backend != backend || !run.gap.empty() || !touches(drift, run.scene)) continue;
    sum += std::log(run.step_ns);
    ++count;
  }
  return std::exp(sum / count);
}

}  // namespace

std::vector<DriftStanding> drift_standings(const Drift& drift) {
  std::vector<DriftStanding> standings;
  for (const DriftRun& run : drift.runs) {
    auto found = std::find_if(standings.begin(), standings.end(),
                              [&](const DriftStanding& each) { return each.backend == run.backend; });
    if (found == standings.end()) {
      found = standings.insert(found, {run.backend, 0, 0, kNaN, kNaN, kNaN, kNaN, kNaN, kNaN, kNaN, ""});
      found->step_ns = mean_step(drift, run.backend);
    }
    if (touches(drift, run.scene)) add(*found, run);
  }
  std::stable_sort(standings.begin(), standings.end(), [](const DriftStanding& x, const DriftStanding& y) {
    if (x.within != y.within) return x.within > y.within;
    return x.step_ns < y.step_ns || (std::isfinite(x.step_ns) && std::isnan(y.step_ns));
  });
  return standings;
}

std::string drift_agreement(const Drift& drift, const std::string& headline) {
  if (drift.build_on.empty()) return "";
  if (headline.empty()) return "The verdict on pairs, as the page opens, names no backend.";
  if (headline == drift.build_on)
    return "The verdict on pairs, as the page opens, names " + headline + " too.";
  std::string text =
      fmt::format("The verdict on pairs, as the page opens, names {}; with dynamics build on {} instead: {} ",
                  headline, drift.build_on, headline);
  const std::vector<DriftStanding> standings = drift_standings(drift);
  const auto of = [&](const std::string& backend) {
    return std::find_if(standings.begin(), standings.end(),
                        [&](const DriftStanding& each) { return each.backend == backend; });
  };
  const auto named = of(headline), other = of(drift.build_on);
  if (named == standings.end()) return text + "was not run.";
  if (named->within < named->scenes) {
    return text + fmt::format("is within the limits of {} of {} scenes that touch; not of {}.", named->within,
                              named->scenes, named->failure);
  }
  if (other == standings.end()) return text + "is within all limits.";
  return text + fmt::format(
                    "is within all limits, at {} ns a step (99.9 %: {}, {} allocations) against {} ({}, {}).",
                    format_ns(named->step_ns), format_ns(named->p999_ns), named->allocations,
                    format_ns(other->step_ns), format_ns(other->p999_ns), other->allocations);
}

}  // namespace touchstone::comparison
