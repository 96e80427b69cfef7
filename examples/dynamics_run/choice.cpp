#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/dynamics_run/results.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

// The backend to build on. A scene is chosen for as all scenes are: one standing a backend, with the times of
// each scene.

namespace touchstone::dynamics {
namespace {

/// Times closer than this are one: other work on the machine shifts them by as much.
constexpr double kAsFast = 1.1;

/// One backend in what is chosen for.
struct Standing {
  std::string backend;
  std::size_t misses = 0;  ///< of a scene's limits; over all scenes: the scenes with any
  std::size_t late = 0;    ///< scenes
  std::uint64_t allocations = 0;
  double pose_error = 0.0;                 ///< the largest
  std::vector<measures::StepTimes> times;  ///< by scene
  double slowness = 1.0;                   ///< times behind the fastest, see set_slowness()
};

/// The largest factor, over the scenes, by which a median or a 99.9th percentile is behind the least one.
void set_slowness(std::vector<Standing>& standings) {
  const std::size_t scenes = standings.empty() ? 0 : standings[0].times.size();
  for (std::size_t s = 0; s < scenes; ++s)
    for (const auto figure : {&measures::StepTimes::median_us, &measures::StepTimes::p999_us}) {
      double least = kInfinity;
      for (const Standing& each : standings) least = std::min(least, each.times[s].*figure);
      for (Standing& each : standings) each.slowness = std::max(each.slowness, each.times[s].*figure / least);
    }
}

template <class Figure>
void keep_least(std::vector<Standing>& standings, const Figure& figure, double factor = 1.0) {
  const auto value = [&](const Standing& each) { return static_cast<double>(figure(each)); };
  double least = kInfinity;
  for (const Standing& each : standings) least = std::min(least, value(each));
  std::erase_if(standings, [&](const Standing& each) { return value(each) > factor * least; });
}

/// The backends left after each criterion: they show why the others are not chosen.
struct Choice {
  std::optional<Standing> best;
  std::vector<Standing> compared;  ///< in time: what the criteria before that left
};

Choice pick(std::vector<Standing> standings) {
  Choice choice;
  keep_least(standings, [](const Standing& each) { return each.misses; });
  if (!standings.empty() && standings[0].misses == 0) {
    keep_least(standings, [](const Standing& each) { return each.late; });
    keep_least(standings, [](const Standing& each) { return each.allocations > 0 ? 1 : 0; });
    set_slowness(standings);
    choice.compared = standings;
    keep_least(
        standings, [](const Standing& each) { return each.slowness; }, kAsFast);
  }
  keep_least(standings, [](const Standing& each) { return each.pose_error; });
  if (!standings.empty()) choice.best = standings[0];
  return choice;
}

/// Those that are not chosen, by what keeps them back.
struct Others {
  std::vector<std::string> off, late, allocating, slower, as_fast;

  std::string text() const {
    std::string text;
    if (!as_fast.empty()) text += "; as fast to 10 %, not closer to the reference: " + joined(as_fast);
    if (!slower.empty()) text += "; slower: " + joined(slower);
    if (!allocating.empty()) text += "; allocates: " + joined(allocating);
    if (!late.empty()) text += "; late: " + joined(late);
    if (!off.empty()) text += "; off: " + joined(off);
    return text;
  }
};

/// Where a standing without misses belongs.
std::vector<std::string>& place(Others& others, const Standing& standing, const Choice& choice) {
  if (standing.late > choice.best->late) return others.late;
  if (standing.allocations > 0 && choice.best->allocations == 0) return others.allocating;
  for (const Standing& each : choice.compared)
    if (each.backend == standing.backend)
      return each.slowness > kAsFast * choice.best->slowness ? others.slower : others.as_fast;
  return others.slower;
}

std::string times_text(const measures::StepTimes& times) {
  return fmt::format("{:.1f} us ({:.1f} at 99.9 %)", times.median_us, times.p999_us);
}

std::string allocations_text(std::uint64_t count) {
  return count == 0 ? "no allocation" : program::format_count(count) + " allocations";
}

/// What the engine does not tell was not judged; empty: it tells all.
std::string not_given_text(const SceneResult& result, const BackendRun& run) {
  if (!result.scene->answers_hold) return "";
  const auto given = std::count_if(run.answers.begin(), run.answers.end(),
                                   [](const AnswerResult& answer) { return answer.is_given; });
  if (given == std::ssize(run.answers)) return "";
  return fmt::format("; it does not give {} of {} answers", std::ssize(run.answers) - given,
                     run.answers.size());
}

std::string off_text(const BackendRun& run) { return run.backend + " (" + joined(run.misses) + ")"; }

Standing standing_of(const BackendRun& run) {
  return {run.backend,
          run.misses.size(),
          run.late ? 1U : 0U,
          run.allocations.value_or(0),
          run.pose_error,
          {run.total},
          1.0};
}

const BackendRun& run_of(const SceneResult& result, const std::string& backend) {
  return *std::find_if(result.runs.begin(), result.runs.end(),
                       [&](const BackendRun& run) { return run.backend == backend; });
}

std::string reason_for(const SceneResult& result, const Choice& choice) {
  const BackendRun& best = run_of(result, choice.best->backend);
  if (!best.misses.empty())
    return "none is within the scene's limits; it is the least off: " + joined(best.misses);
  Others others;
  for (const BackendRun& run : result.runs) {
    if (&run == &best || !run.not_run.empty()) continue;
    if (!run.misses.empty())
      others.off.push_back(off_text(run));
    else if (std::vector<std::string>& list = place(others, standing_of(run), choice);
             &list == &others.allocating)
      list.push_back(fmt::format("{} ({})", run.backend, program::format_count(*run.allocations)));
    else
      list.push_back(run.backend + " " + times_text(run.total));
  }
  std::string reason;
  if (best.late) reason = fmt::format("none keeps the deadline of {:g} us at 99.9 %; ", result.deadline_us);
  return reason + "within the scene's limits at " + times_text(best.total) + " a step, " +
         allocations_text(choice.best->allocations) + not_given_text(result, best) + others.text();
}

/// Nothing touches where the reference finds no contact; if it did not run, where nobody does.
bool touches(const SceneResult& result) {
  for (const BackendRun& run : result.runs)
    if (run.backend == result.reference && run.is_whole()) return run.contact_count > 0;
  return std::any_of(result.runs.begin(), result.runs.end(),
                     [](const BackendRun& run) { return run.contact_count > 0; });
}

bool any_whole(const SceneResult& result) {
  return std::any_of(result.runs.begin(), result.runs.end(),
                     [](const BackendRun& run) { return run.is_whole(); });
}

/// Of every backend that is in all scenes.
std::vector<Standing> standings_over(const std::vector<SceneResult>& results) {
  std::vector<Standing> standings;
  for (const BackendRun& first : results[0].runs) standings.push_back({first.backend, 0, 0, 0, 0.0, {}, 1.0});
  for (const SceneResult& result : results) {
    std::erase_if(standings, [&](const Standing& each) {
      return std::none_of(result.runs.begin(), result.runs.end(),
                          [&](const BackendRun& run) { return run.backend == each.backend; });
    });
    for (Standing& standing : standings) {
      const BackendRun& run = run_of(result, standing.backend);
      standing.misses += run.misses.empty() ? 0 : 1;
      if (!result.touches || !run.is_whole()) continue;
      standing.late += run.late ? 1 : 0;
      standing.allocations += run.allocations.value_or(0);
      standing.pose_error = std::max(standing.pose_error, run.pose_error);
      standing.times.push_back(run.total);
    }
  }
  return standings;
}

std::string overall_reason(const std::vector<Standing>& standings, const Choice& choice, std::size_t scenes) {
  const Standing& best = *choice.best;
  Others others;
  // Every other backend is listed under what it lost by.
  for (const Standing& each : standings) {
    if (each.backend == best.backend) continue;
    if (each.misses > 0) {
      others.off.push_back(fmt::format("{} in {}", each.backend, each.misses));
      continue;
    }
    std::vector<std::string>& list = place(others, each, choice);
    std::string text = each.backend;
    if (&list == &others.late) text += fmt::format(" in {}", each.late);
    if (&list == &others.allocating) text += " (" + program::format_count(each.allocations) + ")";
    for (const Standing& compared : choice.compared)
      if (compared.backend == each.backend) text += fmt::format(" (up to {:.2f} times)", compared.slowness);
    list.push_back(text);
  }
  // Where nobody is within the limits, no pace is stated.
  if (best.misses > 0)
    return fmt::format("none is within every scene's limits; it is off in {} of {}", best.misses, scenes) +
           others.text();
  // The best is named with what it falls short of, its pace and its allocations.
  std::string reason =
      best.late > 0 ? fmt::format("none keeps every deadline, it is late in {} scenes; ", best.late) : "";
  const std::string pace =
      choice.compared.size() > 1
          ? fmt::format("at most {:.2f} times behind the fastest, median and 99.9 %", best.slowness)
          : "the only one to be compared in time";
  return reason + "within every scene's limits; " + pace + ", " + allocations_text(best.allocations) +
         others.text();
}

}  // namespace

void choose(SceneResult& result) {
  result.recommended.clear();
  result.touches = true;
  // Only runs that went through are judged.
  if (!any_whole(result)) {
    result.reason = "none went through";
    return;
  }
  // Where nothing touches, misses alone tell backends apart.
  result.touches = touches(result);
  if (!result.touches) {
    Others others;
    for (const BackendRun& run : result.runs)
      if (run.not_run.empty() && !run.misses.empty()) others.off.push_back(off_text(run));
    result.reason = (others.off.empty() ? "nothing touches: every backend would do"
                                        : "nothing touches: every other backend would do") +
                    others.text();
    return;
  }
  // Whole runs compete; whatever is recommended has its reason.
  std::vector<Standing> standings;
  for (const BackendRun& run : result.runs)
    if (run.is_whole()) standings.push_back(standing_of(run));
  const Choice choice = pick(std::move(standings));
  if (!choice.best) {
    result.reason = "none has final poses that can be compared";
    return;
  }
  result.recommended = choice.best->backend;
  result.reason = reason_for(result, choice);
}

OverallVerdict choose_over_all(const std::vector<SceneResult>& results) {
  if (results.empty()) return {"", "no scene was run"};
  if (std::none_of(results.begin(), results.end(), [](const SceneResult& each) { return each.touches; }))
    return {"", "nothing touches in any scene: every backend would do"};
  const std::vector<Standing> standings = standings_over(results);
  const Choice choice = pick(standings);
  if (!choice.best) return {"", "no backend ran in every scene"};
  return {choice.best->backend, overall_reason(standings, choice, results.size())};
}

}  // namespace touchstone::dynamics
