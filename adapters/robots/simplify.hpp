#pragma once

#include <string>
#include <vector>

#include "touchstone/adapters/robots/robot.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone {

/// The same robot with links that fixed joints join made one: what hangs on a fixed joint becomes part of the
/// link nearer to the root, its solids named `link.solid`, its mass added about the common centre. So frames
/// without solids (flanges, tools, `world`) vanish, which dynamics have no use for. Exempt pairs of what
/// was moved are listed solid by solid. @throws InputError as Mechanism, whose tree it walks.
MechanismDescription without_fixed_joints(const MechanismDescription& robot);

/// Exempts every pair of links that has solids in contact in the reference pose, as covers coarser than their
/// meshes bring about, and returns a line for each: links, and by how deep they overlap there.
/// @throws InputError as Mechanism.
std::vector<std::string> exempt_reference_overlaps(MechanismDescription& robot, Narrowphase& narrowphase);

}  // namespace touchstone
