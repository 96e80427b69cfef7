// A program of a user of the installed package: two boxes, one query, every installed backend by name; and a
// call of each further component, so that what its static library needs is linked.
#include <array>
#include <cstdio>
#include <exception>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/registry.hpp"
#ifdef WITH_exact
#include "touchstone/adapters/exact/exact.hpp"
#endif
#ifdef WITH_bullet
#include "touchstone/adapters/bullet/bullet.hpp"
#endif
#ifdef WITH_bullet_single
#include "touchstone/adapters/bullet/bullet_single.hpp"
#endif
#if defined(WITH_bullet_plugin) || defined(WITH_bullet_plugin_single)
#include "touchstone/adapters/bullet_plugin/bullet_plugin.hpp"
#endif
#ifdef WITH_ode
#include "touchstone/adapters/ode/ode.hpp"
#endif
#ifdef WITH_bullet_dynamics
#include "touchstone/adapters/bullet_dynamics/bullet_dynamics.hpp"
#endif
#ifdef WITH_mujoco_dynamics
#include "touchstone/adapters/mujoco_dynamics/mujoco_dynamics.hpp"
#endif
#ifdef WITH_ode_dynamics
#include "touchstone/adapters/ode_dynamics/ode_dynamics.hpp"
#endif
#ifdef WITH_ode_plugin
#include "touchstone/adapters/ode_plugin/ode_plugin.hpp"
#endif
#ifdef WITH_libccd
#include "touchstone/adapters/libccd/libccd.hpp"
#endif
#ifdef WITH_fcl
#include "touchstone/adapters/fcl/fcl.hpp"
#endif
#ifdef WITH_mujoco
#include "touchstone/adapters/mujoco/mujoco.hpp"
#endif
#ifdef WITH_mujoco_plugin
#include "touchstone/adapters/mujoco_plugin/mujoco_plugin.hpp"
#endif
#ifdef WITH_dart_plugin
#include "touchstone/adapters/dart_plugin/dart_plugin.hpp"
#endif
#ifdef WITH_scene_files
#include "touchstone/adapters/scene_files/pair_file.hpp"
#include "touchstone/adapters/scene_files/scene_file.hpp"
#endif
#ifdef WITH_dynamics_files
#include "touchstone/adapters/scene_files/dynamics_file.hpp"
#endif
#ifdef WITH_mesh_files
#include "touchstone/adapters/mesh_files/mesh_file.hpp"
#endif
#ifdef WITH_robots
#include "touchstone/adapters/robots/enclosing_box.hpp"
#endif
#ifdef WITH_mjcf
#include "touchstone/adapters/mjcf/mjcf.hpp"
#endif
#ifdef WITH_sdf
#include "touchstone/adapters/sdf/sdf.hpp"
#endif
#ifdef WITH_urdf
#include "touchstone/adapters/urdf/urdf.hpp"
#endif
#ifdef WITH_recorder
#include "touchstone/adapters/recorder/recorder.hpp"
#endif
#ifdef WITH_cigi
#include "touchstone/adapters/cigi/cigi_output.hpp"
#endif
#ifdef WITH_gltf
#include "touchstone/adapters/gltf/gltf.hpp"
#endif
#ifdef WITH_c_dynamics
#include "touchstone/adapters/c_files/touchstone_dynamics.h"
#endif
#ifdef WITH_c_files
#include "touchstone/adapters/c_files/touchstone_files.h"
#endif
#ifdef WITH_robot_formats
#include "touchstone/adapters/robot_formats/robot_formats.hpp"
#endif
#ifdef WITH_c_interface
#include "touchstone/adapters/c_interface/touchstone.h"
#endif
#ifdef WITH_plugin
#include "touchstone/adapters/plugin/plugin.hpp"
#endif
#ifdef WITH_process_engine
#include "touchstone/adapters/process_engine/process_engine.hpp"
#endif
#ifdef WITH_physics
#include "touchstone/physics/world/dynamics_world.hpp"
#endif

using namespace touchstone;

namespace {

void register_all(BackendRegistry& registry) {
  register_core(registry);
#ifdef WITH_exact
  register_exact(registry);
#endif
#ifdef WITH_bullet
  register_bullet(registry);
#endif
#ifdef WITH_bullet_single
  register_bullet_single(registry);
#endif
#ifdef WITH_ode
  register_ode(registry);
#endif
#ifdef WITH_libccd
  register_libccd(registry);
#endif
#ifdef WITH_fcl
  register_fcl(registry);
#endif
#ifdef WITH_mujoco
  register_mujoco(registry);
#endif
}

/// Backends that do not find two boxes in contact.
int wrong_backends(const BackendRegistry& registry) {
  const std::array solids = {Hexahedron::from_size({2.0, 2.0, 2.0}), Hexahedron::from_size({1.0, 1.0, 1.0})};
  std::array<Pose, 2> poses;
  poses[1].p = {1.25, 0.0, 0.0};  // a quarter of a metre deep
  const std::array pairs = {SolidPair{0, 1}};
  int wrong = 0;
  for (const BackendRegistry::NarrowphaseEntry& entry : registry.narrowphases()) {
    const std::unique_ptr<Narrowphase> narrowphase = entry.make();
    narrowphase->build(solids);
    const std::unique_ptr<Narrowphase::Workspace> workspace = narrowphase->make_workspace();
    std::array<PairStatus, 1> status;
    std::array<PairGeometry, 1> geometry;
    narrowphase->evaluate({.pairs = pairs, .poses = poses, .query = {}},
                          {.status = status, .geometry = geometry}, *workspace);
    std::printf("%-12s %s\n", entry.name.c_str(), to_string(status[0]).data());
    if (status[0] != PairStatus::overlapping) ++wrong;
  }
  return wrong;
}

/// 1 unless `call` is refused by name, as something that is not there must be.
template <class Call>
[[maybe_unused]] int refused(const char* component, Call call) try {
  call();
  std::printf("%s took what is not there\n", component);
  return 1;
} catch (const InputError& error) {
  std::printf("%-12s refuses: %s\n", component, error.what());
  return 0;
}

/// @param registry whose narrowphases engines take
int wrong_plugins([[maybe_unused]] const BackendRegistry& registry) {
  int wrong = 0;
#if defined(WITH_bullet_plugin) || defined(WITH_bullet_plugin_single)
  // Linked, not called: a dispatcher takes Bullet's headers.
  if (void* const volatile dispatcher = nullptr; dispatcher != nullptr)
    BulletPlugin(*static_cast<btCollisionDispatcher*>(dispatcher));
#endif
#ifdef WITH_ode_plugin
  const OdeBoxOverride ode;
  wrong += create_ode_hexahedron(nullptr, Hexahedron::from_size({1.0, 1.0, 1.0})) == nullptr;
#endif
#ifdef WITH_bullet_dynamics
  physics::EngineRegistry with_bullet;
  register_bullet_dynamics(with_bullet, registry);
  wrong += with_bullet.engines().size() != 1;
#endif
#ifdef WITH_mujoco_dynamics
  physics::EngineRegistry with_mujoco;
  register_mujoco_dynamics(with_mujoco, registry);
  wrong += with_mujoco.engines().size() != 1;
#endif
#ifdef WITH_ode_dynamics
  physics::EngineRegistry with_ode;
  register_ode_dynamics(with_ode, registry);
  wrong += with_ode.engines().size() != 2;
#endif
#ifdef WITH_mujoco_plugin
  const MujocoOverride mujoco;
  wrong += mujoco_native_checks() != 0;
#endif
#ifdef WITH_dart_plugin
  register_dart_detector();
  wrong += dart_native_checks() != 0;
#endif
  return wrong;
}

/// The C interface, scenes and robots of files.
int wrong_with_c() {
  int wrong = 0;
#ifdef WITH_c_interface
  wrong += touchstone_abi_version() == TOUCHSTONE_ABI_VERSION ? 0 : 1;
#endif
#ifdef WITH_c_files
  touchstone_world* scene = nullptr;
  const touchstone_code code = touchstone_load_scene("native", "not_there.yaml", nullptr, 0, &scene);
  wrong += code == TOUCHSTONE_BAD_INPUT ? 0 : 1;
#endif
#ifdef WITH_c_dynamics
  touchstone_simulation* run = nullptr;
  wrong += touchstone_load_simulation("native", "not_there.yaml", nullptr, 0, &run) == TOUCHSTONE_BAD_INPUT
               ? 0
               : 1;
#endif
#ifdef WITH_robot_formats
  wrong += refused("robot_formats", [] { touchstone::load_robot("not_there.urdf"); });
#endif
  return wrong;
}

int wrong_files() {
  // Each component refuses what it cannot read.
  int wrong = 0;
#ifdef WITH_scene_files
  wrong += refused("scene_files", [] { load_scene("not_there.yaml"); });
  wrong += refused("scene_files", [] { load_pairs("not_there.json"); });
#endif
#ifdef WITH_dynamics_files
  wrong += refused("dynamics_files", [] { load_dynamic_scene("not_there.yaml"); });
#endif
#ifdef WITH_mesh_files
  wrong += refused("mesh_files", [] { load_mesh("not_there.dae", {}); });
#endif
#ifdef WITH_robots
  const TriangleMesh triangle{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  wrong += enclosing_box(triangle, "triangle").solids.size() != 1;
#endif
#ifdef WITH_mjcf
  wrong += refused("mjcf", [] { mjcf::load_robot("not_there.xml"); });
#endif
#ifdef WITH_sdf
  wrong += refused("sdf", [] { sdf::parse_robot("<sdf/>"); });
#endif
#ifdef WITH_urdf
  wrong += refused("urdf", [] { urdf::parse_urdf("<robot/>"); });
  wrong += refused("urdf", [] { urdf::parse_srdf("no markup"); });
#endif
#ifdef WITH_recorder
  wrong += refused("recorder", [] { Recorder("/not/there.csv"); });
#endif
#ifdef WITH_cigi
  CigiOptions twice;
  twice.entities.assign(2, {.object = "box", .id = 1, .type = 0, .X_OE = {}});
  wrong += refused("cigi", [&] { CigiOutput output(twice); });
#endif
  wrong += wrong_with_c();
#ifdef WITH_plugin
  BackendRegistry registry;
  wrong += refused("plugin", [&] { register_plugin(registry, "./not_there.so"); });
#endif
#ifdef WITH_process_engine
  BackendRegistry engines;
  wrong += refused("process_engine", [&] { register_process_engine(engines, {{"/not/there"}}); });
#endif
#ifdef WITH_gltf
  wrong += refused("gltf", [] { write_gltf("not_there.gltf", Recording{}, {}); });
#endif
#ifdef WITH_physics
  physics::DynamicsWorld world(physics::DynamicsWorld::Settings{});
  world.step(0.01, {});
#endif
  return wrong;
}

}  // namespace

int main() try {
  BackendRegistry registry;
  register_all(registry);
  const int wrong = wrong_backends(registry) + wrong_plugins(registry) + wrong_files();
  return registry.narrowphases().empty() || wrong != 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
