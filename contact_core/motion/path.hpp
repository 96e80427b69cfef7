#pragma once

#include <cstdint>
#include <span>

#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"

/// @file
/// Motion within one frame: a path over s in [0, 1], from the pose at the frame's start to the commanded one.

namespace touchstone {

/// A body's pose on its path and its motion there; rates are with respect to s.
struct BodyState {
  Pose X_WO;
  Vector3 centre_W = Vector3::Zero();            ///< the point it turns about [m]
  Vector3 velocity_W = Vector3::Zero();          ///< of that point [m]
  Vector3 angular_velocity_W = Vector3::Zero();  ///< [rad]
};

/// The velocity of the point fixed in the body that is at p_W.
inline Vector3 point_velocity(const BodyState& state, const Vector3& p_W) {
  return state.velocity_W + cross(state.angular_velocity_W, p_W - state.centre_W);
}

/// Bounds on how a body and a point fixed in it move, over the rest of a path.
struct MotionBounds {
  double speed, acceleration;  ///< of the point [m]
  double turn, turn_change;    ///< of the angular velocity and its derivative [rad]
};

/// One mover's path: a rigid object, a latched chain or a mechanism. Const use from several threads is safe.
class MotionPath {
 public:
  virtual ~MotionPath() = default;

  /// @param body of a mover with several; 0 otherwise. @param s in [0, 1].
  virtual BodyState at(std::uint32_t body, double s) const noexcept = 0;

  /// True where the state's centre moves straight at a constant rate and the body turns at a constant rate
  /// about a fixed direction: contacts may then be followed by planes that turn with the body.
  virtual bool is_steady() const noexcept { return false; }

  /// A bound on |d^2/ds^2 (n . p)| over [s, 1] for a point p fixed in the body.
  /// @param state of the body at s. @param p_W where the point is at s. @param n_W unit, fixed in the world.
  virtual double curvature_bound(std::uint32_t body, const BodyState& state, const Vector3& p_W,
                                 const Vector3& n_W) const noexcept = 0;
  /// Bounds over [s, 1] for the point that is at p_W at s.
  virtual MotionBounds bounds(std::uint32_t body, const BodyState& state,
                              const Vector3& p_W) const noexcept = 0;
  /// curvature_bound() of several points of the body, which may share terms. @pre as many `out`.
  virtual void curvature_bounds(std::uint32_t body, const BodyState& state, std::span<const Vector3> points_W,
                                const Vector3& n_W, std::span<double> out) const noexcept {
    for (std::size_t i = 0; i < points_W.size(); ++i) out[i] = curvature_bound(body, state, points_W[i], n_W);
  }
};

/// The path of a mechanism in the frame of one of its bodies: that body rests where it is at s = 0, and the
/// world moves. Planes that turn with the body are fixed in that frame.
class PathViews {
 public:
  virtual ~PathViews() = default;
  /// Valid while the path stays as it is.
  virtual const MotionPath& seen_from(std::uint32_t body) noexcept = 0;
  /// The body that is fixed in the world; static objects move with it in every view.
  virtual std::uint32_t standing_body() const noexcept = 0;
};

/// The path of a free object: its origin moves straight, and it turns about a fixed axis at a constant rate
/// (lerp and slerp), by any angle. The same bits everywhere.
class RigidPath final : public MotionPath {
 public:
  /// At rest.
  explicit RigidPath(const Pose& X_WO = {}) : from_(X_WO), to_(X_WO) {}
  /// Turns by the smaller angle; a half turn may go in either direction.
  static RigidPath between(const Pose& from, const Pose& to);
  /// A path by constant rates: `displacement_W` of `centre_O` [m], and `turn_W` about it, axis times angle
  /// [rad].
  static RigidPath by(const Pose& from, const Vector3& displacement_W, const Vector3& turn_W,
                      const Vector3& centre_O = Vector3::Zero());
  /// The same path with the last bits of its end as given.
  /// @pre `to` is the path's end to rounding.
  RigidPath ending_at(const Pose& to) const;

  /// The ends are returned exactly.
  Pose pose_at(double s) const noexcept;
  const Pose& from() const { return from_; }
  const Pose& to() const { return to_; }
  bool at_rest() const { return displacement_ == Vector3::Zero() && angle_ == 0.0; }

  BodyState at(std::uint32_t body, double s) const noexcept override;
  bool is_steady() const noexcept override { return true; }
  /// |omega x n| |omega x (p - centre)|, constant along the path.
  double curvature_bound(std::uint32_t body, const BodyState& state, const Vector3& p_W,
                         const Vector3& n_W) const noexcept override;
  MotionBounds bounds(std::uint32_t body, const BodyState& state, const Vector3& p_W) const noexcept override;

 private:
  Pose along(double s) const noexcept;

  Pose from_;
  Pose to_;
  Vector3 centre_O_ = Vector3::Zero();
  Vector3 displacement_ = Vector3::Zero();
  Vector3 axis_ = Vector3::UnitZ();
  double angle_ = 0.0;
};

/// Several bodies that move as one: each is fixed to a carrier on a RigidPath.
class CarriedPath final : public MotionPath {
 public:
  using MovesByBits = CarriedPath;  ///< see kMovesByBits: it refers to poses, but owns none

  /// @param X_CO of each body in the carrier; must outlive the path. Bodies whose entry is the identity get
  /// the carrier's poses bit by bit.
  CarriedPath(const RigidPath& carrier, std::span<const Pose> X_CO)
      : carrier_(carrier), X_CO_(X_CO.data()), count_(X_CO.size()) {}
  /// The same by the list's poses as they are when the path is asked: the list may grow.
  CarriedPath(const RigidPath& carrier, const GrowingList<Pose>& X_CO)
      : carrier_(carrier), list_(&X_CO), count_(X_CO.size()) {}

  const RigidPath& carrier() const { return carrier_; }
  /// Whether the path covers this body; a body that was added later is not covered.
  bool knows(std::uint32_t body) const { return body < count_; }
  BodyState at(std::uint32_t body, double s) const noexcept override;
  bool is_steady() const noexcept override { return true; }
  double curvature_bound(std::uint32_t body, const BodyState& state, const Vector3& p_W,
                         const Vector3& n_W) const noexcept override;
  MotionBounds bounds(std::uint32_t body, const BodyState& state, const Vector3& p_W) const noexcept override;

 private:
  RigidPath carrier_;
  const Pose* X_CO_ = nullptr;  // or they are in:
  const GrowingList<Pose>* list_ = nullptr;
  std::size_t count_;
};

}  // namespace touchstone
