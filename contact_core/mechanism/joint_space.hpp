#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/mechanism/mechanism_path.hpp"
#include "touchstone/contact_core/motion/mass_metric.hpp"
#include "touchstone/contact_core/motion/row_projection.hpp"

// A mechanism's motions to first order: how a change of joint values moves its links, and the change closest
// to the wanted one that contacts allow.

namespace touchstone {

/// Mechanisms with more joint values do not slide.
inline constexpr int kMostSlideJoints = 32;
using JointVector = std::array<double, kMostSlideJoints>;  ///< unused values are 0
/// A matrix by rows; of a triangular one only the lower half is used.
using JointMatrix = std::array<JointVector, kMostSlideJoints>;

/// The metric of changes of joint values: |dq|^2 = sum of w dq^2, or dq . M dq. Keeps references.
struct JointMetric {
  std::span<const double> weights;    ///< w, one a value, > 0
  const JointMatrix* root = nullptr;  ///< L of M = L L^T, M - diag(w) >= 0; null: M is diag(w)
};
/// Cholesky's L of the lower half of M. @pre M - diag(weights) >= 0, to rounding.
void find_root(const JointMatrix& M, std::span<const double> weights, JointMatrix& L) noexcept;

/// Axes and reaches of a mechanism at its current pose. set() does not allocate.
class JointFrame {
 public:
  explicit JointFrame(const Mechanism& mechanism);

  void set(std::span<const Pose> X_WL) noexcept;
  int size() const { return static_cast<int>(axes_.size()); }

  /// +1: the value moves the link, but not the other one; -1: the other way round; 0: both or neither.
  int sign(std::uint32_t value, std::uint32_t link, std::uint32_t other) const {
    return moves_[link * axes_.size() + value] - moves_[other * axes_.size() + value];
  }
  /// The link's twist relative to the other link per unit of a value: the velocity of its point at c_W, and
  /// its angular velocity.
  Twist twist(std::uint32_t value, const Vector3& c_W) const;
  Twist twist(const JointVector& dq, std::uint32_t link, std::uint32_t other, const Vector3& c_W) const;

  /// The most that a point of the link, within `radius` of its origin, can move relative to the other link
  /// for a change of joint values of length 1 in the metric, at any pose of the arm: sqrt(sum of r^2 / w),
  /// with r of the values that move the link but not the other. @pre set_reaches().
  double reach(std::uint32_t link, std::uint32_t other, double radius, std::span<const double> weights) const;
  /// The most that one unit of a value that moves the link can move a point within `radius` of the link's
  /// origin.
  /// @pre set_reaches().
  double furthest(std::uint32_t value, std::uint32_t link, double radius) const {
    return axes_[value].turns ? reaches_[link * axes_.size() + value] + radius : 1.0;
  }
  /// @param shift_limit no prismatic value goes further from 0 [m].
  void set_reaches(double shift_limit) noexcept;

 private:
  struct Axis {
    bool turns;
    Vector3 direction_W, origin_W;
  };
  const Mechanism* mechanism_;
  std::vector<Axis> axes_;          // by value
  std::vector<std::int8_t> moves_;  // by link and value
  std::vector<double> reaches_;     // by link and value: from the joint to the link's origin, at most [m]
};

/// A contact's constraint: g . dq >= -slack. See SlideRow.
struct JointRow {
  JointVector g{};
  double slack = 0.0, room = 0.0;
  std::uint32_t link = 0, other = 0;  ///< the mover's, and what it is seen from: the obstacle's, or the base
};

/// Bounds how far a path to q + dq bends away from its rows.
class JointBends {
 public:
  virtual ~JointBends() = default;
  /// Sets the path, to q + dq; the other functions refer to it.
  virtual void lay(const JointVector& dq) noexcept = 0;
  /// Bounds |d^2/ds^2| of the row's distance on the path [m]; the first is coarse and costs little.
  virtual double most(std::size_t row) noexcept = 0;
  virtual double bend(std::size_t row) noexcept = 0;
};

struct JointSlidePlan {
  JointVector dq{};  ///< zero: nothing is to be gained
  int active_count = 0;
  std::array<int, kMostSlideJoints> active{};  ///< rows that hold it back
  JointVector force{};                         ///< of these, f >= 0: M (dq - goal) = sum of f g
  bool is_for_all = false;                     ///< planned for all of the goal
  bool is_whole = false;                       ///< and not shortened
  double left_over = 0.0;  ///< what raising rows for bends added to the square of the distance left, about
  double shortfall = 0.0;  ///< by how much more the square of the distance would shrink without bends
  std::uint64_t work = 0;  ///< rows that were projected on, each time, and steps of the projections
};

/// plan_slide() in joint space: min |dq - goal| under the rows, raised by the path's bends; the plan ends
/// where the distance to the goal would grow.
/// @pre at most kMostRows rows, at most kMostSlideJoints weights.
JointSlidePlan plan_joint_slide(const JointVector& goal, const JointMetric& metric,
                                std::span<const JointRow> rows, JointBends& bends);
/// The same without bends and without an end: only the projection on the rows.
/// @returns false where none fulfils the rows (to rounding).
bool project_joints(const JointVector& goal, const JointMetric& metric, std::span<const JointRow> rows,
                    JointSlidePlan& plan);

/// a . M b.
double joint_product(const JointVector& a, const JointVector& b, const JointMetric& metric);

}  // namespace touchstone
