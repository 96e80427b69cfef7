#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "touchstone/adapters/c_interface/touchstone.h"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/mechanism/mechanism.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"

// Shared by the functions of a world.

namespace touchstone::c_interface {

/// Who has the contact world behind a touchstone_world.
class WorldHolder {
 public:
  virtual ~WorldHolder() = default;
  virtual ContactWorld& world() = 0;
};

}  // namespace touchstone::c_interface

struct touchstone_world {
  explicit touchstone_world(std::unique_ptr<touchstone::c_interface::WorldHolder> of)
      : holder(std::move(of)), world(holder->world()) {}

  std::unique_ptr<touchstone::c_interface::WorldHolder> holder;
  touchstone::ContactWorld& world;
  std::vector<touchstone::MotionCommand> commands;  ///< of a frame; kept for their room
  std::vector<touchstone::JointCommand> joint_commands;
  std::vector<touchstone_event> events;  ///< of the last frame, as what follows
  std::vector<touchstone_object> cut_off;
  std::vector<touchstone_feel> felt;
};

namespace touchstone::c_interface {

inline touchstone_object number_of(ObjectHandle object) {
  return object == ObjectHandle{} ? TOUCHSTONE_NO_OBJECT : std::bit_cast<touchstone_object>(object);
}
inline ObjectHandle object_of(touchstone_object number) {
  return number == TOUCHSTONE_NO_OBJECT ? ObjectHandle{} : std::bit_cast<ObjectHandle>(number);
}

inline const Pose& pose_of(const touchstone_pose& X) { return reinterpret_cast<const Pose&>(X); }

inline touchstone_mechanism number_of(MechanismHandle mechanism) {
  return std::bit_cast<touchstone_mechanism>(mechanism);
}
inline MechanismHandle mechanism_of(touchstone_mechanism number) {
  return std::bit_cast<MechanismHandle>(number);
}

/// @param radii NULL, or one a solid [m]. @throws InputError: no hexahedron. Solids are named by their index.
std::vector<PlacedHexahedron> placed_solids(const double* corners, const double* radii, std::size_t solids);

/// @throws InputError: a policy that is none.
inline PairRule rule_of(int32_t policy, double warn_distance) {
  if (policy < TOUCHSTONE_CUE || policy > TOUCHSTONE_SLIDE)
    reject("policy", std::to_string(policy) + " is none");
  PairRule rule;
  rule.policy = static_cast<ContactPolicy>(policy);
  rule.warn_distance = warn_distance;
  return rule;
}

/// Borrows the values. @throws InputError: a mechanism that is none, no values.
JointCommand joint_command_of(const touchstone_world& world, const touchstone_joint_command& command);

/// Keeps what a frame's report says of slides that were cut off and of hands.
void keep_hands(touchstone_world& world, const FrameReport& report);
/// A frame's report, its events kept by the world until the next.
touchstone_report kept_report(touchstone_world& world, const FrameReport& report);

/// @throws InputError: names, but no array, or one that is NULL. @param what the array's name in the header.
std::vector<std::string> names_of(const char* const* names, std::size_t count, const char* what);
/// @throws InputError: values, but no array.
std::vector<double> values_of(const double* values, std::size_t count, const char* what);

/// Options into what they are about. @throws InputError: what is NULL, though it is counted.
void take_options(const touchstone_mechanism_options& options, MechanismDescription& description,
                  MechanismPlacement& placement);
/// Adds a mechanism that is described, in that place. @throws InputError as ContactWorld::add_mechanism().
touchstone_mechanism add_mechanism(touchstone_world& world, MechanismDescription description,
                                   MechanismPlacement placement, const touchstone_pose& X_WB);

}  // namespace touchstone::c_interface
