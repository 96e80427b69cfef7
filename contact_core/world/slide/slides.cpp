#include "touchstone/contact_core/world/slide/slides.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <utility>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"
#include "touchstone/contact_core/world/frame/execution.hpp"
#include "touchstone/contact_core/world/slide/arm_hand.hpp"
#include "touchstone/contact_core/world/slide/arm_plan.hpp"
#include "touchstone/contact_core/world/slide/leading_paths.hpp"
#include "touchstone/contact_core/world/slide/rigid_plan.hpp"
#include "touchstone/contact_core/world/slide/shove.hpp"
#include "touchstone/contact_core/world/slide/slide_reach.hpp"

namespace touchstone {
namespace {

/// A sub-step that is stopped before this share of it was planned for too far: bends grow with the square of
/// its length.
constexpr double kFarEnough = 0.25;
constexpr double kLeastTrust = 0x1p-12;

/// Fewer sliders than these plan in turn: threads would cost more.
constexpr std::size_t kPlansInLanes = 16;
constexpr std::size_t kPlansAtOnce = 4;
/// One slider's near pairs in a lane, more than which allocate.
constexpr std::size_t kNearInLane = 512;

/// A rigid body's sub-step that gains less than this share of Slider::start_distance is not its last because
/// its plan says so. The one drawer of 1 000 that stood still on its way round a corner goes on with
/// 0.01 and with 0.025 as well, not with 0.
constexpr double kLittleGain = 0.05;

bool turns_too_far(const CarriedPath& path, double stop) {
  return (1.0 - stop) * norm(path.carrier().at(0, 0.0).angular_velocity_W) > std::numbers::pi;
}

/// Lays an arm's path to its command, straight on. @returns whether any distance is left.
bool go_on_as_commanded(MechanismMover& arm) {
  arm.go(arm.commanded);
  return arm.commanded != arm.actual;
}

/// By what its last sub-step gained. Where bends or an obstacle keep the first ones short, what comes after
/// them may be worth more.
bool is_worth_going_on(Slider& slider, double gain) {
  const bool is_steady = slider.arm != nullptr && gain >= 0.5 * std::exchange(slider.last_gain, gain);
  if (gain >= kLeastGain * slider.start_distance) return true;
  const bool hardly_begun = slider.start_distance - slider.distance < kHardlyBegun * slider.start_distance;
  return gain > 0.0 && hardly_begun && (is_steady || ++slider.poor_steps <= kMostPoorSteps);
}

/// A plan foresees nothing beyond its planes: a rigid body that is held back, and gains little by each of its
/// sub-steps, may be on its way round a corner, on which it gains more by each than by the one before.
bool may_lead_round(const Slider& slider, double gain) {
  return slider.arm == nullptr && gain < kLittleGain * slider.start_distance;
}

/// A rigid body that turns, stopped by pairs that advance or slide, of which not all slide.
bool may_pivot(const WorldModel& model, const StopPermits& permits, std::uint32_t root) {
  return model.stops[root] < 1.0 && permits.may_pivot[root] && !permits.may_slide[root] &&
         model.mechanism_of(root) == nullptr &&
         model.paths[root].carrier().at(0, 0.0).angular_velocity_W != Vector3::Zero();
}

}  // namespace

double longest_lever(double gap) { return gap / (16.0 * 8.0 * kUnitRoundoff); }

/// Pairs for an arm's plan, from the slides' pairs.
class Slides::ObstaclesOfArm final : public ArmObstacles {
 public:
  ObstaclesOfArm(Slides& slides, const FrameScope& scope, const Slider& slider)
      : slides_(slides), scope_(scope), slider_(slider) {}

  std::span<NearPair> near() override { return pairs().near(); }
  void take_up_standing() override { pairs().find_near(slides_.pair_scope(scope_), slider_); }
  bool take_up_held() override { return pairs().add_held(slides_.pair_scope(scope_), slider_); }
  bool take_up_on_path() override {
    measure_plan(scope_.model, slider_);
    return pairs().add_on_path(slides_.pair_scope(scope_), slider_);
  }
  bool is_over() const override { return slides_.meter_.is_over(); }

 private:
  SlidePairs& pairs() { return slides_.pairs_; }

  Slides& slides_;
  const FrameScope& scope_;
  const Slider& slider_;
};

void Slides::take_room(const WorldModel& model, std::size_t watched, std::size_t lanes, bool anew) {
  const std::size_t slots = model.layout.slots(), solids = model.layout.solids.size();
  const std::size_t mechanisms = model.mechanisms.size();
  permits_.take_room(slots, anew);
  if (anew) sliders_.index_of.clear();
  resize_more(sliders_.index_of, slots, kNoIndex);
  resize_more(moments_, solids);
  reserve_more(sliders_.list, slots), reserve_more(carried_, slots);
  reserve_more(cut_off_, slots), reserve_more(felt_, slots);
  pairs_.reserve(slots, solids, mechanisms);
  pairs_.reserve_watched(watched);
  reserve_more(rows_, 1024 + 8 * solids);
  reserve_more(results_, slots), reserve_more(plans_, slots);
  rooms_.resize(lanes);
  for (PlanRoom& room : rooms_)
    reserve_more(room.near, kNearInLane + 16 * solids), reserve_more(room.rows, 1024 + 8 * solids);
  reserve_more(touching_, 64 + 16 * solids), reserve_more(touching_of_, 64 + 16 * solids);
  joint_rows_.reserve(mechanisms > 0 ? kMostSlideRows : 0);
  if (!anew) return;
  sliders_.list.clear();
  for (std::uint32_t slot = 0; slot < slots; ++slot) begin_object(model, slot);
}

void Slides::begin_object(const WorldModel& model, std::uint32_t slot) {
  const Layout& layout = model.layout;
  for (SolidIndex i = layout.first_solid[slot]; i < layout.first_solid[slot + 1]; ++i) {
    const Hexahedron& solid = layout.solids[i];
    // Moments weigh turns against shifts: of padding about what is no box, the core's do as well.
    moments_[i] = transform(layout.X_OS[i], solid.is_box() ? mass_moments(solid) : core_moments(solid));
  }
}

void Slides::run(const FrameScope& scope, GrowingList<FramePair>& pairs, FrameReport& report) {
  WorldModel& model = scope.model;
  MomentLog& moments = scope.moments;
  cut_off_.clear(), felt_.clear();
  // Shoved objects are found first; sliders start where the commanded paths ended.
  take_shoved(model, pairs, scope.movers, scope.followers, scope.parts);
  if (!begin(scope)) return;
  // The pairs that sliders touch or could meet are found.
  meter_.begin(budget);
  find_touching(model, pairs);
  find_pairs(scope);
  // Each sub-step plans paths, checks them and executes them up to their stops.
  for (std::uint32_t step = 1; step <= kMostSlideSteps; ++step) {
    if (!meter_.has_left()) {
      cut_off_all();
      break;
    }
    pairs_.nothing_is_active();
    const bool moves_on = plan(scope, report);
    moments.note_active(model, scope.query(), scope.contacts, pairs_.pairs(), step - 1);
    if (!moves_on) break;
    if (meter_.is_over()) {
      drop_step(scope);
      break;
    }
    go(scope, step);
    report.slide_steps = step;
    if (!finish_step(scope)) break;
  }
  // The slide's pairs join those of the frame, and the report says what hands feel.
  merge_slide_pairs(model, scope.watched.pairs(), scope.contacts, pairs_.pairs(), pairs);
  report_feel(model, report);
}

// Chooses the movers that slide, pivot or shove from where the commanded paths ended. @returns whether there
// is any.
bool Slides::begin(const FrameScope& scope) {
  WorldModel& model = scope.model;
  const Followers& followers = scope.followers;
  // The sliders of the slide before are cleared.
  for (const Slider& slider : sliders_.list) sliders_.index_of[slider.root] = kNoIndex;
  sliders_.list.clear();
  // A mover goes on if it may slide, if it turns about a contact, or if others go along with it.
  for (const std::uint32_t slot : scope.movers.roots) {
    const double stop = model.stops[slot];
    const RigidPath& path = model.paths[slot].carrier();
    MechanismMover* arm = model.mechanism_of(slot);
    const bool may_go_on =
        arm != nullptr ? arm->actual.size() <= kMostSlideJoints : !turns_too_far(model.paths[slot], stop);
    if (followers.leader_of(slot) != slot) continue;
    const bool has_taken_along = followers.is_followed(slot) && stop < 1.0 && !followers.is_blocked(slot) &&
                                 (arm == nullptr || may_go_on);
    const bool pivots = may_pivot(model, permits_, slot) && may_go_on && !has_taken_along;
    const bool may_slide = stop < 1.0 && permits_.may_slide[slot] && may_go_on;
    if (!may_slide && !pivots && !has_taken_along) continue;
    // Such a mover becomes a slider whose goal is the end of its commanded path.
    sliders_.index_of[slot] = static_cast<std::uint32_t>(sliders_.list.size());
    Slider slider{};
    slider.root = slider.leader = slot, slider.stop = stop, slider.arm = arm;
    slider.goal = path.to();
    slider.pivots = pivots;
    slider.most_work = budget.mover_work;
    slider.shoves = has_taken_along;
    if (has_taken_along && arm == nullptr) begin_shove(slider, path, stop);
    if (arm != nullptr) begin_arm_slide(slider);
    sliders_.list.push_back(slider);
  }
  if (sliders_.list.empty()) return false;
  // Followers get sliders too, and all rest where they stopped until a plan moves them.
  if (!followers.all().empty()) add_follower_sliders(scope);
  for (const std::uint32_t slot : scope.movers.roots) rest(model, slot);
  weigh(model);
  return true;
}

/// Entries for those that go along with a slider, by root as all; more than once does no harm.
void Slides::add_follower_sliders(const FrameScope& scope) {
  for (const std::uint32_t root : scope.followers.all()) {
    const std::uint32_t leader = scope.followers.leader_of(root);
    if (sliders_.find(root) != nullptr || sliders_.find(leader) == nullptr) continue;
    sliders_.index_of[root] = static_cast<std::uint32_t>(sliders_.list.size());
    Slider follower{};
    follower.root = root, follower.leader = leader;
    follower.goal = scope.model.objects[root].X_WO;
    follower.done = follower.follows = true;
    sliders_.list.push_back(follower);
  }
  std::sort(sliders_.list.begin(), sliders_.list.end(),
            [](const Slider& a, const Slider& b) { return a.root < b.root; });
  for (std::uint32_t i = 0; i < sliders_.list.size(); ++i) sliders_.index_of[sliders_.list[i].root] = i;
}

/// Finds the sliders' metrics and how far they are from their goals.
void Slides::weigh(const WorldModel& model) {
  const Layout& layout = model.layout;
  const ObjectTable& objects = model.objects;
  const bool all_arms = std::all_of(sliders_.list.begin(), sliders_.list.end(),
                                    [](const Slider& slider) { return slider.arm != nullptr; });
  // Moments are collected of all objects that a rigid slider moves.
  carried_.clear();
  for (std::uint32_t i = 0; i < layout.slots() && !all_arms; ++i) {
    const Slider* slider = layout.is_alive(i) ? sliders_.find(objects[i].root) : nullptr;
    if (slider == nullptr || slider->arm != nullptr) continue;
    MassMoments moments;
    for (SolidIndex solid = layout.first_solid[i]; solid < layout.first_solid[i + 1]; ++solid)
      moments += moments_[solid];
    if (i != slider->root) moments = transform(objects.poses_in_body()[i], moments);
    // Objects too far from the mover's origin do not count in the metric.
    const Vector3 centre = moments.first / moments.volume;
    if (norm(centre) <= longest_lever(model.gap)) carried_.push_back({slider->root, moments});
  }
  // Sorting makes sums independent of the order in which objects were added.
  std::sort(carried_.begin(), carried_.end());
  for (const CarriedMoments& carried : carried_) sliders_.find(carried.root)->moments += carried.moments;
  // Each slider gets its metric and its distance to the goal.
  for (Slider& slider : sliders_.list) {
    if (slider.follows) continue;
    // All of it is too far out: it stays where it was stopped.
    slider.done = slider.arm == nullptr && !(slider.moments.volume > 0.0);
    if (slider.done) continue;
    if (slider.arm == nullptr) weigh_by_hand(slider, hands.of(objects.handle(slider.root)));
    slider.start_distance = slider.distance = distance_left(slider, objects[slider.root].X_WO);
  }
}

/// Finds the points that pivots turn about, by root.
void Slides::find_touching(const WorldModel& model, std::span<const FramePair> pairs) {
  touching_.clear(), touching_of_.clear();
  for (std::uint32_t i = 0; i < pairs.size(); ++i) {
    if (pairs[i].stop == kNoMoment) continue;
    for (const SolidIndex solid : {pairs[i].solids.a, pairs[i].solids.b}) {
      const Slider* slider = sliders_.find(model.root_of(solid));
      if (slider != nullptr && slider->pivots) touching_of_.emplace_back(slider->root, i);
    }
  }
  std::sort(touching_of_.begin(), touching_of_.end());
  for (const auto& [root, i] : touching_of_) touching_.push_back(pairs[i]);
}

SlidePairs::Scope Slides::pair_scope(const FrameScope& scope) {
  return {scope.model, scope.watched.pairs(), scope.query(), sliders_, meter_, scope.lanes};
}

/// From now on slides look at pairs, as many as are watched.
void Slides::find_pairs(const FrameScope& scope) {
  WatchedPairs& watched = scope.watched;
  for (const std::uint32_t slot : pairs_.begin(scope.model, sliders_)) watched.note_due(slot);
  if (watched.is_due()) watched.update(scope.model, scope.broadphase);
  pairs_.renumber(watched.pairs());
  gather_pairs(scope);
}

void Slides::gather_pairs(const FrameScope& scope) {
  pairs_.gather(scope.model, scope.watched.pairs(), sliders_, scope.lanes);
}

/// Once paths are laid: those that go further than was looked ahead for have more to meet.
void Slides::take_up_pairs(const FrameScope& scope) {
  WatchedPairs& watched = scope.watched;
  if (!watched.is_due()) return;
  watched.update(scope.model, scope.broadphase);
  pairs_.renumber(watched.pairs());
  gather_pairs(scope);
}

/// Those whose own budget is spent stand where their last sub-step led.
void Slides::end_spent() {
  for (Slider& slider : sliders_.list) {
    if (slider.done || !slider.has_spent()) continue;
    // One that had come to rest only went on beside others: nothing was cut off.
    slider.done = true;
    slider.is_cut_off = slider.goes_on;
  }
}

/// @returns whether any moves: their paths are laid, and their stops are known.
bool Slides::plan(const FrameScope& scope, FrameReport& report) {
  WorldModel& model = scope.model;
  end_spent();
  // Sliders that are not done share the budget.
  std::size_t sharers = 0;
  for (const Slider& slider : sliders_.list) sharers += !slider.done;
  if (sharers == 0) return false;
  meter_.begin_step(sharers);
  // Plans are made, in lanes where that is allowed.
  if (may_plan_in_lanes(sharers))
    plan_in_lanes(scope);
  else
    plan_in_turn(scope);
  // Sliders that were cut off end only now, so that all plan alike.
  for (Slider& slider : sliders_.list) slider.done = slider.done || slider.is_cut_off;
  // Sliders that have a path are in motion, and followers move with their leaders.
  bool any = false;
  for (const Slider& slider : sliders_.list) {
    if (slider.arm == nullptr || slider.done)
      model.in_motion[slider.root] = !slider.done && !model.paths[slider.root].carrier().at_rest();
    any = any || model.in_motion[slider.root];
  }
  for (const Slider& slider : sliders_.list) {
    if (!slider.follows) continue;
    model.in_motion[slider.root] = model.in_motion[slider.leader];
    if (model.in_motion[slider.leader]) go_along(model, slider.leader, slider.root);
  }
  if (!any) return false;
  // The paths are laid and checked.
  scope.watched.lay_paths(model, scope.movers.roots);
  take_up_pairs(scope);
  meter_.begin_checks();
  report.iteration_limits += pairs_.find_impacts(pair_scope(scope));
  pairs_.add_looks(model, sliders_);
  return true;
}

void Slides::plan_in_turn(const FrameScope& scope) {
  WorldModel& model = scope.model;
  for (Slider& slider : sliders_.list) {
    if (slider.done) continue;
    model.stops[slider.root] = 1.0;
    meter_.begin_plan();
    if (slider.arm != nullptr) {
      model.in_motion[slider.root] =
          slider.shoves ? go_on_as_commanded(*slider.arm) : plan_arm(scope, slider);
    } else {
      const bool leads = slider.shoves || slider.pivots;
      const RigidPath path = leads ? leading_path(scope, scope.query(), slider) : plan_rigid(scope, slider);
      model.paths[slider.root] = CarriedPath(path, model.objects.poses_in_body());
    }
    slider.is_cut_off = meter_.is_over();
    meter_.clip();
  }
}

/// Arms' plans write travels and more that one plan at a time has; and a budget is shared out in turn.
bool Slides::may_plan_in_lanes(std::size_t sharers) const {
  if (sharers < kPlansInLanes || meter_.is_limited()) return false;
  return std::none_of(sliders_.list.begin(), sliders_.list.end(),
                      [](const Slider& slider) { return slider.arm != nullptr && !slider.done; });
}

/// As plan_in_turn(), with the same bits: a plan reads how all stand, and writes what is its slider's.
void Slides::plan_in_lanes(const FrameScope& scope) {
  WorldModel& model = scope.model;
  const SlidePairs::Scope among = pair_scope(scope);
  const std::size_t count = sliders_.list.size();
  plans_.resize(count), results_.assign(count, {});
  // Sliders that shove or turn about a contact take a path without a plan.
  for (std::size_t k = 0; k < count; ++k) {
    const Slider& slider = sliders_.list[k];
    plans_[k] = !slider.done && !slider.shoves && !slider.pivots;
    if (!slider.done) model.stops[slider.root] = 1.0;
  }
  // Pairs within reach are taken in beforehand: lanes add none to the list.
  pairs_.take_in_reached(among, plans_);
  scope.lanes.for_each(count, kPlansAtOnce, [&](NarrowphaseQuery& asking, std::size_t k) {
    Slider& slider = sliders_.list[k];
    if (slider.done) return;
    const Pose& X_WR = model.objects[slider.root].X_WO;
    CarriedPath& path = model.paths[slider.root];
    if (!plans_[k]) {
      path = CarriedPath(leading_path(scope, asking, slider), model.objects.poses_in_body());
      return;
    }
    // All others plan from the pairs near them.
    PlanRoom& room = rooms_[scope.lanes.lane_of(asking)];
    pairs_.find_near_taken_in(among, asking, slider, room.near);
    const bool translation_only = permits_.translation_only[slider.root] != 0;
    const RigidPlan plan = plan_rigid_slide(slider, X_WR, translation_only, room.near, room.rows);
    results_[k] = {static_cast<std::uint32_t>(room.near.size())};
    // Two sliders may note the same pair at once.
    for_each_holding(room.rows, plan.active.rows(), [&](std::uint32_t source) {
      std::atomic_ref<bool>(pairs_[source].is_active).store(true, std::memory_order_relaxed);
    });
    slider.force_W = plan.force_W, slider.moment_W = plan.moment_W;
    slider.is_near_end = plan.is_near_end, slider.work += plan.work;
    path = CarriedPath(plan.path, model.objects.poses_in_body());
  });
  // The budget counts the pairs in the sliders' order.
  for (const PlanResult& result : results_) meter_.add_pairs(result.near);
}

/// The path of one that shoves or pivots: no rows plan it.
RigidPath Slides::leading_path(const FrameScope& scope, NarrowphaseQuery& query, const Slider& slider) const {
  const WorldModel& model = scope.model;
  const Pose& X_WR = model.objects[slider.root].X_WO;
  if (slider.shoves) return shoving_path(slider, X_WR);
  const auto [first, last] =
      std::equal_range(touching_of_.begin(), touching_of_.end(), std::pair{slider.root, 0u},
                       [](const auto& x, const auto& y) { return x.first < y.first; });
  const auto of_root = std::span<const FramePair>(touching_).subspan(
      static_cast<std::size_t>(first - touching_of_.begin()), static_cast<std::size_t>(last - first));
  const Pivot pivot = find_pivot(model, of_root, scope.moments.all(), slider.root, slider.stop);
  if (pivot.pair == nullptr) return RigidPath(X_WR);
  return pivot_path(X_WR, slider.goal, pressed_point(model, query, pivot, slider.root, slider.goal));
}

RigidPath Slides::plan_rigid(const FrameScope& scope, Slider& slider) {
  const Pose& X_WR = scope.model.objects[slider.root].X_WO;
  pairs_.find_near(pair_scope(scope), slider);
  if (meter_.is_over()) return RigidPath(X_WR);
  const bool translation_only = permits_.translation_only[slider.root] != 0;
  const RigidPlan plan = plan_rigid_slide(slider, X_WR, translation_only, pairs_.near(), rows_);
  for_each_holding(rows_, plan.active.rows(), [&](std::uint32_t source) { pairs_[source].is_active = true; });
  slider.force_W = plan.force_W, slider.moment_W = plan.moment_W;
  slider.is_near_end = plan.is_near_end, slider.work += plan.work;
  return plan.path;
}

bool Slides::plan_arm(const FrameScope& scope, Slider& slider) {
  ObstaclesOfArm obstacles(*this, scope, slider);
  const ArmPlan plan = plan_arm_slide(slider, obstacles, rows_, joint_rows_);
  if (meter_.is_over()) return false;  // what held it so far depends on who came first
  slider.force_W = plan.force_W, slider.moment_W = plan.moment_W;
  pairs_.forget_held(slider);
  for_each_holding(rows_, plan.active_rows(), [&](std::uint32_t source) {
    pairs_[source].is_active = true;
    pairs_.note_held(slider, source);
  });
  slider.is_near_end = plan.is_near_end, slider.work += plan.work;
  return plan.moves;
}

/// Stops and executes the paths that are laid, as a part of the frame.
void Slides::go(const FrameScope& scope, std::uint32_t step) {
  WorldModel& model = scope.model;
  scope.stops.resolve({model, scope.query(), scope.movers.roots, scope.followers, permits_, scope.moments},
                      pairs_.pairs(), step);
  execute(model, scope.watched, scope.movers, scope.lanes);
  record_part(model, scope.movers, step, scope.parts);
  scope.moments.note_executed(model, scope.query(), scope.contacts, pairs_.pairs(), step);
  scope.moments.note_active(model, scope.query(), scope.contacts, pairs_.pairs(), step);
}

/// @returns whether another sub-step is worth while.
bool Slides::finish_step(const FrameScope& scope) {
  WorldModel& model = scope.model;
  bool goes_on = false;
  // Objects that stopped a slider may go along from here on.
  const bool shoves_more = take_shoved(model, pairs_.pairs(), scope.movers, scope.followers, scope.parts);
  // A slider goes on if it gained enough, or if a shorter sub-step still may.
  for (Slider& slider : sliders_.list) {
    if (!model.in_motion[slider.root]) {
      slider.goes_on = false;
      continue;
    }
    const double before = slider.distance, stop = model.stops[slider.root];
    rest(model, slider.root);
    if (slider.follows) continue;
    slider.distance = distance_left(slider, model.objects[slider.root].X_WO);
    const bool may_slide = permits_.may_slide[slider.root] != 0;
    if (slider.shoves) {
      const bool shoves = go_on_shoving(slider, stop, scope.followers.is_blocked(slider.root), may_slide);
      goes_on = shoves || !slider.done || goes_on;
      continue;
    }
    slider.done = !may_slide || slider.pivots;
    // A plan that was stopped early was too long: the next one is planned for less.
    const double trust = slider.trust;
    slider.trust = stop < kFarEnough ? 0.25 * trust : std::min(1.0, 4.0 * trust);
    const double gain = before - slider.distance;
    const bool ends = stop == 1.0 && slider.is_near_end && !may_lead_round(slider, gain);
    const bool gained = is_worth_going_on(slider, gain) && !ends;
    const bool shorter = stop < kFarEnough && slider.trust >= kLeastTrust;
    slider.goes_on = !slider.done && (gained || shorter);
    goes_on = goes_on || slider.goes_on;
  }
  // New followers change the pairs that matter.
  if (shoves_more) {
    add_follower_sliders(scope);
    gather_pairs(scope);
  }
  return goes_on;
}

/// The budget ended before all paths of a sub-step were checked: none is gone.
void Slides::drop_step(const FrameScope& scope) {
  WorldModel& model = scope.model;
  meter_.clip();
  for (const Slider& slider : sliders_.list)
    if (model.in_motion[slider.root]) model.stops[slider.root] = 0.0;
  execute(model, scope.watched, scope.movers, scope.lanes);
  for (const Slider& slider : sliders_.list)
    if (model.in_motion[slider.root]) rest(model, slider.root);
  cut_off_all();
}

void Slides::cut_off_all() {
  for (Slider& slider : sliders_.list) slider.is_cut_off = slider.is_cut_off || !slider.done;
}

void Slides::report_feel(const WorldModel& model, FrameReport& report) {
  report.slide_pairs = meter_.seen();
  for (const Slider& slider : sliders_.list) {
    const ObjectHandle object = model.objects.handle(slider.root);
    if (slider.is_cut_off) cut_off_.push_back(object);
    report.most_slide_work = std::max(report.most_slide_work, slider.work);
    if (slider.pivots || slider.start_distance == 0.0) continue;
    if (slider.arm != nullptr) {
      if (slider.arm->hand != nullptr)
        felt_.push_back(feel_of(*slider.arm, object, slider.force_W, slider.moment_W));
      continue;
    }
    const Pose& X_WR = model.objects[slider.root].X_WO;
    const Twist left = twist_to_goal(slider, X_WR);
    felt_.push_back(
        {object, transform(X_WR, slider.metric.centre), left.v, left.w, slider.force_W, slider.moment_W});
  }
  report.cut_off = cut_off_;
  report.felt = felt_;
}

}  // namespace touchstone
