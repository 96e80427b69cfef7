#pragma once

#include <span>

#include "touchstone/contact_core/broadphase/broadphase.hpp"
#include "touchstone/contact_core/world/frame/executed_parts.hpp"
#include "touchstone/contact_core/world/frame/followers.hpp"
#include "touchstone/contact_core/world/frame/moment_log.hpp"
#include "touchstone/contact_core/world/frame/movers.hpp"
#include "touchstone/contact_core/world/frame/stop_resolver.hpp"
#include "touchstone/contact_core/world/frame/watched_pairs.hpp"
#include "touchstone/contact_core/world/model/frame_lanes.hpp"
#include "touchstone/contact_core/world/model/world_model.hpp"

namespace touchstone {

/// Executes a part of a frame: the parts that every path goes through, commanded or planned by a slide.
struct FrameScope {
  WorldModel& model;
  Broadphase& broadphase;
  FrameLanes& lanes;
  WatchedPairs& watched;
  Movers& movers;
  Followers& followers;
  StopResolver& stops;
  MomentLog& moments;
  ExecutedParts& parts;
  std::span<const ContactState> contacts;  ///< as the frame began, by solids

  NarrowphaseQuery& query() const { return lanes.first(); }
};

}  // namespace touchstone
