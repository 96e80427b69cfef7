#pragma once

#include <ode/ode.h>

#include "touchstone/contact_core/geometry/pose.hpp"

namespace touchstone::ode {

static_assert(sizeof(dReal) == sizeof(double));

/// Keeps ODE initialised while it lives. ODE counts its initialisations but does not lock the count; this
/// does.
class LibraryUse {
 public:
  LibraryUse();
  ~LibraryUse();
  LibraryUse(const LibraryUse&) = delete;
  LibraryUse& operator=(const LibraryUse&) = delete;
};

struct GeomDeleter {
  void operator()(dGeomID geom) const { dGeomDestroy(geom); }
};

/// ODE's row-major rotation, rows padded to four.
struct Rotation {
  dMatrix3 rows;

  explicit Rotation(const Matrix3& R)
      : rows{R(0, 0), R(0, 1), R(0, 2), 0, R(1, 0), R(1, 1), R(1, 2), 0, R(2, 0), R(2, 1), R(2, 2), 0} {}
};

}  // namespace touchstone::ode
