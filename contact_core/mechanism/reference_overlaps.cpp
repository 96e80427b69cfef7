#include "touchstone/contact_core/mechanism/reference_overlaps.hpp"

#include <sstream>

#include "touchstone/contact_core/geometry/constants.hpp"

namespace touchstone {
namespace {

std::vector<Pose> solid_poses(const Mechanism& mechanism, std::span<const double> q) {
  std::vector<Pose> X_WL(mechanism.links().size()), X_WS;
  mechanism.link_poses({}, q, X_WL);
  for (std::uint32_t i = 0; i < mechanism.solids().size(); ++i)
    X_WS.push_back(compose(X_WL[mechanism.link_of(i)], mechanism.placed(i).X_OS));
  return X_WS;
}

}  // namespace

std::vector<ReferenceOverlap> find_reference_overlaps(const Mechanism& mechanism, Narrowphase& narrowphase) {
  // All pairs that are not exempt are checked.
  const auto count = static_cast<std::uint32_t>(mechanism.solids().size());
  std::vector<SolidPair> pairs;
  for (std::uint32_t a = 0; a < count; ++a)
    for (std::uint32_t b = a + 1; b < count; ++b)
      if (!mechanism.is_exempt(a, b)) pairs.push_back({a, b});
  if (pairs.empty()) return {};

  // They are evaluated in the reference configuration, with depths where the backend knows them.
  narrowphase.build(mechanism.solids());
  const Capabilities& can = narrowphase.capabilities();
  const std::vector<Pose> poses = solid_poses(mechanism, mechanism.reference());
  Query query;
  query.kind = can.distance && can.penetration ? QueryKind::distance : QueryKind::overlap;
  std::vector<PairStatus> status(pairs.size());
  std::vector<PairGeometry> geometry(pairs.size());
  const auto workspace = narrowphase.make_workspace();
  narrowphase.evaluate({pairs, poses, query}, {status, geometry, {}}, *workspace);

  // All pairs that are not separated are reported.
  std::vector<ReferenceOverlap> overlaps;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (status[i] == PairStatus::separated) continue;
    const bool has_depth = query.kind == QueryKind::distance &&
                           (status[i] == PairStatus::overlapping || status[i] == PairStatus::undecided);
    overlaps.push_back({pairs[i], status[i], has_depth ? geometry[i].separation : kNaN});
  }
  return overlaps;
}

std::string to_string(const ReferenceOverlap& overlap, const Mechanism& mechanism) {
  std::ostringstream text;
  text.precision(6);
  text << "mechanism '" << mechanism.name() << "': '" << mechanism.solid_name(overlap.solids.a) << "' and '"
       << mechanism.solid_name(overlap.solids.b) << "' are " << to_string(overlap.status)
       << " in the reference pose, separation " << overlap.separation << " m";
  return text.str();
}

}  // namespace touchstone
