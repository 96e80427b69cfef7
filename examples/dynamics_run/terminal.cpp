#include <fmt/format.h>

#include <cmath>

#include "touchstone/examples/dynamics_run/results.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::dynamics {
namespace {

using physics::SceneAnswer;
using program::format_error;
using program::TextTable;

std::string scaled(double value, double factor) { return format_error(factor * value); }

std::string time_text(double us) { return std::isnan(us) ? "-" : fmt::format("{:.1f}", us); }

std::string answers_text(const SceneResult& result, const BackendRun& run) {
  if (result.scene->answers.empty() || !result.scene->answers_hold) return "-";
  std::size_t held = 0, given = 0;
  for (const AnswerResult& answer : run.answers) {
    held += answer.holds ? 1 : 0;
    given += answer.is_given ? 1 : 0;
  }
  return fmt::format("{}/{}", held, given);
}

/// What came out, and what it took: in one table they are wider than a terminal.
std::string tables_text(const SceneResult& result) {
  TextTable errors(
      {"", "answers", "pose mm", "rad", "depth mm", "dp", "dP", "dL", "J gained", "J lost", "m/s"});
  TextTable times({"", "us find", "us med", "99.9%", "alloc"});
  for (const BackendRun& run : result.runs) {
    if (!run.not_run.empty()) continue;
    errors.add({run.backend, answers_text(result, run), scaled(run.pose_error, 1e3),
                format_error(run.angle_error), scaled(run.deepest, 1e3),
                format_error(run.unexplained_momentum), format_error(run.linear_drift),
                format_error(run.angular_drift), format_error(run.energy_made), format_error(run.energy_lost),
                format_error(run.rest_speed)});
    times.add({run.backend, time_text(run.detection.median_us), time_text(run.total.median_us),
               time_text(run.total.p999_us),
               run.allocations ? program::format_count(*run.allocations) : "-"});
  }
  return errors.str() + times.str();
}

std::string subject(const physics::DynamicScene& scene, const SceneAnswer& answer) {
  if (answer.is_vector()) return scene.scene.objects[answer.object].tree.name() + " ";
  if (!answer.is_of_joint()) return "";
  return name_of(scene, answer.joint) + " ";
}

std::string value_text(const SceneAnswer& answer, const Vector3& value) {
  if (!answer.is_vector()) return fmt::format("{:.9g}", value.x());
  return fmt::format("({:.9g}, {:.9g}, {:.9g})", value.x(), value.y(), value.z());
}

/// Answers that are off, and how the run went on.
std::string remarks(const SceneResult& result, const BackendRun& run) {
  const physics::DynamicScene& scene = *result.scene;
  // A run that did not begin has a reason alone.
  if (!run.not_run.empty()) return fmt::format("  {}: not run: {}\n", run.backend, run.not_run);
  std::string text;
  if (!run.stopped.empty()) text += fmt::format("  {}: stopped {}\n", run.backend, run.stopped);
  // Of the known answers only those that do not hold are printed.
  for (std::size_t i = 0; i < run.answers.size() && scene.answers_hold; ++i) {
    const SceneAnswer& answer = scene.answers[i];
    if (run.answers[i].holds) continue;
    if (!run.answers[i].is_given) {
      text += fmt::format("  {}: {}{}: not given by this engine\n", run.backend, subject(scene, answer),
                          to_string(answer.figure));
      continue;
    }
    const JointKind kind = answer.is_of_joint() ? kind_of(scene, answer.joint) : JointKind::fixed;
    text += fmt::format("  {}: {}{}: {}, off by {:.2g} {}; closed form {}, within {:.2g}\n", run.backend,
                        subject(scene, answer), to_string(answer.figure),
                        value_text(answer, run.answers[i].found), run.answers[i].error, unit_of(answer, kind),
                        value_text(answer, answer.value), answer.tolerance);
  }
  // Pairs and solves without a result make the others doubtful.
  if (run.failed + run.undecided + run.unconverged > 0)
    text += fmt::format(
        "  {}: {} contacts in all; pairs: {} undecided, {} failed or unsupported; solves: {} unconverged, "
        "residual {:.1e} m/s\n",
        run.backend, run.contact_count, run.undecided, run.failed, run.unconverged, run.worst_residual);
  return text;
}

}  // namespace

std::string legend_text(const std::string& reference) {
  return fmt::format(
      "answers: closed forms met; pose mm, rad: final poses from those over {}; depth mm: worst, by native;\n"
      "dp: momentum of free bodies from nothing [N s]; dP, dL: drift of total momenta that the scene says "
      "stay\n"
      "[N s, N m s]; J gained, lost: energy beyond the work of drives and kinematic bodies [J]; m/s: fastest "
      "at the end; us: to find the\n"
      "contacts, and of a step (contacts and forces), median and 99.9 %; alloc: in all steps but the first\n",
      reference);
}

std::string terminal_text(const SceneResult& result) {
  const physics::DynamicScene& scene = *result.scene;
  std::string text = fmt::format("\n{}: {}\n  {} steps of {:g} s{}\n", result.file, scene.scene.name,
                                 program::format_count(scene.step_count()), scene.step,
                                 scene.answers_hold ? "" : "; parameters replaced: answers are not judged");
  text += tables_text(result);
  for (const BackendRun& run : result.runs) text += remarks(result, run);
  if (!result.recommended.empty())
    text += "  build on " + result.recommended + ": ";
  else
    text += result.touches ? "  build on: none: " : "  no verdict: ";
  return text + result.reason + "\n";
}

std::string terminal_text(const OverallVerdict& verdict, std::size_t scenes) {
  return fmt::format("\nover all {} scenes {}: {}\n", scenes,
                     verdict.recommended.empty() ? "no verdict" : "build on " + verdict.recommended,
                     verdict.reason);
}

}  // namespace touchstone::dynamics
