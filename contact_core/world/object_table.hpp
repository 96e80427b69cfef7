#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/world/contact_world.hpp"

namespace touchstone {

struct ObjectRecord {
  ObjectDescription description;
  std::uint32_t generation = 0;
  bool alive = false;
  Pose X_WO;  ///< actual
  Pose commanded;
  std::uint32_t carrier = 0xffffffff;  ///< slot it is latched to, or none
  std::uint32_t body = 0;  ///< slot of what it is rigid with: itself, or the end of its chain of carriers
  std::uint32_t root = 0;  ///< slot of what it moves with: its body, or its body's mechanism's lead
  std::uint32_t mechanism = 0xffffffff;  ///< index of the mechanism that it is a link of, or none
  std::uint32_t link = 0;                ///< of that mechanism
  std::uint32_t lead = 0;                ///< the slot that stands for the whole mechanism
  std::uint64_t groups = 0;              ///< bit per group

  const std::string& name() const { return description.tree->name(); }
  bool is_static() const { return description.is_static; }
  bool is_root(std::uint32_t slot) const { return root == slot; }
  bool is_link() const { return mechanism != 0xffffffff; }
};

inline constexpr std::uint32_t kAllSolids = 0xffffffff;
/// An Exemption looked up.
struct SolidExemption {
  ObjectHandle a, b;               ///< a < b
  std::uint32_t solid_a, solid_b;  ///< within their trees; kAllSolids: any
  ObjectHandle carried;            ///< it ends with that one's latch; none: with unexempt()

  friend auto operator<=>(const SolidExemption&, const SolidExemption&) = default;
};

/// The objects by slot, their groups, exemptions and latches (the paper's Object_manager).
class ObjectTable {
 public:
  ObjectHandle add(ObjectDescription description);
  void remove(ObjectHandle object);
  void exempt(const Exemption& pair);
  void unexempt(const Exemption& pair);
  void latch(ObjectHandle carrier, ObjectHandle carried, std::span<const Exemption> allowed);
  void unlatch(ObjectHandle carried);
  void reset();

  bool is_alive(ObjectHandle object) const;
  /// Alive, not static, not carried, no link.
  bool may_move(ObjectHandle object) const;
  /// @throws InputError.
  std::uint32_t slot_of(ObjectHandle object) const;
  ObjectHandle handle(std::uint32_t slot) const { return {slot, records_[slot].generation}; }
  ObjectHandle find(std::string_view name) const;
  /// The groups' indices; new ones where the names are. @throws InputError: a 65th group, a name that is too
  /// long; no name is taken up then.
  std::vector<std::uint32_t> groups(std::span<const std::string> names);
  std::optional<std::uint32_t> find_group(std::string_view name) const;

  std::uint32_t size() const { return static_cast<std::uint32_t>(records_.size()); }
  ObjectRecord& operator[](std::uint32_t slot) { return records_[slot]; }
  const ObjectRecord& operator[](std::uint32_t slot) const { return records_[slot]; }
  const std::set<SolidExemption>& exemptions() const { return exemptions_; }
  /// X_BO of each slot in its body; the identity for bodies.
  std::span<const Pose> poses_in_body() const { return X_BO_; }
  /// Makes an object a link; `lead` stands for all links of its mechanism.
  void make_link(ObjectHandle object, std::uint32_t mechanism, std::uint32_t link, std::uint32_t lead);
  /// Of a link, as remove().
  void remove_link(ObjectHandle object);
  /// @throws InputError if it carries another, is carried, or is gone.
  void check_removable(ObjectHandle object) const;

 private:
  void find_bodies();
  std::uint32_t group(std::string_view name);
  void check_latch(std::uint32_t carrier, std::uint32_t carried) const;
  SolidExemption find(const Exemption& pair, ObjectHandle carried) const;

  std::vector<ObjectRecord> records_;
  std::vector<Pose> X_BO_;
  std::vector<Pose> X_CO_;  // in the carrier, as latched
  std::vector<std::string> group_names_;
  std::set<SolidExemption> exemptions_;
};

/// The objects alive, flattened for the checks: solids counted through the objects in the order of their
/// slots.
struct Layout {
  std::vector<std::uint32_t> slots;
  std::vector<ObjectHandle> handles;    ///< one a slot of `slots`
  std::vector<SolidIndex> first_solid;  ///< one more than slots
  std::vector<std::uint32_t> slot_of;   ///< by solid
  std::vector<Hexahedron> solids;
  std::vector<Pose> X_OS;
  std::vector<const HexahedronTree*> trees;
  std::vector<std::uint8_t> is_static;
  std::vector<SolidPair> exempt;  ///< sorted; see exempt_pairs()

  bool is_exempt(const SolidPair& pair) const;
  std::uint32_t index_of_slot(std::uint32_t slot) const;
  SolidIndex first_solid_of(SolidIndex solid) const { return first_solid[index_of_slot(slot_of[solid])]; }
  ObjectHandle handle_of(SolidIndex solid) const { return handles[index_of_slot(slot_of[solid])]; }
  /// Where a solid of another layout is in this one; none if its object is not.
  std::optional<SolidIndex> find(const Layout& other, SolidIndex solid) const;
};

/// All but its exempt pairs.
Layout make_layout(const ObjectTable& objects);
/// Those of the table's exemptions, ascending.
std::vector<SolidPair> exempt_pairs(const ObjectTable& objects, const Layout& layout);

}  // namespace touchstone
