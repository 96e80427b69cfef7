#include <memory>
#include <utility>

#include "touchstone/adapters/c_interface/calls.hpp"
#include "touchstone/adapters/c_interface/world.hpp"
#include "touchstone/contact_core/mechanism/arms/bundled_arms.hpp"
#include "touchstone/contact_core/mechanism/mechanism.hpp"

// A world's mechanisms.

using namespace touchstone;
using c_interface::guarded;
using c_interface::mechanism_of;
using c_interface::names_of;
using c_interface::number_of;
using c_interface::pose_of;
using c_interface::require;
using c_interface::values_of;

namespace {

static_assert(TOUCHSTONE_FIXED == static_cast<int>(JointKind::fixed) &&
              TOUCHSTONE_REVOLUTE == static_cast<int>(JointKind::revolute) &&
              TOUCHSTONE_PRISMATIC == static_cast<int>(JointKind::prismatic));

Vector3 vector_of(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

LinkDescription link_of(const touchstone_link& link, const double* radii) {
  require(link.name, "links: name");
  LinkDescription out;
  out.name = link.name;
  if (link.solids == 0) return out;
  require(link.corners, "links: corners");
  out.solids = c_interface::placed_solids(link.corners, radii, link.solids);
  return out;
}

JointDescription joint_of(const touchstone_joint& joint) {
  require(joint.name, "joints: name");
  require(joint.parent, "joints: parent");
  require(joint.child, "joints: child");
  if (joint.kind < TOUCHSTONE_FIXED || joint.kind > TOUCHSTONE_PRISMATIC)
    reject("joints: kind", std::to_string(joint.kind) + " is none");
  JointDescription out;
  out.name = joint.name;
  out.parent = joint.parent;
  out.child = joint.child;
  out.kind = static_cast<JointKind>(joint.kind);
  out.X_PJ = pose_of(joint.X_PJ);
  if (out.kind != JointKind::fixed) out.axis_J = vector_of(joint.axis_J);
  out.lower = joint.lower;
  out.upper = joint.upper;
  return out;
}

MechanismDescription description_of(const touchstone_mechanism_description& given,
                                    const double* const* radii) {
  require(given.name, "name");
  if (given.link_count > 0) require(given.links, "links");
  if (given.joint_count > 0) require(given.joints, "joints");
  MechanismDescription out;
  out.name = given.name;
  for (std::size_t i = 0; i < given.link_count; ++i)
    out.links.push_back(link_of(given.links[i], radii == nullptr ? nullptr : radii[i]));
  for (std::size_t i = 0; i < given.joint_count; ++i) out.joints.push_back(joint_of(given.joints[i]));
  if (given.base != nullptr) out.base = given.base;
  return out;
}

}  // namespace

void c_interface::take_options(const touchstone_mechanism_options& options, MechanismDescription& description,
                               MechanismPlacement& placement) {
  if (options.exempt_count > 0) require(options.exempt, "options: exempt");
  for (std::size_t i = 0; i < options.exempt_count; ++i) {
    require(options.exempt[i].first, "options: exempt: first");
    require(options.exempt[i].second, "options: exempt: second");
    description.exempt_pairs.push_back({options.exempt[i].first, options.exempt[i].second});
  }
  placement.groups = names_of(options.groups, options.group_count, "options: groups");
  placement.weights = values_of(options.weights, options.weight_count, "options: weights");
}

touchstone_mechanism c_interface::add_mechanism(touchstone_world& world, MechanismDescription description,
                                                MechanismPlacement placement, const touchstone_pose& X_WB) {
  placement.mechanism = std::make_shared<const Mechanism>(std::move(description));
  placement.X_WB = pose_of(X_WB);
  return number_of(world.world.add_mechanism(std::move(placement)));
}

JointCommand c_interface::joint_command_of(const touchstone_world& world,
                                           const touchstone_joint_command& command) {
  const MechanismHandle mechanism = mechanism_of(command.mechanism);
  if (!world.world.is_alive(mechanism)) reject("joints: mechanism", "is none, or no longer");
  if (command.count > 0) require(command.values, "joints: values");
  return {mechanism, {command.values, command.count}};
}

touchstone_code touchstone_add_mechanism(touchstone_world* world,
                                         const touchstone_mechanism_description* description,
                                         const touchstone_pose* X_WB, const double* values, size_t count,
                                         touchstone_mechanism* out) {
  return touchstone_add_mechanism_with(world, description, nullptr, X_WB, values, count, out);
}

touchstone_code touchstone_add_mechanism_with(touchstone_world* world,
                                              const touchstone_mechanism_description* description,
                                              const touchstone_mechanism_options* options,
                                              const touchstone_pose* X_WB, const double* values, size_t count,
                                              touchstone_mechanism* out) {
  return touchstone_add_rounded_mechanism(world, description, nullptr, options, X_WB, values, count, out);
}

touchstone_code touchstone_add_rounded_mechanism(touchstone_world* world,
                                                 const touchstone_mechanism_description* description,
                                                 const double* const* radii,
                                                 const touchstone_mechanism_options* options,
                                                 const touchstone_pose* X_WB, const double* values,
                                                 size_t count, touchstone_mechanism* out) {
  return guarded({{world, "world"}, {description, "description"}, {X_WB, "X_WB"}, {out, "out"}}, [&] {
    MechanismDescription described = description_of(*description, radii);
    MechanismPlacement placement;
    placement.initial = values_of(values, count, "values");
    if (options != nullptr) c_interface::take_options(*options, described, placement);
    *out = c_interface::add_mechanism(*world, std::move(described), std::move(placement), *X_WB);
  });
}

touchstone_code touchstone_add_arm(touchstone_world* world, const char* name, const char* model,
                                   const touchstone_pose* X_WB, const double* values, size_t count,
                                   touchstone_mechanism* out) {
  return guarded({{world, "world"}, {name, "name"}, {model, "model"}, {X_WB, "X_WB"}, {out, "out"}}, [&] {
    MechanismDescription arm = make_bundled_arm(model);
    arm.name = name;
    MechanismPlacement placement;
    placement.initial = values_of(values, count, "values");
    *out = c_interface::add_mechanism(*world, std::move(arm), std::move(placement), *X_WB);
  });
}

touchstone_code touchstone_remove_mechanism(touchstone_world* world, touchstone_mechanism mechanism) {
  return guarded({{world, "world"}}, [&] { world->world.remove_mechanism(mechanism_of(mechanism)); });
}

touchstone_code touchstone_get_link(const touchstone_world* world, touchstone_mechanism mechanism,
                                    const char* link, touchstone_object* out) {
  return guarded({{world, "world"}, {link, "link"}, {out, "out"}},
                 [&] { *out = number_of(world->world.link(mechanism_of(mechanism), link)); });
}

touchstone_code touchstone_get_joints(const touchstone_world* world, touchstone_mechanism mechanism,
                                      const double** values, size_t* count) {
  return guarded({{world, "world"}, {static_cast<const void*>(values), "values"}, {count, "count"}}, [&] {
    const std::span<const double> joints = world->world.joint_values(mechanism_of(mechanism));
    *values = joints.data();
    *count = joints.size();
  });
}

touchstone_code touchstone_set_arm_hand(touchstone_world* world, touchstone_mechanism mechanism,
                                        const touchstone_arm_hand* hand) {
  return guarded({{world, "world"}}, [&] {
    if (hand == nullptr) return world->world.set_hand(mechanism_of(mechanism), std::nullopt);
    require(hand->link, "hand: link");
    ArmHandStiffness stiffness;
    stiffness.link = hand->link;
    stiffness.X_LT = pose_of(hand->X_LT);
    stiffness.translation = vector_of(hand->translation);
    stiffness.turning = vector_of(hand->turning);
    stiffness.joints = values_of(hand->joints, hand->joint_count, "hand: joints");
    world->world.set_hand(mechanism_of(mechanism), stiffness);
  });
}
