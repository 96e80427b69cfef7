#include "touchstone/examples/fit/samples.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone::fitting {
namespace {

class Random {
 public:
  double next() {  // [0, 1), xorshift
    state_ ^= state_ << 13;
    state_ ^= state_ >> 7;
    state_ ^= state_ << 17;
    return static_cast<double>(state_ >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_ = 0x9e3779b97f4a7c15U;
};

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

std::vector<double> area_sums(const TriangleMesh& mesh) {
  std::vector<double> sums;
  double sum = 0.0;
  for (const auto& t : mesh.triangles) {
    sum += norm(cross(mesh.vertices[t[1]] - mesh.vertices[t[0]], mesh.vertices[t[2]] - mesh.vertices[t[0]]));
    sums.push_back(sum);
  }
  return sums;
}

Vector3 on_surface(const TriangleMesh& mesh, const std::vector<double>& sums, Random& random) {
  const auto found = std::lower_bound(sums.begin(), sums.end(), random.next() * sums.back());
  const auto& t = mesh.triangles[std::min<std::size_t>(found - sums.begin(), sums.size() - 1)];
  const double root = std::sqrt(random.next()), share = random.next();
  return (1.0 - root) * mesh.vertices[t[0]] + root * (1.0 - share) * mesh.vertices[t[1]] +
         root * share * mesh.vertices[t[2]];
}

}  // namespace

SampleCount count_uncovered(const MeshDistance& mesh, const Fit& fit, std::size_t samples) {
  const std::vector<Faces> faces = faces_of(fit);
  const std::vector<double> sums = area_sums(mesh.mesh());
  const double tolerance = 1e-12 * mesh.largest_coordinate();
  const Vector3 size = mesh.bounds().high - mesh.bounds().low;
  Random random;
  std::size_t hint = 0;
  SampleCount count;
  while (count.asked < samples) {
    Vector3 p = on_surface(mesh.mesh(), sums, random);
    count.uncovered += is_covered(faces, p, tolerance, hint) ? 0 : 1;
    ++count.asked;
    // A point of the bounding box that is covered needs no look at the solid.
    p = mesh.bounds().low +
        Vector3(random.next() * size.x(), random.next() * size.y(), random.next() * size.z());
    if (!is_covered(faces, p, tolerance, hint)) count.uncovered += mesh.is_inside(p) ? 1 : 0;
    ++count.asked;
  }
  return count;
}

}  // namespace touchstone::fitting
