#include "touchstone/contact_core/motion/impact.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/motion/clear_stretch.hpp"
#include "touchstone/contact_core/motion/sampled_impact.hpp"

namespace touchstone {
namespace {

/// A pair that comes from further away is held above this share of the gap: what lies between it and a half
/// is room for rounding and for motion along the contact.
constexpr double kStopShare = 0.75;

}  // namespace

std::string_view to_string(MotionCheck check) { return check == MotionCheck::proven ? "proven" : "sampled"; }

Pose MovingSolid::pose_at(double s) const noexcept {
  return compose(path->at(body, std::min(s, stop)).X_WO, X_OS);
}

double GapRule::threshold(double start, double scale) const {
  if (start > gap) return kStopShare * gap;
  // Below g/2 the room for rounding shrinks, to none at g/4: rounding alone never brings a pair to touch.
  const double room = start < 0.0 ? 1.0 : std::clamp((start - 0.25 * gap) / (0.25 * gap), 0.0, 1.0);
  return std::min(0.5 * gap, start - room * kSeparationRounding * scale);
}

Impact find_impact(const MovingSolid& a, const MovingSolid& b, const GapRule& rule, SeparationQuery& query,
                   double interest, double until, bool ask_at_end) noexcept {
  if (query.judges_poses()) return find_sampled_impact(a, b, rule, query, interest);
  Impact impact;
  double threshold = 0.0;
  bool from_afar = false;
  for (double s = 0.0;;) {
    const PlacedSolid on_a = place(a, s), on_b = place(b, s);
    const PairStatus status = query.separation(on_a.X_WS, on_b.X_WS, impact.geometry);
    impact.lo = s;
    if (!has_geometry(status)) {
      impact.status = ImpactStatus::failed;
      return impact;
    }
    const double separation = impact.geometry.separation;
    // Once apart, a pair that started in contact is like any other.
    if (impact.queries == 0 || (!from_afar && separation > rule.gap)) {
      threshold = rule.threshold(separation, scale_of(on_a, on_b));
      from_afar = separation > rule.gap;
    }
    if (impact.queries++ == 0) {
      impact.start_separation = separation;
      impact.starts_overlapping = separation < 0.0;
    }
    impact.least_separation = std::min(impact.least_separation, separation);
    if (s >= 1.0 || (on_a.at_rest && on_b.at_rest)) {
      impact.lo = 1.0;
      return impact;
    }
    const double way = std::min(until, 1.0) * (a.travel + b.travel);
    if (impact.queries == 1 && separation - way > std::max(interest, rule.gap)) {
      impact.is_far = true;
      impact.lo = 1.0;
      return impact;
    }
    const double end = next_break(a, b, s);
    const Stretch stretch =
        find_clear_stretch(on_a, on_b, impact.geometry, rule, threshold, end - s, impact.queries);
    if (stretch.at_end && end == 1.0 && separation > interest && stretch.least_at_end > interest) {
      impact.is_far = true;
      impact.lo = 1.0;
      return impact;
    }
    if (stretch.at_end && end == 1.0 && !ask_at_end) {
      impact.lo = 1.0;
      return impact;
    }
    const double next = stretch.at_end ? end : s + stretch.length;
    const bool stopped = stretch.length < kStalled * (end - s);
    if (separation <= rule.gap && !stretch.at_end && stopped) {
      impact.status = ImpactStatus::blocked;
      impact.hi = next;
      return impact;
    }
    if (next > until) {
      impact.lo = next;
      return impact;
    }
    if (impact.queries >= kImpactIterations || !(next > s)) {
      impact.status = ImpactStatus::iteration_limit;
      return impact;
    }
    s = next;
  }
}

}  // namespace touchstone
