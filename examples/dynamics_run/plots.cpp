#include <algorithm>
#include <cmath>

#include "touchstone/examples/dynamics_run/panel_plot.hpp"
#include "touchstone/examples/dynamics_run/results.hpp"

namespace touchstone::dynamics {
namespace {

/// Of objects and joints drawn: more lines than dashes tell apart are left to the CSV.
constexpr std::size_t kMostNames = 5;

template <typename Figure>
std::vector<double> over_samples(const BackendRun& run, const Figure& figure) {
  std::vector<double> y;
  for (std::size_t i = 0; i < run.series.samples.size(); ++i) y.push_back(figure(i));
  return y;
}

class Panels {
 public:
  explicit Panels(const SceneResult& result) : result_(&result) {
    for (const BackendRun& run : result.runs)
      if (!run.series.samples.empty()) runs_.push_back(&run);
  }

  PanelPlot plot() const {
    PanelPlot out{result_->scene->scene.name, {}, {}, {}};
    for (const BackendRun* run : runs_) {
      out.colours.push_back(run->backend);
      out.times.push_back(over_samples(*run, [&](std::size_t i) { return run->series.samples[i].time; }));
    }
    if (runs_.empty()) return out;
    for (PlotPanel panel : {forces(), torques()})
      if (!panel.lines.empty()) out.panels.push_back(std::move(panel));
    const auto samples = [](const BackendRun& run) -> const std::vector<Sample>& {
      return run.series.samples;
    };
    out.panels.push_back(of_all("momentum, magnitude [N s]", [&](const BackendRun& run, std::size_t i) {
      return norm(samples(run)[i].linear_W);
    }));
    out.panels.push_back(
        of_all("angular momentum about the world's origin, magnitude [N m s]",
               [&](const BackendRun& run, std::size_t i) { return norm(samples(run)[i].angular_W); }));
    out.panels.push_back(
        of_all("energy [J]", [&](const BackendRun& run, std::size_t i) { return samples(run)[i].energy; }));
    return out;
  }

 private:
  template <typename Figure>
  PlotPanel of_all(const char* title, const Figure& figure) const {
    PlotPanel panel{title, {}};
    for (std::size_t r = 0; r < runs_.size(); ++r)
      panel.lines.push_back(
          {"", r, over_samples(*runs_[r], [&](std::size_t i) { return figure(*runs_[r], i); })});
    return panel;
  }

  /// Objects that are pushed most; not what is commanded or at rest.
  PlotPanel forces() const {
    PlotPanel panel{"contact force on an object, magnitude, mean of the step [N]", {}};
    const std::size_t objects = result_->scene->bodies.size();
    std::vector<std::pair<double, std::size_t>> most;
    for (std::size_t o = 0; o < objects; ++o) {
      const physics::BodyKind kind = result_->scene->bodies[o].kind;
      if (kind != physics::BodyKind::dynamic && kind != physics::BodyKind::link) continue;
      double largest = 0.0;
      for (const BackendRun* run : runs_)
        for (std::size_t i = o; i < run->series.force_W.size(); i += objects)
          largest = std::max(largest, norm(run->series.force_W[i]));
      if (largest > 0.0) most.emplace_back(-largest, o);
    }
    std::sort(most.begin(), most.end());
    most.resize(std::min(most.size(), kMostNames));
    for (const std::pair<double, std::size_t>& pushed : most) {
      const std::size_t o = pushed.second;
      for (std::size_t r = 0; r < runs_.size(); ++r)
        panel.lines.push_back(
            {result_->scene->scene.objects[o].tree.name(), r, over_samples(*runs_[r], [&](std::size_t i) {
               return norm(runs_[r]->series.force_W[i * objects + o]);
             })});
    }
    return panel;
  }

  PlotPanel torques() const {
    PlotPanel panel{"torque of a joint's drive [N m], force of a sliding one's [N]", {}};
    const std::vector<std::string> joints = joint_names(*result_->scene);
    for (std::size_t j = 0; j < std::min(joints.size(), kMostNames); ++j)
      for (std::size_t r = 0; r < runs_.size(); ++r)
        panel.lines.push_back({joints[j], r, over_samples(*runs_[r], [&](std::size_t i) {
                                 return runs_[r]->series.torque[i * joints.size() + j];
                               })});
    return panel;
  }

  const SceneResult* result_;
  std::vector<const BackendRun*> runs_;
};

}  // namespace

std::string time_plot(const SceneResult& result) { return panel_plot(Panels(result).plot()); }

}  // namespace touchstone::dynamics
