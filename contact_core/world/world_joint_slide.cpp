#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/world/world_state.hpp"

// Slides of mechanisms: as those of rigid bodies (world_slide.cpp), but the motion is a change of joint
// values.

namespace touchstone {
namespace {

/// What is planned is executed where it gains this share.
constexpr double kWorthwhile = 0x1p-30;
/// A plan changes what may come near, and what is near the plan.
constexpr int kRounds = 2 * kSlidePlaneRounds;

/// By the bounds of the path that a change of joint values makes.
class ArmBends final : public JointBends {
 public:
  ArmBends(MechanismMover& arm, std::span<const SlideRow> rows, std::span<const JointRow> joint_rows)
      : arm_(arm), rows_(rows), joint_rows_(joint_rows) {}

  void lay(const JointVector& dq) noexcept override { lay_path(arm_, dq); }
  double most(std::size_t row) noexcept override { return most_of(rows_[row], joint_rows_[row]); }
  double bend(std::size_t row) noexcept override { return bend_of(rows_[row], joint_rows_[row]); }

  static void lay_path(MechanismMover& arm, const JointVector& dq) noexcept {
    JointVector to{};
    const std::size_t count = arm.actual.size();
    for (std::size_t k = 0; k < count; ++k) to[k] = arm.actual[k] + dq[k];
    arm.go(std::span(to).first(count));
  }

 private:
  const MechanismPath& path_of(const JointRow& at) { return arm_.relative.seen_from(at.other, arm_.path); }

  double most_of(const SlideRow& row, const JointRow& at) noexcept {
    const MechanismPath& path = path_of(at);
    const Vector3 p_L = rotate_back(arm_.X_WL[at.link].R, row.r);
    const double straight = path.acceleration_bound(at.link, p_L);
    return straight + steepness_of(row) * bend_of_plane(path, at.link, p_L);
  }

  double bend_of(const SlideRow& row, const JointRow& at) noexcept {
    const MechanismPath& path = path_of(at);
    const BodyState state = path.at(at.link, 0.0);
    const Vector3 p_W = row.r + arm_.X_WL[at.link].p;
    const double straight = path.curvature_bound(at.link, state, p_W, row.n);
    const double steepness = steepness_of(row);
    if (steepness == 0.0) return straight;
    return straight + steepness * bend_of_plane(path, at.link, transform(inverse(state.X_WO), p_W));
  }

  /// How much faster than the mover a row's plane may turn: two edges' does the more, the less they cross.
  static double steepness_of(const SlideRow& row) noexcept {
    if (row.turns) return 1.0;
    return row.e == Vector3::Zero() ? 0.0 : norm(row.e) * norm(row.f);
  }

  /// A plane of the mover's own turns with it. With o the mover's point that is in the obstacle's at p at
  /// first, T and T' bounds on its turning and V on o's speed:
  ///   |(n . (p - o))''| <= |n''| |p - o| + 2 |n'| |o'| + |n . o''| <= (T^2 + T') V + 2 T V + |n . o''|.
  static double bend_of_plane(const MechanismPath& path, std::uint32_t link, const Vector3& p_L) noexcept {
    const double V = path.speed_bound(link, p_L), T = path.turn_bound(link);
    return ((T * T + path.turn_change_bound(link)) + 2.0 * T) * V;
  }

  MechanismMover& arm_;
  std::span<const SlideRow> rows_;
  std::span<const JointRow> joint_rows_;
};

}  // namespace

void ContactWorld::State::begin_joint_slide(Slider& slider) {
  MechanismMover& arm = *slider.arm;
  // No value is ever further from its goal than now in the metric.
  const double distance = distance_of(slider);
  double shift_limit = 0.0;
  for (std::size_t k = 0; k < arm.actual.size(); ++k)
    shift_limit = std::max(shift_limit, std::abs(arm.commanded[k]) + distance / std::sqrt(arm.weights[k]));
  if (shift_limit > arm.shift_limit) arm.frame.set_reaches(arm.shift_limit = 2.0 * shift_limit);
}

std::uint32_t ContactWorld::State::other_link(const Slider& slider, SolidIndex other) const {
  return root_of(other) == slider.root ? objects[body_of(other)].link : slider.arm->mechanism->base();
}

void ContactWorld::State::add_joint_rows(const Slider& slider) {
  const MechanismMover& arm = *slider.arm;
  slides.joint_rows.clear();
  for (const SlideRow& row : slides.rows) {
    const auto [mover, obstacle] = mover_first(slides.pairs[row.source].solids, slider.root);
    JointRow out;
    out.slack = row.slack, out.room = row.room;
    out.link = objects[body_of(mover)].link;
    out.other = other_link(slider, obstacle);
    for (std::uint32_t k = 0; k < arm.actual.size(); ++k) {
      const int way = arm.frame.sign(k, out.link, out.other);
      if (way == 0) continue;
      const Twist twist = arm.frame.twist(k, arm.X_WL[out.link].p);
      out.g[k] = way * dot(row.n, twist.v + cross(twist.w, row.r));
    }
    slides.joint_rows.push_back(out);
  }
}

Twist ContactWorld::State::joint_twist(const Slider& slider, const JointVector& dq,
                                       const NearPair& near) const {
  const auto [mover, obstacle] = mover_first(slides.pairs[near.source].solids, slider.root);
  return slider.arm->frame.twist(dq, objects[body_of(mover)].link, other_link(slider, obstacle),
                                 near.centre_W);
}

/// How far the path that is laid takes each solid, for add_pairs_in_way(); further than was looked ahead for,
/// there is more to meet.
void ContactWorld::State::measure_plan(const Slider& slider) {
  bool is_beyond = false;
  const std::pair<std::uint32_t, std::uint32_t> first{slider.root, 0};
  for (auto member = std::lower_bound(members.begin(), members.end(), first);
       member != members.end() && member->first == slider.root; ++member) {
    const std::uint32_t i = member->second;
    const bool is_carried_on = moves(i);
    for (SolidIndex solid = layout.first_solid[i]; solid < layout.first_solid[i + 1]; ++solid) {
      const double planned = is_carried_on ? travel_on(*slider.arm, solid) : 0.0;
      travels.planned_solid[solid] = planned;
      is_beyond = is_beyond || !(travels.of_solid[solid] + planned <= travels.lively_solid[solid]);
    }
  }
  measure_own_travels(*slider.arm, travels.planned_own);
  const std::size_t links = slider.arm->X_WL.size(), first_own = slider.arm->first_own;
  for (std::size_t own = first_own; own < first_own + links * links; ++own)
    is_beyond = is_beyond || !(travels.of_own[own] + travels.planned_own[own] <= travels.lively_own[own]);
  if (slides.sliders.size() > 1 || !is_beyond) return;
  choose_lively();
  gather_slide_pairs();
}

void ContactWorld::State::note_held_pairs(const Slider& slider, const JointSlidePlan& plan) {
  std::erase_if(slides.held, [&](const HeldPair& held) { return held.root == slider.root; });
  for (int i = 0; i < plan.active_count; ++i) {
    const std::uint32_t source = slides.rows[plan.active[i]].source;
    const bool is_noted = std::any_of(slides.held.begin(), slides.held.end(), [&](const HeldPair& held) {
      return held.root == slider.root && held.source == source;
    });
    if (!is_noted) slides.held.push_back({slider.root, source});
  }
}

/// @returns whether there is any that is not near already.
bool ContactWorld::State::add_held_pairs(const Slider& slider) {
  const std::size_t before = slides.near.size();
  for (const HeldPair& held : slides.held) {
    const std::uint32_t watch = slides.pairs[held.source].watch;
    if (held.root != slider.root || watch == SlideState::kNone || slides.is_near[watch]) continue;
    slides.is_near[watch] = 1;
    add_near_pair(slider, held.source);
  }
  return slides.near.size() > before;
}

/// Rows of what the plan could meet only: with the others it would be the same.
bool ContactWorld::State::plan_joints(Slider& slider) {
  MechanismMover& arm = *slider.arm;
  arm.frame.set(arm.X_WL);
  JointVector goal{}, wanted{};
  for (std::size_t k = 0; k < arm.actual.size(); ++k) {
    goal[k] = arm.commanded[k] - arm.actual[k];
    wanted[k] = slider.trust * goal[k];
  }
  find_near_pairs(slider);
  const auto plan_with = [&](bool all) {
    order_near_rows(all);
    add_joint_rows(slider);
    ArmBends bends(arm, slides.rows, slides.joint_rows);
    return plan_joint_slide(wanted, arm.weights, slides.joint_rows, bends);
  };
  const auto choose_planes = [&](const JointSlidePlan& along) {
    bool changed = false;
    for (NearPair& near : slides.near)
      if (!near.is_sure && choose_plane(near, joint_twist(slider, along.dq, near))) changed = true;
    return changed;
  };
  JointSlidePlan plan = plan_with(false);
  bool has_all =
      std::all_of(slides.near.begin(), slides.near.end(), [](const NearPair& near) { return near.is_sure; });
  // What held the last sub-step is likely to hold this one: without it the plan goes far off, and all that
  // lies there is looked at.
  if (add_held_pairs(slider)) {
    choose_planes(plan);
    plan = plan_with(true);
    has_all = true;
  }
  for (int round = 0; round < kRounds; ++round) {
    ArmBends::lay_path(arm, plan.dq);
    measure_plan(slider);
    bool changed = add_pairs_in_way(slider) || !has_all;
    if (slides.meter.is_over()) break;
    if (choose_planes(plan)) changed = true;
    if (!changed) break;
    plan = plan_with(true);
    has_all = true;
  }
  slider.is_near_end =
      slider.trust == 1.0 && plan.is_whole && !shares_room() && leaves_little(slider, plan.left_over);
  for (int i = 0; i < plan.active_count; ++i) mark_active(plan.active[i]);
  note_held_pairs(slider, plan);
  for (std::size_t k = 0; k < arm.actual.size(); ++k) goal[k] -= plan.dq[k];
  const double gain = slider.distance - std::sqrt(joint_product(goal, goal, arm.weights));
  const bool moves = gain >= kWorthwhile * slider.start_distance && gain > 0.0 && !slides.meter.is_over();
  ArmBends::lay_path(arm, moves ? plan.dq : JointVector{});
  if (moves) arm.path.finish();
  return moves;
}

}  // namespace touchstone
