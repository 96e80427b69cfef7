#include "touchstone/contact_core/motion/impact.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/motion/advancement.hpp"
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

namespace {

/// One look after the other at a pair in motion.
class Advancing final : OverlapAhead {
 public:
  Advancing(const MovingSolid& a, const MovingSolid& b, const GapRule& rule, SeparationQuery& query,
            double interest, double until, bool ask_at_end)
      : a_(a),
        b_(b),
        rule_(rule),
        query_(query),
        interest_(interest),
        until_(until),
        ask_at_end_(ask_at_end) {}

  Impact find() {
    double s = 0.0;
    const auto look_at = [&](double at) { return look(at); };
    if (advance(s, kImpactIterations, look_at) == AdvanceEnd::looks_spent)
      impact_.status = ImpactStatus::iteration_limit;
    return impact_;
  }

 private:
  bool overlaps_at(double s) noexcept override {
    return query_.verdict(a_.pose_at(s), b_.pose_at(s)) == PairStatus::overlapping;
  }

  std::optional<double> look(double s) {
    // The narrowphase is asked about the poses at s.
    const PlacedSolid on_a = place(a_, s), on_b = place(b_, s);
    const PairStatus status = query_.separation(on_a.X_WS, on_b.X_WS, impact_.geometry);
    impact_.lo = s;
    if (!has_geometry(status)) {
      impact_.status = ImpactStatus::failed;
      return {};
    }
    take(on_a, on_b);
    // The rest is clear if nothing moves on, or if the two cannot come near.
    if (s >= 1.0 || (on_a.at_rest && on_b.at_rest)) return clear_to_the_end(false);
    const double separation = impact_.geometry.separation;
    const double reach = std::min(until_, 1.0) * (a_.travel + b_.travel);
    if (impact_.queries == 1 && separation - reach > std::max(interest_, rule_.gap))
      return clear_to_the_end(true);
    // The next look is as far on as the pair is sure to stay apart.
    const PathStep step =
        next_step(on_a, on_b, impact_.geometry, rule_, threshold_, interest_, impact_.queries, this);
    if (step.is_far) return clear_to_the_end(true);
    if (step.at_end && !ask_at_end_) return clear_to_the_end(false);
    if (step.is_stalled) {
      impact_.status = ImpactStatus::blocked;
      impact_.hi = step.next;
      return {};
    }
    if (step.next > until_) {
      impact_.lo = step.next;
      return {};
    }
    return step.next;
  }

  void take(const PlacedSolid& on_a, const PlacedSolid& on_b) {
    const double separation = impact_.geometry.separation;
    // Once apart, a pair that started in contact is like any other.
    if (impact_.queries == 0 || (!from_afar_ && separation > rule_.gap)) {
      threshold_ = rule_.threshold(separation, scale_of(on_a, on_b));
      from_afar_ = separation > rule_.gap;
    }
    if (impact_.queries++ == 0) {
      impact_.start_separation = separation;
      impact_.starts_overlapping = separation < 0.0;
    }
    impact_.least_separation = std::min(impact_.least_separation, separation);
  }

  std::optional<double> clear_to_the_end(bool is_far) {
    impact_.is_far = is_far;
    impact_.lo = 1.0;
    return {};
  }

  const MovingSolid& a_;
  const MovingSolid& b_;
  const GapRule& rule_;
  SeparationQuery& query_;
  double interest_, until_;
  bool ask_at_end_;
  double threshold_ = 0.0;
  bool from_afar_ = false;
  Impact impact_;
};

}  // namespace

Impact find_impact(const MovingSolid& a, const MovingSolid& b, const GapRule& rule, SeparationQuery& query,
                   double interest, double until, bool ask_at_end) noexcept {
  if (query.judges_poses()) return find_sampled_impact(a, b, rule, query, interest);
  return Advancing(a, b, rule, query, interest, until, ask_at_end).find();
}

}  // namespace touchstone
