#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/memory/reserve_more.hpp"
#include "touchstone/contact_core/world/model/world_model.hpp"
#include "touchstone/contact_core/world/pairs/frame_pairs.hpp"

namespace touchstone {

/// When in a frame pairs touched or stopped a mover, and how they stood then. Pairs name moments by index:
/// FramePair::stop and FramePair::touch. Allocates only where there are more than were reserved.
class MomentLog {
 public:
  void reserve(std::size_t moments) { reserve_more(moments_, moments); }
  void clear() { moments_.clear(); }
  const Moment& operator[](std::uint32_t index) const { return moments_[index]; }
  std::span<const Moment> all() const { return moments_; }

  /// Notes the pair's geometry at s of the paths that are laid, up to their stops so far. @returns its index.
  std::uint32_t add(const WorldModel& model, NarrowphaseQuery& query, const FramePair& pair,
                    std::uint32_t part, double s);
  /// Once a part is executed: the first stop and the first touch of each pair.
  /// @param contacts as the frame began, by solids.
  void note_executed(const WorldModel& model, NarrowphaseQuery& query, std::span<const ContactState> contacts,
                     std::span<FramePair> among, std::uint32_t part);
  /// Notes the pairs that hold back a sub-step's plan, at the poses at the end of `part`.
  void note_active(const WorldModel& model, NarrowphaseQuery& query, std::span<const ContactState> contacts,
                   std::span<FramePair> among, std::uint32_t part);

 private:
  void note_touch(const WorldModel& model, NarrowphaseQuery& query, std::span<const ContactState> contacts,
                  FramePair& pair, std::uint32_t part);

  std::vector<Moment> moments_;
};

}  // namespace touchstone
