#include <algorithm>
#include <array>
#include <memory>
#include <new>
#include <string>

#include "touchstone/adapters/ode/ode_library.hpp"
#include "touchstone/adapters/ode_plugin/engine_twin.hpp"
#include "touchstone/adapters/ode_plugin/native_collider.hpp"
#include "touchstone/adapters/ode_plugin/ode_plugin.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using namespace ode_plugin;

/// A geom's data, in memory that ODE gives, all zero: so it stays in a geom that dCreateGeom has made.
struct GeomSolid {
  std::shared_ptr<native::SolidStore> store;  ///< null without a solid
  native::SolidHandle solid{};
  std::array<Vector3, Hexahedron::kVertices> vertices;
  std::unique_ptr<EngineTwin> twin;
};

GeomSolid& solid_of(dGeomID geom) { return *static_cast<GeomSolid*>(dGeomGetClassData(geom)); }

void destroy(dGeomID geom) {
  GeomSolid& data = solid_of(geom);
  if (data.store) data.store->release(data.solid);
  data.~GeomSolid();
}

void find_bounds(dGeomID geom, dReal bounds[6]) {
  const Pose X = pose_of(geom);
  const GeomSolid& data = solid_of(geom);
  if (!data.store) {
    for (int k = 0; k < 3; ++k) bounds[2 * k] = bounds[2 * k + 1] = X.p[k];
    return;
  }
  for (int k = 0; k < 3; ++k) bounds[2 * k] = dInfinity, bounds[2 * k + 1] = -dInfinity;
  for (const Vector3& vertex : data.vertices) {
    const Vector3 p = transform(X, vertex);
    for (int k = 0; k < 3; ++k) {
      bounds[2 * k] = std::min(bounds[2 * k], p[k]);
      bounds[2 * k + 1] = std::max(bounds[2 * k + 1], p[k]);
    }
  }
}

int collide_hexahedra(dGeomID geom1, dGeomID geom2, int flags, dContactGeom* contacts, int skip) {
  const GeomSolid &a = solid_of(geom1), &b = solid_of(geom2);
  if (!a.store || a.store != b.store) return refuse();
  return collide_solids(geom1, a.solid, geom2, b.solid, *a.store, flags, contacts, skip);
}

int collide_with_box(dGeomID geom, dGeomID box, int flags, dContactGeom* contacts, int skip) {
  const GeomSolid& a = solid_of(geom);
  const native::SolidHandle* const b = solid_of_box(box);
  if (!a.store || !a.store->is_native() || !b) return refuse();
  return collide_solids(geom, a.solid, box, *b, *a.store, flags, contacts, skip);
}

/// The vertices on or below the plane, the deepest first.
int collide_with_plane(dGeomID geom, dGeomID plane, int flags, dContactGeom* contacts, int skip) {
  const GeomSolid& data = solid_of(geom);
  if (!data.store) return refuse();
  count_check();
  dVector4 n;
  dGeomPlaneGetParams(plane, n);
  const Pose X = pose_of(geom);
  // Vertices below the plane, sorted.
  struct Below {
    Vector3 p;
    double depth;
  };
  std::array<Below, Hexahedron::kVertices> below;
  int count = 0;
  for (const Vector3& vertex : data.vertices) {
    const Vector3 p = transform(X, vertex);
    const double depth = n[3] - dot({n[0], n[1], n[2]}, p);
    if (depth >= 0.0) below[count++] = {p, depth};
  }
  std::stable_sort(below.begin(), below.begin() + count,
                   [](const Below& u, const Below& v) { return u.depth > v.depth; });
  count = std::min(count, most_contacts(flags));
  // Contacts half-way between vertex and plane.
  for (int i = 0; i < count; ++i) {
    dContactGeom& contact = contact_at(contacts, skip, i);
    for (int k = 0; k < 3; ++k) {
      contact.pos[k] = below[i].p[k] + 0.5 * below[i].depth * n[k];
      contact.normal[k] = n[k];
    }
    contact.pos[3] = contact.normal[3] = 0.0;
    contact.depth = below[i].depth;
    contact.g1 = geom, contact.g2 = plane;
    contact.side1 = contact.side2 = -1;
  }
  return count;
}

/// Classes that only ODE's own check knows.
int collide_as_engine(dGeomID geom, dGeomID other, int flags, dContactGeom* contacts, int skip) {
  GeomSolid& data = solid_of(geom);
  const bool is_placed = is_finite(pose_of(geom)) && is_finite(pose_of(other));
  if (!data.twin || !is_placed) return refuse();
  const int other_class = dGeomGetClass(other);
  if (!data.twin->is_box() && (other_class == dTriMeshClass || other_class == dHeightfieldClass))
    return refuse();
  return data.twin->collide(geom, other, flags, contacts, skip);
}

constexpr std::array kEngineClasses = {dSphereClass, dCapsuleClass, dCylinderClass,   dConvexClass,
                                       dRayClass,    dTriMeshClass, dHeightfieldClass};

dColliderFn* collider_for(int other_class) {
  if (other_class == ode_hexahedron_class()) return &collide_hexahedra;
  if (other_class == dBoxClass) return &collide_with_box;
  if (other_class == dPlaneClass) return &collide_with_plane;
  const bool is_engines =
      std::find(kEngineClasses.begin(), kEngineClasses.end(), other_class) != kEngineClasses.end();
  return is_engines ? &collide_as_engine : nullptr;
}

/// ODE counts user classes anew when it is closed: it stays open.
struct HexahedronClass {
  ode::LibraryUse library;
  int number;

  HexahedronClass() {
    const dGeomClass description{sizeof(GeomSolid), &collider_for, &find_bounds, nullptr, &destroy};
    number = dCreateGeomClass(&description);
  }
};

std::array<std::array<double, 3>, 8> points_of(const Hexahedron& solid) {
  std::array<std::array<double, 3>, 8> points{};
  if (solid.is_box()) {
    for (int k = 0; k < 3; ++k) points[0][k] = 2.0 * solid.half_extents()[k];
  } else {
    for (int i = 0; i < Hexahedron::kVertices; ++i)
      for (int k = 0; k < 3; ++k) points[i][k] = solid.vertices()[i][k];
  }
  return points;
}

}  // namespace

int ode_hexahedron_class() {
  static const HexahedronClass hexahedron;
  return hexahedron.number;
}

dxGeom* create_ode_hexahedron(dxSpace* space, const Hexahedron& solid,
                              const std::shared_ptr<CheckInside>& inside) {
  refuse_rounded({&solid, 1}, "ODE hexahedron");
  const std::shared_ptr<native::SolidStore> store = inside ? inside : solid_store();
  const auto handle = store->acquire({solid.is_box(), points_of(solid)});
  if (!handle)
    throw InputError("ODE hexahedron: zero volume, or refused by check '" + std::string(store->name()) + "'");
  dAllocateODEDataForThread(dAllocateMaskAll);
  const dGeomID geom = dCreateGeom(ode_hexahedron_class());
  new (dGeomGetClassData(geom))
      GeomSolid{store, *handle, solid.vertices(), std::make_unique<EngineTwin>(solid)};
  if (space != nullptr) dSpaceAdd(space, geom);
  return geom;
}

}  // namespace touchstone
