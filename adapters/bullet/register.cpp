#include <LinearMath/btScalar.h>

#include "touchstone/adapters/bullet/backends.hpp"
#ifdef BT_USE_DOUBLE_PRECISION
#include "touchstone/adapters/bullet/bullet.hpp"
#else
#include "touchstone/adapters/bullet/bullet_single.hpp"
#endif

// Defined by both builds of this adapter, under one name: a program that registers both does not link.
extern "C" {
extern const char touchstone_bullet_one_precision_in_a_process;
const char touchstone_bullet_one_precision_in_a_process = 0;
}

namespace touchstone {
namespace TOUCHSTONE_BULLET_NAMESPACE {
namespace {

std::string describe(const std::string& what) {
  const std::string version =
      std::to_string(BT_BULLET_VERSION / 100) + "." + std::to_string(BT_BULLET_VERSION % 100);
  return "Bullet " + version + ", " + (kDouble ? "double" : "single") + " precision: " + what;
}

void add_narrowphase(BackendRegistry& registry, const std::string& name, Method method,
                     const std::string& what) {
  registry.add(BackendRegistry::NarrowphaseEntry{name, describe(what),
                                                 [=] { return make_narrowphase(name, method); },
                                                 [=] { return make_raw_check(method); }});
}

void register_all(BackendRegistry& registry, const std::string& name) {
  add_narrowphase(registry, name, Method::box_and_convex,
                  "btBoxBoxDetector for boxes, GJK/EPA for hulls, margin 0");
  add_narrowphase(registry, name + "_gjk", Method::gjk, "GJK/EPA for all, margin 0");
  registry.add(BackendRegistry::BroadphaseEntry{name, describe("btDbvt over bounding boxes"),
                                                [=] { return make_broadphase(name); }});
}

#ifdef BT_USE_DOUBLE_PRECISION
SweepEntry sweep_entry(const char* name, SweepMethod method, const char* what) {
  return {name, describe(what), "bullet", [=] { return make_sweep(method); }};
}
#endif

}  // namespace
}  // namespace TOUCHSTONE_BULLET_NAMESPACE

#ifdef BT_USE_DOUBLE_PRECISION
void register_bullet(BackendRegistry& registry) { bullet_double::register_all(registry, "bullet"); }

std::vector<SweepEntry> bullet_sweeps() {
  using bullet_double::sweep_entry;
  using bullet_double::SweepMethod;
  return {sweep_entry("bullet_continuous", SweepMethod::continuous, "btContinuousConvexCollision"),
          sweep_entry("bullet_subsimplex_cast", SweepMethod::subsimplex, "btSubsimplexConvexCast"),
          sweep_entry("bullet_gjk_cast", SweepMethod::gjk, "btGjkConvexCast, boxes with their margins")};
}
#else
void register_bullet_single(BackendRegistry& registry) {
  bullet_single::register_all(registry, "bullet_single");
}
#endif

}  // namespace touchstone
