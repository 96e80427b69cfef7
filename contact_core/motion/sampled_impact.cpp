#include "touchstone/contact_core/motion/sampled_impact.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/motion/clear_stretch.hpp"

namespace touchstone {
namespace {

/// Of what is left of a path, no step past where the separations would stop is longer than this, unless the
/// pair is further apart or deeper.
constexpr double kLongestProbe = 1.0 / 64;

struct Sample {
  double s = 0.0;
  PlacedSolid on_a, on_b;
  PairGeometry geometry{};
  PairStatus verdict = PairStatus::failed;

  bool is_clear() const { return verdict == PairStatus::separated; }
  double separation() const { return geometry.separation; }
};

class Sampling {
 public:
  Sampling(const MovingSolid& a, const MovingSolid& b, const GapRule& rule, SeparationQuery& query)
      : a_(a), b_(b), rule_(rule), query_(query) {
    impact_.check = MotionCheck::sampled;
  }

  Impact find(double interest) {
    if (!take(0.0, now_)) return stopped_at(now_, ImpactStatus::failed, 0.0);
    impact_.start_separation = now_.separation();
    impact_.starts_overlapping = now_.verdict == PairStatus::overlapping;
    is_held_ = !now_.is_clear();
    begin_rule();
    while (now_.s < 1.0 && !(now_.on_a.at_rest && now_.on_b.at_rest)) {
      const double end = next_break(a_, b_, now_.s);
      const Stretch stretch = find_clear_stretch(now_.on_a, now_.on_b, now_.geometry, rule_now_, threshold_,
                                                 end - now_.s, impact_.queries);
      const bool is_far =
          stretch.at_end && end == 1.0 && now_.separation() > interest && stretch.least_at_end > interest;
      const bool in_contact = now_.separation() <= rule_now_.gap;
      const bool would_stop = in_contact && !stretch.at_end && stretch.length < kStalled * (end - now_.s);
      double next = stretch.at_end ? end : now_.s + stretch.length;
      if (would_stop && is_held_) return stopped_at(now_, ImpactStatus::blocked, next);
      if (would_stop && probes_ == 0) unprobed_ = now_;
      if (would_stop) next = std::min(end, now_.s + probe(end));
      if (impact_.queries >= kImpactIterations || !(next > now_.s))
        return stopped_at(now_, ImpactStatus::iteration_limit, 1.0);
      Sample ahead;
      if (!take(next, ahead)) return stopped_at(now_, ImpactStatus::failed, next);
      if (!ahead.is_clear() && !is_held_) return bracket(ahead, would_stop);
      if (is_far && ahead.is_clear()) {
        impact_.is_far = true;
        return stopped_at(now_, ImpactStatus::clear, 1.0);
      }
      go_to(ahead, would_stop);
    }
    return stopped_at(now_, ImpactStatus::clear, 1.0);
  }

 private:
  /// False: no separation.
  bool take(double s, Sample& out) {
    out.s = s;
    out.on_a = place(a_, s), out.on_b = place(b_, s);
    const bool known = has_geometry(query_.separation(out.on_a.X_WS, out.on_b.X_WS, out.geometry));
    out.verdict = known ? query_.verdict(out.on_a.X_WS, out.on_b.X_WS) : PairStatus::failed;
    ++impact_.queries;
    return known;
  }

  /// A pair that is not called separated comes no nearer than it is: as one in contact would, whose gap that
  /// is.
  void begin_rule() {
    rule_now_.gap = is_held_ ? std::max(rule_.gap, 2.0 * now_.separation()) : rule_.gap;
    threshold_ = rule_now_.threshold(now_.separation(), scale_of(now_.on_a, now_.on_b));
    from_afar_ = now_.separation() > rule_now_.gap;
  }

  void go_to(const Sample& ahead, bool was_probe) {
    probes_ = was_probe ? probes_ + 1 : 0;
    now_ = ahead;
    impact_.least_separation = std::min(impact_.least_separation, now_.separation());
    const bool is_freed = is_held_ && now_.is_clear();
    if (is_freed) is_held_ = false;
    if (is_freed || was_probe || (!from_afar_ && !is_held_ && now_.separation() > rule_.gap)) begin_rule();
  }

  double probe(double end) const {
    const double speed = relative_speed(now_.on_a, now_.on_b);
    if (!(speed > 0.0)) return end - now_.s;
    const double measured = std::abs(now_.separation()) / speed;
    const double grown = std::ldexp(rule_.gap, std::min(probes_, 60)) / speed;
    return std::max(measured, std::min(grown, kLongestProbe));
  }

  Impact bracket(Sample hi, bool was_probe) {
    Sample lo = now_;
    const double speed = relative_speed(lo.on_a, lo.on_b);
    while ((hi.s - lo.s) * speed > rule_.gap && impact_.queries < kImpactIterations) {
      Sample middle;
      if (!(lo.s < 0.5 * (lo.s + hi.s)) || !take(0.5 * (lo.s + hi.s), middle)) break;
      (middle.is_clear() ? lo : hi) = middle;
    }
    // The gap rule: of the backend's clear poses none that is apart by less than where probing began is used.
    if (was_probe && lo.separation() >= 0.0 && lo.separation() < unprobed_.separation()) lo = unprobed_;
    const bool decided = hi.verdict == PairStatus::overlapping || hi.verdict == PairStatus::undecided;
    return stopped_at(lo, decided ? ImpactStatus::blocked : ImpactStatus::failed, hi.s);
  }

  Impact stopped_at(const Sample& sample, ImpactStatus status, double hi) {
    impact_.status = status;
    impact_.lo = status == ImpactStatus::clear ? 1.0 : sample.s;
    impact_.hi = hi;
    impact_.geometry = sample.geometry;
    impact_.least_separation = std::min(impact_.least_separation, sample.separation());
    return impact_;
  }

  const MovingSolid& a_;
  const MovingSolid& b_;
  GapRule rule_;
  SeparationQuery& query_;
  Impact impact_;
  GapRule rule_now_{0.0};
  double threshold_ = 0.0;
  bool from_afar_ = false;
  bool is_held_ = false;  // not called separated since the start
  int probes_ = 0;        // in a row, past where the separations would stop
  Sample now_;
  Sample unprobed_;  // where the row of probes began
};

}  // namespace

Impact find_sampled_impact(const MovingSolid& a, const MovingSolid& b, const GapRule& rule,
                           SeparationQuery& query, double interest) noexcept {
  return Sampling(a, b, rule, query).find(interest);
}

}  // namespace touchstone
