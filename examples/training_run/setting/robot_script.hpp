#pragma once

#include "touchstone/adapters/scene_files/script_file.hpp"

namespace touchstone::training {

/// A flight for a robot that comes without a scene: it stands in the middle of its joints' limits (at its
/// reference where there are none), bent where its hand would be near a singularity there, links and block
/// apart where that is found, with a block before the link that most joints move, a twentieth of its
/// reach away in a direction that one of its joints takes it, where the block is freest of other links.
/// The hand goes that way at a tenth of the reach a second for 1.5 s, so that it meets the block, back, and
/// to either side; as much slower and longer as keeps the joint to half its rate. @throws InputError: no
/// joint that moves a link with hexahedra.
Script robot_script(const MechanismDescription& robot);

}  // namespace touchstone::training
