#pragma once

#include <ode/ode.h>

#include <array>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone::ode_plugin {

/// Answers for a hexahedron geom against the classes that our check does not know. A box is a dBox of ODE's.
/// Another hexahedron is a dConvex, of the faces that are not collapsed and about the mean of its vertices,
/// but for the classes that ODE's check of convexes gets wrong: spheres and capsules (libccd's depths near an
/// edge are off by a tenth and more) and rays (it takes the distance square to a face for the one along the
/// ray) are met by closed forms of ours, meshes and height fields not at all (it ends the process where a
/// mesh was not preprocessed for it).
class EngineTwin {
 public:
  explicit EngineTwin(const Hexahedron& solid);
  ~EngineTwin();
  EngineTwin(const EngineTwin&) = delete;
  EngineTwin& operator=(const EngineTwin&) = delete;

  bool is_box() const { return planes_.empty(); }
  /// Contacts of the solid where `geom` stands, attributed to `geom`. @param flags, contacts, skip dCollide's
  /// @pre a class that it meets
  int collide(dGeomID geom, dGeomID other, int flags, dContactGeom* contacts, int skip);

 private:
  int collide_ray(dGeomID geom, dGeomID ray, dContactGeom& contact) const;
  int collide_round(dGeomID geom, dGeomID other, int flags, dContactGeom* contacts, int skip) const;
  void make_convex(const Hexahedron& solid);

  dGeomID twin_ = nullptr;
  Vector3 centre_ = Vector3::Zero();                     ///< the twin's origin in the solid's frame
  std::array<Vector3, Hexahedron::kVertices> vertices_;  ///< about it
  // A convex points into these.
  std::vector<dReal> points_, planes_;
  std::vector<unsigned int> polygons_;
};

}  // namespace touchstone::ode_plugin
