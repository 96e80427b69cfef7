#include <algorithm>
#include <cmath>
#include <numbers>

#include "touchstone/contact_core/world/slide/arm_plan.hpp"
#include "touchstone/contact_core/world/slide/leading_paths.hpp"
#include "touchstone/contact_core/world/slide/rigid_plan.hpp"
#include "touchstone/contact_core/world/world_state.hpp"

// The slide policy: movers that slide pairs stopped go on towards their commanded poses in sub-steps. All of
// a sub-step are planned from the same poses, each for itself (a pair of two sliders shares its slack), then
// move together as in any frame: who is registered first does not matter. What is here leads from part to
// part: SlidePairs finds what is near, plan_rigid_slide() and plan_arm_slide() plan, and stops and execution
// are those of any path.

namespace touchstone {
namespace {

constexpr double kUnitRoundoff = 0x1p-53;
/// A sub-step that is stopped before this share of it was planned for too far: bends grow with the square of
/// its length.
constexpr double kFarEnough = 0.25;
constexpr double kLeastTrust = 0x1p-12;

bool turns_too_far(const CarriedPath& path, double stop) {
  return (1.0 - stop) * norm(path.carrier().at(0, 0.0).angular_velocity_W) > std::numbers::pi;
}

}  // namespace

/// What an arm's plan asks for, from the slides' pairs; further than the lively pairs reach they are chosen
/// anew.
class ContactWorld::State::ObstaclesOfArm final : public ArmObstacles {
 public:
  ObstaclesOfArm(State& world, const Slider& slider) : world_(world), slider_(slider) {}

  std::span<NearPair> near() override { return pairs().near(); }
  Links links_of(std::uint32_t source) const override {
    const auto [link, other] = touchstone::links_of(world_, slider_, world_.slides.pairs[source].solids);
    return {link, other};
  }
  void take_up_standing() override { pairs().find_near(world_.slide_scope(), slider_); }
  bool take_up_held() override { return pairs().add_held(world_.slide_scope(), slider_); }
  bool take_up_on_path() override {
    if (plan_goes_beyond(world_, slider_) && world_.slides.sliders.list.size() == 1) {
      world_.choose_lively();
      world_.gather_slide_pairs();
    }
    return pairs().add_on_path(world_.slide_scope(), slider_);
  }
  bool is_over() const override { return world_.slides.meter.is_over(); }

 private:
  SlidePairs& pairs() { return world_.slides.pairs; }

  State& world_;
  const Slider& slider_;
};

void ContactWorld::State::prepare_slides() {
  slides.sliders.list.clear();
  for (SolidIndex i = 0; i < layout.solids.size(); ++i)
    slides.moments[i] = transform(layout.X_OS[i], mass_moments(layout.solids[i]));
}

/// See take_room().
void ContactWorld::State::take_room_for_slides(bool anew) {
  const std::size_t slots = layout.slots(), solids = layout.solids.size();
  const auto reserve_more = [](auto& list, std::size_t count) {
    if (count > list.capacity()) list.reserve(std::max(count, 2 * list.capacity()));
  };
  slides.permits.take_room(slots, anew);
  if (anew) slides.sliders.index_of.clear();
  slides.sliders.index_of.resize(slots, Sliders::kNone);
  slides.moments.resize(solids);
  followers.take_room(slots, anew);
  reserve_more(slides.sliders.list, slots), reserve_more(slides.carried, slots);
  reserve_more(slides.cut_off, slots), reserve_more(slides.felt, slots);
  slides.pairs.reserve(slots, solids, mechanisms.size());
  reserve_more(slides.rows, 1024 + 8 * solids);
  reserve_more(slides.touching, 64 + 16 * solids), reserve_more(slides.touching_of, 64 + 16 * solids);
  slides.joint_rows.reserve(mechanisms.size() > 0 ? kMostSlideRows : 0);
  std::size_t values = 0;
  for (std::uint32_t i = 0; i < mechanisms.size(); ++i)
    if (const MechanismMover* mover = mechanisms.at(i)) values += mover->actual.size();
  parts.reserve((kMostSlideSteps + 1) * slots, (kMostSlideSteps + 1) * 2 * values);
}

SlidePairs::Scope ContactWorld::State::slide_scope() {
  return {*this, watched, *query, slides.sliders, slides.meter, lanes};
}

void ContactWorld::State::gather_slide_pairs() {
  if (slides.sliders.is_one_arm() && needs_lively) choose_lively();
  slides.pairs.gather(*this, watched, slides.sliders, lively, lanes);
}

/// From now on slides look at pairs, as many as watch_pairs() finds.
void ContactWorld::State::find_slide_pairs() {
  for (const std::uint32_t slot : slides.pairs.begin(*this, slides.sliders)) note_due(slot);
  if (is_watch_due()) watch_pairs();
  slides.pairs.renumber(watched);
  gather_slide_pairs();
}

/// Once paths are laid: those that go further than was looked ahead for have more to meet.
void ContactWorld::State::take_up_slide_pairs() {
  if (is_watch_due()) {
    watch_pairs();
    slides.pairs.renumber(watched);
    gather_slide_pairs();
  } else if (needs_lively && slides.sliders.is_one_arm()) {
    gather_slide_pairs();
  }
}

void ContactWorld::State::rest(std::uint32_t root) {
  paths[root] = CarriedPath(RigidPath(objects[root].X_WO), objects.poses_in_body());
  if (MechanismMover* mover = mechanism_of(root)) mover->rest();
  in_motion[root] = 0;
}

void ContactWorld::State::record_parts(std::uint32_t part) {
  for (const std::uint32_t slot : movers) {
    if (!in_motion[slot]) continue;
    const MechanismMover* mover = mechanism_of(slot);
    if (mover == nullptr)
      parts.add(objects.handle(slot), part, paths[slot], stops[slot]);
    else
      parts.add(objects.handle(slot), part, paths[slot], stops[slot], mover->path.from(), mover->path.to());
  }
  parts.set_count(part + 1);
}

void ContactWorld::State::slide(FrameReport& report) {
  parts.clear();
  slides.cut_off.clear(), slides.felt.clear();
  record_parts(0);
  shove(pairs);
  if (!begin_slides()) return;
  slides.meter.begin(slides.budget);
  find_touching();
  find_slide_pairs();
  for (std::uint32_t step = 1; step <= kMostSlideSteps; ++step) {
    if (!slides.meter.has_left()) {
      cut_off_all();
      break;
    }
    slides.pairs.nothing_is_active();
    const bool moves_on = plan_slides(report);
    note_active(step - 1);
    if (!moves_on) break;
    if (slides.meter.is_over()) {
      drop_step();
      break;
    }
    resolve_stops(slides.pairs.pairs(), step);
    execute();
    record_parts(step);
    note_moments(slides.pairs.pairs(), step);
    note_active(step);
    report.slide_steps = step;
    if (!finish_step()) break;
  }
  merge_slide_pairs(*this, watched, contacts, slides.pairs.pairs(), pairs);
  report_slides(report);
}

void ContactWorld::State::cut_off_all() {
  for (Slider& slider : slides.sliders.list) slider.is_cut_off = slider.is_cut_off || !slider.done;
}

/// The budget ended before all paths of a sub-step were checked: none is gone.
void ContactWorld::State::drop_step() {
  slides.meter.clip();
  for (const Slider& slider : slides.sliders.list)
    if (in_motion[slider.root]) stops[slider.root] = 0.0;
  execute();
  for (const Slider& slider : slides.sliders.list)
    if (in_motion[slider.root]) rest(slider.root);
  cut_off_all();
}

bool ContactWorld::State::begin_slides() {
  Sliders& sliders = slides.sliders;
  for (const Slider& slider : sliders.list) sliders.index_of[slider.root] = Sliders::kNone;
  sliders.list.clear();
  for (const std::uint32_t slot : movers) {
    const double stop = stops[slot];
    MechanismMover* arm = mechanism_of(slot);
    const bool may_go_on =
        arm != nullptr ? arm->actual.size() <= kMostSlideJoints : !turns_too_far(paths[slot], stop);
    if (followers.leader_of(slot) != slot) continue;
    const bool has_taken_along = followers.is_followed(slot) && stop < 1.0 && !followers.is_blocked(slot);
    const bool pivots = may_pivot(slot) && may_go_on && !has_taken_along;
    const bool may_slide = stop < 1.0 && slides.permits.may_slide[slot] && may_go_on;
    if (!may_slide && !pivots && !has_taken_along) continue;
    sliders.index_of[slot] = static_cast<std::uint32_t>(sliders.list.size());
    Slider slider{};
    slider.root = slider.leader = slot, slider.stop = stop, slider.arm = arm;
    slider.goal = paths[slot].carrier().to();
    slider.pivots = pivots;
    if (has_taken_along) begin_shove(slider, paths[slot].carrier(), stop);
    if (arm != nullptr) begin_arm_slide(slider);
    sliders.list.push_back(slider);
  }
  if (sliders.list.empty()) return false;
  if (!followers.all().empty()) add_follower_sliders();
  for (const std::uint32_t slot : movers) rest(slot);
  weigh_sliders();
  return true;
}

/// A rigid body that turns, stopped by pairs that advance or slide, of which not all slide.
bool ContactWorld::State::may_pivot(std::uint32_t root) const {
  return stops[root] < 1.0 && slides.permits.may_pivot[root] && !slides.permits.may_slide[root] &&
         mechanism_of(root) == nullptr &&
         paths[root].carrier().at(0, 0.0).angular_velocity_W != Vector3::Zero();
}

/// Entries for those that go along with a slider, by root as all; more than once does no harm.
void ContactWorld::State::add_follower_sliders() {
  Sliders& sliders = slides.sliders;
  for (const std::uint32_t root : followers.all()) {
    const std::uint32_t leader = followers.leader_of(root);
    if (sliders.find(root) != nullptr || sliders.find(leader) == nullptr) continue;
    sliders.index_of[root] = static_cast<std::uint32_t>(sliders.list.size());
    Slider follower{};
    follower.root = root, follower.leader = leader;
    follower.goal = objects[root].X_WO;
    follower.done = follower.follows = true;
    sliders.list.push_back(follower);
  }
  std::sort(sliders.list.begin(), sliders.list.end(),
            [](const Slider& a, const Slider& b) { return a.root < b.root; });
  for (std::uint32_t i = 0; i < sliders.list.size(); ++i) sliders.index_of[sliders.list[i].root] = i;
}

/// Parts that are further out than this from a mover's origin do not count in its metric: a pose that turns
/// about their centre of mass would round by 8 u of that, more than a sixteenth of the gap.
double ContactWorld::State::longest_lever() const { return gap / (16.0 * 8.0 * kUnitRoundoff); }

void ContactWorld::State::weigh_sliders() {
  Sliders& sliders = slides.sliders;
  const bool all_arms = std::all_of(sliders.list.begin(), sliders.list.end(),
                                    [](const Slider& slider) { return slider.arm != nullptr; });
  slides.carried.clear();
  for (std::uint32_t i = 0; i < layout.slots() && !all_arms; ++i) {
    const Slider* slider = layout.is_alive(i) ? sliders.find(objects[i].root) : nullptr;
    if (slider == nullptr || slider->arm != nullptr) continue;
    MassMoments own;
    for (SolidIndex solid = layout.first_solid[i]; solid < layout.first_solid[i + 1]; ++solid)
      own += slides.moments[solid];
    if (i != slider->root) own = transform(objects.poses_in_body()[i], own);
    const Vector3 centre = own.first / own.volume;
    if (norm(centre) <= longest_lever()) slides.carried.push_back({slider->root, own});
  }
  std::sort(slides.carried.begin(), slides.carried.end());
  for (const CarriedMoments& carried : slides.carried) sliders.find(carried.root)->moments += carried.moments;
  for (Slider& slider : sliders.list) {
    if (slider.follows) continue;
    // All of it is too far out: it stays where it was stopped.
    slider.done = slider.arm == nullptr && !(slider.moments.volume > 0.0);
    if (slider.done) continue;
    if (slider.arm == nullptr) weigh_by_hand(slider, slides.hands.of(objects.handle(slider.root)));
    slider.start_distance = slider.distance = distance_left(slider, objects[slider.root].X_WO);
  }
}

void ContactWorld::State::report_slides(FrameReport& report) {
  report.slide_pairs = slides.meter.seen();
  for (const Slider& slider : slides.sliders.list) {
    if (slider.is_cut_off) slides.cut_off.push_back(objects.handle(slider.root));
    if (slider.arm != nullptr || slider.pivots || slider.start_distance == 0.0) continue;
    const Pose& X_WR = objects[slider.root].X_WO;
    const Twist left = twist_to_goal(slider, X_WR);
    slides.felt.push_back({objects.handle(slider.root), transform(X_WR, slider.metric.centre), left.v, left.w,
                           slider.force_W, slider.moment_W});
  }
  report.cut_off = slides.cut_off;
  report.felt = slides.felt;
}

/// What pivots turn about, by root.
void ContactWorld::State::find_touching() {
  slides.touching.clear(), slides.touching_of.clear();
  for (std::uint32_t i = 0; i < pairs.size(); ++i) {
    if (pairs[i].stop == kNoMoment) continue;
    for (const SolidIndex solid : {pairs[i].solids.a, pairs[i].solids.b}) {
      const Slider* slider = slides.sliders.find(root_of(solid));
      if (slider != nullptr && slider->pivots) slides.touching_of.emplace_back(slider->root, i);
    }
  }
  std::sort(slides.touching_of.begin(), slides.touching_of.end());
  for (const auto& [root, i] : slides.touching_of) slides.touching.push_back(pairs[i]);
}

RigidPath ContactWorld::State::plan_of(Slider& slider) {
  const Pose& X_WR = objects[slider.root].X_WO;
  slides.pairs.find_near(slide_scope(), slider);
  if (slides.meter.is_over()) return RigidPath(X_WR);
  const RigidPlan plan = plan_rigid_slide(slider, X_WR, slides.permits.translation_only[slider.root] != 0,
                                          slides.pairs.near(), slides.rows);
  for (int i = 0; i < plan.held_by; ++i) slides.pairs[plan.sources[i]].is_active = true;
  slider.force_W = plan.force_W, slider.moment_W = plan.moment_W;
  slider.is_near_end = plan.is_near_end;
  return plan.path;
}

RigidPath ContactWorld::State::rigid_path(Slider& slider) {
  const Pose& X_WR = objects[slider.root].X_WO;
  if (slider.shoves) return shoving_path(slider, X_WR);
  if (!slider.pivots) return plan_of(slider);
  Vector3 p_W = Vector3::Zero();
  const auto [first, last] =
      std::equal_range(slides.touching_of.begin(), slides.touching_of.end(), std::pair{slider.root, 0u},
                       [](const auto& x, const auto& y) { return x.first < y.first; });
  const auto of_root = std::span<const FramePair>(slides.touching)
                           .subspan(static_cast<std::size_t>(first - slides.touching_of.begin()),
                                    static_cast<std::size_t>(last - first));
  const bool touches = find_pivot(*this, of_root, moments, slider.root, slider.stop, p_W);
  return touches ? pivot_path(X_WR, slider.goal, p_W) : RigidPath(X_WR);
}

bool ContactWorld::State::plan_arm(Slider& slider) {
  ObstaclesOfArm obstacles(*this, slider);
  const ArmPlan plan = plan_arm_slide(slider, obstacles, slides.rows, slides.joint_rows);
  const auto sources = std::span(plan.sources).first(static_cast<std::size_t>(plan.held_by));
  for (const std::uint32_t source : sources) slides.pairs[source].is_active = true;
  slides.pairs.note_held(slider, sources);
  slider.is_near_end = plan.is_near_end;
  return plan.moves;
}

/// @returns whether any moves: their paths are laid, and where they stop is known.
bool ContactWorld::State::plan_slides(FrameReport& report) {
  std::vector<Slider>& sliders = slides.sliders.list;
  std::size_t sharers = 0;
  for (const Slider& slider : sliders) sharers += !slider.done;
  if (sharers == 0) return false;
  slides.meter.begin_step(sharers);
  for (Slider& slider : sliders) {
    if (slider.done) continue;
    stops[slider.root] = 1.0;
    slides.meter.begin_plan();
    if (slider.arm != nullptr)
      in_motion[slider.root] = plan_arm(slider);
    else
      paths[slider.root] = CarriedPath(rigid_path(slider), objects.poses_in_body());
    slider.is_cut_off = slides.meter.is_over();
    slides.meter.clip();
  }
  // Only now, so that all plan alike.
  for (Slider& slider : sliders) slider.done = slider.done || slider.is_cut_off;
  bool any = false;
  for (const Slider& slider : sliders) {
    if (slider.arm == nullptr || slider.done)
      in_motion[slider.root] = !slider.done && !paths[slider.root].carrier().at_rest();
    any = any || in_motion[slider.root];
  }
  for (const Slider& slider : sliders) {
    if (!slider.follows) continue;
    in_motion[slider.root] = in_motion[slider.leader];
    if (in_motion[slider.leader]) go_along(slider.leader, slider.root);
  }
  if (!any) return false;
  lay_paths();
  take_up_slide_pairs();
  slides.meter.begin_checks();
  report.iteration_limits += slides.pairs.find_impacts(slide_scope());
  return true;
}

bool ContactWorld::State::finish_step() {
  bool goes_on = false;
  const bool shoves_more = shove(slides.pairs.pairs());
  for (Slider& slider : slides.sliders.list) {
    if (!in_motion[slider.root]) continue;
    const double before = slider.distance, stop = stops[slider.root];
    rest(slider.root);
    if (slider.follows) continue;
    slider.distance = distance_left(slider, objects[slider.root].X_WO);
    const bool may_slide = slides.permits.may_slide[slider.root] != 0;
    if (slider.shoves) {
      const bool shoves = go_on_shoving(slider, stop, followers.is_blocked(slider.root), may_slide);
      goes_on = shoves || !slider.done || goes_on;
      continue;
    }
    slider.done = !may_slide || slider.pivots;
    const double trust = slider.trust;
    slider.trust = stop < kFarEnough ? 0.25 * trust : std::min(1.0, 4.0 * trust);
    const bool gained = before - slider.distance >= kLeastGain * slider.start_distance &&
                        !(slider.is_near_end && stop == 1.0);
    const bool shorter = stop < kFarEnough && slider.trust >= kLeastTrust;
    goes_on = goes_on || (!slider.done && (gained || shorter));
  }
  if (shoves_more) {
    add_follower_sliders();
    gather_slide_pairs();
  }
  return goes_on;
}

}  // namespace touchstone
