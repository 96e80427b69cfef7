#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/memory/record_list.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/contact_core/world/objects/object_levels.hpp"

namespace touchstone {

inline constexpr std::uint32_t kAllSolids = 0xffffffff;
/// An Exemption looked up.
struct SolidExemption {
  ObjectHandle a, b;               ///< a < b
  std::uint32_t solid_a, solid_b;  ///< within their trees; kAllSolids: any
  ObjectHandle carried;            ///< it ends with that one's latch; none: with unexempt()

  friend auto operator<=>(const SolidExemption&, const SolidExemption&) = default;
};

struct ObjectRecord {
  ObjectDescription description;  ///< its tree stays after the object, until the slot is used again
  std::shared_ptr<const ObjectLevels> levels;  ///< null: its hexahedra are always looked at one by one
  std::uint32_t generation = 0;
  bool alive = false;
  Pose X_WO;  ///< actual
  Pose commanded;
  std::uint32_t carrier = kNoIndex;  ///< slot it is latched to, or none
  std::uint32_t body = 0;  ///< slot of what it is rigid with: itself, or the end of its chain of carriers
  std::uint32_t root = 0;  ///< slot of what it moves with: its body, or its body's mechanism's lead
  std::uint32_t mechanism = kNoIndex;      ///< index of the mechanism that it is a link of, or none
  std::uint32_t link = 0;                  ///< of that mechanism
  std::uint32_t lead = 0;                  ///< the slot that stands for the whole mechanism
  std::uint64_t groups = 0;                ///< bit per group
  std::uint32_t first_carried = kNoIndex;  ///< slot of one that is latched to it, or none; of that one's
  std::uint32_t next_carried = kNoIndex;   ///< carrier, the next one
  std::vector<SolidExemption> exemptions;  ///< that name it
  std::vector<SolidExemption> allowed;     ///< that end with its latch

  const std::string& name() const { return description.tree->name(); }
  bool is_static() const { return description.is_static; }
  bool is_root(std::uint32_t slot) const { return root == slot; }
  bool is_link() const { return mechanism != kNoIndex; }
};

/// Changes of the objects since they were last taken up, each slot named once. Its size is bounded: beyond
/// that many exemptions `all` is set, and the rest has no meaning.
struct TableChanges {
  static constexpr std::size_t kMostExemptions = 4096;
  struct ExemptionChange {
    SolidExemption exemption;
    bool is_on;
  };

  std::vector<std::uint32_t> replaced;      ///< slots whose object came or went
  std::vector<std::uint32_t> moved;         ///< slots of objects that reset() put back
  std::vector<std::uint32_t> rebodied;      ///< slots of objects that move with another body, or their own
  std::vector<ExemptionChange> exemptions;  ///< in order
  bool all = false;

  bool empty() const {
    return !all && replaced.empty() && moved.empty() && rebodied.empty() && exemptions.empty();
  }
};

/// The objects by slot, their groups, exemptions and latches (the paper's Object_manager).
class ObjectTable {
 public:
  /// Whatever it throws, also where memory ends, changes nothing.
  ObjectHandle add(ObjectDescription description);
  void remove(ObjectHandle object);
  void exempt(const Exemption& pair);
  void unexempt(const Exemption& pair);
  void latch(ObjectHandle carrier, ObjectHandle carried, std::span<const Exemption> allowed);
  void unlatch(ObjectHandle carried);
  /// All stand where they stood first, and no latch is left.
  void reset() noexcept;

  const TableChanges& changes() const { return changes_; }
  /// The changes were taken up.
  void forget_changes();

  bool is_alive(ObjectHandle object) const;
  /// Whether it is alive, not static, not carried, and no link.
  bool may_move(ObjectHandle object) const;
  /// @throws InputError.
  std::uint32_t slot_of(ObjectHandle object) const;
  ObjectHandle handle(std::uint32_t slot) const { return {slot, records_[slot].generation}; }
  ObjectHandle find(std::string_view name) const;
  /// The groups' indices; new ones where the names are. @throws InputError: a 65th group, a name that is too
  /// long; no name is taken up then.
  std::vector<std::uint32_t> groups(std::span<const std::string> names);
  /// The groups of two names; does not allocate where both are known.
  std::pair<std::uint32_t, std::uint32_t> groups_of(std::string_view first, std::string_view second);
  std::optional<std::uint32_t> find_group(std::string_view name) const;
  std::size_t group_count() const { return group_names_.size(); }
  /// @pre no object that is alive, and no rule, is of these.
  void forget_groups_from(std::size_t first) noexcept;

  std::uint32_t size() const { return static_cast<std::uint32_t>(records_.size()); }
  ObjectRecord& operator[](std::uint32_t slot) { return records_[slot]; }
  const ObjectRecord& operator[](std::uint32_t slot) const { return records_[slot]; }
  const std::set<SolidExemption>& exemptions() const { return exemptions_; }
  /// X_BO of each slot in its body; the identity for bodies.
  const GrowingList<Pose>& poses_in_body() const { return X_BO_; }
  /// Makes an object a link; `lead` stands for all links of its mechanism.
  void make_link(ObjectHandle object, std::uint32_t mechanism, std::uint32_t link, std::uint32_t lead);
  /// Removes a link, as remove() does an object. @pre check_removable().
  void remove_link(ObjectHandle object) noexcept;
  /// @throws InputError if it carries another, is carried, or is gone.
  void check_removable(ObjectHandle object) const;

  /// In a group; some may be gone.
  std::span<const ObjectHandle> members_of_group(std::uint32_t group) const { return group_members_[group]; }

 private:
  void find_bodies(std::uint32_t slot) noexcept;
  std::uint32_t after_in_chain(std::uint32_t slot, std::uint32_t first) const noexcept;
  void note(std::vector<std::uint32_t>& slots, std::uint32_t slot, std::uint8_t flag) noexcept;
  void note(const SolidExemption& exemption, bool is_on) noexcept;
  bool add_exemption(const SolidExemption& exemption);
  void drop_exemption(const SolidExemption& exemption) noexcept;
  void make_room_in_group(std::uint32_t group);
  std::uint32_t slot_for(const ObjectRecord& object) const;
  void make_room_for(const ObjectRecord& object, std::uint32_t slot);
  ObjectHandle put(ObjectRecord&& object, std::uint32_t slot) noexcept;
  std::uint32_t group(std::string_view name);
  void check_latch(std::uint32_t carrier, std::uint32_t carried) const;
  void unlink(std::uint32_t carried) noexcept;
  SolidExemption find(const Exemption& pair, ObjectHandle carried) const;

  RecordList<ObjectRecord> records_;
  std::map<std::string_view, std::uint32_t> slot_of_name_;  // names are the records' own; never hashed anew
  struct FreeSlots {
    std::vector<std::uint32_t> slots;  // a heap, the least one first; it has room for all that are alike
    std::size_t count = 0;             // of these, free or not
  };
  /// By the number of their solids, and whether they have levels.
  std::map<std::pair<std::size_t, bool>, FreeSlots> free_slots_;
  GrowingList<Pose> X_BO_;
  GrowingList<Pose> X_CO_;  // in the carrier, as latched
  std::vector<std::string> group_names_;
  std::vector<std::vector<ObjectHandle>> group_members_;
  std::set<SolidExemption> exemptions_;
  TableChanges changes_;
  GrowingList<std::uint8_t> is_noted_;  // by slot: in which lists of changes_
};

/// The objects flattened for the checks: solids counted through the objects in the order of their slots. One
/// that went keeps its solids' indices until another with as many takes its slot: nothing else is renumbered.
struct Layout {
  GrowingList<ObjectHandle> handles;    ///< by slot; none: it is gone
  GrowingList<SolidIndex> first_solid;  ///< by slot, and one more
  GrowingList<std::uint32_t> slot_of;   ///< by solid
  GrowingList<Hexahedron> solids;
  GrowingList<Pose> X_OS;
  GrowingList<const HexahedronTree*> trees;
  GrowingList<const ObjectLevels*> levels;  ///< by slot; null: none
  // Broadphases see proxies: an object's hexahedra, or one box about an object with levels.
  GrowingList<const HexahedronTree*> proxy_trees;
  GrowingList<SolidIndex> first_proxy;       ///< by slot, and one more
  GrowingList<std::uint32_t> slot_of_proxy;  ///< by proxy
  GrowingList<std::uint8_t> is_static;
  std::vector<SolidPair> exempt;  ///< sorted; one as often as exemptions name it

  std::uint32_t slots() const { return static_cast<std::uint32_t>(handles.size()); }
  bool is_alive(std::uint32_t slot) const { return handles[slot] != ObjectHandle{}; }
  bool is_exempt(const SolidPair& pair) const;
  /// @pre the slot has no levels.
  SolidIndex proxy_of(std::uint32_t slot, SolidIndex solid) const {
    return first_proxy[slot] + (solid - first_solid[slot]);
  }
  SolidIndex solid_of(std::uint32_t slot, SolidIndex proxy) const {
    return first_solid[slot] + (proxy - first_proxy[slot]);
  }
  SolidIndex first_solid_of(SolidIndex solid) const { return first_solid[slot_of[solid]]; }
  ObjectHandle handle_of(SolidIndex solid) const { return handles[slot_of[solid]]; }
  /// And for more, which come later.
  void reserve(std::size_t slots, std::size_t all_solids);
  /// Takes up the slot's object anew, or that it is gone. @pre the slot is laid out, or the next one.
  void put(const ObjectTable& objects, std::uint32_t slot);
  /// Sorted pairs, each once more or once less.
  void add_exempt(std::span<const SolidPair> pairs);
  void remove_exempt(std::span<const SolidPair> pairs);
  std::span<const Hexahedron> solids_of(std::uint32_t slot) const {
    return std::span(solids).subspan(first_solid[slot], first_solid[slot + 1] - first_solid[slot]);
  }
  /// Where a solid of another layout is in this one; none if its object is not.
  std::optional<SolidIndex> find(const Layout& other, SolidIndex solid) const;
};

/// All but its exempt pairs.
Layout make_layout(const ObjectTable& objects);
/// Those that an exemption names, ascending.
std::vector<SolidPair> exempt_pairs(const Layout& layout, const SolidExemption& exemption);

}  // namespace touchstone
