#pragma once

#include <filesystem>
#include <string>

#include "touchstone/adapters/robots/robot.hpp"

/// @file
/// Robots from SDF (SDFormat 1.4 to 1.11), read by TinyXML-2. Set-up only; several threads may read at once.

namespace touchstone::sdf {

/// Reads the first `<model>` of an SDF file, in `<sdf>` or a `<world>`: its links' `<collision>`s and its
/// joints, fixed, revolute, continuous and prismatic. A link's frame is that of the joint that moves it.
/// Poses may be `relative_to` links, joints and frames. Axes are in the joint's frame, in 1.4 in the model's,
/// or in the one that `expressed_in` names. Joint values and limits are the file's; the reference is what is
/// nearest to 0 within them. `world` as a parent is a link without solids. The first link without a joint
/// above it is held. Models in the model, and those that `<include>` brings, are part of it: their links and
/// joints are named `model::link`, merged ones as they are. An include's `uri` is `model://NAME` (its
/// folder's model.config names the file), `package://`, `file://`, or a file or folder beside the file; names
/// of meshes are looked for beside the file that has them.
/// @throws InputError, one line `file:line: element 'x': reason`: no XML, no model, an included file that is
/// not there, leaves its package or includes itself, a placement frame, other joints, mimic joints unless
/// the options free them, planes and other shapes, frames that are not there or go round in a ring, and as
/// the readers of shapes.
Robot load_robot(const std::filesystem::path& file, const RobotOptions& options = {});
/// @param source stands in messages for the file's name; relative names are looked for beside it.
Robot parse_robot(const std::string& xml, const std::string& source = "sdf",
                  const RobotOptions& options = {});

}  // namespace touchstone::sdf
