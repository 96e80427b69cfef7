#pragma once

#include <string>
#include <vector>

#include "touchstone/adapters/scene_files/scene_file.hpp"
#include "touchstone/adapters/scene_files/yaml_reader.hpp"
#include "touchstone/contact_core/mechanism/mechanism.hpp"

// Private to this folder: what the readers of a scene file share.

namespace touchstone::scene_files {

inline std::string in_quotes(const std::string& name) { return "'" + name + "'"; }

/// Fails at the reader's place unless the value is above 0.
double read_positive(const YamlReader& reader, double value);

/// Sets the source's factors; returns the text for the scene.
std::string read_units(const YamlReader& root, YamlSource& source);

/// Sets the source's parameters: the file's own, replaced by those given.
/// @throws InputError: one given that the file has not, or that is not finite.
void read_parameters(const YamlReader& root, const SceneParameters& given, YamlSource& source);

Mechanism read_arm_model(const YamlReader& reader);  ///< by YamlSource::arm_models
/// Joint values: turns as the file's angles, shifts as its lengths. As many as the list has: their number is
/// for the caller to check.
std::vector<double> read_joint_values(const YamlReader& list, const Mechanism& mechanism);
ContactPolicy read_policy(const YamlReader& reader);
Passive read_passive(const YamlReader& reader);
bool read_choice(const YamlReader& reader);  ///< true or false
/// A list of rules, as Scene::rules.
std::vector<SceneRule> read_rules(const YamlReader& reader, const Scene& scene);

/// A list of pairs of names, each of an object, `object/hexahedron` or a group of the scene.
std::vector<ExemptPair> read_exempt_pairs(const YamlReader& reader, const Scene& scene);
/// A list of latches, added to Scene::latches. @throws InputError: validate_latch()
void read_latches(const YamlReader& reader, Scene& scene);

}  // namespace touchstone::scene_files
