#pragma once

#include "touchstone/physics/solver/body_contact_lanes.hpp"

// cone_projection.hpp and the residual of contact_laws.hpp for contacts side by side, to the bit.

namespace touchstone::physics {

/// Of y: in the polar, its apex left out; else in the cone; else beside.
struct ConeLanes {
  Four t;  // length of y's tangents
  FourMask is_below, is_in;
  Four divisor;  // t; 1 where that is 0, which is never beside
};

/// Lanes that are padding divide by 1: by 0 they would raise floating-point exceptions.
TOUCHSTONE_INLINE Four divisor_of(const Four& p) { return select(p <= in_all(0.0), in_all(1.0), p); }

TOUCHSTONE_INLINE ConeLanes regions_of(const Four& friction, const ContactLanes& y) {
  const Four t = square_root(y.t1 * y.t1 + y.t2 * y.t2);
  return {t, (y.n < in_all(0.0)) & (friction * t <= -y.n), t <= friction * y.n, divisor_of(t)};
}

/// `below` is 0.
TOUCHSTONE_INLINE Four by_region(const ConeLanes& of, const Four& in, const Four& beside) {
  return select(of.is_below, in_all(0.0), select(of.is_in, in, beside));
}

TOUCHSTONE_INLINE ContactLanes project_on_cones(const Four& friction, const ContactLanes& y) {
  const ConeLanes of = regions_of(friction, y);
  const Four p = (y.n + friction * of.t) / (in_all(1.0) + friction * friction);
  return {by_region(of, y.n, p), by_region(of, y.t1, friction * p * (y.t1 / of.divisor)),
          by_region(of, y.t2, friction * p * (y.t2 / of.divisor))};
}

TOUCHSTONE_INLINE SymmetricLanes slopes_of_projection(const Four& friction, const ContactLanes& y,
                                                      const Four& factor) {
  const ConeLanes of = regions_of(friction, y);
  const Four p = (y.n + friction * of.t) / (in_all(1.0) + friction * friction);
  const Four share = factor / (in_all(1.0) + friction * friction), e1 = y.t1 / of.divisor,
             e2 = y.t2 / of.divisor;
  const Four across = factor * (friction * p / of.divisor), along = friction * friction * share;
  const Four none = in_all(0.0);
  return {{by_region(of, factor, share), by_region(of, none, friction * share * e1),
           by_region(of, factor, along * e1 * e1 + across * e2 * e2),
           by_region(of, none, friction * share * e2), by_region(of, none, (along - across) * e1 * e2),
           by_region(of, factor, along * e2 * e2 + across * e1 * e1)}};
}

/// ConeSlope.
struct ConeSlopes {
  Four projection, change;
};

TOUCHSTONE_INLINE ConeSlopes slopes_along(const Four& friction, const ContactLanes& y,
                                          const ContactLanes& d) {
  const ConeLanes of = regions_of(friction, y);
  const Four across_d = d.t1 * d.t1 + d.t2 * d.t2, wide = in_all(1.0) + friction * friction;
  const Four p = (y.n + friction * of.t) / wide, share = in_all(1.0) / of.divisor;
  const Four out = share * (y.t1 * d.t1 + y.t2 * d.t2), along = d.n + friction * out;
  return {by_region(of, (y.n * d.n + y.t1 * d.t1) + y.t2 * d.t2, p * along),
          by_region(of, d.n * d.n + across_d,
                    along * along / wide + (friction * p * share) * (across_d - out * out))};
}

/// contact_residual(); of w = 0, a lane that is padding, no figure but no exception.
TOUCHSTONE_INLINE Four contact_residuals(const Four& w, const Four& friction, const ContactLanes& x,
                                         const ContactLanes& u) {
  const Four none = in_all(0.0), wx = w * x.n, normal = select((wx < u.n) | (wx != wx), wx, u.n);
  const Four scale = divisor_of(w), t1 = x.t1 - u.t1 / scale, t2 = x.t2 - u.t2 / scale;
  // The tangents are shrunk to the disc.
  const Four radius = friction * select(x.n < none, none, x.n), length = square_root(t1 * t1 + t2 * t2);
  const Four factor =
      select(length <= radius, in_all(1.0), select(none < radius, radius / divisor_of(length), none));
  const Four r1 = w * (x.t1 - factor * t1), r2 = w * (x.t2 - factor * t2);
  return worse_of(magnitude(normal), square_root(r1 * r1 + r2 * r2));
}

}  // namespace touchstone::physics
