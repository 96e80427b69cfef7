#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "touchstone/physics/solver/contact_arc.hpp"

/// @file
/// The path to a solution from an easy problem, followed through its turns and corners.

namespace touchstone::physics {

/// Follows the solutions y of the problem softened by s, with velocities u = W y + b + s (y - a) for an
/// anchor a, from a large s, where there is one only, towards s = 0.
///
/// Why it arrives: solutions of the softened problem dissipate, so y (W y + b) + s y (y - a) <= 0; with b = J
/// v in the range of W = J M^-1 J^T and a = 0, s |y|^2 is at most |v|^2 / 4 in the metric of M: as s goes to
/// 0, what softening adds to velocities, s y, falls at least as sqrt(s). The solutions are a curve of smooth
/// arcs, on each of which the contacts go on doing what they do. Arcs are followed by their own length, as
/// friction makes them turn back in s (pseudo-arclength continuation: Allgower and Georg, Numerical
/// Continuation Methods, 1990). Where one ends, a contact does something else, and the next arc leads on from
/// there: what Lemke's method is for pyramids, for cones.
class ContactPath {
 public:
  void reserve(std::size_t rows);
  /// @param anchor of rows, kept; or empty: 0. @return false where even the softest problem was not solved.
  bool start(const ScaledContacts& problem, std::span<const double> anchor = {});
  /// One step: a distance along an arc, or to its end. @return false where it leads no further.
  bool advance();

  std::span<const double> y() const { return arc_.y(); }
  double softness() const { return arc_.softness(); }
  int linear_solves() const { return linear_solves_; }
  int arcs() const { return arcs_; }

 private:
  bool solve();
  double length_of(std::span<const double> step) const;
  double along_tangent(std::span<const double> step) const;
  bool take_tangent(double arc_length, double longest);
  double least_of(std::size_t limit) const;
  bool correct(const ContactArc::Limit* limit, double length);
  bool go(double length, double& broken_at, ContactArc::Limit& broken);
  bool meet(ContactArc::Limit limit, double length);

  ContactArc arc_;
  int linear_solves_ = 0, arcs_ = 0, corrections_ = 0;
  bool is_lost_ = false;
  double step_ = 0.0, first_softness_ = 1.0;
  // By unknown: along the arc, in units of length; steps; of the length's metric.
  std::vector<double> tangent_, next_tangent_, curvature_, change_;
  std::vector<double> values_, rates_;  // of limits, where the step starts
};

}  // namespace touchstone::physics
