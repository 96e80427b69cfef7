#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/world/frame/moment_log.hpp"
#include "touchstone/contact_core/world/model/frame_lanes.hpp"
#include "touchstone/contact_core/world/model/world_model.hpp"
#include "touchstone/contact_core/world/pairs/frame_pairs.hpp"

namespace touchstone {

/// Whether two solids that were not in contact are in contact at their current poses.
bool touches(const WorldModel& model, NarrowphaseQuery& query, const FramePair& pair);

/// The pairs in contact from frame to frame, and the events that follow from how each pair stands at a
/// frame's end and from the moments that the frame's parts noted.
class ContactLog {
 public:
  void take_room(std::size_t solids);
  /// Forgets all contacts; none is reported as ended.
  void clear() { contacts_.clear(), left_.clear(); }
  /// Set-up renumbers solids in the same order: contacts follow their solids, and those of removed objects
  /// end with the next report().
  void renumber(const Layout& before, const Layout& next);
  /// The same where objects of single slots were removed or replaced. @param slots sorted.
  void end_of(const Layout& layout, std::span<const std::uint32_t> slots);

  /// The contacts at the end of the last frame, by solids.
  std::span<const ContactState> now() const { return contacts_; }

  /// Appends a frame's events of pairs, by solids, and takes up its contacts.
  /// @param pairs all that matter and all that were in contact, by solids.
  /// @param last_part the frame's last.
  void report(const WorldModel& model, FrameLanes& lanes, std::span<const FramePair> pairs,
              const MomentLog& moments, std::uint32_t last_part, std::vector<ContactEvent>& events);

 private:
  std::vector<ContactState> contacts_, contacts_before_;
  std::vector<ContactEvent> left_;               // ended with the removal of an object
  std::vector<SolidPair> ahead_;                 // of report(): what is asked about
  std::vector<SeparationMemo::Answer> answers_;  // the same: to those
};

}  // namespace touchstone
