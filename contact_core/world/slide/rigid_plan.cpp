#include "touchstone/contact_core/world/slide/rigid_plan.hpp"

#include <algorithm>

namespace touchstone {
namespace {

constexpr int kPlaneRounds = 3;
/// The square of the distance along a twist is a parabola but for terms of third order in its turn: it falls
/// throughout where it still falls from here to the end.
constexpr double kNearEnd = 0.875;
constexpr int kShortenings = 16;
constexpr double kShorter = 0.75;

/// By the rows that hold the plan alone: what they take from the whole of what is left.
void feel(const Slider& slider, const Twist& left, const TwistMetric& metric_W, bool translation_only,
          std::span<const SlideRow> all, const ActiveRows& active, RigidPlan& plan) {
  std::array<SlideRow, kTwistSize> rows;
  for (int i = 0; i < active.count; ++i) {
    rows[i] = all[active.row[i]];
    rows[i].slack = std::max(rows[i].slack, 0.0);
  }
  Twist kept;
  ActiveRows holding;
  constexpr std::array<double, kTwistSize> kNoLift{};
  const auto count = static_cast<std::size_t>(active.count);
  if (!project(left, metric_W, std::span(rows).first(count), std::span(kNoLift).first(count),
               translation_only, kept, holding))
    return;
  for (int i = 0; i < holding.count; ++i) {
    const SlideRow& row = rows[holding.row[i]];
    const Vector3 force_W = (slider.stiffness * holding.force[i]) * row.n;
    plan.force_W += force_W;
    plan.moment_W += cross(row.r, force_W);
  }
}

/// As far along a twist as the distance falls; else nowhere.
void take_path(const Slider& slider, const Pose& X_WR, Twist step, RigidPlan& plan) {
  for (int i = 0; i < kShortenings; ++i, step = kShorter * step) {
    const RigidPath path = RigidPath::by(X_WR, step.v, step.w, slider.metric.centre);
    if (i == 1) plan.is_near_end = false;
    const double end = distance_to_goal(slider, path.to()), gain = slider.distance - end;
    if (!(gain >= kWorthwhile * slider.start_distance && gain > 0.0)) continue;
    if (end > distance_to_goal(slider, path.pose_at(kNearEnd))) continue;
    plan.path = path;
    return;
  }
}

}  // namespace

RigidPlan plan_rigid_slide(const Slider& slider, const Pose& X_WR, bool translation_only,
                           std::span<NearPair> near, std::vector<SlideRow>& rows) {
  const TwistMetric metric_W = metric_at(slider, X_WR);
  Twist goal = twist_to_goal(slider, X_WR);
  if (translation_only) goal.w = Vector3::Zero();
  std::uint64_t work = near.size();
  const auto plan_with = [&](bool all) {
    collect_rows(near, all, rows);
    const SlidePlan plan = plan_slide(slider.trust * goal, metric_W, rows, translation_only);
    work += plan.work;
    return plan;
  };
  // The first plan uses only the pairs whose plane is certain; planes of the others follow from the plans.
  SlidePlan twist = plan_with(false);
  for (int round = 0; round < kPlaneRounds; ++round) {
    bool changed = round == 0;
    for (NearPair& pair : near)
      if (!pair.is_sure && choose_plane(pair, twist.twist)) changed = true;
    if (!changed || (round > 0 && slider.has_spent(work))) break;
    twist = plan_with(true);
  }
  // The result names the contacts that hold the plan, and the hand feels them.
  RigidPlan plan{RigidPath(X_WR)};
  plan.active = twist.active;
  plan.work = work;
  feel(slider, goal, metric_W, translation_only, rows, twist.active, plan);
  plan.is_near_end =
      slider.trust == 1.0 && twist.is_whole && !shares_room(near) && leaves_little(slider, twist.left_over);
  take_path(slider, X_WR, twist.twist, plan);
  return plan;
}

}  // namespace touchstone
