#include <fmt/format.h>

#include <cmath>

#include "touchstone/examples/dynamics_run/panel_plot.hpp"
#include "touchstone/examples/guarded_run/run.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::guarded {
namespace {

std::string in_ms(double us) { return std::isnan(us) ? "-" : fmt::format("{:.3f}", 1e-3 * us); }

std::string times_row(const GuardedRun& run) {
  const auto share = [&](double us) { return 100.0 * run.frame.worst_us / us; };
  return fmt::format(
      "  {:14} frame {} ms median, {} at 99.9 %, {} worst: {:.2g} % of 150 ms, {:.3g} % of 20 ms; "
      "a step {} ms median, {} worst; on the wall {}, {}\n",
      run.contacts, in_ms(run.frame.median_us), in_ms(run.frame.p999_us), in_ms(run.frame.worst_us),
      share(kNoticed), share(kFrameAt50Hz), in_ms(run.step.median_us), in_ms(run.step.worst_us),
      in_ms(run.wall.median_us), in_ms(run.wall.worst_us));
}

template <typename Figure>
dynamics::PlotLine line(const GuardedRun& run, std::string name, std::size_t colour, const Figure& figure) {
  dynamics::PlotLine out{std::move(name), colour, {}};
  for (const Sample& sample : run.samples) out.y.push_back(figure(sample));
  return out;
}

}  // namespace

std::string legend_text() {
  return "contacts: the narrowphase behind the dynamics' contacts; `native` proves what is shown, whichever "
         "it is.\n"
         "cut: steps in which something did not go where dynamics led; standing: of them, by hold or "
         "advance.\n"
         "stalled: frames in which a joint gave all its torque and the hand did not get on; back: driven "
         "back.\n"
         "merged: contact points in each other, shown, over all steps, by the judge; least: separation shown "
         "[m].\n"
         "unexplained: momentum of a cut that its impulses do not account for [N s]; taken: energy by cuts "
         "[J].\n";
}

std::string terminal_text(const std::string& name, const GuardedScene& scene,
                          const std::vector<GuardedRun>& runs) {
  program::TextTable table({"contacts", "steps", "cut", "standing", "stalled", "back", "merged", "least [m]",
                            "unexplained", "taken [J]", "held back [m]", "allocations"});
  std::string text = fmt::format("\n{}: {}\n", name, scene.scene.scene.name), times;
  for (const GuardedRun& run : runs) {
    if (!run.not_run.empty()) {
      times += fmt::format("  {:14} not run: {}\n", run.contacts, run.not_run);
      continue;
    }
    table.add({run.contacts, fmt::format("{}", run.steps), fmt::format("{}", run.cut),
               fmt::format("{}", run.standing), fmt::format("{}", run.stalled),
               fmt::format("{}", run.driven_back), fmt::format("{}", run.merged),
               fmt::format("{:.3g}", run.least_separation), fmt::format("{:.2g}", run.linear),
               fmt::format("{:.3g}", run.energy), fmt::format("{:.2g}", run.held_back),
               run.allocations ? fmt::format("{}", *run.allocations) : "-"});
    times += times_row(run);
    if (run.began_merged > 0)
      times += fmt::format("  {:14} the scene begins with {} points merged or touching, of {} first\n",
                           run.contacts, run.began_merged, run.first_merged);
    if (run.slides_ended > 0)
      times += fmt::format("  {:14} slides ended by the guard's budget in {} steps\n", run.contacts,
                           run.slides_ended);
    if (!run.stopped.empty()) times += fmt::format("  {:14} stopped {}\n", run.contacts, run.stopped);
  }
  return text + table.str() + times;
}

std::string results_csv(const std::string& name, const std::vector<GuardedRun>& runs) {
  std::string text =
      "scene,contacts,not_run,steps,frames,cut,standing,stalled,driven_back,judge,merged,least_separation_m,"
      "unexplained_N_s,energy_taken_J,held_back_m,allocations,frame_median_us,frame_p999_us,frame_worst_us,"
      "step_median_us,step_worst_us,slides_ended\n";
  for (const GuardedRun& run : runs)
    text += fmt::format(
        "{},{},{},{},{},{},{},{},{},{},{},{:.17g},{:.17g},{:.17g},{:.17g},{},{:.6g},{:.6g},{:.6g},{:.6g},{:."
        "6g},{}\n",
        name, run.contacts, run.not_run.empty() ? "" : "\"" + run.not_run + "\"", run.steps, run.frames,
        run.cut, run.standing, run.stalled, run.driven_back, run.judge, run.merged, run.least_separation,
        run.linear, run.energy, run.held_back, run.allocations ? fmt::format("{}", *run.allocations) : "",
        run.frame.median_us, run.frame.p999_us, run.frame.worst_us, run.step.median_us, run.step.worst_us,
        run.slides_ended);
  return text;
}

std::string series_csv(const GuardedRun& run) {
  std::string text =
      "time_s,asked_x_m,asked_y_m,asked_z_m,hand_x_m,hand_y_m,hand_z_m,force_N,torque_share,separation_m,"
      "impulse_N_s\n";
  for (const Sample& s : run.samples)
    text += fmt::format(
        "{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g}\n", s.time,
        s.asked_W.x(), s.asked_W.y(), s.asked_W.z(), s.hand_W.x(), s.hand_W.y(), s.hand_W.z(), s.force,
        s.torque_share, s.separation, s.impulse);
  return text;
}

std::string plot(const GuardedScene& scene, const std::vector<GuardedRun>& runs) {
  dynamics::PanelPlot out{scene.scene.scene.name, {}, {}, {}};
  out.panels = {{"the hand's point: height asked for and shown, z [m]", {}},
                {"the same along x [m]", {}},
                {"contact force on the hand's link, magnitude, mean of the frame [N]", {}},
                {"largest joint torque over its limit", {}},
                {"least separation shown in a frame [um]", {}}};
  for (const GuardedRun& run : runs) {
    if (run.samples.empty()) continue;
    const std::size_t c = out.colours.size();
    out.colours.push_back(run.contacts);
    out.times.emplace_back();
    for (const Sample& sample : run.samples) out.times.back().push_back(sample.time);
    out.panels[0].lines.push_back(line(run, "asked", c, [](const Sample& s) { return s.asked_W.z(); }));
    out.panels[0].lines.push_back(line(run, "shown", c, [](const Sample& s) { return s.hand_W.z(); }));
    out.panels[1].lines.push_back(line(run, "asked", c, [](const Sample& s) { return s.asked_W.x(); }));
    out.panels[1].lines.push_back(line(run, "shown", c, [](const Sample& s) { return s.hand_W.x(); }));
    out.panels[2].lines.push_back(line(run, "", c, [](const Sample& s) { return s.force; }));
    out.panels[3].lines.push_back(line(run, "", c, [](const Sample& s) { return s.torque_share; }));
    // Nothing near: as far as is looked.
    out.panels[4].lines.push_back(line(
        run, "", c, [](const Sample& s) { return std::isnan(s.separation) ? 100.0 : 1e6 * s.separation; }));
  }
  return out.colours.empty() ? "" : dynamics::panel_plot(out);
}

}  // namespace touchstone::guarded
