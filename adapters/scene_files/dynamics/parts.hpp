#pragma once

#include <string>

#include "touchstone/adapters/scene_files/scene_head.hpp"
#include "touchstone/physics/scene/dynamic_scene.hpp"

// Private to scene_files: readers of the parts of a scene file's `dynamics`, in the order in which they are
// read.

namespace touchstone::scene_files {

// ---- helpers

/// The node's file and line, as errors begin.
std::string where(const YamlReader& reader);
/// The same node, its errors prefixed by `what` alone.
YamlReader called(const YamlReader& reader, const std::string& what);
/// An object of the scene by its name.
std::size_t read_object(const YamlReader& reader, const Scene& scene);
double read_at_least_0(const YamlReader& reader, double value);
/// A figure of a joint: an angle where it turns, a length where it shifts.
double read_joint_figure(const YamlReader& reader, JointKind kind);

// ---- joints: mechanisms come first, since bodies, joints and actions name their links

void read_mechanisms(const YamlReader& dynamics, physics::DynamicScene& out);
/// A joint between two bodies.
void read_body_joint(const YamlReader& item, physics::DynamicScene& out);
/// A drive and its figures. @param reader has no other keys than a drive's and its owner's.
physics::SceneDrive read_drive(const YamlReader& reader, JointKind kind);
/// `mechanism.joint`, or the name of a joint between bodies.
physics::JointAddress read_joint_name(const YamlReader& reader, const physics::DynamicScene& scene);

// ---- bodies

void read_surface(const YamlReader& reader, physics::Surface& surface);
void read_bodies(const YamlReader& dynamics, physics::DynamicScene& out);
/// Rules by which figures of two surfaces combine, and pairs with figures of their own.
void read_pairs(const YamlReader& dynamics, physics::DynamicScene& out);

// ---- actions and answers

physics::SceneAction read_action(const YamlReader& item, const physics::DynamicScene& scene);
physics::SceneAnswer read_answer(const YamlReader& item, const physics::DynamicScene& scene);
void read_conserved(const YamlReader& reader, physics::DynamicScene& out);
void read_accept(const YamlReader& reader, physics::DynamicScene& out);

}  // namespace touchstone::scene_files
