#pragma once

#include <algorithm>
#include <cstdint>

#include "touchstone/physics/solver/contact_laws.hpp"

// The projection on the cone |(p_1, p_2)| <= friction p_0, and its derivatives, as convex contacts ask for
// them. Vectors have the normal's part first.

namespace touchstone::physics {

enum class ConeRegion : std::uint8_t { in, below, beside };  // the cone, its polar, neither

/// Whether y is in the cone's polar, its apex left out. @param t length of y's tangents.
inline bool is_below_cone(double friction, const double* y, double t) {
  return y[0] < 0.0 && friction * t <= -y[0];
}

/// The projection on the cone. @param t length of y's tangents.
inline ConeRegion project_on_cone(double friction, const double* y, double t, double* p) {
  // First, as 0 <= 0 y_0 holds for y_0 < 0 without friction.
  if (is_below_cone(friction, y, t)) {
    p[0] = p[1] = p[2] = 0.0;
    return ConeRegion::below;
  }
  if (t <= friction * y[0]) {
    std::copy(y, y + 3, p);
    return ConeRegion::in;
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

/// The projection p of y, and its change along d, both multiplied by d.
struct ConeSlope {
  double projection, change;
};

inline ConeSlope slope_along(double friction, const double* y, const double* d) {
  const double t = length_of(y[1], y[2]), across_d = d[1] * d[1] + d[2] * d[2];
  if (is_below_cone(friction, y, t)) return {0.0, 0.0};
  if (t <= friction * y[0]) return {(y[0] * d[0] + y[1] * d[1]) + y[2] * d[2], d[0] * d[0] + across_d};
  const double p = (y[0] + friction * t) / (1.0 + friction * friction), share = 1.0 / t;
  const double out = share * (y[1] * d[1] + y[2] * d[2]), along = d[0] + friction * out;
  return {p * along,
          along * along / (1.0 + friction * friction) + (friction * p * share) * (across_d - out * out)};
}

}  // namespace touchstone::physics
