#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/motion/clear_stretch.hpp"
#include "touchstone/contact_core/world/world_state.hpp"

// Which pairs slides have to look at: those of the watched pairs (world_travel.cpp) that are not known to
// stay apart. What a plan leaves out stops no motion later than it may: every sub-step's path is checked
// against all of them.

namespace touchstone {
namespace {

/// Rounding of distances and of poses.
constexpr double kUp = 1.0 + 0x1p-20;
/// Rounds sums of travels down.
constexpr double kDown = 1.0 - 0x1p-50;

}  // namespace

void ContactWorld::State::find_slide_pairs() {
  std::fill(travels.needed.begin(), travels.needed.end(), 0.0);
  for (const Slider& slider : slides.sliders)
    if (slider.arm == nullptr && !slider.done) need_watch_of(slider);
  slides.pairs.clear();
  if (is_watch_due()) watch_pairs();
  slides.pair_of.assign(watched.size(), SlideState::kNone);
  slides.is_near.assign(watched.size(), 0);
  gather_slide_pairs();
}

/// A rigid body plans with all that it could reach: as the distance to its goal never grows, it goes no
/// further than there and beyond by the same.
void ContactWorld::State::need_watch_of(const Slider& slider) {
  const std::pair<std::uint32_t, std::uint32_t> first{slider.root, 0};
  for (auto member = std::lower_bound(members.begin(), members.end(), first);
       member != members.end() && member->first == slider.root; ++member) {
    const std::uint32_t i = member->second;
    for (SolidIndex solid = layout.first_solid[i]; solid < layout.first_solid[i + 1]; ++solid) {
      // watch_pairs() takes the last path, gone by now, from its reserve.
      const double needed = 2.0 * (slide_reach(slider, solid, solid) + travels.last_solid[solid]);
      travels.needed[solid] = needed;
      if (travels.of_solid[solid] + needed > travels.solid_limit[solid]) note_due(i);
    }
  }
}

/// An arm alone meets lively pairs only (see measure_plan()); rigid bodies plan with all that they could
/// reach.
void ContactWorld::State::gather_slide_pairs() {
  slides.met.clear(), slides.by_root.clear();
  if (slides.sliders.size() == 1 && slides.sliders[0].arm != nullptr) {
    if (needs_lively) choose_lively();
    const std::uint32_t root = slides.sliders[0].root;
    for (const std::uint32_t i : lively) {
      if (root_of(watched[i].a) != root && root_of(watched[i].b) != root) continue;
      slides.by_root.emplace_back(root, i);
      slides.met.push_back(i);
    }
    return;
  }
  const auto before = [&](std::uint32_t x, std::uint32_t y) { return watched.solids(x) < watched.solids(y); };
  for (const Slider& slider : slides.sliders) {  // by root
    const auto begin = static_cast<std::ptrdiff_t>(slides.by_root.size());
    for_each_member(slider.root, [&](std::uint32_t slot) {
      for (SolidIndex i = layout.first_solid[slot]; i < layout.first_solid[slot + 1]; ++i)
        watched.for_each_of(i, [&](std::uint32_t index) {
          // Of two solids of the slider's, the one that is a.
          const bool is_inner = root_of(watched[index].a) == root_of(watched[index].b);
          if (is_inner && watched[index].a != i) return;
          slides.by_root.emplace_back(slider.root, index);
          slides.met.push_back(index);
        });
    });
    std::sort(slides.by_root.begin() + begin, slides.by_root.end(),
              [&](const auto& x, const auto& y) { return before(x.second, y.second); });
  }
  std::sort(slides.met.begin(), slides.met.end(), before);
  slides.met.erase(std::unique(slides.met.begin(), slides.met.end()), slides.met.end());
}

/// Once paths are laid: those that go further than was looked ahead for have more to meet.
void ContactWorld::State::take_up_slide_pairs() {
  if (is_watch_due())
    watch_slide_pairs();
  else if (needs_lively && slides.sliders.size() == 1 && slides.sliders[0].arm != nullptr)
    gather_slide_pairs();
}

/// Asks the broadphase again within a frame.
void ContactWorld::State::watch_slide_pairs() {
  watch_pairs();
  slides.pair_of.assign(watched.size(), SlideState::kNone);
  slides.is_near.assign(watched.size(), 0);
  gather_slide_pairs();
  for (std::uint32_t i = 0; i < slides.pairs.size(); ++i) {
    const SolidPair& pair = slides.pairs[i].solids;
    slides.pairs[i].watch = SlideState::kNone;
    const std::uint32_t watch = watched.find(pair);
    if (watch == PairWatch::kNone) continue;
    slides.pairs[i].watch = watch;
    slides.pair_of[watch] = i;
  }
}

/// Its index in slides.pairs, or kNone where it is not checked.
std::uint32_t ContactWorld::State::take_in(std::uint32_t watch) {
  std::uint32_t& index = slides.pair_of[watch];
  const SolidPair pair{watched[watch].a, watched[watch].b};
  if (index == SlideState::kNone && is_checked(pair)) {
    index = static_cast<std::uint32_t>(slides.pairs.size());
    slides.pairs.push_back(frame_pair(pair));
    slides.pairs.back().watch = watch;
  }
  return index;
}

void ContactWorld::State::find_slide_impacts(FrameReport& report) {
  for (FramePair& pair : slides.pairs) {
    pair.is_settled = false;
    pair.impact.status = ImpactStatus::clear;
    pair.impact.queries = 0;  // of the sub-step before
  }
  ahead.clear(), close.clear();
  for (const std::uint32_t watch : slides.met) {
    const SolidPair solids{watched[watch].a, watched[watch].b};
    if (is_clear(watched[watch])) continue;
    if (!in_motion[root_of(solids.a)] && !in_motion[root_of(solids.b)]) continue;
    const std::uint32_t index = take_in(watch);
    if (index == SlideState::kNone) continue;
    close.push_back(index);
    if (watched[watch].own == kNotOwn) ahead.push_back(solids);
  }
  query->look_ahead(ahead, from);
  for (const std::uint32_t index : close) {
    if (!slides.meter.may_go_on()) return;  // nothing of this sub-step is executed
    FramePair& pair = slides.pairs[index];
    WatchedPair& watch = watched[pair.watch];
    pair.clear_until = watch.clear_until;
    pair.impact = impact_of(pair);
    watch.clear_until = pair.clear_until;
    if (pair.impact.queries > 0 &&
        !(pair.impact.start_separation - last_travel(pair.solids, pair.own) > pair.interest))
      slides.meter.add_pair();
    if (pair.impact.queries > 0) watch.axis_W = pair.impact.geometry.n_AB_W;
    if (pair.impact.status == ImpactStatus::iteration_limit) ++report.iteration_limits;
  }
}

Vector3 ContactWorld::State::slide_centre(const Slider& slider, SolidIndex solid) const {
  if (slider.arm != nullptr) return slider.arm->X_WL[objects[body_of(solid)].link].p;
  return transform(objects[slider.root].X_WO, slider.metric.centre);
}

/// How far a slider's solid can still go, as seen from the other one.
double ContactWorld::State::slide_reach(const Slider& slider, SolidIndex solid, SolidIndex other) const {
  const Vector3 centre_W = slide_centre(slider, solid);
  const Sphere& sphere = layout.solids[solid].bounding_sphere();
  const double furthest = norm(transform(from[solid], sphere.centre) - centre_W) + sphere.radius;
  if (slider.arm == nullptr) return kUp * slider.distance * (1.0 + slider.turn_rate() * furthest);
  return kUp * slider.distance *
         slider.arm->frame.reach(objects[body_of(solid)].link, other_link(slider, other), furthest,
                                 slider.arm->weights);
}

/// How far the solid that is not the slider's can still come; 0: it does not slide, or with the slider.
double ContactWorld::State::other_reach(const Slider& slider, const SolidPair& pair) {
  const auto [mover, obstacle] = mover_first(pair, slider.root);
  const Slider* other = slides.find(root_of(obstacle));
  if (other == nullptr || other == &slider || other->done) return 0.0;
  return slide_reach(*other, obstacle, mover);
}

/// How far the slider's side of a pair can still go.
double ContactWorld::State::reach_of_pair(const Slider& slider, const SolidPair& pair) {
  const auto [mover, obstacle] = mover_first(pair, slider.root);
  double reach = slide_reach(slider, mover, obstacle);
  if (root_of(obstacle) == slider.root) reach += slide_reach(slider, obstacle, mover);
  return reach;
}

void ContactWorld::State::add_near_pair(const Slider& slider, std::uint32_t source) {
  const FramePair& pair = slides.pairs[source];
  const auto [mover, obstacle] = mover_first(pair.solids, slider.root);
  const bool is_b = mover == pair.solids.b;
  NearPair near;
  near.centre_W = slide_centre(slider, mover);
  near.reach = reach_of_pair(slider, pair.solids);
  const double furthest = near.reach + other_reach(slider, pair.solids) + 2.0 * pair.gap;
  query->set_pair(pair.solids);
  PairGeometry geometry{};
  const PairStatus status =
      query->manifold(from[pair.solids.a], from[pair.solids.b], furthest, geometry, near.points);
  const bool has_geometry =
      status == PairStatus::separated || status == PairStatus::overlapping || status == PairStatus::undecided;
  if (!has_geometry || !(geometry.separation < furthest)) return;
  near.mover = &layout.solids[mover], near.obstacle = &layout.solids[obstacle];
  near.X_WM = from[mover], near.X_WB = from[obstacle];
  near.gap = pair.gap;
  near.source = source;
  near.separation = geometry.separation;
  near.n = is_b ? geometry.n_AB_W : Vector3(-geometry.n_AB_W);
  near.point_count = geometry.point_count;
  if (!is_b)
    for (int i = 0; i < near.point_count; ++i) std::swap(near.points[i].p_A_W, near.points[i].p_B_W);
  const Slider* other = slides.find(root_of(obstacle));
  const bool is_shared = other != nullptr && other != &slider && !other->done;
  near.share = is_shared ? share_of_pair(slider, *other, near) : 1.0;
  classify(near);
  slides.near.push_back(near);
  slides.meter.add_pair();
}

/// Of a rigid body: all that it could reach. Of an arm: all that is not known to be apart.
void ContactWorld::State::find_near_pairs(const Slider& slider) {
  slides.near.clear();
  if (slider.arm != nullptr) {
    std::fill(slides.is_near.begin(), slides.is_near.end(), std::uint8_t{0});
    std::fill(travels.planned_solid.begin(), travels.planned_solid.end(), 0.0);
    std::fill(travels.planned_own.begin(), travels.planned_own.end(), 0.0);
    add_pairs_in_way(slider);
    return;
  }
  const std::pair<std::uint32_t, std::uint32_t> first{slider.root, 0};
  for (auto entry = std::lower_bound(slides.by_root.begin(), slides.by_root.end(), first);
       entry != slides.by_root.end() && entry->first == slider.root; ++entry) {
    const WatchedPair& watch = watched[entry->second];
    const SolidPair pair{watch.a, watch.b};
    if (leader_of(root_of(pair.a)) == leader_of(root_of(pair.b))) continue;  // they go as one
    // At rest it has at least so much left.
    const double left = watch.clear_until - travelled(pair, watch.own);
    if (left > reach_of_pair(slider, pair) + other_reach(slider, pair)) continue;
    const std::uint32_t source = take_in(entry->second);
    if (source == SlideState::kNone || slides.pairs[source].rule.policy != ContactPolicy::slide) continue;
    if (!slides.meter.may_go_on()) return;
    add_near_pair(slider, source);
  }
}

/// Whether a pair that is taken in is further apart than `way` and what is of interest: then this is noted.
bool ContactWorld::State::stays_apart(std::uint32_t watch, double way) {
  if (query->judges_poses()) return false;  // what separations say is not what such a backend sees
  const FramePair& pair = slides.pairs[slides.pair_of[watch]];
  PairGeometry geometry{};
  query->set_pair(pair.solids);
  if (query->separation(from[pair.solids.a], from[pair.solids.b], geometry) != PairStatus::separated)
    return false;
  // The gap is far more than separations and sums round.
  const double room = geometry.separation - pair.interest - pair.gap;
  watched[watch].axis_W = geometry.n_AB_W;
  if (!(room > 0.0)) return false;
  double& clear_until = watched[watch].clear_until;
  clear_until = std::max(clear_until, travelled(pair.solids, pair.own) * kDown + room);
  return room > way;
}

/// Whether a pair that is taken in stays apart on an arm's plan, the path that is laid, along the axis that
/// parted it last: a link that goes by close to a face would be near by how far it goes.
bool ContactWorld::State::is_passed_by(const Slider& slider, const FramePair& pair) {
  const WatchedPair& watch = watched[pair.watch];
  if (query->judges_poses() || slides.sliders.size() > 1 || watch.axis_W == Vector3::Zero()) return false;
  const auto [a, b] = pair.solids;
  MovingSolid first = moving_solid(a), second = moving_solid(b);
  if (pair.own != kNotOwn) {
    const std::uint32_t link = objects[body_of(a)].link;
    first = seen_from(link, a), second = seen_from(link, b);
    first.travel = 0.0, second.travel = travels.planned_own[pair.own];
  } else {
    first.travel = travels.planned_solid[a], second.travel = travels.planned_solid[b];
  }
  first.stop = root_of(a) == slider.root ? 1.0 : 0.0;
  second.stop = root_of(b) == slider.root ? 1.0 : 0.0;
  return stays_apart_along(first, second, watch.axis_W, pair.interest);
}

/// Takes up what an arm's plan could bring together. @returns whether there is any.
bool ContactWorld::State::add_pairs_in_way(const Slider& slider) {
  const std::size_t before = slides.near.size();
  ahead.clear(), close.clear();
  const std::pair<std::uint32_t, std::uint32_t> first{slider.root, 0};
  for (auto entry = std::lower_bound(slides.by_root.begin(), slides.by_root.end(), first);
       entry != slides.by_root.end() && entry->first == slider.root; ++entry) {
    const WatchedPair& watch = watched[entry->second];
    const SolidPair pair{watch.a, watch.b};
    const double planned = watch.own != kNotOwn
                               ? travels.planned_own[watch.own]
                               : travels.planned_solid[watch.a] + travels.planned_solid[watch.b];
    const bool meets_slider = slides.sliders.size() > 1 && other_reach(slider, pair) > 0.0;
    const double way = meets_slider ? planned + other_reach(slider, pair) : planned;
    if (travelled(pair, watch.own) + way <= watch.clear_until || slides.is_near[entry->second]) continue;
    const std::uint32_t source = take_in(entry->second);
    if (source == SlideState::kNone) continue;
    FramePair& met = slides.pairs[source];
    if (is_apart_by_axis(watched[entry->second], met, travelled(pair, watch.own) * kDown, way)) continue;
    met.way = way;
    close.push_back(source), ahead.push_back(pair);
  }
  query->look_ahead(ahead, from);
  for (const std::uint32_t source : close) {
    const std::uint32_t watch = slides.pairs[source].watch;
    if (stays_apart(watch, slides.pairs[source].way) || is_passed_by(slider, slides.pairs[source])) continue;
    slides.is_near[watch] = 1;
    if (slides.pairs[source].rule.policy != ContactPolicy::slide) continue;
    if (!slides.meter.may_go_on()) return false;
    add_near_pair(slider, source);
  }
  return slides.near.size() > before;
}

bool ContactWorld::State::was_in_contact(const SolidPair& pair) const {
  const auto place = std::lower_bound(contacts.begin(), contacts.end(), pair,
                                      [](const ContactState& x, const SolidPair& y) { return x.solids < y; });
  return place != contacts.end() && place->solids == pair;
}

void ContactWorld::State::merge_slide_pairs() {
  const auto by_solids = [](const FramePair& a, const FramePair& b) { return a.solids < b.solids; };
  const std::size_t known = pairs.size();
  for (FramePair& met : slides.pairs)
    if (met.watch != SlideState::kNone) met.clear_until = watched[met.watch].clear_until;
  for (FramePair& met : slides.pairs) {
    const auto end = pairs.begin() + static_cast<std::ptrdiff_t>(known);
    const auto place = std::lower_bound(pairs.begin(), end, met, by_solids);
    if (place != end && place->solids == met.solids) {
      place->impact.is_far = false;
      if (place->stop == kNoMoment) place->stop = met.stop;
      if (place->touch == kNoMoment) place->touch = met.touch;
      continue;
    }
    // What is known to be further apart than anything of interest has nothing to report.
    const bool is_apart = travelled(met.solids, met.own) <= met.clear_until;
    if (is_apart && !met.has_moment() && !was_in_contact(met.solids)) continue;
    met.impact.is_far = false;
    met.impact.starts_overlapping = false;  // a sub-step's start is not the frame's
    pairs.push_back(met);
  }
  std::sort(pairs.begin(), pairs.end(), by_solids);
}

}  // namespace touchstone
