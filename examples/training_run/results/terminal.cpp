#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "touchstone/examples/program/terminal/text_table.hpp"
#include "touchstone/examples/training_run/results/results.hpp"

namespace touchstone::training {
namespace {

using program::format_count;
using program::TextTable;

constexpr std::size_t kMostStops = 6;

std::string depth_mm(double depth) { return depth == 0.0 ? "0" : fmt::format("{:.3f}", 1e3 * depth); }

std::string length_m(double length) {
  return std::abs(length) < 1e-4 ? fmt::format("{:.2e}", length) : fmt::format("{:.6f}", length);
}

std::string time_us(double time) { return fmt::format("{:.{}f}", time, time < 100.0 ? 1 : 0); }

std::string label(const MethodResult& method) {
  if (method.backend == "-") return method.method;
  if (method.method != "contact world") return method.method + ", " + method.backend;
  return "world, " + method.backend + (method.check == MotionCheck::sampled ? " (sampled)" : "");
}

/// Stops of one time, between the same two objects, are one line.
std::size_t end_of_group(const Setting& setting, const std::vector<Stop>& stops, std::size_t first) {
  const auto objects = [&](const Stop& stop) {
    return std::pair(setting.instance().object_of(stop.solids.a),
                     setting.instance().object_of(stop.solids.b));
  };
  std::size_t end = first + 1;
  while (end < stops.size() && stops[end].time == stops[first].time &&
         objects(stops[end]) == objects(stops[first]))
    ++end;
  return end;
}

/// When, what and how close, one line a stop; in the method's own words.
std::string stops_text(const ScriptResult& result, const MethodResult& method) {
  std::string text;
  std::size_t lines = 0;
  const auto add = [&](double time, const std::string& what) {
    if (++lines <= kMostStops) text += fmt::format("    {:12.6f} s  {}\n", time, what);
  };
  for (const Cue& cue : method.verdict.cues)
    if (result.setting->scene().policy == ContactPolicy::cue || cue.kind == EventKind::penetrating_at_start)
      add(cue.time, fmt::format("{}: {}", to_string(cue.kind), pair_name(*result.setting, cue.solids)));
  const std::vector<Stop>& stops = method.verdict.stops;
  for (std::size_t i = 0, end = 0; i < stops.size(); i = end) {
    end = end_of_group(*result.setting, stops, i);
    double least = stops[i].clearance;
    for (std::size_t k = i; k < end; ++k) least = std::min(least, stops[k].clearance);
    const std::string others = end - i == 1 ? "" : fmt::format(" and {} more", end - i - 1);
    add(stops[i].time, fmt::format("stopped: {}{}, clearance {} m",
                                   pair_name(*result.setting, stops[i].solids), others, length_m(least)));
  }
  if (lines > kMostStops) text += fmt::format("    and {} more\n", lines - kMostStops);
  return text;
}

std::string arm_text(const MethodResult& method) {
  std::string text;
  for (const HandFigures& hand : method.hands)
    if (hand.is_arm)
      text += fmt::format("    arm: {} frames at a joint's limit, {} damped, {} m off where the hand asked\n",
                          hand.limited_frames, hand.damped_frames, length_m(hand.largest_residual));
  return text;
}

/// Of receivers that lost something.
std::string losses_text(const MethodResult& method) {
  std::string text;
  for (const OutputFigures& output : method.outputs) {
    if (output.status.dropped > 0 || output.status.errors > 0)
      text += fmt::format("    {}: {} of {} frames lost, {} errors\n", output.receiver, output.status.dropped,
                          output.status.offered, output.status.errors);
    if (!output.error.empty()) text += fmt::format("    {}: {}\n", output.receiver, output.error);
  }
  return text;
}

void add_row(const MethodResult& method, TextTable& table) {
  if (!method.not_flown.empty()) return;
  const Verdict& v = method.verdict;
  table.add({label(method), v.stops.empty() ? "-" : fmt::format("{:.6f}", v.stops[0].time),
             v.stops.empty() ? "-" : length_m(v.stops[0].clearance), depth_mm(v.deepest_shown),
             depth_mm(v.deepest_between), format_count(v.merged), format_count(v.missed),
             format_count(v.phantom), format_count(v.false_stops) + "/" + format_count(v.blocked),
             time_us(method.times.median_us), time_us(method.times.p999_us), time_us(method.times.worst_us),
             time_us(method.cpu_times.worst_us),
             method.allocations ? std::to_string(*method.allocations) : "-"});
}

}  // namespace

std::string terminal_text(const ScriptResult& result) {
  const Setting& setting = *result.setting;
  const Scene& scene = setting.scene();
  std::string text = fmt::format("\n{}: {}\n  {}, {} Hz, gap {:g} m, {} frames\n", result.file,
                                 setting.script().name, to_string(scene.policy), scene.frame_rate,
                                 scene.contact_gap, format_count(setting.frame_count()));
  TextTable table({"", "stopped s", "clear m", "deep mm", "between", "merged", "missed", "phantom",
                   "false stops", "us med", "99.9%", "worst", "cpu", "alloc"});
  for (const MethodResult& method : result.methods) add_row(method, table);
  text += table.str();
  for (const MethodResult& method : result.methods) {
    if (!method.not_flown.empty()) {
      text += fmt::format("  {}: not flown: {}\n", label(method), method.not_flown);
      continue;
    }
    const std::string lines = stops_text(result, method) + arm_text(method) + losses_text(method);
    if (!lines.empty()) text += "  " + label(method) + "\n" + lines;
  }
  return text;
}

namespace {

struct Sum {
  std::string label;
  std::size_t scripts = 0, frames = 0, merged = 0, passed_through = 0, missed = 0, phantom = 0, blocked = 0,
              false_stops = 0;
  double worst_cpu_us = 0.0;
  std::optional<std::uint64_t> allocations = 0;  ///< none where they cannot be counted
};

void add(const MethodResult& method, std::vector<Sum>& sums) {
  auto sum =
      std::find_if(sums.begin(), sums.end(), [&](const Sum& each) { return each.label == label(method); });
  if (sum == sums.end()) sum = sums.insert(sums.end(), Sum{label(method)});
  const Verdict& v = method.verdict;
  ++sum->scripts;
  sum->frames += v.frames;
  sum->merged += v.merged;
  sum->passed_through += v.passed_through;
  sum->missed += v.missed;
  sum->phantom += v.phantom;
  sum->blocked += v.blocked;
  sum->false_stops += v.false_stops;
  sum->worst_cpu_us = std::max(sum->worst_cpu_us, method.cpu_times.worst_us);
  if (method.allocations && sum->allocations)
    *sum->allocations += *method.allocations;
  else
    sum->allocations.reset();
}

}  // namespace

std::string summary_text(const std::vector<ScriptResult>& results) {
  std::vector<Sum> sums;
  for (const ScriptResult& result : results)
    for (const MethodResult& method : result.methods)
      if (method.not_flown.empty()) add(method, sums);
  TextTable table({"all scripts", "scripts", "frames", "merged", "passed through", "missed", "phantom",
                   "false stops", "cpu us", "alloc/frame"});
  for (const Sum& sum : sums)
    table.add(
        {sum.label, std::to_string(sum.scripts), format_count(sum.frames), format_count(sum.merged),
         format_count(sum.passed_through), format_count(sum.missed), format_count(sum.phantom),
         format_count(sum.false_stops) + "/" + format_count(sum.blocked),
         fmt::format("{:.1f}", sum.worst_cpu_us),
         sum.allocations && sum.frames > 0
             ? fmt::format("{:.3g}", static_cast<double>(*sum.allocations) / static_cast<double>(sum.frames))
             : "-"});
  return "\n" + table.str();
}

}  // namespace touchstone::training
