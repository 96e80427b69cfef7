#pragma once

#include <memory>
#include <span>
#include <vector>

#include "touchstone/adapters/scene_files/script_file.hpp"
#include "touchstone/contact_core/mechanism/mechanism.hpp"

namespace touchstone::training {

/// An arm in a scene: each link with hexahedra is an object of it.
struct Arm {
  std::shared_ptr<const Mechanism> mechanism;
  Pose X_WB;                   ///< of the base
  std::vector<double> joints;  ///< at the start
  std::uint32_t flown_link;
  bool holds;               ///< see ArmScript
  std::size_t hand;         ///< that flies it
  std::size_t first_value;  ///< of its joint values among those of all arms
  std::uint32_t first_object, object_count;
  std::vector<std::uint32_t> object_of_link;  ///< kNone: no hexahedra
  std::vector<std::uint32_t> link_of_object;  ///< from first_object on
  std::vector<std::uint32_t> held_values;     ///< see ArmScript::held_joints
  /// Of joints in slides (MechanismPlacement): 1, jaws and other shifts that no hand drives less, held ones
  /// more.
  std::vector<double> weights;
};

/// Adds the links of all arms that hands fly to the script's scene, and the pairs that they exempt.
/// @throws InputError: an unknown model or link, joint values that do not fit, or out of limits.
std::vector<Arm> add_arms(Script& script);

/// The same arm held by another link, where that is. Objects, joint values and weights keep their places.
/// @param joints its values now. @throws InputError: no such link.
Arm held_by(const Arm& arm, std::uint32_t base, const Pose& X_WB, std::uint32_t flown_link,
            std::span<const double> joints);

}  // namespace touchstone::training
