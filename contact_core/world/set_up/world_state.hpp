#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/threads/thread_team.hpp"
#include "touchstone/contact_core/world/frame/contact_log.hpp"
#include "touchstone/contact_core/world/frame/executed_parts.hpp"
#include "touchstone/contact_core/world/frame/followers.hpp"
#include "touchstone/contact_core/world/frame/frame_scope.hpp"
#include "touchstone/contact_core/world/frame/moment_log.hpp"
#include "touchstone/contact_core/world/frame/movers.hpp"
#include "touchstone/contact_core/world/frame/pair_finder.hpp"
#include "touchstone/contact_core/world/frame/selection_log.hpp"
#include "touchstone/contact_core/world/frame/stop_resolver.hpp"
#include "touchstone/contact_core/world/frame/watched_pairs.hpp"
#include "touchstone/contact_core/world/model/frame_lanes.hpp"
#include "touchstone/contact_core/world/model/world_model.hpp"
#include "touchstone/contact_core/world/slide/slides.hpp"

namespace touchstone {

/// A contact world's model and the parts that a frame goes through: see ContactWorld::frame(). Its functions
/// set these up (world_changes.cpp).
struct ContactWorld::State : WorldModel {
  std::unique_ptr<Broadphase> broadphase;
  bool needs_layout = true;   // all is to be built anew
  bool needs_places = false;  // the solids stay, but all is to be placed and watched anew
  double noted_margin = 0.0;  // wanted_margin() when set-up was taken up last [m]
  bool was_reset = false;     // since set-up was taken up
  bool is_fresh = true;       // set-up was taken up since the last frame

  // Taken up by prepare().
  std::unique_ptr<ThreadTeam> team;  // set_threads()'s; null: none
  FrameLanes lanes;

  // In the order in which a frame goes through them.
  std::uint64_t frame = 0;
  SelectionLog selections;
  Movers movers;
  Followers followers;
  WatchedPairs watched;
  PairFinder finder;
  StopResolver stop_resolver;
  ExecutedParts parts;
  Slides slides;
  ContactLog contact_log;

  // From part to part of one frame.
  GrowingList<FramePair> pairs;  // that matter, by solids
  MomentLog moments;
  std::vector<ContactEvent> events;

  GrowingList<Pose> answered_poses;  // by solid: solid_poses() of objects with levels

  FrameScope scope() {
    return {*this,     *broadphase,   lanes,   watched, movers,
            followers, stop_resolver, moments, parts,   contact_log.now()};
  }

  void take_loads();
  /// @throws InputError naming the tree's first rounded solid, where the narrowphase takes none.
  void check_takes(const HexahedronTree& tree) const;
  /// Takes up all set-up since the last time.
  void take_up_set_up();
  void build_all();
  void build_broadphase(const Layout& laid_out);
  double wanted_margin() const;
  void begin_anew();
  bool take_up_changes();
  void take_room(bool anew);
  bool replace_object(std::uint32_t slot);
  void raise_reach(std::uint32_t slot, double warn);
  void raise_reach_of_group(std::uint32_t first, std::uint32_t second);
};

}  // namespace touchstone
