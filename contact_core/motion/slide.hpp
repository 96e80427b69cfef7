#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "touchstone/contact_core/motion/mass_metric.hpp"
#include "touchstone/contact_core/motion/row_projection.hpp"

// The motion of a body along the contacts that stop it: a god-object with six degrees of freedom (Ortega,
// Redon, Coquillart 2007). Of all twists that the contacts allow it takes the one closest to the twist that
// leads to its goal, in its mass metric (Gauss' principle of least constraint).

namespace touchstone {

/// A contact, or one near enough to become one: the mover's point at r may come nearer to the obstacle's
/// plane by `slack`, n . (v + w x r) >= -slack.
struct SlideRow {
  Vector3 n = Vector3::Zero();  ///< unit, from the obstacle to the mover
  Vector3 r = Vector3::Zero();  ///< from the mover's centre of mass [m]
  double slack = 0.0;           ///< [m]; < 0: it is to move away by so much
  double room = 0.0;            ///< what remains below that for paths that bend [m]; >= 0
  bool turns = false;           ///< the plane is fixed to the mover and turns with it
  /// Not zero: the plane is spanned by the mover's edge e and the obstacle's f, n = e x f, and turns with e.
  Vector3 e = Vector3::Zero(), f = Vector3::Zero();
  std::uint32_t source = 0;  ///< whose contact it is; not read
  /// The links of an arm that the row is about: rows of other links differ, even if all else is equal.
  std::uint32_t link = 0, other_link = 0;

  /// Signs and places alone decide, so that rows in this order do not depend on where they came from.
  friend bool operator<(const SlideRow& a, const SlideRow& b);
};

inline constexpr int kMostSlideRows = kMostRows;
inline constexpr int kTwistSize = 6;

/// The metric of twists: |u|^2 = v . K v + w . J w. K and J are in the frame of the twists, symmetric and
/// positive definite; no eigenvalue of K is below 1, so that no displacement is longer than its twist [m].
struct TwistMetric {
  Matrix3 J = Matrix3::Identity();  ///< [m2]
  Matrix3 K = Matrix3::Identity();
  bool is_even = true;  ///< K is the identity

  TwistMetric() = default;
  /// Even: of a body at uniform density, or of a hand that is as stiff in all directions.
  TwistMetric(const Matrix3& inertia) : J(inertia) {}  // NOLINT(google-explicit-constructor)
  TwistMetric(const Matrix3& turning, const Matrix3& translation)
      : J(turning), K(translation), is_even(false) {}
};

double inner_product(const TwistMetric& metric, const Twist& a, const Twist& b);

/// The rows that hold a projection: at most as many as a twist has components.
struct ActiveRows {
  int count = 0;
  std::array<int, kTwistSize> row{};
  /// M (u - goal) = sum of f_i (n_i, r_i x n_i), M the metric's matrix; f_i >= 0 [m].
  std::array<double, kTwistSize> force{};

  std::span<const int> rows() const { return std::span(row).first(static_cast<std::size_t>(count)); }
};

/// The twist closest to `goal` that fulfils every row: min |u - goal|. Dual active set (Goldfarb, Idnani
/// 1983); ties fall to the first row.
/// @param lift one a row: added to what the row asks for [m]. @param translation_only u.w = 0.
/// @returns false where no twist fulfils the rows (to rounding), or none was found; `out` is then zero.
/// @pre at most kMostSlideRows.
bool project(const Twist& goal, const TwistMetric& metric_W, std::span<const SlideRow> rows,
             std::span<const double> lift, bool translation_only, Twist& out, ActiveRows& active);

struct SlidePlan {
  Twist twist;            ///< zero: nothing is to be gained
  ActiveRows active;      ///< what holds it back
  bool is_whole = false;  ///< planned for all of the goal, and not shortened
  double left_over =
      0.0;  ///< what raising rows for bends added to the square of the distance left, about [m2]
  std::uint64_t work = 0;  ///< rows that were projected on, each time
};

/// Plans the motion of one sub-step. A straight twist (the centre of mass moves straight, the body turns
/// evenly) keeps contact to first order only. So the rows are raised by how far the path could bend below
/// their room, and the path is clear from end to end. Along the twist the distance to the goal shrinks; the
/// twist ends where it would grow again.
/// @param goal from where the body is to where it is to be.
SlidePlan plan_slide(const Twist& goal, const TwistMetric& metric_W, std::span<const SlideRow> rows,
                     bool translation_only);

/// Bounds -d^2/dt^2 of the row's distance along a twist of unit duration [m]; may be < 0: it surely bends up.
double bend_of(const SlideRow& row, const Twist& twist);

}  // namespace touchstone
