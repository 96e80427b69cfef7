#include "touchstone/contact_core/narrowphase/answer_check.hpp"

#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"

namespace touchstone {
namespace {

/// Beyond this deviation from 1 a normal's length [-] is refused; how well it is directed is judged
/// elsewhere. Wide enough for half precision.
constexpr double kLengthTolerance = 1e-2;

const char* broken_points(const Query& query, int count, const ContactPoint* points) {
  if (count < 0 || count > query.max_points) return "its number of contact points is out of range";
  for (int i = 0; i < count; ++i) {
    const ContactPoint& point = points[i];
    if (!is_finite(point.p_A_W) || !is_finite(point.p_B_W) || !std::isfinite(point.separation))
      return "a contact point is not finite";
  }
  return nullptr;
}

bool carries_geometry(PairStatus status) { return status <= PairStatus::undecided; }

}  // namespace

const char* broken_answer(const Query& query, PairStatus status, const PairGeometry* geometry,
                          const ContactPoint* points) noexcept {
  if (status > PairStatus::unsupported) return "its status is none, or was not written";
  if (geometry == nullptr || query.kind == QueryKind::overlap || !carries_geometry(status)) return nullptr;
  const bool may_be_beyond = status == PairStatus::separated && std::isfinite(query.max_separation);
  if (may_be_beyond && geometry->separation == kInfinity) return nullptr;
  if (!std::isfinite(geometry->separation)) return "its separation is not finite";
  const double squared = dot(geometry->n_AB_W, geometry->n_AB_W);
  if (!(std::abs(squared - 1.0) <= 2.0 * kLengthTolerance)) return "its normal is no unit vector";
  if (!is_finite(geometry->p_A_W) || !is_finite(geometry->p_B_W)) return "a witness point is not finite";
  return query.kind == QueryKind::manifold ? broken_points(query, geometry->point_count, points) : nullptr;
}

const char* broken_capabilities(const Capabilities& of) noexcept {
  const auto is_figure = [](double value) { return value >= 0.0 && std::isfinite(value); };
  if (!is_figure(of.resolution.absolute) || !is_figure(of.resolution.relative) ||
      !(of.resolution.of_depth >= 0.0))
    return "its resolution is negative or no figure";
  return nullptr;
}

std::size_t settle_answers(const Query& query, std::size_t pairs, const NarrowphaseOutput& output,
                           std::size_t& first_broken, const char*& what) noexcept {
  const auto slots = static_cast<std::size_t>(query.max_points);
  std::size_t broken = 0;
  for (std::size_t i = 0; i < pairs; ++i) {
    PairGeometry* const geometry = output.geometry.empty() ? nullptr : &output.geometry[i];
    const ContactPoint* const points = output.points.empty() ? nullptr : &output.points[i * slots];
    if (const char* const reason = broken_answer(query, output.status[i], geometry, points)) {
      if (broken++ == 0) first_broken = i, what = reason;
      output.status[i] = PairStatus::failed;
    }
    if (geometry == nullptr) continue;
    const bool beyond = query.kind != QueryKind::overlap && output.status[i] == PairStatus::separated &&
                        geometry->separation == kInfinity;
    if (beyond) {
      *geometry = no_geometry(geometry->separation);
    } else if (query.kind == QueryKind::overlap || !carries_geometry(output.status[i])) {
      *geometry = no_geometry();
    } else if (query.kind == QueryKind::distance) {
      geometry->point_count = 0;
    }
  }
  return broken;
}

}  // namespace touchstone
