#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"
#include "touchstone/contact_core/scene/motion.hpp"

/// @file
/// A scene as plain data: objects made of hexahedra, how they are commanded to move, and which pairs do not
/// matter. It holds no state of a run; SceneInstance (scene_instance.hpp) turns it into solids and poses at a
/// time.

namespace touchstone {

/// The response when a commanded step would bring a pair into contact. Recorded here; carried out by motion
/// modification.
enum class ContactPolicy : std::uint8_t {
  cue,      ///< report entry and exit, let it move
  hold,     ///< the paper's rule: the step is not executed
  advance,  ///< up to the contact
  slide,    ///< up to it, then along it
};
/// The enumerator's name, as scene files have it.
std::string_view to_string(ContactPolicy policy);

/// How an object without a command of its own responds to a rigid mover, or a link, that comes against it:
/// quasi-static. It is passive while it is not commanded, not static, no link, and carried by nobody.
enum class Passive : std::uint8_t {
  stays,    ///< it stays, and the mover stops or slides along it, by its policy
  shoved,   ///< where it stopped a mover it goes along for the rest of the frame, as one with the mover
  carried,  ///< it goes along from the frame's start if the two were in contact then; else as `shoved`
};
/// The enumerator's name, as scene files have it.
std::string_view to_string(Passive passive);

/// One rigid object: its hexahedra, initial pose and commanded motion.
struct SceneObject {
  HexahedronTree tree;  ///< tree.name() is the object's name
  Pose X_WO;            ///< initial pose
  Motion motion;
  std::vector<std::string> groups;  ///< names under which exemptions may refer to several objects at once
  /// Never moves: it is neither commanded nor carried nor shoved. Without a motion, and without a rule by
  /// which it may be shoved or carried, an object is static anyway.
  bool is_static = false;
  /// Coarser and coarser trees of the object: ObjectDescription::levels (world/contact_world.hpp).
  std::vector<std::shared_ptr<const HexahedronTree>> levels = {};
};

/// A rule of the pairs between two objects, or between the objects of two groups (the same one: within it).
/// Unset members are inherited as by PairRule (world/contact_world.hpp).
struct SceneRule {
  std::string first, second;  ///< an object or a group each
  std::optional<ContactPolicy> policy = {};
  std::optional<double> warn_distance = {};   ///< [m]
  std::optional<bool> translation_only = {};  ///< of `slide`
  std::optional<Passive> passive = {};
};

/// Two sets of solids that are not checked against each other. Each is named by an object,
/// `object/hexahedron`, or a group.
struct ExemptPair {
  std::string first;
  std::string second;
};

/// `carried` moves with `carrier` from the start on, as the two stand. What moves as one is never checked
/// against itself.
struct SceneLatch {
  std::string carrier;
  std::string carried;  ///< has no motion of its own
  /// Further pairs that are not checked while the latch holds, such as both jaws of a gripper against their
  /// payload.
  std::vector<ExemptPair> allowed;
};

/// A round part that the scene models by flat facets, and their error.
struct FacetFigure {
  std::string object;
  std::string hexahedron;  ///< the round part's name in its object
  int facets;
  bool inscribed;  ///< corners on the circle; otherwise the facets touch it (circumscribed)
  double radius;   ///< of the circle [m]
  double error;    ///< r (1 - cos(pi/n)) inscribed, r (1 / cos(pi/n) - 1) circumscribed [m]
};

/// A whole scene in SI units, not checked: see validate().
struct Scene {
  std::string name;
  std::string description;
  std::string units;         ///< as in the source it came from, for reports; all figures here are SI
  double frame_rate = 0.0;   ///< [Hz]
  double contact_gap = 0.0;  ///< g [m]
  double duration = 0.0;     ///< [s]
  ContactPolicy policy = ContactPolicy::hold;
  Passive passive = Passive::stays;
  std::vector<SceneObject> objects;  ///< solids of one object are never paired
  std::vector<SceneRule> rules;      ///< one that names an object comes first; else the one given last
  std::vector<ExemptPair> exempt_pairs;
  std::vector<SceneLatch> latches;
  std::vector<FacetFigure> facet_figures;
  std::map<std::string, double> parameters;  ///< the values this scene was made with

  /// Frames at times 0, 1/rate, ... up to and including the last that is <= duration (to rounding of duration
  /// * rate).
  std::uint64_t frame_count() const;
  double frame_time(std::uint64_t frame) const { return static_cast<double>(frame) / frame_rate; }
};

/// Stands for "none" where an object's index is returned.
inline constexpr std::size_t kNoObject = static_cast<std::size_t>(-1);

/// The object's index, or kNoObject.
std::size_t find_object(const Scene& scene, std::string_view name);
/// The index of what carries the object, or kNoObject.
std::size_t carrier_of(const Scene& scene, std::size_t object);
/// Objects of that name or in that group, ascending; none: it means nothing in the scene.
std::vector<std::size_t> find_objects(const Scene& scene, std::string_view name);
/// True for what may be shoved or carried off, by a rule or the scene's own `passive`: not static, without a
/// motion, and carried by nobody.
bool may_be_taken_along(const Scene& scene, std::size_t object);

/// @throws InputError naming the object and the figure: no name, no object, duplicate or ambiguous names, a
/// rate, gap or duration that is not positive and finite, a bad pose or motion, an exemption that names
/// nothing, a bad latch, a static object that moves or is carried, a bad rule.
void validate(const Scene& scene);

/// Latch `index` with those before it. @throws InputError: unknown objects, what is already carried or has a
/// motion of its own, a cycle, an allowed pair that names nothing.
void validate_latch(const Scene& scene, std::size_t index);

/// @throws InputError: a name that is neither an object's nor a group's, one object twice, a warn distance
/// that is no length, nothing set.
void validate_rule(const Scene& scene, const SceneRule& rule);

}  // namespace touchstone
