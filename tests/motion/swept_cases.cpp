#include "swept_cases.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/adapters/exact/exact.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/motion/clear_stretch.hpp"
#include "touchstone/contact_core/motion/narrowphase_query.hpp"
#include "touchstone/contact_core/native/native.hpp"

namespace touchstone {
namespace {

std::unique_ptr<Narrowphase> make_exact(const SweptCase& swept) {
  BackendRegistry registry;
  register_exact(registry);
  auto exact = registry.make_narrowphase("exact");
  exact->build(swept.solids);
  return exact;
}

double separation_at(const SweptCase& swept, NarrowphaseQuery& query, double s) {
  PairGeometry geometry{};
  query.separation(compose(swept.paths[0].pose_at(s), swept.X_OS[0]),
                   compose(swept.paths[1].pose_at(s), swept.X_OS[1]), geometry);
  return geometry.separation;
}

/// Of a function that falls and then rises.
double least_separation(const SweptCase& swept, NarrowphaseQuery& query) {
  double low = 0.0, high = 1.0;
  double least = std::min(separation_at(swept, query, 0.0), separation_at(swept, query, 1.0));
  for (int i = 0; i < 100; ++i) {
    const double first = low + (high - low) / 3, second = high - (high - low) / 3;
    const double at_first = separation_at(swept, query, first),
                 at_second = separation_at(swept, query, second);
    least = std::min({least, at_first, at_second});
    (at_first <= at_second ? high : low) = at_first <= at_second ? second : first;
  }
  return least;
}

/// @param reach how far apart a stop may be [m].
void judge(const SweptCase& swept, double reach, SweptAnswer& out) {
  const bool stops = out.lo != SweptCase::kNever;
  if (out.start_separation <= out.gap) {
    out.remark = stops ? "starts in contact, pressed" : "starts in contact, free to leave";
  } else if (swept.exact_time == SweptCase::kNever) {
    if (stops)
      out.remark =
          "stops, least separation on the path " + std::to_string(out.least_separation / out.gap) + " g";
    if (stops && !(out.least_separation <= out.gap)) out.violation = "stops where nothing is within the gap";
  } else if (!stops) {
    out.violation = "passes";
  } else if (out.lo > swept.exact_time + swept.error) {
    out.violation = "late";
  } else if (!(out.separation <= reach * (1 + 1e-6))) {
    out.violation = "stops further away than the gap";
  } else if (!out.is_sampled && !(out.separation > 0.0)) {
    out.violation = "stops in contact";
  }
}

}  // namespace

SweptAnswer answer(const SweptCase& swept, Narrowphase& narrowphase) {
  const bool has_distance = gives_signed_distance(narrowphase);
  const auto native = make_native();
  native->build(swept.solids);
  const Narrowphase& separations = has_distance ? narrowphase : *native;
  NarrowphaseQuery query(narrowphase, *native, 2);
  const auto exact = make_exact(swept);
  NarrowphaseQuery truth(*exact, 2);
  const MovingSolid a{&swept.solids[0], swept.X_OS[0], &swept.paths[0]};
  const MovingSolid b{&swept.solids[1], swept.X_OS[1], &swept.paths[1]};
  const double scale =
      std::max(scale_of(place(a, 0.0), place(b, 0.0)), scale_of(place(a, 1.0), place(b, 1.0)));
  SweptAnswer out{};
  // Those that are right to rounding have 1e-9 m, as far out as that is more than rounding.
  out.gap = std::max(1e-9, 4 * separations.capabilities().resolution.at(scale));
  const Impact impact = find_impact(a, b, {out.gap}, query);
  out.lo = impact.status == ImpactStatus::clear ? SweptCase::kNever : impact.lo * swept.duration;
  out.queries = impact.queries;
  out.is_sampled = impact.check == MotionCheck::sampled;
  out.start_separation = separation_at(swept, truth, 0.0);
  out.separation = separation_at(swept, truth, impact.lo);
  const bool is_straight = swept.paths[0].at(0, 0).angular_velocity_W == Vector3::Zero() &&
                           swept.paths[1].at(0, 0).angular_velocity_W == Vector3::Zero();
  out.least_separation = kNaN;
  if (swept.exact_time == SweptCase::kNever && is_straight)
    out.least_separation = least_separation(swept, truth);
  if (impact.status == ImpactStatus::iteration_limit) out.violation = "iteration limit";
  // A verdict may begin as early as the backend declares.
  const double early = out.is_sampled ? narrowphase.capabilities().resolution.absolute : 0.0;
  if (out.violation.empty()) judge(swept, out.gap + early, out);
  return out;
}

}  // namespace touchstone
