#include "touchstone/contact_core/motion/sampled_impact.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/motion/advancement.hpp"
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
    double s = 0.0;
    const auto look_at = [&](double at) { return look(at, interest); };
    if (advance(s, kImpactIterations, look_at) == AdvanceEnd::looks_spent)
      stopped_at(now_, ImpactStatus::iteration_limit, 1.0);
    return impact_;
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

  std::optional<double> look(double s, double interest) {
    if (!(impact_.queries == 0 ? begin() : go_on(s))) return {};
    if (!(now_.s < 1.0) || (now_.on_a.at_rest && now_.on_b.at_rest)) {
      stopped_at(now_, ImpactStatus::clear, 1.0);
      return {};
    }
    const PathStep step =
        next_step(now_.on_a, now_.on_b, now_.geometry, rule_now_, threshold_, interest, impact_.queries);
    is_far_ = step.is_far, is_probe_ = step.is_stalled;
    if (is_probe_ && is_held_) {
      stopped_at(now_, ImpactStatus::blocked, step.next);
      return {};
    }
    if (is_probe_ && probes_ == 0) unprobed_ = now_;
    if (!is_probe_) return step.next;
    const double end = next_break(a_, b_, now_.s);
    return std::min(end, now_.s + probe(end));
  }

  /// False, as with the next: it ends there.
  bool begin() {
    if (!take(0.0, now_)) {
      stopped_at(now_, ImpactStatus::failed, 0.0);
      return false;
    }
    impact_.start_separation = now_.separation();
    impact_.starts_overlapping = now_.verdict == PairStatus::overlapping;
    is_held_ = !now_.is_clear();
    begin_rule();
    return true;
  }

  bool go_on(double s) {
    Sample ahead;
    if (!take(s, ahead)) {
      stopped_at(now_, ImpactStatus::failed, s);
      return false;
    }
    if (!ahead.is_clear() && !is_held_) {
      bracket(ahead, is_probe_);
      return false;
    }
    if (is_far_ && ahead.is_clear()) {
      impact_.is_far = true;
      stopped_at(now_, ImpactStatus::clear, 1.0);
      return false;
    }
    go_to(ahead, is_probe_);
    return true;
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

  void bracket(Sample hi, bool was_probe) {
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
    stopped_at(lo, decided ? ImpactStatus::blocked : ImpactStatus::failed, hi.s);
  }

  void stopped_at(const Sample& sample, ImpactStatus status, double hi) {
    impact_.status = status;
    impact_.lo = status == ImpactStatus::clear ? 1.0 : sample.s;
    impact_.hi = hi;
    impact_.geometry = sample.geometry;
    impact_.least_separation = std::min(impact_.least_separation, sample.separation());
  }

  const MovingSolid& a_;
  const MovingSolid& b_;
  GapRule rule_;
  SeparationQuery& query_;
  Impact impact_;
  GapRule rule_now_{0.0};
  double threshold_ = 0.0;
  bool from_afar_ = false;
  bool is_held_ = false;   // not called separated since the start
  bool is_far_ = false;    // the step at hand stays further apart than what is of interest
  bool is_probe_ = false;  // it goes past where the separations would stop
  int probes_ = 0;         // in a row, past where the separations would stop
  Sample now_;
  Sample unprobed_;  // where the row of probes began
};

}  // namespace

Impact find_sampled_impact(const MovingSolid& a, const MovingSolid& b, const GapRule& rule,
                           SeparationQuery& query, double interest) noexcept {
  return Sampling(a, b, rule, query).find(interest);
}

}  // namespace touchstone
