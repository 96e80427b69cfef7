#include "touchstone/physics/solver/contact_path.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone::physics {
namespace {

// Lengths are in log softness, radians, and impulses over their size.
constexpr double kFirstStep = 1.0, kLongestStep = 3.0, kShortestStep = 1e-5, kShorter = 0.35;
constexpr int kMostCorrections = 5;
// Of Newton's steps: the longest, the most of the one before, the bound of the last one, and how far back
// they may lead.
constexpr double kMostCorrection = 0.3, kContraction = 0.5, kLastCorrection = 1e-2, kSharpest = 1e-6,
                 kLoosest = 1e-3, kBackwards = 1e-6;
constexpr double kMostTurn = 2.0;  // one over the cosine between the tangents of a step
// How far from the path a point may be, and beyond a limit, over the sizes of velocities and impulses.
constexpr double kOff = 1e-8;
// A path that gets this much softer than it began has turned back on itself.
constexpr double kLost = 1.5;

}  // namespace

void ContactPath::reserve(std::size_t rows) {
  arc_.reserve(rows);
  for (auto* vector : {&tangent_, &next_tangent_, &curvature_, &change_}) vector->reserve(rows + 1);
  for (auto* vector : {&values_, &rates_}) vector->reserve(2 * rows);
}

bool ContactPath::solve() {
  ++linear_solves_;
  return arc_.solve(change_, next_tangent_);
}

/// Of a step in the unknowns.
double ContactPath::along_tangent(std::span<const double> step) const {
  double sum = 0.0;
  for (std::size_t j = 0; j < arc_.unknowns(); ++j) {
    const double unit = arc_.unit(j);
    sum += (step[j] / unit) * (tangent_[j] / unit);
  }
  return sum;
}

double ContactPath::length_of(std::span<const double> step) const {
  double sum = 0.0;
  for (std::size_t j = 0; j < arc_.unknowns(); ++j) {
    const double scaled = step[j] / arc_.unit(j);
    sum += scaled * scaled;
  }
  return std::sqrt(sum);
}

/// Takes next_tangent_ at the point, of length 1, and the limits' rates along it.
/// @param arc_length the length since the last point, if it was on the same arc, or 0. @return false where it
/// turned too much.
bool ContactPath::take_tangent(double arc_length, double longest) {
  const double length = length_of(next_tangent_);
  if (!(length > 0.0) || !std::isfinite(length) || length > longest) return false;
  for (double& change : next_tangent_) change /= length;
  if (arc_length > 0.0) {
    arc_.find_curvature(tangent_, next_tangent_, arc_length, curvature_);
  } else {
    std::fill(curvature_.begin(), curvature_.end(), 0.0);
  }
  tangent_.swap(next_tangent_);
  arc_.set_rates(tangent_);
  for (std::size_t i = 0; i < arc_.limits(); ++i) {
    const ContactArc::Limit limit = ContactArc::limit(i);
    values_[i] = arc_.value(limit);
    rates_[i] = arc_.rate(limit, tangent_);
  }
  arc_.keep();
  return true;
}

bool ContactPath::start(const ScaledContacts& problem, std::span<const double> anchor) {
  linear_solves_ = arcs_ = 0;
  arc_.load(problem, anchor);
  for (auto* vector : {&tangent_, &next_tangent_, &curvature_, &change_})
    vector->assign(problem.rows() + 1, 0.0);
  for (auto* vector : {&values_, &rates_}) vector->assign(arc_.limits(), 0.0);
  if (!arc_.begin()) return false;
  first_softness_ = arc_.softness();
  step_ = kFirstStep;
  is_lost_ = false;
  // At the first softness, then off towards less.
  tangent_[arc_.unknowns() - 1] = -1.0;
  for (int i = 0; i < 4; ++i) {
    const double off = arc_.linearise();
    arc_.border_by(tangent_);
    if (!solve()) return false;
    if (off <= kOff) return take_tangent(0.0, kInfinity);
    arc_.move(change_);
  }
  return false;
}

/// From `length` along the tangent back to the path: at right angles, or to where the limit is 0. Newton's
/// steps must shrink, and the last one of all is so short that no error is left.
bool ContactPath::correct(const ContactArc::Limit* limit, double length) {
  arc_.go_back();
  arc_.predict(tangent_, curvature_, length);
  double last = kInfinity, travel = length;
  for (corrections_ = 1; corrections_ <= kMostCorrections; ++corrections_) {
    arc_.linearise();
    if (limit != nullptr) {
      arc_.border_by(*limit);
    } else {
      arc_.border_by(tangent_);
    }
    if (!solve()) return false;
    const double size = length_of(change_);
    if (!(size <= kMostCorrection) || size > kContraction * last) return false;
    last = size;
    travel += along_tangent(change_);
    arc_.move(change_);
    if (size > (limit != nullptr ? kSharpest : std::clamp(kLastCorrection * length, kSharpest, kLoosest)))
      continue;
    arc_.update_velocities();
    return travel >= -kBackwards && travel <= 2.0 * length + kBackwards;
  }
  return false;
}

/// Of a limit: one that was slightly below 0 may stay so.
double ContactPath::least_of(std::size_t limit) const { return 2.0 * std::min(values_[limit], 0.0) - kOff; }

/// To the end of the arc and around the corner.
bool ContactPath::meet(ContactArc::Limit limit, double length) {
  if (!correct(&limit, length)) return false;
  for (std::size_t i = 0; i < arc_.limits(); ++i)
    if (arc_.value(ContactArc::limit(i)) < least_of(i)) return false;
  const ContactArc::Limit growing = arc_.cross(limit);
  ++arcs_;
  arc_.linearise();
  arc_.border_by(growing);
  is_lost_ = !solve() || !(length_of(change_) <= kLoosest);
  if (is_lost_) return false;
  arc_.move(change_);
  arc_.update_velocities();
  is_lost_ = !take_tangent(0.0, kInfinity);
  return !is_lost_;
}

/// Along the arc. Where limits are passed: which first, and about where.
bool ContactPath::go(double length, double& broken_at, ContactArc::Limit& broken) {
  if (!correct(nullptr, length)) return false;
  bool all_kept = true;
  for (std::size_t i = 0; i < arc_.limits(); ++i) {
    const double value = arc_.value(ContactArc::limit(i));
    if (!(value < least_of(i))) continue;
    all_kept = false;
    // One that has only just been crossed comes again later, if at all.
    const double before = values_[i], at = length * (before / (before - value));
    if (before > kOff && at < broken_at) broken_at = at, broken = ContactArc::limit(i);
  }
  return all_kept && take_tangent(length, kMostTurn);
}

bool ContactPath::advance() {
  if (is_lost_ || !(arc_.softness() <= kLost * first_softness_)) return false;
  // The nearest limit along the tangent may end the arc.
  double first = kInfinity;
  ContactArc::Limit limit;
  for (std::size_t i = 0; i < arc_.limits(); ++i) {
    const double at = arc_.length_to_zero(values_[i], rates_[i], tangent_);
    if (at < first) first = at, limit = ContactArc::limit(i);
  }
  // The step is shortened until it succeeds or a limit is met.
  double length = std::min(step_, kLongestStep);
  while (length > kShortestStep) {
    if (first <= length) {
      if (meet(limit, first)) return true;
      if (is_lost_) return false;
      first = kInfinity;
    }
    // A step that succeeds sets the next length; one that breaks a limit goes to that limit.
    double broken_at = kInfinity;
    ContactArc::Limit broken;
    if (go(length, broken_at, broken)) {
      step_ = corrections_ <= 2 ? 1.7 * length : corrections_ == 3 ? 1.2 * length : length;
      return true;
    }
    if (broken_at < kInfinity && meet(broken, broken_at)) return true;
    if (is_lost_) return false;
    length *= kShorter;
    step_ = length;
  }
  return false;
}

}  // namespace touchstone::physics
