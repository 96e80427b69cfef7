#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "contact_core/world/world_state.hpp"

// The slide policy: movers that slide pairs stopped go on towards their commanded poses in sub-steps. All of
// a sub-step are planned from the same poses, each for itself (a pair of two sliders shares its slack), then
// move together as in any frame: who is registered first does not matter.

namespace touchstone {
namespace {

/// A sub-step that brings no slider closer to its goal by this share of its distance at first is the last.
constexpr double kLeastGain = 0x1p-10;
/// What is planned is executed where it gains this share.
constexpr double kWorthwhile = 0x1p-30;
/// Of the room between two sliders neither gets less than this share, whatever they are told to do.
constexpr double kLeastShare = 0.125;
/// The square of the distance along a twist is a parabola but for terms of third order in its turn: it falls
/// throughout where it still falls from here to the end.
constexpr double kNearEnd = 0.875;
constexpr int kShortenings = 16;
constexpr double kShorter = 0.75;
/// Rounding of distances and of poses.
constexpr double kUp = 1.0 + 0x1p-20;

Twist twist_to(const Pose& X_WR, const Slider& slider) {
  const BodyState way = RigidPath::between(X_WR, slider.goal).at(0, 0.0);
  return {transform(slider.goal, slider.metric.centre) - transform(X_WR, slider.metric.centre),
          way.angular_velocity_W};
}

double distance_to_goal(const Pose& X_WR, const Slider& slider) {
  const Twist left = twist_to(X_WR, slider);
  return std::sqrt(inner_product(rotated(X_WR.R, slider.metric.J), left, left));
}

/// No turn of the slider is longer than this for each metre of distance in the metric [rad/m].
double turn_rate(const Slider& slider) { return 1.0 / std::sqrt(least_inertia(slider.metric.J)); }

/// How fast a slider would come along n if it went straight to its goal.
double rate_along(const Vector3& n, const Vector3& p_W, const Pose& X_WR, const Slider& slider) {
  const Twist way = twist_to(X_WR, slider);
  return dot(n, way.v + cross(way.w, p_W - transform(X_WR, slider.metric.centre)));
}

/// What a slider gets of the room between it and another one: by how fast each would come.
double share_of(double own_rate, double other_rate) {
  const double own = std::max(own_rate, 0.0), other = std::max(other_rate, 0.0);
  if (own == other) return 0.5;
  return std::clamp(own / (own + other), kLeastShare, 1.0 - kLeastShare);
}

JointVector joints_left(const MechanismMover& arm) {
  JointVector left{};
  for (std::size_t k = 0; k < arm.actual.size(); ++k) left[k] = arm.commanded[k] - arm.actual[k];
  return left;
}

bool turns_too_far(const CarriedPath& path, double stop) {
  return (1.0 - stop) * norm(path.carrier().at(0, 0.0).angular_velocity_W) > std::numbers::pi;
}

}  // namespace

void ContactWorld::State::prepare_slides() {
  const std::size_t slots = objects.size(), solids = layout.solids.size();
  slides.may_slide.assign(slots, 0);
  slides.translation_only.assign(slots, 0);
  slides.moments.clear();
  for (SolidIndex i = 0; i < solids; ++i)
    slides.moments.push_back(transform(layout.X_OS[i], mass_moments(layout.solids[i])));
  slides.sliders.reserve(slots);
  slides.sliders.clear();
  slides.slider_of.assign(slots, SlideState::kNone);
  slides.pairs.reserve(64 + 16 * solids);
  slides.by_root.reserve(128 + 32 * solids);
  slides.near.reserve(64 + 16 * solids);
  slides.rows.reserve(1024 + 8 * solids);
  slides.joint_rows.reserve(mechanisms.size() > 0 ? kMostSlideRows : 0);
  slides.parts.reserve((kMostSlideSteps + 1) * slots);
  std::size_t values = 0;
  for (std::uint32_t i = 0; i < mechanisms.size(); ++i)
    if (const MechanismMover* mover = mechanisms.at(i)) values += mover->actual.size();
  slides.joints.reserve((kMostSlideSteps + 1) * 2 * values);
}

void ContactWorld::State::rest(std::uint32_t root) {
  has_path[root] = 1;
  paths[root] = CarriedPath(RigidPath(objects[root].X_WO), objects.poses_in_body());
  if (MechanismMover* mover = mechanism_of(root)) mover->rest();
  in_motion[root] = 0;
}

void ContactWorld::State::record_parts(std::uint32_t part) {
  for (const std::uint32_t slot : movers) {
    if (!in_motion[slot]) continue;
    slides.parts.push_back(
        {slot, part, paths[slot], stops[slot], static_cast<std::uint32_t>(slides.joints.size())});
    const MechanismMover* mover = mechanism_of(slot);
    if (mover == nullptr) continue;
    const MechanismPath& path = mover->path;
    slides.joints.insert(slides.joints.end(), path.from().begin(), path.from().end());
    slides.joints.insert(slides.joints.end(), path.to().begin(), path.to().end());
  }
  slides.part_count = part + 1;
}

void ContactWorld::State::slide(FrameReport& report) {
  slides.parts.clear();
  slides.joints.clear();
  record_parts(0);
  if (!begin_slides()) return;
  find_slide_pairs();
  for (std::uint32_t step = 1; step <= kMostSlideSteps; ++step) {
    if (!plan_slides(report)) break;
    resolve_stops(slides.pairs);
    execute();
    record_parts(step);
    report.slide_steps = step;
    if (!finish_step()) break;
  }
  merge_slide_pairs();
}

bool ContactWorld::State::begin_slides() {
  for (const Slider& slider : slides.sliders) slides.slider_of[slider.root] = SlideState::kNone;
  slides.sliders.clear();
  for (const std::uint32_t slot : movers) {
    const double stop = stops[slot];
    MechanismMover* arm = mechanism_of(slot);
    const bool may_slide =
        arm != nullptr ? arm->actual.size() <= kMostSlideJoints : !turns_too_far(paths[slot], stop);
    if (stop < 1.0 && slides.may_slide[slot] && may_slide) {
      slides.slider_of[slot] = static_cast<std::uint32_t>(slides.sliders.size());
      slides.sliders.push_back({slot, stop, arm, paths[slot].carrier().to(), {}, {}, 0.0, 0.0});
      if (arm != nullptr) begin_joint_slide(slides.sliders.back());
    }
  }
  if (slides.sliders.empty()) return false;
  for (const std::uint32_t slot : movers) rest(slot);
  weigh_sliders();
  return true;
}

void ContactWorld::State::weigh_sliders() {
  for (std::uint32_t i = 0; i < layout.slots.size(); ++i) {
    Slider* slider = slides.find(objects[layout.slots[i]].root);
    if (slider == nullptr || slider->arm != nullptr) continue;
    MassMoments own;
    for (SolidIndex solid = layout.first_solid[i]; solid < layout.first_solid[i + 1]; ++solid)
      own += slides.moments[solid];
    slider->moments +=
        layout.slots[i] == slider->root ? own : transform(objects.poses_in_body()[layout.slots[i]], own);
  }
  for (Slider& slider : slides.sliders) {
    if (slider.arm == nullptr) slider.metric = mass_metric(slider.moments);
    slider.start_distance = slider.distance = distance_of(slider);
  }
}

double ContactWorld::State::distance_of(const Slider& slider) const {
  if (slider.arm == nullptr) return distance_to_goal(objects[slider.root].X_WO, slider);
  const JointVector left = joints_left(*slider.arm);
  return std::sqrt(joint_product(left, left, slider.arm->weights));
}

double ContactWorld::State::watched_until(const SolidPair& pair) const {
  const auto place = std::lower_bound(
      watched.begin(), watched.end(), pair,
      [](const WatchedPair& x, const SolidPair& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
  return place != watched.end() && place->a == pair.a && place->b == pair.b ? place->clear_until : kNotKnown;
}

void ContactWorld::State::find_slide_pairs() {
  // As the distance to the goal never grows, a slider stays within what it is now around its goal.
  // All others are where they are: what the broadphase knew was where they could be.
  for (const std::uint32_t i : movable) {
    const std::uint32_t slot = layout.slots[i];
    const Slider* slider = slides.find(objects[slot].root);
    for (SolidIndex solid = layout.first_solid[i]; solid < layout.first_solid[i + 1]; ++solid) {
      bulges[solid] = 0.0;
      to[solid] = from[solid];
      if (slider == nullptr) continue;
      if (slider->arm != nullptr) {
        bound_joint_slide(*slider, slot, solid);
        continue;
      }
      to[solid] = compose(compose(slider->goal, objects.poses_in_body()[slot]), layout.X_OS[solid]);
      const Vector3 centre_W = transform(to[solid], layout.solids[solid].bounding_sphere().centre);
      const double radius = norm(centre_W - transform(slider->goal, slider->metric.centre));
      const double turn = std::min(2.0, slider->distance * turn_rate(*slider));
      bulges[solid] = kUp * (slider->distance + turn * radius);
    }
  }
  broadphase->update_paths({to, to, bulges}, movable);
  slides.pairs.clear();
  slides.by_root.clear();
  PairCursor cursor;
  std::array<SolidPair, 256> block;
  while (!cursor.done) {
    const std::size_t count = broadphase->find_pairs(cursor, block);
    for (std::size_t i = 0; i < count; ++i) {
      if (!is_checked(block[i])) continue;
      const auto index = static_cast<std::uint32_t>(slides.pairs.size());
      bool met = false;
      for (const SolidIndex solid : {block[i].a, block[i].b}) {
        if (slides.find(root_of(solid)) == nullptr) continue;
        if (solid == block[i].b && root_of(block[i].a) == root_of(solid)) continue;  // an arm's own
        slides.by_root.emplace_back(root_of(solid), index);
        met = true;
      }
      if (!met) continue;
      slides.pairs.push_back(frame_pair(block[i]));
      slides.pairs.back().clear_until = watched_until(block[i]);
    }
  }
  std::sort(slides.by_root.begin(), slides.by_root.end());
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
  if (slider.arm == nullptr) return kUp * slider.distance * (1.0 + turn_rate(slider) * furthest);
  return kUp * slider.distance *
         slider.arm->frame.reach(objects[body_of(solid)].link, other_link(slider, other), furthest,
                                 slider.arm->weights);
}

double ContactWorld::State::share_of_pair(const Slider& slider, const Slider& other,
                                          const NearPair& near) const {
  if (slider.arm != nullptr || other.arm != nullptr) return 0.5;
  return share_of(-rate_along(near.n, near.points[0].p_B_W, objects[slider.root].X_WO, slider),
                  rate_along(near.n, near.points[0].p_A_W, objects[other.root].X_WO, other));
}

void ContactWorld::State::add_near_pair(const Slider& slider, const FramePair& pair, std::uint32_t source) {
  const auto [mover, obstacle] = mover_first(pair.solids, slider.root);
  const bool is_b = mover == pair.solids.b;
  NearPair near;
  near.centre_W = slide_centre(slider, mover);
  near.reach = slide_reach(slider, mover, obstacle);
  const Slider* other = slides.find(root_of(obstacle));
  if (other != nullptr && other->done) other = nullptr;
  if (other == &slider) near.reach += slide_reach(slider, obstacle, mover), other = nullptr;
  const double both = near.reach + (other != nullptr ? slide_reach(*other, obstacle, mover) : 0.0);
  // At rest it has at least so much left.
  if (pair.clear_until - travelled(pair.solids, pair.own) > both) return;
  query->set_pair(pair.solids);
  PairGeometry geometry{};
  const PairStatus status =
      query->manifold(from[pair.solids.a], from[pair.solids.b], both + 2.0 * pair.gap, geometry, near.points);
  const bool has_geometry =
      status == PairStatus::separated || status == PairStatus::overlapping || status == PairStatus::undecided;
  if (!has_geometry || !(geometry.separation < both + 2.0 * pair.gap)) return;
  near.mover = &layout.solids[mover], near.obstacle = &layout.solids[obstacle];
  near.X_WM = from[mover], near.X_WB = from[obstacle];
  near.gap = pair.gap;
  near.source = source;
  near.separation = geometry.separation;
  near.n = is_b ? geometry.n_AB_W : Vector3(-geometry.n_AB_W);
  near.point_count = geometry.point_count;
  if (!is_b)
    for (int i = 0; i < near.point_count; ++i) std::swap(near.points[i].p_A_W, near.points[i].p_B_W);
  near.share = 1.0;
  if (other != nullptr) near.share = share_of_pair(slider, *other, near);
  classify(near);
  slides.near.push_back(near);
}

void ContactWorld::State::find_near_pairs(const Slider& slider) {
  slides.near.clear();
  const std::pair<std::uint32_t, std::uint32_t> first{slider.root, 0};
  for (auto entry = std::lower_bound(slides.by_root.begin(), slides.by_root.end(), first);
       entry != slides.by_root.end() && entry->first == slider.root; ++entry) {
    const FramePair& pair = slides.pairs[entry->second];
    if (pair.rule.policy == ContactPolicy::slide) add_near_pair(slider, pair, entry->second);
  }
}

/// @param all the rows of pairs that are not sure too.
void ContactWorld::State::order_near_rows(bool all) {
  slides.rows.clear();
  for (const NearPair& near : slides.near)
    if (near.is_sure || all) add_rows(near, near.reach, slides.rows);
  order_rows(slides.rows);
}

void ContactWorld::State::mark_active(std::uint32_t row, double stop) {
  FramePair& pair = slides.pairs[slides.rows[row].source];
  if (!pair.has_blocked) pair.blocked_at = stop;
  pair.has_blocked = true;
}

RigidPath ContactWorld::State::plan_of(Slider& slider) {
  const Pose& X_WR = objects[slider.root].X_WO;
  const Matrix3 J_W = rotated(X_WR.R, slider.metric.J);
  Twist goal = twist_to(X_WR, slider);
  const bool translation_only = slides.translation_only[slider.root];
  if (translation_only) goal.w = Vector3::Zero();
  find_near_pairs(slider);
  const auto plan_with = [&](bool all) {
    order_near_rows(all);
    return plan_slide(goal, J_W, slides.rows, translation_only);
  };
  // Faces in contact first; then, along the motion that they leave, the planes of all that is near.
  SlidePlan plan = plan_with(false);
  for (int round = 0; round < kSlidePlaneRounds; ++round) {
    bool changed = round == 0;
    for (NearPair& near : slides.near)
      if (!near.is_sure && choose_plane(near, plan.twist)) changed = true;
    if (!changed) break;
    plan = plan_with(true);
  }
  for (int i = 0; i < plan.active.count; ++i) mark_active(plan.active.row[i], slider.stop);
  Twist step = plan.twist;
  for (int i = 0; i < kShortenings; ++i, step = kShorter * step) {
    const RigidPath path = RigidPath::by(X_WR, step.v, step.w, slider.metric.centre);
    const double end = distance_to_goal(path.to(), slider), gain = slider.distance - end;
    if (!(gain >= kWorthwhile * slider.start_distance && gain > 0.0)) continue;
    if (end <= distance_to_goal(path.pose_at(kNearEnd), slider)) return path;
  }
  return RigidPath(X_WR);
}

bool ContactWorld::State::plan_slides(FrameReport& report) {
  for (Slider& slider : slides.sliders) {
    if (slider.done) continue;
    stops[slider.root] = 1.0;
    if (slider.arm != nullptr)
      in_motion[slider.root] = plan_joints(slider);
    else
      paths[slider.root] = CarriedPath(plan_of(slider), objects.poses_in_body());
  }
  bool any = false;
  for (const Slider& slider : slides.sliders) {
    if (slider.arm == nullptr)
      in_motion[slider.root] = !slider.done && !paths[slider.root].carrier().at_rest();
    any = any || in_motion[slider.root];
  }
  if (!any) return false;
  lay_paths();
  for (FramePair& pair : slides.pairs) {
    pair.is_settled = false;
    pair.impact.status = ImpactStatus::clear;
    if (!in_motion[root_of(pair.solids.a)] && !in_motion[root_of(pair.solids.b)]) continue;
    pair.impact = impact_of(pair);
    if (pair.impact.status == ImpactStatus::iteration_limit) ++report.iteration_limits;
  }
  return true;
}

bool ContactWorld::State::finish_step() {
  bool gained = false;
  for (Slider& slider : slides.sliders) {
    if (!in_motion[slider.root]) continue;
    const double before = slider.distance;
    slider.distance = distance_of(slider);
    gained = gained || before - slider.distance >= kLeastGain * slider.start_distance;
    slider.done = !slides.may_slide[slider.root];
    rest(slider.root);
  }
  return gained;
}

void ContactWorld::State::merge_slide_pairs() {
  const auto by_solids = [](const FramePair& a, const FramePair& b) { return a.solids < b.solids; };
  const std::size_t known = pairs.size();
  for (FramePair& met : slides.pairs) {
    const auto end = pairs.begin() + static_cast<std::ptrdiff_t>(known);
    const auto place = std::lower_bound(pairs.begin(), end, met, by_solids);
    double stop = 1.0;
    for (const SolidIndex solid : {met.solids.a, met.solids.b})
      if (const Slider* slider = slides.find(root_of(solid))) stop = std::min(stop, slider->stop);
    if (place != end && place->solids == met.solids) {
      place->impact.is_far = false;
      place->impact.lo = std::min(place->impact.lo, stop);
      if (met.has_blocked && !place->has_blocked) place->blocked_at = stop;
      place->has_blocked = place->has_blocked || met.has_blocked;
      continue;
    }
    met.impact.is_far = false;
    met.impact.lo = met.blocked_at = stop;
    pairs.push_back(met);
  }
  std::sort(pairs.begin(), pairs.end(), by_solids);
}

}  // namespace touchstone
