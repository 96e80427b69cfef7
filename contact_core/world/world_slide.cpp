#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/world/world_state.hpp"

// The slide policy: movers that slide pairs stopped go on towards their commanded poses in sub-steps. All of
// a sub-step are planned from the same poses, each for itself (a pair of two sliders shares its slack), then
// move together as in any frame: who is registered first does not matter.

namespace touchstone {
namespace {

/// What is planned is executed where it gains this share.
constexpr double kWorthwhile = 0x1p-30;
/// Of the room between two sliders neither gets less than this share, whatever they are told to do.
constexpr double kLeastShare = 0.125;
/// The square of the distance along a twist is a parabola but for terms of third order in its turn: it falls
/// throughout where it still falls from here to the end.
constexpr double kNearEnd = 0.875;
constexpr int kShortenings = 16;
constexpr double kUnitRoundoff = 0x1p-53;
constexpr double kShorter = 0.75;
/// A sub-step that is stopped before this share of it was planned for too far: bends grow with the square of
/// its length.
constexpr double kFarEnough = 0.25;
constexpr double kLeastTrust = 0x1p-12;

Twist twist_to(const Pose& X_WR, const Slider& slider) {
  const BodyState way = RigidPath::between(X_WR, slider.goal).at(0, 0.0);
  return {transform(slider.goal, slider.metric.centre) - transform(X_WR, slider.metric.centre),
          way.angular_velocity_W};
}

/// J goes with the body: a turn about the axis of what is left changes nothing of w . J w. K stands as
/// commanded.
TwistMetric metric_at(const Pose& X_WR, const Slider& slider) {
  const Matrix3 J_W = turned(X_WR.R, slider.metric.J);
  return slider.is_even ? TwistMetric(J_W) : TwistMetric(J_W, slider.K_W);
}

double distance_to_goal(const Pose& X_WR, const Slider& slider) {
  const Twist left = twist_to(X_WR, slider);
  return std::sqrt(inner_product(metric_at(X_WR, slider), left, left));
}

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

}  // namespace

bool leaves_little(const Slider& slider, double left_over) {
  return left_over <= 2.0 * kLeastGain * slider.start_distance * slider.distance;
}

/// Of the room between two sliders either plans for a share only.
bool ContactWorld::State::shares_room() const {
  return std::any_of(slides.near.begin(), slides.near.end(),
                     [](const NearPair& near) { return near.share < 1.0; });
}

namespace {

bool turns_too_far(const CarriedPath& path, double stop) {
  return (1.0 - stop) * norm(path.carrier().at(0, 0.0).angular_velocity_W) > std::numbers::pi;
}

}  // namespace

void ContactWorld::State::prepare_slides() {
  slides.sliders.clear();
  for (SolidIndex i = 0; i < layout.solids.size(); ++i)
    slides.moments[i] = transform(layout.X_OS[i], mass_moments(layout.solids[i]));
}

/// See take_room().
void ContactWorld::State::take_room_for_slides(bool anew) {
  const std::size_t slots = layout.slots(), solids = layout.solids.size();
  for (std::vector<std::uint8_t>* flags :
       {&slides.may_slide, &slides.may_pivot, &slides.translation_only, &slides.translation_only_before}) {
    if (anew) flags->clear();
    flags->resize(slots, 0);
  }
  if (anew) slides.slider_of.clear();
  slides.slider_of.resize(slots, SlideState::kNone);
  slides.moments.resize(solids);
  const auto reserve_more = [](auto& list, std::size_t count) {
    if (count > list.capacity()) list.reserve(std::max(count, 2 * list.capacity()));
  };
  if (anew) shoves = {};
  shoves.leader_of.resize(slots, SlideState::kNone), shoves.claim_of.resize(slots, SlideState::kNone);
  shoves.is_told.resize(slots, 0), shoves.is_disputed.resize(slots, 0), shoves.is_blocked.resize(slots, 0);
  reserve_more(shoves.followers, slots), reserve_more(shoves.claimed, slots);
  reserve_more(slides.sliders, slots), reserve_more(slides.carried, slots);
  reserve_more(slides.cut_off, slots), reserve_more(slides.felt, slots);
  reserve_more(slides.pairs, 64 + 16 * solids), reserve_more(slides.near, 64 + 16 * solids);
  slides.held.reserve(mechanisms.size() * kMostSlideJoints);
  reserve_more(slides.rows, 1024 + 8 * solids);
  slides.joint_rows.reserve(mechanisms.size() > 0 ? kMostSlideRows : 0);
  reserve_more(slides.parts, (kMostSlideSteps + 1) * slots);
  std::size_t values = 0;
  for (std::uint32_t i = 0; i < mechanisms.size(); ++i)
    if (const MechanismMover* mover = mechanisms.at(i)) values += mover->actual.size();
  slides.joints.reserve((kMostSlideSteps + 1) * 2 * values);
}

/// As many as the watched pairs.
void ContactWorld::State::reserve_slide_pairs() {
  slides.met.reserve(2 * watched.capacity()), slides.by_root.reserve(2 * watched.capacity());
  slides.pair_of.reserve(watched.capacity()), slides.is_near.reserve(watched.capacity());
}

void ContactWorld::State::rest(std::uint32_t root) {
  paths[root] = CarriedPath(RigidPath(objects[root].X_WO), objects.poses_in_body());
  if (MechanismMover* mover = mechanism_of(root)) mover->rest();
  in_motion[root] = 0;
}

void ContactWorld::State::record_parts(std::uint32_t part) {
  for (const std::uint32_t slot : movers) {
    if (!in_motion[slot]) continue;
    slides.parts.push_back({slot, part, paths[slot], stops[slot],
                            static_cast<std::uint32_t>(slides.joints.size()), objects.handle(slot)});
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
  slides.cut_off.clear(), slides.felt.clear();
  record_parts(0);
  shove(pairs);
  if (!begin_slides()) return;
  slides.meter.begin(slides.budget);
  find_slide_pairs();
  for (std::uint32_t step = 1; step <= kMostSlideSteps; ++step) {
    if (!slides.meter.has_left()) {
      cut_off_all();
      break;
    }
    for (FramePair& pair : slides.pairs) pair.is_active = false;
    const bool moves_on = plan_slides(report);
    note_active(step - 1);
    if (!moves_on) break;
    if (slides.meter.is_over()) {
      drop_step();
      break;
    }
    resolve_stops(slides.pairs, step);
    execute();
    record_parts(step);
    note_moments(slides.pairs, step);
    note_active(step);
    report.slide_steps = step;
    if (!finish_step()) break;
  }
  merge_slide_pairs();
  report.slide_pairs = slides.meter.seen();
  for (const Slider& slider : slides.sliders)
    if (slider.is_cut_off) slides.cut_off.push_back(objects.handle(slider.root));
  report.cut_off = slides.cut_off;
  report_feel(report);
}

void ContactWorld::State::cut_off_all() {
  for (Slider& slider : slides.sliders) slider.is_cut_off = slider.is_cut_off || !slider.done;
}

/// The budget ended before all paths of a sub-step were checked: none is gone.
void ContactWorld::State::drop_step() {
  slides.meter.clip();
  for (const Slider& slider : slides.sliders)
    if (in_motion[slider.root]) stops[slider.root] = 0.0;
  execute();
  for (const Slider& slider : slides.sliders)
    if (in_motion[slider.root]) rest(slider.root);
  cut_off_all();
}

bool ContactWorld::State::begin_slides() {
  for (const Slider& slider : slides.sliders) slides.slider_of[slider.root] = SlideState::kNone;
  slides.sliders.clear(), slides.held.clear();
  for (const std::uint32_t slot : movers) {
    const double stop = stops[slot];
    MechanismMover* arm = mechanism_of(slot);
    const bool may_slide =
        arm != nullptr ? arm->actual.size() <= kMostSlideJoints : !turns_too_far(paths[slot], stop);
    if (leader_of(slot) != slot) continue;
    const bool has_taken_along = is_followed(slot) && stop < 1.0 && !shoves.is_blocked[slot];
    const bool pivots = may_pivot(slot) && !turns_too_far(paths[slot], stop) && !has_taken_along;
    if ((stop < 1.0 && slides.may_slide[slot] && may_slide) || pivots || has_taken_along) {
      slides.slider_of[slot] = static_cast<std::uint32_t>(slides.sliders.size());
      Slider slider{};
      slider.root = slot, slider.stop = stop, slider.arm = arm;
      slider.goal = paths[slot].carrier().to();
      slider.pivots = pivots;
      slides.sliders.push_back(slider);
      if (has_taken_along) begin_shove(slides.sliders.back(), stop);
      if (arm != nullptr) begin_joint_slide(slides.sliders.back());
    }
  }
  if (slides.sliders.empty()) return false;
  if (!shoves.followers.empty()) add_follower_sliders();
  for (const std::uint32_t slot : movers) rest(slot);
  weigh_sliders();
  return true;
}

/// Parts that are further out than this from a mover's origin do not count in its metric: a pose that turns
/// about their centre of mass would round by 8 u of that, more than a sixteenth of the gap.
double ContactWorld::State::longest_lever() const { return gap / (16.0 * 8.0 * kUnitRoundoff); }

void ContactWorld::State::weigh_sliders() {
  const bool all_arms = std::all_of(slides.sliders.begin(), slides.sliders.end(),
                                    [](const Slider& slider) { return slider.arm != nullptr; });
  slides.carried.clear();
  for (std::uint32_t i = 0; i < layout.slots() && !all_arms; ++i) {
    const Slider* slider = layout.is_alive(i) ? slides.find(objects[i].root) : nullptr;
    if (slider == nullptr || slider->arm != nullptr) continue;
    MassMoments own;
    for (SolidIndex solid = layout.first_solid[i]; solid < layout.first_solid[i + 1]; ++solid)
      own += slides.moments[solid];
    if (i != slider->root) own = transform(objects.poses_in_body()[i], own);
    const Vector3 centre = own.first / own.volume;
    if (norm(centre) <= longest_lever()) slides.carried.push_back({slider->root, own});
  }
  std::sort(slides.carried.begin(), slides.carried.end());
  for (const CarriedMoments& carried : slides.carried) slides.find(carried.root)->moments += carried.moments;
  for (Slider& slider : slides.sliders) {
    if (slider.follows) continue;
    // All of it is too far out: it stays where it was stopped.
    slider.done = slider.arm == nullptr && !(slider.moments.volume > 0.0);
    if (slider.done) continue;
    if (slider.arm == nullptr) weigh_by_hand(slider);
    slider.start_distance = slider.distance = distance_of(slider);
  }
}

/// The slider's metric, in its root's frame: by its hand, or by its mass.
void ContactWorld::State::weigh_by_hand(Slider& slider) const {
  slider.metric = mass_metric(slider.moments);
  const std::uint32_t slot = slider.root;
  const bool has_own = slot < slides.hands.size() && slides.hands[slot].object == objects.handle(slot);
  const std::optional<HandStiffness>& hand = has_own ? slides.hands[slot].hand : slides.default_hand;
  if (!hand) return;
  const Pose X_RT = hand->X_OT.value_or(Pose{});
  if (hand->X_OT) slider.metric.centre = X_RT.p;
  const Vector3 &k = hand->translation, &c = hand->turning;
  slider.stiffness = k.minCoeff();
  const auto diagonal = [&](const Vector3& values) {
    Matrix3 out = Matrix3::Zero();
    for (int i = 0; i < 3; ++i) out(i, i) = values[i] / slider.stiffness;
    return turned(X_RT.R, out);
  };
  slider.metric.J = diagonal(c);
  slider.is_even = k.x() == k.y() && k.y() == k.z();
  if (!slider.is_even) slider.K_W = turned(slider.goal.R, diagonal(k));
}

double ContactWorld::State::distance_of(const Slider& slider) const {
  if (slider.arm == nullptr) return distance_to_goal(objects[slider.root].X_WO, slider);
  const JointVector left = joints_left(*slider.arm);
  return std::sqrt(joint_product(left, left, slider.arm->weights));
}

double ContactWorld::State::share_of_pair(const Slider& slider, const Slider& other,
                                          const NearPair& near) const {
  if (slider.arm != nullptr || other.arm != nullptr) return 0.5;
  return share_of(-rate_along(near.n, near.points[0].p_B_W, objects[slider.root].X_WO, slider),
                  rate_along(near.n, near.points[0].p_A_W, objects[other.root].X_WO, other));
}

/// @param all the rows of pairs that are not sure too.
void ContactWorld::State::order_near_rows(bool all) {
  slides.rows.clear();
  for (const NearPair& near : slides.near)
    if (near.is_sure || all) add_rows(near, near.reach, slides.rows);
  order_rows(slides.rows);
}

/// By the rows that hold the plan alone: what they take from the whole of what is left.
void ContactWorld::State::feel(Slider& slider, const Twist& left, const TwistMetric& metric_W,
                               const ActiveRows& active) const {
  std::array<SlideRow, kTwistSize> rows;
  for (int i = 0; i < active.count; ++i) {
    rows[i] = slides.rows[active.row[i]];
    rows[i].slack = std::max(rows[i].slack, 0.0);
  }
  slider.force_W = slider.moment_W = Vector3::Zero();
  Twist kept;
  ActiveRows holding;
  constexpr std::array<double, kTwistSize> kNoLift{};
  const auto count = static_cast<std::size_t>(active.count);
  const bool translation_only = slides.translation_only[slider.root];
  if (!project(left, metric_W, std::span(rows).first(count), std::span(kNoLift).first(count),
               translation_only, kept, holding))
    return;
  for (int i = 0; i < holding.count; ++i) {
    const SlideRow& row = rows[holding.row[i]];
    const Vector3 force_W = (slider.stiffness * holding.force[i]) * row.n;
    slider.force_W += force_W;
    slider.moment_W += cross(row.r, force_W);
  }
}

void ContactWorld::State::report_feel(FrameReport& report) {
  for (const Slider& slider : slides.sliders) {
    if (slider.arm != nullptr || slider.pivots || slider.start_distance == 0.0) continue;
    const Pose& X_WR = objects[slider.root].X_WO;
    const Twist left = twist_to(X_WR, slider);
    slides.felt.push_back({objects.handle(slider.root), transform(X_WR, slider.metric.centre), left.v, left.w,
                           slider.force_W, slider.moment_W});
  }
  report.felt = slides.felt;
}

void ContactWorld::State::mark_active(std::uint32_t row) {
  slides.pairs[slides.rows[row].source].is_active = true;
}

RigidPath ContactWorld::State::plan_of(Slider& slider) {
  const Pose& X_WR = objects[slider.root].X_WO;
  const TwistMetric metric_W = metric_at(X_WR, slider);
  Twist goal = twist_to(X_WR, slider);
  const bool translation_only = slides.translation_only[slider.root];
  if (translation_only) goal.w = Vector3::Zero();
  find_near_pairs(slider);
  if (slides.meter.is_over()) return RigidPath(X_WR);
  const auto plan_with = [&](bool all) {
    order_near_rows(all);
    return plan_slide(slider.trust * goal, metric_W, slides.rows, translation_only);
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
  for (int i = 0; i < plan.active.count; ++i) mark_active(plan.active.row[i]);
  feel(slider, goal, metric_W, plan.active);
  slider.is_near_end =
      slider.trust == 1.0 && plan.is_whole && !shares_room() && leaves_little(slider, plan.left_over);
  Twist step = plan.twist;
  for (int i = 0; i < kShortenings; ++i, step = kShorter * step) {
    const RigidPath path = RigidPath::by(X_WR, step.v, step.w, slider.metric.centre);
    if (i == 1) slider.is_near_end = false;
    const double end = distance_to_goal(path.to(), slider), gain = slider.distance - end;
    if (!(gain >= kWorthwhile * slider.start_distance && gain > 0.0)) continue;
    if (end <= distance_to_goal(path.pose_at(kNearEnd), slider)) return path;
  }
  return RigidPath(X_WR);
}

RigidPath ContactWorld::State::rigid_path(Slider& slider) {
  if (slider.pivots) return pivot_path(slider);
  return slider.shoves ? shoving_path(slider) : plan_of(slider);
}

bool ContactWorld::State::plan_slides(FrameReport& report) {
  std::size_t sharers = 0;
  for (const Slider& slider : slides.sliders) sharers += !slider.done;
  if (sharers == 0) return false;
  slides.meter.begin_step(sharers);
  for (Slider& slider : slides.sliders) {
    if (slider.done) continue;
    stops[slider.root] = 1.0;
    slides.meter.begin_plan();
    if (slider.arm != nullptr)
      in_motion[slider.root] = plan_joints(slider);
    else
      paths[slider.root] = CarriedPath(rigid_path(slider), objects.poses_in_body());
    slider.is_cut_off = slides.meter.is_over();
    slides.meter.clip();
  }
  // Only now, so that all plan alike.
  for (Slider& slider : slides.sliders) slider.done = slider.done || slider.is_cut_off;
  bool any = false;
  for (const Slider& slider : slides.sliders) {
    if (slider.arm == nullptr || slider.done)
      in_motion[slider.root] = !slider.done && !paths[slider.root].carrier().at_rest();
    any = any || in_motion[slider.root];
  }
  for (const Slider& slider : slides.sliders) {
    if (!slider.follows) continue;
    const std::uint32_t leader = leader_of(slider.root);
    in_motion[slider.root] = in_motion[leader];
    if (in_motion[leader]) paths[slider.root] = path_along(leader, slider.root), stops[slider.root] = 1.0;
  }
  if (!any) return false;
  lay_paths();
  take_up_slide_pairs();
  slides.meter.begin_checks();
  find_slide_impacts(report);
  return true;
}

bool ContactWorld::State::finish_step() {
  bool goes_on = false;
  const bool shoves_more = shove(slides.pairs);
  for (Slider& slider : slides.sliders) {
    if (!in_motion[slider.root]) continue;
    const double before = slider.distance, stop = stops[slider.root];
    if (slider.follows) {
      rest(slider.root);
      continue;
    }
    slider.distance = distance_of(slider);
    if (slider.shoves) {
      goes_on = go_on_shoving(slider, stop) || !slider.done || goes_on;
      rest(slider.root);
      continue;
    }
    slider.done = !slides.may_slide[slider.root] || slider.pivots;
    const double trust = slider.trust;
    slider.trust = stop < kFarEnough ? 0.25 * trust : std::min(1.0, 4.0 * trust);
    const bool gained = before - slider.distance >= kLeastGain * slider.start_distance &&
                        !(slider.is_near_end && stop == 1.0);
    const bool shorter = stop < kFarEnough && slider.trust >= kLeastTrust;
    goes_on = goes_on || (!slider.done && (gained || shorter));
    rest(slider.root);
  }
  if (shoves_more) {
    add_follower_sliders();
    gather_slide_pairs();
  }
  return goes_on;
}

}  // namespace touchstone
