#pragma once

#include <cstdint>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"

namespace touchstone {

/// Objects that go along with a link of a mechanism for a frame: see slide/shove.hpp.
class Rides {
 public:
  struct Ride {
    using MovesByBits = Ride;  ///< see kMovesByBits

    std::uint32_t lead = kNoIndex;  ///< slot that stands for the mechanism; none: it goes with no link
    std::uint32_t link = kNoIndex;  ///< MechanismMover::rigid_with of the link, by which it goes
    Pose X_LR;                      ///< of the object in the link

    friend class Rides;

   private:
    Pose X_WL_, X_WR_;  // where the last frame left the two
  };

  /// @param anew forgets all rides.
  void take_room(std::size_t slots, bool anew) {
    if (anew) rides_.clear();
    resize_more(rides_, slots);
  }
  /// The slot's object is new, or moves with another body.
  void forget(std::uint32_t root) { rides_[root] = {}; }

  /// The ride of a root, or null.
  const Ride* find(std::uint32_t root) const {
    return rides_[root].lead == kNoIndex ? nullptr : &rides_[root];
  }
  /// Begins a ride at the current poses. An object that stands where its last ride on the same link left it
  /// keeps its place in the link, so that a thousand rides round no more than one.
  void begin(std::uint32_t root, std::uint32_t lead, std::uint32_t link, const Pose& X_WL, const Pose& X_WR) {
    Ride& ride = rides_[root];
    const bool goes_on = ride.link == link && is_same(ride.X_WL_, X_WL) && is_same(ride.X_WR_, X_WR);
    if (!goes_on) ride.X_LR = compose(inverse(X_WL), X_WR);
    ride.lead = lead, ride.link = link;
  }
  /// Notes where a frame, or a part of it, left object and link. @pre it rides.
  void note_place(std::uint32_t root, const Pose& X_WL, const Pose& X_WR) {
    rides_[root].X_WL_ = X_WL, rides_[root].X_WR_ = X_WR;
  }
  void end(std::uint32_t root) { rides_[root].lead = kNoIndex; }

 private:
  GrowingList<Ride> rides_;  // by slot
};

}  // namespace touchstone
