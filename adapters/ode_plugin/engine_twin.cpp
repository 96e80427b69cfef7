#include "touchstone/adapters/ode_plugin/engine_twin.hpp"

#include "touchstone/adapters/ode/convex_data.hpp"
#include "touchstone/adapters/ode/ode_library.hpp"
#include "touchstone/adapters/ode_plugin/native_collider.hpp"
#include "touchstone/adapters/ode_plugin/rounded_segment.hpp"

namespace touchstone::ode_plugin {

EngineTwin::EngineTwin(const Hexahedron& solid) {
  if (solid.is_box()) {
    const Vector3 sides = 2.0 * solid.half_extents();
    twin_ = dCreateBox(nullptr, sides.x(), sides.y(), sides.z());
  } else {
    make_convex(solid);
  }
}

EngineTwin::~EngineTwin() { dGeomDestroy(twin_); }

void EngineTwin::make_convex(const Hexahedron& solid) {
  centre_ = ode::mean_vertex(solid);
  const ode::ConvexData data(solid, centre_);
  for (std::size_t i = 0; i < vertices_.size(); ++i) vertices_[i] = solid.vertices()[i] - centre_;
  points_.assign(data.points.begin(), data.points.end());
  for (int face = 0; face < 6; ++face) {
    if (solid.face_plane(face).normal == Vector3::Zero()) continue;  // collapsed
    planes_.insert(planes_.end(), data.planes.begin() + 4 * face, data.planes.begin() + 4 * face + 4);
    polygons_.push_back(4);
    for (const std::uint8_t vertex : Hexahedron::kFaceVertices[static_cast<std::size_t>(face)])
      polygons_.push_back(vertex);
  }
  twin_ = dCreateConvex(nullptr, planes_.data(), static_cast<unsigned int>(planes_.size() / 4),
                        points_.data(), Hexahedron::kVertices, polygons_.data());
}

int EngineTwin::collide(dGeomID geom, dGeomID other, int flags, dContactGeom* contacts, int skip) {
  const int other_class = dGeomGetClass(other);
  if (!is_box() && other_class == dRayClass) return collide_ray(geom, other, contacts[0]);
  if (!is_box() && (other_class == dSphereClass || other_class == dCapsuleClass))
    return collide_round(geom, other, flags, contacts, skip);
  const Pose X = pose_of(geom);
  const Vector3 p = transform(X, centre_);
  const ode::Rotation R(X.R);
  dGeomSetPosition(twin_, p.x(), p.y(), p.z());
  dGeomSetRotation(twin_, R.rows);
  dReal bounds[6];
  dGeomGetAABB(twin_, bounds);  // meshes read what this brings up to date
  const int count = dCollide(twin_, other, flags, contacts, skip);
  for (int i = 0; i < count; ++i) {
    dContactGeom& contact = contact_at(contacts, skip, i);
    if (contact.g1 == twin_) contact.g1 = geom;
    if (contact.g2 == twin_) contact.g2 = geom;
  }
  return count;
}

/// Where the ray comes into all planes, or, begun within, where it leaves the first.
int EngineTwin::collide_ray(dGeomID geom, dGeomID ray, dContactGeom& contact) const {
  count_check();
  // The ray is clipped in the solid's frame, where the planes stand still.
  dVector3 start, along;
  dGeomRayGet(ray, start, along);
  const Pose X = pose_of(geom);
  const Matrix3 R_GW = X.R.transpose();
  const Vector3 p_W(start[0], start[1], start[2]), d_W(along[0], along[1], along[2]);
  const Vector3 p = rotate(R_GW, p_W - X.p) - centre_, d = rotate(R_GW, d_W);
  // It is inside from the last plane that it enters to the first that it leaves.
  double enters = -dInfinity, leaves = dInfinity;
  Vector3 n_in = Vector3::Zero(), n_out = Vector3::Zero();
  for (std::size_t i = 0; i < planes_.size(); i += 4) {
    const Vector3 n(planes_[i], planes_[i + 1], planes_[i + 2]);
    const double above = dot(n, p) - planes_[i + 3], rate = dot(n, d);
    if (rate == 0.0 && above > 0.0) return 0;
    if (rate < 0.0 && -above / rate > enters) enters = -above / rate, n_in = n;
    if (rate > 0.0 && -above / rate < leaves) leaves = -above / rate, n_out = n;
  }
  // A ray from within meets the surface where it leaves.
  const bool from_within = enters < 0.0;
  const double distance = from_within ? leaves : enters;
  if (!(enters <= leaves) || !(distance >= 0.0) || !(distance <= dGeomRayGetLength(ray))) return 0;
  // ODE expects the contact in the world's frame.
  const Vector3 on_surface = p_W + distance * d_W;
  const Vector3 n_W = rotate(X.R, from_within ? n_out : Vector3(-n_in));  // into the solid, or back into it
  for (int k = 0; k < 3; ++k) contact.pos[k] = on_surface[k], contact.normal[k] = n_W[k];
  contact.pos[3] = contact.normal[3] = 0.0;
  contact.depth = distance;
  contact.g1 = geom, contact.g2 = ray;
  contact.side1 = contact.side2 = -1;
  return 1;
}

/// One contact; of a capsule whose two ends are both in, along one normal, two.
int EngineTwin::collide_round(dGeomID geom, dGeomID other, int flags, dContactGeom* contacts,
                              int skip) const {
  count_check();
  const Pose X = pose_of(geom), X_WO = pose_of(other);
  double radius = 0.0, length = 0.0;
  if (dGeomGetClass(other) == dCapsuleClass)
    dGeomCapsuleGetParams(other, &radius, &length);
  else
    radius = dGeomSphereGetRadius(other);
  const Matrix3 R_GW = X.R.transpose();
  const Vector3 middle = rotate(R_GW, X_WO.p - X.p) - centre_,
                half = rotate(R_GW, 0.5 * length * Vector3(X_WO.R.col(2)));
  const Vector3 a = middle - half, b = middle + half;
  int count = 0;
  const auto write = [&](const Nearest& at) {
    dContactGeom& contact = contact_at(contacts, skip, count++);
    const double depth = radius - at.distance;
    // Half-way between the two surfaces.
    const Vector3 p_W = transform(X, at.on_segment - (radius - 0.5 * depth) * at.n + centre_),
                  n_W = rotate(X.R, at.n);
    for (int k = 0; k < 3; ++k) contact.pos[k] = p_W[k], contact.normal[k] = -n_W[k];
    contact.pos[3] = contact.normal[3] = 0.0;
    contact.depth = depth;
    contact.g1 = geom, contact.g2 = other;
    contact.side1 = contact.side2 = -1;
  };
  // Both ends where one normal serves both, else the deepest point.
  const Nearest deepest = nearest(a, b, vertices_, planes_);
  if (!(deepest.distance <= radius)) return 0;
  if (length > 0.0 && most_contacts(flags) >= 2) {
    constexpr double kOneNormal = 0.999;  // the cosine of 2.5 degrees
    const Nearest at_a = nearest(a, a, vertices_, planes_), at_b = nearest(b, b, vertices_, planes_);
    if (at_a.distance <= radius && at_b.distance <= radius && dot(at_a.n, deepest.n) >= kOneNormal &&
        dot(at_b.n, deepest.n) >= kOneNormal) {
      const bool is_a_deeper = at_a.distance <= at_b.distance;
      write(is_a_deeper ? at_a : at_b), write(is_a_deeper ? at_b : at_a);
      return count;
    }
  }
  write(deepest);
  return count;
}

}  // namespace touchstone::ode_plugin
