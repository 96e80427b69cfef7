#pragma once

#include <algorithm>
#include <cstdint>

#include "touchstone/physics/solver/contact_laws.hpp"

// The projection on the cone |(p_1, p_2)| <= friction p_0, and its derivatives, as convex contacts ask for
// them. Vectors have the normal's part first.

namespace touchstone::physics {

enum class ConeRegion : std::uint8_t { in, below, beside };  // the cone, its polar, neither

/// The projection on the cone. @param t length of y's tangents.
inline ConeRegion project_on_cone(double friction, const double* y, double t, double* p) {
  if (t <= friction * y[0]) {
    std::copy(y, y + 3, p);
    return ConeRegion::in;
  }
  if (friction * t <= -y[0]) {
    p[0] = p[1] = p[2] = 0.0;
    return ConeRegion::below;
  }
  p[0] = (y[0] + friction * t) / (1.0 + friction * friction);
  p[1] = friction * p[0] * (y[1] / t);
  p[2] = friction * p[0] * (y[2] / t);
  return ConeRegion::beside;
}

/// Its derivative times `factor`: symmetric, 3 x 3, row by row.
inline void slope_of_projection(double friction, const double* y, double factor, double* G) {
  const double t = length_of(y[1], y[2]);
  double p[3];
  std::fill(G, G + 9, 0.0);
  switch (project_on_cone(friction, y, t, p)) {
    case ConeRegion::below:
      return;
    case ConeRegion::in:
      G[0] = G[4] = G[8] = factor;
      return;
    case ConeRegion::beside:
      break;
  }
  const double share = factor / (1.0 + friction * friction), e1 = y[1] / t, e2 = y[2] / t;
  const double across = factor * (friction * p[0] / t), along = friction * friction * share;
  G[0] = share;
  G[1] = G[3] = friction * share * e1;
  G[2] = G[6] = friction * share * e2;
  G[4] = along * e1 * e1 + across * e2 * e2;
  G[8] = along * e2 * e2 + across * e1 * e1;
  G[5] = G[7] = (along - across) * e1 * e2;
}

/// How much the projection changes along d.
inline void change_of_projection(double friction, const double* y, const double* d, double* p,
                                 double* change) {
  const double t = length_of(y[1], y[2]);
  switch (project_on_cone(friction, y, t, p)) {
    case ConeRegion::below:
      change[0] = change[1] = change[2] = 0.0;
      return;
    case ConeRegion::in:
      std::copy(d, d + 3, change);
      return;
    case ConeRegion::beside:
      break;
  }
  const double e1 = y[1] / t, e2 = y[2] / t, out = e1 * d[1] + e2 * d[2], across = friction * p[0] / t;
  change[0] = (d[0] + friction * out) / (1.0 + friction * friction);
  change[1] = friction * change[0] * e1 + across * (d[1] - out * e1);
  change[2] = friction * change[0] * e2 + across * (d[2] - out * e2);
}

}  // namespace touchstone::physics
