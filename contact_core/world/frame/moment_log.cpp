#include "touchstone/contact_core/world/frame/moment_log.hpp"

namespace touchstone {

std::uint32_t MomentLog::add(const WorldModel& model, NarrowphaseQuery& query, const FramePair& pair,
                             std::uint32_t part, double s) {
  PairGeometry geometry{};
  const bool is_known =
      pair.link_pair == kNoLinkPair && pair.impact.lo == s &&
      (pair.impact.status == ImpactStatus::blocked || pair.impact.status == ImpactStatus::iteration_limit);
  if (is_known) {
    geometry = pair.impact.geometry;
  } else {
    query.set_pair(pair.solids);
    query.separation(model.moving_solid(pair.solids.a).pose_at(s),
                     model.moving_solid(pair.solids.b).pose_at(s), geometry);
  }
  moments_.push_back({part, s, geometry});
  return static_cast<std::uint32_t>(moments_.size() - 1);
}

void MomentLog::note_executed(const WorldModel& model, NarrowphaseQuery& query,
                              std::span<const ContactState> contacts, std::span<FramePair> among,
                              std::uint32_t part) {
  for (FramePair& pair : among) {
    if (pair.touch == kNoMoment) note_touch(model, query, contacts, pair, part);
    if (pair.stopped_at != kNotStopped && pair.stop == kNoMoment) {
      const bool is_touch = pair.touch != kNoMoment && moments_[pair.touch].part == part &&
                            moments_[pair.touch].s == pair.stopped_at;
      pair.stop = is_touch ? pair.touch : add(model, query, pair, part, pair.stopped_at);
    }
    pair.stopped_at = kNotStopped;
  }
}

void MomentLog::note_touch(const WorldModel& model, NarrowphaseQuery& query,
                           std::span<const ContactState> contacts, FramePair& pair, std::uint32_t part) {
  const Impact& impact = pair.impact;
  if (impact.queries == 0 || is_among(contacts, pair.solids)) return;
  const bool starts_close = impact.start_separation <= pair.gap && !query.judges_poses();
  const bool starts = starts_close || impact.starts_overlapping;
  const bool meets = pair.stopped_at != kNotStopped || impact.status != ImpactStatus::clear;
  if (!starts && !meets) return;
  const double s = starts ? 0.0 : pair.stopped_at != kNotStopped ? pair.stopped_at : impact.lo;
  const std::uint32_t moment = add(model, query, pair, part, s);
  // Where poses are judged, a pair under `cue` that goes on past the last clear pose is in contact from
  // there.
  const bool is_entry = query.judges_poses() && pair.rule.policy == ContactPolicy::cue;
  if (starts || is_entry || moments_[moment].geometry.separation <= pair.gap)
    pair.touch = moment;
  else
    moments_.pop_back();
}

void MomentLog::note_active(const WorldModel& model, NarrowphaseQuery& query,
                            std::span<const ContactState> contacts, std::span<FramePair> among,
                            std::uint32_t part) {
  for (FramePair& pair : among) {
    if (!pair.is_active || pair.stop != kNoMoment) continue;
    PairGeometry geometry{};
    query.set_pair(pair.solids);
    query.separation(model.from[pair.solids.a], model.from[pair.solids.b], geometry);
    if (!(geometry.separation <= 2.0 * pair.gap)) continue;
    pair.stop = static_cast<std::uint32_t>(moments_.size());
    moments_.push_back({part, 1.0, geometry});
    const bool touches = pair.touch == kNoMoment && geometry.separation <= pair.gap;
    if (touches && !is_among(contacts, pair.solids)) pair.touch = pair.stop;
  }
}

}  // namespace touchstone
