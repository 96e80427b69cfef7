#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/motion/advancement.hpp"
#include "touchstone/contact_core/scene/motion.hpp"
#include "touchstone/physics/contacts/narrowphase_contacts.hpp"

// Pairs that close by more than the margin in a step.

namespace touchstone::physics {
namespace {

/// A pair is looked at so often on its way; it takes three or four, more where solids turn past each other.
constexpr int kMostAdvances = 64;

/// A point of a mover that goes on evenly from where it is, after `t`; `t` < 0: before.
Vector3 moved(const Vector3& p_W, const Vector3& about_W, const Vector3& v_W, const Vector3& w_W, double t) {
  const double w = norm(w_W);
  const Vector3 r = p_W - about_W;
  return (about_W + t * v_W) + (w > 0.0 ? rotate(rotation_about(w_W / w, w * t), r) : r);
}

}  // namespace

/// The part's motion as its mover has it now, and how far its solids' centres and points may come in the
/// step.
double NarrowphaseContacts::find_motion(const DynamicsWorld& world, double h, Part& part) {
  if (part.mover.kind == Mover::Kind::ground) return 0.0;
  const bool is_body = part.mover.kind == Mover::Kind::body;
  part.p_W = is_body ? world.state(part.mover.index).p_W : part.X_WM.p;
  part.v_W = world.velocity_at(part.mover, part.p_W);
  part.w_W = is_body ? world.angular_velocity(part.mover.index)
                     : world.link_angular_velocity(part.mover.index, part.mover.link);
  const double w = norm(part.w_W);
  double travel = 0.0;
  for (std::size_t i = 0; i < part.tree->solids().size(); ++i) {
    const std::size_t solid = part.first_solid + i;
    const Sphere sphere = part.tree->solids()[i].solid.bounding_sphere();
    const double lever = norm(touchstone::transform(poses_[solid], sphere.centre) - part.p_W);
    path_lengths_[solid] = (norm(part.v_W) + w * lever) * h + fall_;
    travel = std::max(travel, path_lengths_[solid] + w * sphere.radius * h);
  }
  return travel;
}

/// @return whether any part is fast.
bool NarrowphaseContacts::find_path_lengths(const DynamicsWorld& world, double h) {
  bool any = false;
  double first = 0.0, second = 0.0;  // the two longest
  fall_ = norm(world.settings().gravity_W) * h * h;
  for (Part& part : parts_) {
    part.travel = h > 0.0 ? find_motion(world, h, part) : 0.0;
    part.is_fast = part.travel > 0.5 * margin_;
    any = any || part.is_fast;
    second = std::max(second, std::min(first, part.travel));
    first = std::max(first, part.travel);
  }
  reach_ = any ? margin_ + (first + second) : margin_;
  return any;
}

/// The largest speed at which the solids close along n, whose bounding spheres' centres are at a_W and b_W:
/// the centres' velocities and the share of each solid's rotation. A turning centre's velocity changes by w^2
/// times its lever.
double NarrowphaseContacts::closing_speed(const SolidPair& pair, const Vector3& n_AB_W, const Vector3& a_W,
                                          const Vector3& b_W) const {
  double speed = 0.0;
  for (const int side : {0, 1}) {
    const SolidIndex solid = side == 0 ? pair.a : pair.b;
    const Part& part = part_of(solid);
    const double radius = part.tree->solids()[solid - part.first_solid].solid.bounding_sphere().radius;
    const Vector3 r = (side == 0 ? a_W : b_W) - part.p_W;
    const double w = norm(part.w_W), towards = dot(n_AB_W, part.v_W + cross(part.w_W, r));
    speed += (side == 0 ? towards : -towards) + (w * radius + w * w * norm(r) * step_);
  }
  return speed + 2.0 * fall_ / step_;
}

/// The pair's solids as their movers have them after `t` if they go on evenly: into trial_poses_.
void NarrowphaseContacts::place_on_path(const SolidPair& pair, double t) {
  for (const SolidIndex solid : {pair.a, pair.b}) {
    const Part& part = part_of(solid);
    const double w = norm(part.w_W);
    Pose& X = trial_poses_[solid] = poses_[solid];
    X.p = moved(X.p, part.p_W, part.v_W, part.w_W, t);
    if (w > 0.0) X.R = product(rotation_about(part.w_W / w, w * t), X.R);
  }
}

/// How long the pair surely stays further apart than half the margin, from `t` on.
double NarrowphaseContacts::clear_time(const SolidPair& pair, const PairGeometry& geometry, double t) const {
  const auto centre_of = [&](SolidIndex solid) {
    const Part& part = part_of(solid);
    const Sphere sphere = part.tree->solids()[solid - part.first_solid].solid.bounding_sphere();
    return moved(touchstone::transform(poses_[solid], sphere.centre), part.p_W, part.v_W, part.w_W, t);
  };
  const double speed = closing_speed(pair, geometry.n_AB_W, centre_of(pair.a), centre_of(pair.b));
  if (!(speed > 0.0) || !std::isfinite(geometry.separation)) return kInfinity;
  return (geometry.separation - 0.5 * margin_) / speed;
}

/// Conservative advancement: from each distance as far on as cannot bring the solids within half the margin,
/// until they are within it.
void NarrowphaseContacts::meet_on_path(const SolidPair& pair, const PairGeometry& now) {
  PairGeometry geometry = now;
  PairStatus status = PairStatus::separated;
  std::array<ContactPoint, kMaxManifoldPoints> points;
  double t = 0.0;
  bool meets = false;
  const auto look = [&](double at) -> std::optional<double> {
    if (at > 0.0) {
      place_on_path(pair, at);
      const Query query{QueryKind::manifold, reach_, kMaxManifoldPoints, reach_};
      narrowphase_->evaluate({{&pair, 1}, trial_poses_, query, {}}, {{&status, 1}, {&geometry, 1}, points},
                             *workspace_);
    }
    meets = !(status == PairStatus::separated && geometry.separation > margin_);
    if (meets) return {};
    const double next = at + clear_time(pair, geometry, at);
    return next < step_ ? std::optional(next) : std::nullopt;
  };
  if (advance(t, kMostAdvances + 1, look) == AdvanceEnd::looks_spent) ++unfollowed_;
  if (meets) take_met(pair, status, geometry, points, t);
}

/// The points where the two meet after `t`, as the bodies stand now.
void NarrowphaseContacts::take_met(const SolidPair& pair, PairStatus status, PairGeometry& geometry,
                                   std::span<ContactPoint> points, double t) {
  const Part &a = part_of(pair.a), &b = part_of(pair.b);
  int kept = 0;
  for (const ContactPoint& there : points.first(static_cast<std::size_t>(geometry.point_count))) {
    ContactPoint point = there;
    point.p_A_W = moved(there.p_A_W, a.p_W + t * a.v_W, -a.v_W, -a.w_W, t);
    point.p_B_W = moved(there.p_B_W, b.p_W + t * b.v_W, -b.v_W, -b.w_W, t);
    // A turn may bring points together from beyond each other: seen along n they never meet.
    if (dot(geometry.n_AB_W, point.p_B_W - point.p_A_W) > 0.0) points[kept++] = point;
  }
  unfollowed_ += kept == 0 ? 1 : 0;
  geometry.point_count = kept;
  take(pair, status, geometry, points, {trial_poses_, t});
}

}  // namespace touchstone::physics
