#include "touchstone/examples/compare_backends/fitted/fitted_covers.hpp"

#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/examples/compare_backends/fitted/clearances.hpp"
#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/measures/common/random.hpp"

namespace touchstone::comparison {
namespace {

constexpr std::size_t kTriesAPose = 100;

// A point of the surface, by area, and the normal of its triangle.
struct SurfacePoint {
  Vector3 p, n;
};

class Surface {
 public:
  explicit Surface(const TriangleMesh& mesh) : mesh_(mesh) {
    double sum = 0.0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      sums_.push_back(sum += norm(area_vector(mesh, t)));
  }

  SurfacePoint point(Random& random) const {
    const auto found = std::lower_bound(sums_.begin(), sums_.end(), random.uniform() * sums_.back());
    const auto t = std::min<std::size_t>(static_cast<std::size_t>(found - sums_.begin()), sums_.size() - 1);
    const auto& i = mesh_.triangles[t];
    double u = random.uniform(), v = random.uniform();
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    const Vector3 &a = mesh_.vertices[i[0]], &b = mesh_.vertices[i[1]], &c = mesh_.vertices[i[2]];
    const Vector3 n = area_vector(mesh_, t);
    return {a + u * (b - a) + v * (c - a), n / norm(n)};
  }

 private:
  const TriangleMesh& mesh_;
  std::vector<double> sums_;
};

}  // namespace

ClearancePoses make_poses(const TriangleMesh& mesh, const FittedCover& finest, const PosesRequest& request) {
  ClearancePoses result{Hexahedron::from_size(Vector3::Constant(request.side)), request.range, {}};
  const Surface surface(mesh);
  ClearanceQuery clear(finest, result, make_native());
  Random random(mix_seed(request.seed, 0, 0));
  // A mesh may be turned inside out, and a sheet has two sides: the side to look from is drawn at random.
  for (std::size_t i = 0; i < kTriesAPose * request.count && result.poses.size() < request.count; ++i) {
    const SurfacePoint at = surface.point(random);
    const Vector3 out = random.sign() * at.n;
    Pose X_MP;
    X_MP.R = random_rotation(random);
    const Vector3 across = (X_MP.R.transpose() * out).cwiseAbs();
    X_MP.p = at.p + (0.5 * request.side * across.sum() + random.uniform(0.0, request.range)) * out;
    const Clearance clearance = clear(X_MP);
    if (clearance.is_known && clearance.value > 0.0 && clearance.value < request.range - finest.error)
      result.poses.push_back(X_MP);
  }
  if (result.poses.size() < request.count)
    reject("fitted", "only " + std::to_string(result.poses.size()) + " of " + std::to_string(request.count) +
                         " poses of the probe are apart from the mesh and within the range of it");
  return result;
}

}  // namespace touchstone::comparison
