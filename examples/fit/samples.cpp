#include "touchstone/examples/fit/samples.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone::fitting {
namespace {

struct Faces {
  Bounds box;
  std::array<Plane, 6> planes;
};

std::vector<Faces> faces_of(const Fit& fit) {
  std::vector<Faces> all;
  for (const FittedHexahedron& each : fit.hexahedra) {
    const Hexahedron solid = Hexahedron::from_vertices(each.vertices);
    Faces faces;
    for (int f = 0; f < 6; ++f) faces.planes[f] = solid.face_plane(f);
    for (const Vector3& p : each.vertices) faces.box.add(p);
    all.push_back(faces);
  }
  return all;
}

bool is_covered(const std::vector<Faces>& all, const Vector3& p, double tolerance, std::size_t& hint) {
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::size_t at = (hint + i) % all.size();
    const Faces& faces = all[at];
    if ((faces.box.low - p).maxCoeff() > tolerance || (p - faces.box.high).maxCoeff() > tolerance) continue;
    const bool holds = std::all_of(faces.planes.begin(), faces.planes.end(),
                                   [&](const Plane& plane) { return plane.signed_distance(p) <= tolerance; });
    if (!holds) continue;
    hint = at;
    return true;
  }
  return false;
}

}  // namespace

SurfacePoints::SurfacePoints(const TriangleMesh& mesh) : mesh_(mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) {
    sum += norm(cross(mesh.vertices[t[1]] - mesh.vertices[t[0]], mesh.vertices[t[2]] - mesh.vertices[t[0]]));
    area_sums_.push_back(sum);
  }
}

double SurfacePoints::uniform() {  // xorshift
  state_ ^= state_ << 13;
  state_ ^= state_ >> 7;
  state_ ^= state_ << 17;
  return static_cast<double>(state_ >> 11) * 0x1p-53;
}

Vector3 SurfacePoints::next() {
  const auto found = std::lower_bound(area_sums_.begin(), area_sums_.end(), uniform() * area_sums_.back());
  const auto& t = mesh_.triangles[std::min<std::size_t>(found - area_sums_.begin(), area_sums_.size() - 1)];
  const double root = std::sqrt(uniform()), share = uniform();
  return (1.0 - root) * mesh_.vertices[t[0]] + root * (1.0 - share) * mesh_.vertices[t[1]] +
         root * share * mesh_.vertices[t[2]];
}

SampleCount count_uncovered(const MeshDistance& mesh, const Fit& fit, std::size_t samples) {
  const std::vector<Faces> faces = faces_of(fit);
  const double tolerance = 1e-12 * mesh.largest_coordinate();
  const Vector3 size = mesh.bounds().high - mesh.bounds().low;
  SurfacePoints points(mesh.mesh());
  std::size_t hint = 0;
  SampleCount count;
  while (count.asked < samples) {
    Vector3 p = points.next();
    count.uncovered += is_covered(faces, p, tolerance, hint) ? 0 : 1;
    ++count.asked;
    // A point of the bounding box that is covered needs no look at the solid.
    p = mesh.bounds().low +
        Vector3(points.uniform() * size.x(), points.uniform() * size.y(), points.uniform() * size.z());
    if (!is_covered(faces, p, tolerance, hint)) count.uncovered += mesh.is_inside(p) ? 1 : 0;
    ++count.asked;
  }
  return count;
}

}  // namespace touchstone::fitting
