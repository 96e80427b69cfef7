#pragma once

#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/tests/support/at.hpp"

// A narrowphase's answers with the memory they need.

namespace touchstone {

/// The outputs for each pair; query.max_points slots of `points` a pair.
struct Answers {
  std::vector<PairStatus> status;
  std::vector<PairGeometry> geometry;
  std::vector<ContactPoint> points;
};

/// Into `out`, which keeps its memory from one call to the next.
inline void evaluate(const Narrowphase& narrowphase, std::span<const SolidPair> pairs,
                     std::span<const Pose> poses, const Query& query, Narrowphase::Workspace& workspace,
                     Answers& out) {
  out.status.resize(pairs.size());
  out.geometry.resize(pairs.size());
  out.points.resize(pairs.size() * static_cast<std::size_t>(query.max_points));
  narrowphase.evaluate({pairs, poses, query, {}}, {out.status, out.geometry, out.points}, workspace);
}

inline Answers ask(const Narrowphase& narrowphase, std::span<const SolidPair> pairs,
                   std::span<const Pose> poses, const Query& query) {
  Answers out;
  const auto workspace = narrowphase.make_workspace();
  evaluate(narrowphase, pairs, poses, query, *workspace, out);
  return out;
}

/// The outputs for one pair; point_count points.
struct Answer {
  PairStatus status = PairStatus::failed;
  PairGeometry geometry{};
  std::vector<ContactPoint> points;
};

/// One pair of the solids that `narrowphase` was built for.
inline Answer ask(const Narrowphase& narrowphase, std::span<const Pose> poses, const Query& query,
                  SolidPair pair = {0, 1}) {
  Answers all = ask(narrowphase, {&pair, 1}, poses, query);
  all.points.resize(static_cast<std::size_t>(all.geometry[0].point_count));
  return {all.status[0], all.geometry[0], std::move(all.points)};
}

}  // namespace touchstone
