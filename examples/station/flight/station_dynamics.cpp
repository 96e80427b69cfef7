#include "touchstone/examples/station/flight/station_dynamics.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/adapters/scene_files/guard_file.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/station/flight/station_scene.hpp"
#include "touchstone/physics/scene/scene_arm.hpp"

namespace touchstone::station {
namespace {

using physics::DynamicScene;

/// The file's scene with the script's objects only; the script may leave some out.
DynamicScene without_arm(const training::Setting& setting, const DynamicScene& file, std::size_t objects) {
  DynamicScene out = file;
  out.scene = setting.scene();
  out.scene.objects.erase(out.scene.objects.begin() + static_cast<std::ptrdiff_t>(objects),
                          out.scene.objects.end());
  std::erase_if(out.scene.exempt_pairs, [&](const ExemptPair& pair) {  // add_arm() brings the arm's
    return pair.first.starts_with(setting.arms()[0].mechanism->name() + ".") &&
           pair.second.starts_with(setting.arms()[0].mechanism->name() + ".");
  });
  out.bodies.clear();
  std::vector<std::size_t> index_of(file.bodies.size(), kNoObject);
  for (std::size_t i = 0; i < objects; ++i) {
    const std::size_t found = find_object(file.scene, out.scene.objects[i].tree.name());
    index_of[found] = i;
    out.bodies.push_back(file.bodies[found]);
  }
  std::erase_if(out.pairs, [&](const physics::ScenePair& pair) {
    return index_of[pair.a] == kNoObject || index_of[pair.b] == kNoObject;
  });
  for (physics::ScenePair& pair : out.pairs) pair.a = index_of[pair.a], pair.b = index_of[pair.b];
  out.answers.clear();
  out.conserved = {};
  return out;
}

void check(const DynamicScene& file, const std::string& where) {
  const char* const what = !file.mechanisms.empty() ? "arms or mechanisms"
                           : !file.joints.empty()   ? "joints between bodies"
                           : !file.actions.empty()  ? "actions"
                                                    : nullptr;
  if (what != nullptr)
    throw InputError(where + ": dynamics: the station flies the script's arm: " + what +
                     " of the scene's own are not flown");
}

/// One to each object, in the scene's order: frames and the judge count on it.
void check_order(const DynamicScene& scene, const training::Setting& setting) {
  bool is_same = scene.scene.objects.size() == setting.object_count();
  for (std::uint32_t i = 0; is_same && i < setting.object_count(); ++i)
    is_same = scene.scene.objects[i].tree.name() == setting.object_name(i);
  if (!is_same) throw InputError("script '" + setting.script().name + "': dynamics: an arm of another order");
}

std::vector<ExemptPair> names_of(std::span<const SolidPair> pairs, const training::Setting& setting) {
  const SceneInstance& instance = setting.instance();
  const auto name = [&](SolidIndex solid) {
    const std::uint32_t object = instance.object_of(solid);
    return setting.object_name(object) + "/" +
           instance.trees()[object]->solids()[solid - instance.first_solid(object)].name;
  };
  std::vector<ExemptPair> out;
  for (const SolidPair& pair : pairs) out.push_back({name(pair.a), name(pair.b)});
  return out;
}

/// Of the arm's end that is not its base.
physics::SceneBodyJoint hold_of(std::uint32_t end, const DynamicScene& scene) {
  physics::SceneBodyJoint hold;
  hold.name = "hold";
  hold.child = end;
  hold.p_W = scene.scene.objects[end].X_WO.p;
  hold.is_on = false;
  return hold;
}

/// As the last objects of a scene without it, with what may be latched and what may hold its free end.
void add_flown_arm(const StationDynamics& dynamics, const training::Setting& setting,
                   const training::Arm& arm, DynamicScene& scene) {
  // Assumed: as the first object's.
  const physics::Surface surface = scene.bodies.empty() ? physics::Surface{} : scene.bodies[0].surface;
  physics::add_arm(scene, *arm.mechanism, arm.mechanism->name(), arm.X_WB, arm.joints, surface);
  check_order(scene, setting);
  for (const std::uint32_t end : dynamics.ends)
    if (scene.bodies[end].kind == physics::BodyKind::link) scene.joints.push_back(hold_of(end, scene));
}

/// As `now` moves it, free or carried.
void set_velocities(const physics::SceneSimulation& now, std::size_t object, const Pose& X_WO,
                    physics::SceneBody& body) {
  const physics::Mover& mover = now.mover_of(object);
  body.v_W = now.world().velocity_at(mover, transform(X_WO, body.inertia.centre_B));
  body.w_W = Vector3::Zero();
  if (mover.kind == physics::Mover::Kind::body) body.w_W = now.world().angular_velocity(mover.index);
  if (mover.kind == physics::Mover::Kind::link)
    body.w_W = now.world().link_angular_velocity(mover.index, mover.link);
}

}  // namespace

std::shared_ptr<const StationDynamics> load_station_dynamics(const training::Setting& setting,
                                                             std::span<const LatchOption> latches,
                                                             std::vector<std::uint32_t> ends) {
  const std::filesystem::path& file = setting.script().scene_file;
  if (file.empty() || !has_guard(file)) return nullptr;
  if (setting.arms().empty())
    throw InputError(file.string() + ": dynamics: the station needs an arm to fly with forces");
  const GuardedScene read = load_guarded_scene(file, setting.scene().parameters);
  check(read.scene, file.string());
  const training::Arm& arm = setting.arms()[0];
  auto out = std::make_shared<StationDynamics>();
  out->settings = read.settings;
  out->ends = std::move(ends);
  // The file's objects, and what of them may be latched.
  out->things = without_arm(setting, read.scene, arm.first_object);
  for (const LatchOption& option : latches) {
    if (option.carried >= arm.first_object ||
        out->things.bodies[option.carried].kind != physics::BodyKind::dynamic)
      throw InputError(file.string() + ": dynamics: '" + setting.object_name(option.carried) +
                       "' may be latched, and is not dynamic");
    out->things.latch_options.push_back({option.carrier, option.carried, names_of(option.allowed, setting)});
  }
  // As many steps as come nearest to the file's make a frame.
  const double frame = 1.0 / setting.scene().frame_rate;
  out->steps = std::max<std::size_t>(1, static_cast<std::size_t>(std::llround(frame / read.scene.step)));
  out->things.step = frame / static_cast<double>(out->steps);
  out->scene = out->things;
  add_flown_arm(*out, setting, arm, out->scene);
  validate(out->scene);
  return out;
}

DynamicScene go_on_from(const physics::GuardedSimulation& now, const StationDynamics& dynamics,
                        const training::Setting& setting, const training::Arm& arm) {
  const physics::SceneSimulation& simulation = now.simulation();
  DynamicScene out = dynamics.things;
  // Free and carried objects keep their velocities.
  for (std::size_t i = 0; i < out.bodies.size(); ++i) {
    Pose& X_WO = out.scene.objects[i].X_WO;
    X_WO = now.shown_pose(i);
    if (out.bodies[i].kind == physics::BodyKind::dynamic) set_velocities(simulation, i, X_WO, out.bodies[i]);
  }
  add_flown_arm(dynamics, setting, arm, out);
  // Joints turn on at their rates.
  const std::span<const double> rates = simulation.world().joint_rates(0);
  for (const Mechanism::Joint& before : simulation.dynamics_of(0).mechanism().joints())
    for (physics::SceneJoint& joint : out.mechanisms.back().joints)
      if (before.value != Mechanism::kNone && before.name == joint.name) joint.rate = rates[before.value];
  // Latches hold on.
  out.scene.latches.clear();
  for (std::size_t i = 0; i < dynamics.things.bodies.size(); ++i) {
    const std::size_t carrier = simulation.carrier_of(i);
    if (carrier == kNoObject) continue;
    const std::span<const ExemptPair> allowed = simulation.allowed_with(i);
    out.scene.latches.push_back({setting.object_name(static_cast<std::uint32_t>(carrier)),
                                 setting.object_name(static_cast<std::uint32_t>(i)),
                                 {allowed.begin(), allowed.end()}});
  }
  validate(out);
  return out;
}

}  // namespace touchstone::station
