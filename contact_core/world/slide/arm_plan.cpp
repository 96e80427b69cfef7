#include "touchstone/contact_core/world/slide/arm_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/world/slide/arm_hand.hpp"

namespace touchstone {
namespace {

/// A plan changes what may come near, and what is near the plan.
constexpr int kRounds = 6;

/// By the bounds of the path that a change of joint values makes.
class ArmBends final : public JointBends {
 public:
  ArmBends(MechanismMover& arm, std::span<const SlideRow> rows, std::span<const JointRow> joint_rows)
      : arm_(arm), rows_(rows), joint_rows_(joint_rows) {}

  void lay(const JointVector& dq) noexcept override {
    lay_path(arm_, dq);
    along_.link = kNoIndex;
  }
  // Those behind the contacts' are of joints' stops, from which nothing bends.
  double most(std::size_t row) noexcept override {
    return row < rows_.size() ? most_of(rows_[row], joint_rows_[row]) : 0.0;
  }
  double bend(std::size_t row) noexcept override {
    return row < rows_.size() ? bend_of(rows_[row], joint_rows_[row]) : 0.0;
  }

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
    const Vector3 p_L = transform(inverse(path.at(at.link, 0.0).X_WO), Vector3(row.r + arm_.X_WL[at.link].p));
    // Rows of one plane, and of several that lie flush, share their direction.
    if (along_.link != at.link || along_from_ != at.other || along_.n_W != row.n)
      along_ = path.along_of(at.link, row.n), along_from_ = at.other;
    const double straight = path.curvature_along(along_, p_L);
    const double steepness = steepness_of(row);
    return steepness == 0.0 ? straight : straight + steepness * bend_of_plane(path, at.link, p_L);
  }

  /// How much faster than the mover a row's plane may turn: two edges' does the more, the less they cross.
  static double steepness_of(const SlideRow& row) noexcept {
    if (row.turns) return 1.0;
    return row.e == Vector3::Zero() ? 0.0 : norm(row.e) * norm(row.f);
  }

  /// A plane of the mover turns with it. With o the mover's point that is in the obstacle's at p at
  /// first, T and T' bounds on its turning and V on o's speed:
  ///   |(n . (p - o))''| <= |n''| |p - o| + 2 |n'| |o'| + |n . o''| <= (T^2 + T') V + 2 T V + |n . o''|.
  static double bend_of_plane(const MechanismPath& path, std::uint32_t link, const Vector3& p_L) noexcept {
    const double V = path.speed_bound(link, p_L), T = path.turn_bound(link);
    return ((T * T + path.turn_change_bound(link)) + 2.0 * T) * V;
  }

  MechanismMover& arm_;
  std::span<const SlideRow> rows_;
  std::span<const JointRow> joint_rows_;
  // Of the path that is laid, as seen from a link.
  MechanismPath::Along along_{kNoIndex, Vector3::Zero(), 0.0, 0.0};
  std::uint32_t along_from_ = kNoIndex;
};

void find_joint_rows(const MechanismMover& arm, std::span<const SlideRow> rows,
                     std::vector<JointRow>& joint_rows) {
  joint_rows.clear();
  // Mostly all rows are of one link, whose twists are the same in each.
  std::array<Twist, kMostSlideJoints> twists;
  std::uint32_t twists_of = kNoIndex;
  for (const SlideRow& row : rows) {
    if (row.link != twists_of) {
      for (std::uint32_t k = 0; k < arm.actual.size(); ++k)
        twists[k] = arm.frame.twist(k, arm.X_WL[row.link].p);
      twists_of = row.link;
    }
    JointRow& out = joint_rows.emplace_back();
    out.slack = row.slack, out.room = row.room;
    out.link = row.link, out.other = row.other_link;
    for (std::uint32_t k = 0; k < arm.actual.size(); ++k) {
      const int sign = arm.frame.sign(k, row.link, row.other_link);
      if (sign != 0) out.g[k] = sign * dot(row.n, twists[k].v + cross(twists[k].w, row.r));
    }
  }
}

/// Limits of joints that a plan would go beyond, as rows behind those of the contacts: in a metric that
/// couples joints one that is held changes where the others do best.
class JointStops {
 public:
  /// @returns whether the plan goes beyond any that has no row yet; it has one from now on.
  bool take_up(const MechanismMover& arm, const JointVector& dq) {
    bool any = false;
    for (const Mechanism::Joint& joint : arm.mechanism->joints()) {
      if (joint.value == Mechanism::kNone) continue;
      const double q = arm.actual[joint.value], to = q + dq[joint.value];
      const bool is_low = to < joint.lower;
      if (!is_low && !(to > joint.upper)) continue;
      bool& has_row = (is_low ? has_lower_ : has_upper_)[joint.value];
      if (has_row || count_ == kMostStops) continue;
      has_row = any = true;
      stops_[count_++] = {joint.value, is_low ? 1.0 : -1.0, is_low ? q - joint.lower : joint.upper - q};
    }
    return any;
  }
  /// How many rows contacts may have.
  std::size_t room() const { return kMostSlideRows - count_; }
  void append_to(std::vector<JointRow>& rows) const {
    for (const Stop& stop : std::span(stops_).first(count_)) {
      JointRow& row = rows.emplace_back();
      row.g[stop.value] = stop.sign;
      row.slack = stop.left;
    }
  }
  /// Where rounding takes a value beyond its stop.
  void hold(const MechanismMover& arm, JointVector& dq) const {
    for (const Mechanism::Joint& joint : arm.mechanism->joints()) {
      if (joint.value == Mechanism::kNone || !(has_lower_[joint.value] || has_upper_[joint.value])) continue;
      const double q = arm.actual[joint.value];
      dq[joint.value] = std::clamp(q + dq[joint.value], joint.lower, joint.upper) - q;
    }
  }

 private:
  struct Stop {
    std::uint32_t value;
    double sign, left;  // +-1, of motion away from it; how far it is
  };
  static constexpr std::size_t kMostStops = 2 * kMostSlideJoints;

  std::array<bool, kMostSlideJoints> has_lower_{}, has_upper_{};
  std::array<Stop, kMostStops> stops_;
  std::size_t count_ = 0;
};

/// Along a change of joint values. @returns whether any plane is another one than before.
bool choose_planes(const MechanismMover& arm, ArmObstacles& obstacles, const JointVector& dq) {
  bool changed = false;
  for (NearPair& near : obstacles.near()) {
    if (near.is_sure) continue;
    if (choose_plane(near, arm.frame.twist(dq, near.link, near.other_link, near.centre_W))) changed = true;
  }
  return changed;
}

/// A plan that leaves less than this share of its gain to the next sub-step is near its end. In the steady
/// slides of arms another sub-step gained a hundredth of what the first one did, and took as long.
constexpr double kLittleOfGain = 0x1p-5;

/// Whether a pair in contact does not hold the plan: it parts from it, and what comes then is not foreseen.
bool parts_from_any(std::span<const NearPair> near, std::span<const SlideRow> rows,
                    std::span<const int> active) {
  return std::any_of(near.begin(), near.end(), [&](const NearPair& pair) {
    if (pair.separation > pair.gap) return false;
    bool holds = false;
    for_each_holding(rows, active, [&](std::uint32_t source) { holds = holds || source == pair.source; });
    return !holds;
  });
}

/// Whether a next sub-step would gain little, where this one is gone to its end. @param gain of the plan [m].
bool is_near_end(const Slider& slider, std::span<const NearPair> near, const JointSlidePlan& plan,
                 double gain, std::span<const SlideRow> rows, const ArmPlan& out) {
  if (slider.trust < 1.0 || !plan.is_for_all || shares_room(near)) return false;
  if (plan.is_whole && leaves_little(slider, plan.left_over)) return true;
  // What the rows that were raised for bends keep from it is all that is left to gain.
  const double left = std::max(plan.left_over, plan.shortfall);
  return left <= 2.0 * kLittleOfGain * gain * slider.distance &&
         !parts_from_any(near, rows, out.active_rows());
}

/// Writes the contacts that hold a plan, whether it is worth its while, and its path. @param goal what the
/// command has left.
void take_plan(const Slider& slider, ArmObstacles& obstacles, const JointSlidePlan& plan, JointVector goal,
               std::span<const SlideRow> rows, std::span<const JointRow> joint_rows, ArmPlan& out) {
  MechanismMover& arm = *slider.arm;
  // The result names the contacts that hold the plan, and the hand feels them.
  for (const int row : std::span(plan.active).first(static_cast<std::size_t>(plan.active_count)))
    if (static_cast<std::size_t>(row) < rows.size()) out.active[out.held_by++] = row;
  if (arm.hand != nullptr)
    feel(arm, rows, joint_rows, std::span(plan.active).first(static_cast<std::size_t>(plan.active_count)),
         out.force_W, out.moment_W);
  // The plan is laid as a path only if it gains enough.
  for (std::size_t k = 0; k < arm.actual.size(); ++k) goal[k] -= plan.dq[k];
  const double gain = slider.distance - std::sqrt(joint_product(goal, goal, arm.metric()));
  out.is_near_end = is_near_end(slider, obstacles.near(), plan, gain, rows, out);
  out.moves = gain >= kWorthwhile * slider.start_distance && gain > 0.0 && !obstacles.is_over();
  ArmBends::lay_path(arm, out.moves ? plan.dq : JointVector{});
  if (out.moves) arm.path.finish();
}

}  // namespace

void begin_arm_slide(const Slider& slider) {
  MechanismMover& arm = *slider.arm;
  if (arm.hand != nullptr) weigh_by_hand(arm);
  // No value is ever further from its goal than now in the metric.
  const double distance = distance_left(slider, {});
  double shift_limit = 0.0;
  for (std::size_t k = 0; k < arm.actual.size(); ++k)
    shift_limit = std::max(shift_limit, std::abs(arm.commanded[k]) + distance / std::sqrt(arm.weights[k]));
  if (shift_limit > arm.shift_limit) arm.frame.set_reaches(arm.shift_limit = 2.0 * shift_limit);
}

ArmPlan plan_arm_slide(const Slider& slider, ArmObstacles& obstacles, std::vector<SlideRow>& rows,
                       std::vector<JointRow>& joint_rows) {
  // The plan aims at the part of the remaining joint motion that the slider is trusted with.
  MechanismMover& arm = *slider.arm;
  arm.frame.set(arm.X_WL);
  const JointVector goal = joints_left(arm);
  JointVector wanted{};
  for (std::size_t k = 0; k < arm.actual.size(); ++k) wanted[k] = slider.trust * goal[k];
  // Pairs near where the arm stands are taken up first.
  obstacles.take_up_standing();
  // A plan is repeated with a row for each joint limit that it goes beyond, until it keeps to all.
  JointStops stops;
  ArmPlan out;
  const auto has_spent = [&] { return slider.has_spent(out.work + obstacles.near().size()); };
  const auto plan_with = [&](bool all) {
    collect_rows(obstacles.near(), all, rows);
    for (;;) {
      if (rows.size() > stops.room()) rows.resize(stops.room());
      find_joint_rows(arm, rows, joint_rows);
      stops.append_to(joint_rows);
      ArmBends bends(arm, rows, joint_rows);
      JointSlidePlan plan = plan_joint_slide(wanted, arm.metric(), joint_rows, bends);
      out.work += plan.work;
      if (stops.take_up(arm, plan.dq) && !has_spent()) continue;  // each limit once at most
      stops.hold(arm, plan.dq);
      return plan;
    }
  };
  // The first plan uses only the pairs whose plane is certain.
  const std::span<const NearPair> standing = obstacles.near();
  const auto is_sure = [](const NearPair& near) { return near.is_sure; };
  const bool has_all = std::all_of(standing.begin(), standing.end(), is_sure);
  const bool has_any = standing.empty() || std::any_of(standing.begin(), standing.end(), is_sure);
  JointSlidePlan plan;
  plan.dq = wanted;
  if (has_any) plan = plan_with(false);
  // Pairs in contact probably hold this sub-step, and so do those that held the last one: without them the
  // plan goes far off, and all that lies there is looked at.
  if (obstacles.take_up_held() || !has_all) {
    choose_planes(arm, obstacles, plan.dq);
    plan = plan_with(true);
  }
  // Pairs that the plan could bring together are added, until no plane changes any more.
  for (int round = 0; round < kRounds; ++round) {
    ArmBends::lay_path(arm, plan.dq);
    bool changed = obstacles.take_up_on_path();
    if (obstacles.is_over()) break;
    if (choose_planes(arm, obstacles, plan.dq)) changed = true;
    if (!changed || has_spent()) break;
    plan = plan_with(true);
  }
  out.work += obstacles.near().size();
  take_plan(slider, obstacles, plan, goal, rows, joint_rows, out);
  return out;
}

}  // namespace touchstone
