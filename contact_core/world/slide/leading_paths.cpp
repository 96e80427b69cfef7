#include "touchstone/contact_core/world/slide/leading_paths.hpp"

#include <array>
#include <numbers>
#include <tuple>

#include "touchstone/contact_core/motion/clear_stretch.hpp"

namespace touchstone {

RigidPath pivot_path(const Pose& X_WO, const Pose& goal, const Vector3& touching_W) {
  const Vector3 p_O = transform(inverse(X_WO), touching_W);
  const Vector3 turn = RigidPath::between(X_WO, goal).at(0, 0.0).angular_velocity_W;
  return RigidPath::by(X_WO, transform(goal, p_O) - touching_W, turn, p_O).ending_at(goal);
}

Pivot find_pivot(const WorldModel& model, std::span<const FramePair> pairs, std::span<const Moment> moments,
                 std::uint32_t root, double stop) {
  Pivot pivot;
  const Moment* found = nullptr;
  for (const FramePair& pair : pairs) {
    if (pair.stop == kNoMoment) continue;
    const Moment& moment = moments[pair.stop];
    const bool of_a = model.root_of(pair.solids.a) == root, of_b = model.root_of(pair.solids.b) == root;
    if (!(of_a || of_b) || moment.part != 0 || moment.s != stop) continue;
    const Vector3& p = of_a ? moment.geometry.p_A_W : moment.geometry.p_B_W;
    // Places alone decide between equals, so that no order of pairs shows.
    const auto key = [](double separation, const Vector3& at) {
      return std::tuple(separation, at.x(), at.y(), at.z());
    };
    if (found != nullptr &&
        !(key(moment.geometry.separation, p) < key(found->geometry.separation, pivot.touching_W)))
      continue;
    found = &moment;
    pivot = {&pair, p};
  }
  return pivot;
}

Vector3 pressed_point(const WorldModel& model, NarrowphaseQuery& query, const Pivot& pivot,
                      std::uint32_t root, const Pose& goal) {
  const auto [a, b] = pivot.pair->solids;
  const bool is_a = model.root_of(a) == root;
  PairGeometry geometry{};
  std::array<ContactPoint, kMaxManifoldPoints> points;
  query.set_pair(pivot.pair->solids);
  const double reach = 2.0 * pivot.pair->gap;
  if (!has_geometry(query.manifold(model.from[a], model.from[b], reach, geometry, points)))
    return pivot.touching_W;
  const Vector3 n = is_a ? Vector3(-geometry.n_AB_W) : geometry.n_AB_W;  // from the obstacle
  const BodyState start = RigidPath::between(model.objects[root].X_WO, goal).at(0, 0.0);
  const auto key = [&](const Vector3& p) {
    const double away = dot(n, point_velocity(start, p));
    return std::tuple(away, p.x(), p.y(), p.z());
  };
  const Vector3* pressed = nullptr;
  for (const ContactPoint& point : std::span(points).first(static_cast<std::size_t>(geometry.point_count))) {
    const Vector3& p = is_a ? point.p_A_W : point.p_B_W;
    if (pressed == nullptr || key(p) < key(*pressed)) pressed = &p;
  }
  return pressed == nullptr ? pivot.touching_W : *pressed;
}

void begin_shove(Slider& slider, const RigidPath& path, double stop) {
  const BodyState start = path.at(0, 0.0);
  slider.shoves = true;
  slider.remaining = (1.0 - stop) * Twist{start.velocity_W, start.angular_velocity_W};
  slider.remaining_centre_O = transform(inverse(path.from()), start.centre_W);
}

bool go_on_shoving(Slider& slider, double stop, bool is_blocked, bool may_slide) {
  slider.remaining = (1.0 - stop) * slider.remaining;
  slider.shoves = stop < 1.0 && !is_blocked;
  const bool slides_on = may_slide && (slider.arm != nullptr || norm(slider.remaining.w) <= std::numbers::pi);
  slider.done = stop >= 1.0 || (!slider.shoves && !slides_on);
  return slider.shoves;
}

RigidPath shoving_path(const Slider& slider, const Pose& X_WO) {
  return RigidPath::by(X_WO, slider.remaining.v, slider.remaining.w, slider.remaining_centre_O)
      .ending_at(slider.goal);
}

RigidPath path_along(const RigidPath& leader, const Pose& X_WO) {
  if (leader.at_rest()) return RigidPath(X_WO);
  const BodyState start = leader.at(0, 0.0);
  return RigidPath::by(X_WO, start.velocity_W, start.angular_velocity_W,
                       transform(inverse(X_WO), start.centre_W));
}

}  // namespace touchstone
