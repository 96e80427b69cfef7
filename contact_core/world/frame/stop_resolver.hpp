#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/world/frame/followers.hpp"
#include "touchstone/contact_core/world/frame/moment_log.hpp"
#include "touchstone/contact_core/world/frame/stop_permits.hpp"
#include "touchstone/contact_core/world/frame/stop_queue.hpp"
#include "touchstone/contact_core/world/model/world_model.hpp"

namespace touchstone {

/// Decides which pairs stop which movers, in one part of a frame.
///
/// It works in rounds: all pairs that meet first stop their movers; then the other pairs of these movers are
/// asked again when they meet, until no pair is open. Results do not depend on the order of pairs. A pair
/// that holds takes its movers back to their start: stops that they had caused by then came from a motion
/// that is not executed, so the rounds begin again without it.
class StopResolver {
 public:
  struct Scope {
    WorldModel& model;  ///< its stops are written
    NarrowphaseQuery& query;
    std::span<const std::uint32_t> movers;  ///< roots
    const Followers& followers;
    StopPermits& permits;
    MomentLog& moments;
  };

  /// @param anew nothing has stopped yet.
  void take_room(std::size_t slots, std::size_t solids, bool anew);
  /// @param among pairs by solids, with their impacts on the paths that are laid.
  void resolve(const Scope& scope, std::span<FramePair> among, std::uint32_t part);

 private:
  void begin(const Scope& scope, std::span<const FramePair> among);
  void queue_open(std::span<const FramePair> among);
  bool settle(const Scope& scope, std::span<FramePair> among, double least, std::uint32_t part);
  bool stop_movers(const Scope& scope, const FramePair& pair);
  void stop_together(const Scope& scope, std::uint32_t root, double target);
  void recheck(const Scope& scope, std::uint32_t root, std::span<FramePair> among);
  void begin_again(const Scope& scope, std::span<FramePair> among);

  StopQueue queue_;
  std::vector<std::uint32_t> restopped_;    // roots whose pairs are to be asked again
  GrowingList<std::uint8_t> is_restopped_;  // by slot
  GrowingList<std::uint8_t> is_held_;       // by slot; a root's: a pair that holds took it back to its start
  bool took_back_ = false;                  // a pair that holds did, in these rounds
};

}  // namespace touchstone
