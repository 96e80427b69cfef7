#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "touchstone/adapters/c_interface/calls.hpp"
#include "touchstone/adapters/c_interface/corners.hpp"
#include "touchstone/adapters/c_interface/layout.hpp"
#include "touchstone/adapters/c_interface/world.hpp"

using namespace touchstone;
using c_interface::guarded;
using c_interface::number_of;
using c_interface::object_of;
using c_interface::pose_of;
using c_interface::registry;
using c_interface::require;
using c_interface::rule_of;

namespace {

static_assert(TOUCHSTONE_CUE == static_cast<int>(ContactPolicy::cue) &&
              TOUCHSTONE_HOLD == static_cast<int>(ContactPolicy::hold) &&
              TOUCHSTONE_ADVANCE == static_cast<int>(ContactPolicy::advance) &&
              TOUCHSTONE_SLIDE == static_cast<int>(ContactPolicy::slide));
static_assert(TOUCHSTONE_NEAR == static_cast<int>(EventKind::near) &&
              TOUCHSTONE_BEGAN == static_cast<int>(EventKind::began) &&
              TOUCHSTONE_PERSISTS == static_cast<int>(EventKind::persists) &&
              TOUCHSTONE_ENDED == static_cast<int>(EventKind::ended) &&
              TOUCHSTONE_PENETRATING_AT_START == static_cast<int>(EventKind::penetrating_at_start) &&
              TOUCHSTONE_BLOCKED == static_cast<int>(EventKind::blocked) &&
              TOUCHSTONE_REFUSED == static_cast<int>(EventKind::refused) &&
              TOUCHSTONE_AT_LIMIT == static_cast<int>(EventKind::at_limit));

touchstone_event event_of(const ContactEvent& event) {
  touchstone_event out{number_of(event.a),
                       number_of(event.b),
                       event.solids.a,
                       event.solids.b,
                       static_cast<int32_t>(event.kind),
                       event.part,
                       event.s,
                       {}};
  // By the checked layout; not by reference, which aliasing rules forbid.
  std::memcpy(&out.geometry, static_cast<const void*>(&event.geometry), sizeof out.geometry);
  return out;
}

SelectionChange change_of(touchstone_object a, touchstone_object b, bool on) {
  if (a == TOUCHSTONE_NO_OBJECT && b != TOUCHSTONE_NO_OBJECT) reject("a", "is no object, though b is one");
  if (a == TOUCHSTONE_NO_OBJECT) return SelectionChange::of_everything(on);
  if (b == TOUCHSTONE_NO_OBJECT) return SelectionChange::of(object_of(a), on);
  return SelectionChange::of(object_of(a), object_of(b), on);
}

/// A world of its own, not of a file's.
class OwnWorld final : public c_interface::WorldHolder {
 public:
  OwnWorld(std::unique_ptr<Narrowphase> narrowphase, std::unique_ptr<Broadphase> broadphase, double gap)
      : world_(std::move(narrowphase), std::move(broadphase), gap) {}
  ContactWorld& world() override { return world_; }

 private:
  ContactWorld world_;
};

Exemption exemption_of(const touchstone_exemption& pair) {
  return {object_of(pair.a), object_of(pair.b), pair.solid_a == nullptr ? "" : pair.solid_a,
          pair.solid_b == nullptr ? "" : pair.solid_b};
}

}  // namespace

std::vector<std::string> c_interface::names_of(const char* const* names, std::size_t count,
                                               const char* what) {
  if (count > 0) require(static_cast<const void*>(names), what);
  std::vector<std::string> out;
  for (std::size_t i = 0; i < count; ++i) {
    require(names[i], what);
    out.emplace_back(names[i]);
  }
  return out;
}

std::vector<double> c_interface::values_of(const double* values, std::size_t count, const char* what) {
  if (count > 0) require(values, what);
  return values == nullptr ? std::vector<double>{} : std::vector<double>(values, values + count);
}

touchstone_report c_interface::kept_report(touchstone_world& world, const FrameReport& report) {
  world.events.clear();
  for (const ContactEvent& event : report.events) world.events.push_back(event_of(event));
  keep_hands(world, report);
  return {report.frame,
          world.events.data(),
          world.events.size(),
          report.queries,
          report.blocked_movers,
          report.candidate_pairs,
          static_cast<uint8_t>(report.check == MotionCheck::proven ? 1 : 0),
          {}};
}

std::vector<PlacedHexahedron> c_interface::placed_solids(const double* corners, const double* radii,
                                                         std::size_t solids) {
  std::vector<PlacedHexahedron> placed;
  for (Hexahedron& solid : c_interface::solids_from_corners({corners, solids * c_interface::kCornerDoubles},
                                                            {radii, radii == nullptr ? 0 : solids}))
    placed.push_back({std::to_string(placed.size()), std::move(solid), Pose{}});
  return placed;
}

touchstone_code touchstone_create_world(const char* backend, double gap, touchstone_world** out) {
  return guarded({{backend, "backend"}, {static_cast<const void*>(out), "out"}}, [&] {
    auto made = std::make_unique<touchstone_world>(
        std::make_unique<OwnWorld>(registry().make_narrowphase(backend), registry().make_broadphase("native"),
                                   gap == 0.0 ? kDefaultGap : gap));
    *out = made.release();
  });
}

void touchstone_destroy_world(touchstone_world* world) { delete world; }

touchstone_code touchstone_add_object(touchstone_world* world, const char* name, const double* corners,
                                      size_t solids, const touchstone_pose* X_WO, int32_t is_static,
                                      touchstone_object* out) {
  return touchstone_add_object_in_groups(world, name, corners, solids, X_WO, is_static, nullptr, 0, out);
}

touchstone_code touchstone_add_object_in_groups(touchstone_world* world, const char* name,
                                                const double* corners, size_t solids,
                                                const touchstone_pose* X_WO, int32_t is_static,
                                                const char* const* groups, size_t group_count,
                                                touchstone_object* out) {
  return touchstone_add_rounded_object(world, name, corners, nullptr, solids, X_WO, is_static, groups,
                                       group_count, out);
}

touchstone_code touchstone_add_rounded_object(touchstone_world* world, const char* name,
                                              const double* corners, const double* radii, size_t solids,
                                              const touchstone_pose* X_WO, int32_t is_static,
                                              const char* const* groups, size_t group_count,
                                              touchstone_object* out) {
  return guarded({{world, "world"}, {name, "name"}, {corners, "corners"}, {X_WO, "X_WO"}, {out, "out"}}, [&] {
    std::vector<std::string> names = c_interface::names_of(groups, group_count, "groups");
    auto tree =
        std::make_shared<const HexahedronTree>(c_interface::placed_solids(corners, radii, solids), name);
    *out = number_of(world->world.add({std::move(tree), pose_of(*X_WO), is_static != 0, std::move(names)}));
  });
}

touchstone_code touchstone_remove_object(touchstone_world* world, touchstone_object object) {
  return guarded({{world, "world"}}, [&] { world->world.remove(object_of(object)); });
}

touchstone_code touchstone_set_policy(touchstone_world* world, touchstone_object a, touchstone_object b,
                                      int32_t policy, double warn_distance) {
  return guarded({{world, "world"}}, [&] {
    const PairRule rule = rule_of(policy, warn_distance);
    if (a == TOUCHSTONE_NO_OBJECT && b == TOUCHSTONE_NO_OBJECT)
      world->world.set_default_rule(rule);
    else
      world->world.set_pair_rule(object_of(a), object_of(b), rule);
  });
}

touchstone_code touchstone_latch(touchstone_world* world, touchstone_object carrier,
                                 touchstone_object carried) {
  return guarded({{world, "world"}}, [&] { world->world.latch(object_of(carrier), object_of(carried)); });
}

touchstone_code touchstone_unlatch(touchstone_world* world, touchstone_object carried) {
  return guarded({{world, "world"}}, [&] { world->world.unlatch(object_of(carried)); });
}

touchstone_code touchstone_select(touchstone_world* world, touchstone_object a, touchstone_object b,
                                  int32_t on) {
  return guarded({{world, "world"}}, [&] { world->world.select(change_of(a, b, on != 0)); });
}

touchstone_code touchstone_prepare(touchstone_world* world) {
  return guarded({{world, "world"}}, [&] { world->world.prepare(); });
}

touchstone_code touchstone_frame(touchstone_world* world, const touchstone_command* commands, size_t count,
                                 touchstone_report* out) {
  return touchstone_frame_with_joints(world, commands, count, nullptr, 0, out);
}

touchstone_code touchstone_frame_with_joints(touchstone_world* world, const touchstone_command* commands,
                                             size_t count, const touchstone_joint_command* joints,
                                             size_t joint_count, touchstone_report* out) {
  return guarded({{world, "world"}, {out, "out"}}, [&] {
    if (count > 0) require(commands, "commands");
    if (joint_count > 0) require(joints, "joints");
    // All commands are looked at before anything moves.
    world->commands.clear();
    for (std::size_t i = 0; i < count; ++i)
      world->commands.push_back(world->world.go_to(object_of(commands[i].object), pose_of(commands[i].X_WO)));
    world->joint_commands.clear();
    for (std::size_t i = 0; i < joint_count; ++i)
      world->joint_commands.push_back(c_interface::joint_command_of(*world, joints[i]));
    *out = c_interface::kept_report(*world, world->world.frame(world->commands, world->joint_commands));
  });
}

touchstone_code touchstone_get_poses(const touchstone_world* world, const touchstone_object* objects,
                                     size_t count, touchstone_pose* poses) {
  return guarded({{world, "world"}}, [&] {
    if (count == 0) return;
    require(objects, "objects");
    require(poses, "poses");
    for (std::size_t i = 0; i < count; ++i) world->world.actual_pose(object_of(objects[i]));
    for (std::size_t i = 0; i < count; ++i)
      reinterpret_cast<Pose&>(poses[i]) = world->world.actual_pose(object_of(objects[i]));
  });
}

touchstone_code touchstone_exempt(touchstone_world* world, const touchstone_exemption* pair) {
  return guarded({{world, "world"}, {pair, "pair"}}, [&] { world->world.exempt(exemption_of(*pair)); });
}

touchstone_code touchstone_unexempt(touchstone_world* world, const touchstone_exemption* pair) {
  return guarded({{world, "world"}, {pair, "pair"}}, [&] { world->world.unexempt(exemption_of(*pair)); });
}

touchstone_code touchstone_find_object(const touchstone_world* world, const char* name,
                                       touchstone_object* out) {
  return guarded({{world, "world"}, {name, "name"}, {out, "out"}},
                 [&] { *out = number_of(world->world.find(name)); });
}
