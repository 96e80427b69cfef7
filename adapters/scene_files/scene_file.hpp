#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "touchstone/contact_core/mechanism/mechanism.hpp"
#include "touchstone/contact_core/scene/scene.hpp"

namespace touchstone {

/// Values for a scene file's `parameters`, in the file's units; they replace the file's own.
using SceneParameters = std::map<std::string, double>;

/// Returns the arm that a file's `model` names: a bundled one, or a robot's file, relative to `folder`, which
/// is that of the YAML file. So programs choose the formats that they read, and this component links none of
/// them.
/// @throws InputError for what is neither.
using ArmModels =
    std::function<MechanismDescription(const std::string& model, const std::filesystem::path& folder)>;

/// Reads a scene file (YAML; the format is described in adapters/scene_files/README.md). Figures come out in
/// SI units.
/// @throws InputError, one line `file:line: object 'x': hexahedron 'y': reason`: unreadable or malformed
/// file, unknown or repeated key, repeated name, wrong type, a figure that is not finite, an unknown
/// parameter or reference, and whatever Hexahedron, HexahedronTree and validate(Scene) refuse.
Scene load_scene(const std::filesystem::path& path, const SceneParameters& parameters = {});

}  // namespace touchstone
