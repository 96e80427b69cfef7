#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/scene/scene.hpp"

namespace touchstone {

/// The global indices of the solids that `name` means: an object, `object/hexahedron`, or a group. Ascending.
/// @throws InputError when it means nothing in the scene.
std::vector<SolidIndex> find_solids(const Scene& scene, std::string_view name);

/// A scene flattened for the checks: solids counted through the objects' trees in order, as a Broadphase
/// counts them. Immutable after construction; const use from several threads is safe.
class SceneInstance {
 public:
  /// Keeps pointers into `scene`, which must outlive it and not change.
  /// @throws InputError as validate(scene).
  explicit SceneInstance(const Scene& scene);
  explicit SceneInstance(Scene&&) = delete;

  const Scene& scene() const { return *scene_; }
  std::span<const HexahedronTree* const> trees() const { return trees_; }
  /// In global order, for Narrowphase::build.
  std::span<const Hexahedron> solids() const { return solids_; }
  std::uint32_t object_of(SolidIndex solid) const { return object_of_[solid]; }
  SolidIndex first_solid(std::uint32_t object) const { return first_solid_[object]; }
  /// `object/hexahedron`.
  std::string solid_name(SolidIndex solid) const;

  /// The commanded pose X_WS of every solid, with its carrier where it has one, at `time` [s]. No allocation.
  /// @pre out.size() == solids().size()
  void poses_at(double time, std::span<Pose> out) const;

  /// True for solids of one object or of objects latched together and for exempted pairs, in either order. No
  /// allocation.
  bool is_exempt(SolidIndex a, SolidIndex b) const;
  /// The exempted pairs of solids of different objects, those that a latch allows among them: a scene's
  /// latches hold from its start to its end. a < b, ascending.
  std::span<const SolidPair> exempt_pairs() const { return exempt_pairs_; }
  /// The pairs of solids of different objects that `pair` names, a < b, ascending.
  /// @throws InputError as find_solids().
  std::vector<SolidPair> solids_of(const ExemptPair& pair) const;
  /// Every pair that is checked, a < b, ascending.
  std::vector<SolidPair> checked_pairs() const;

 private:
  const Scene* scene_;
  std::vector<const HexahedronTree*> trees_;
  std::vector<Hexahedron> solids_;
  std::vector<std::uint32_t> object_of_;
  std::vector<SolidIndex> first_solid_;
  std::vector<std::uint32_t> root_of_;  ///< of an object: what it moves with; itself, or what carries it
  std::vector<Pose> X_RO_;              ///< in its root; the identity for roots
  std::vector<SolidPair> exempt_pairs_;
};

}  // namespace touchstone
