#include <fmt/format.h>

#include <iterator>

#include "touchstone/examples/dynamics_run/results.hpp"
#include "touchstone/examples/program/files/csv.hpp"

namespace touchstone::dynamics {
namespace {

void add_names(std::string& text, const std::string& name, const std::string& figure,
               const std::string& unit) {
  for (const char axis : {'x', 'y', 'z'})
    text += "," + program::csv_text(fmt::format("{}.{}_{}_{}", name, figure, axis, unit));
}

void add(std::string& text, const Vector3& v) {
  fmt::format_to(std::back_inserter(text), ",{},{},{}", v.x(), v.y(), v.z());
}

}  // namespace

std::string series_csv(const SceneResult& result, const BackendRun& run) {
  const physics::DynamicScene& scene = *result.scene;
  const std::vector<std::string> joints = joint_names(scene);
  std::string text =
      "time_s,momentum_x_ns,momentum_y_ns,momentum_z_ns,angular_x_nms,angular_y_nms,angular_z_nms,energy_j";
  // Columns are named by the scene's joints and objects.
  for (const std::string& joint : joints)
    for (const char* figure : {"value", "rate", "torque"})
      text += "," + program::csv_text(joint + "." + figure);
  for (const SceneObject& object : scene.scene.objects) {
    add_names(text, object.tree.name(), "position", "m");
    add_names(text, object.tree.name(), "force", "n");
    add_names(text, object.tree.name(), "moment", "nm");
  }
  // Attitudes are quaternions, w first.
  for (const SceneObject& object : scene.scene.objects)
    for (const char* part : {"w", "x", "y", "z"})
      text += "," + program::csv_text(fmt::format("{}.attitude_{}", object.tree.name(), part));
  text += "\n";
  const std::size_t objects = scene.scene.objects.size();
  const Series& series = run.series;
  // A sample's joints and objects are a stretch of each flat array.
  for (std::size_t i = 0; i < series.samples.size(); ++i) {
    const Sample& sample = series.samples[i];
    text += fmt::format("{}", sample.time);
    add(text, sample.linear_W);
    add(text, sample.angular_W);
    text += fmt::format(",{}", sample.energy);
    for (std::size_t j = i * joints.size(); j < (i + 1) * joints.size(); ++j)
      fmt::format_to(std::back_inserter(text), ",{},{},{}", series.value[j], series.rate[j],
                     series.torque[j]);
    for (std::size_t o = i * objects; o < (i + 1) * objects; ++o) {
      add(text, series.p_W[o]);
      add(text, series.force_W[o]);
      add(text, series.moment_W[o]);
    }
    for (std::size_t o = i * objects; o < (i + 1) * objects; ++o) {
      fmt::format_to(std::back_inserter(text), ",{}", series.q_WO[o].w);
      add(text, series.q_WO[o].v);
    }
    text += "\n";
  }
  return text;
}

std::string contacts_csv(const SceneResult& result, const BackendRun& run) {
  std::string text =
      "time_s,a,b,status,point_x_m,point_y_m,point_z_m,normal_x,normal_y,normal_z,depth_m,force_x_n,force_y_"
      "n,force_z_n,impact_x_ns,impact_y_ns,impact_z_ns\n";
  for (const ContactRow& row : run.series.contacts) {
    fmt::format_to(std::back_inserter(text), "{},{},{},{}", row.time,
                   program::csv_text(result.solid_names[row.a]), program::csv_text(result.solid_names[row.b]),
                   to_string(row.status));
    add(text, row.p_W);
    add(text, row.n_AB_W);
    fmt::format_to(std::back_inserter(text), ",{}", row.depth);
    add(text, row.force_W);
    add(text, row.impact_W);
    text += "\n";
  }
  return text;
}

}  // namespace touchstone::dynamics
