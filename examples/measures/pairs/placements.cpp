#include "touchstone/examples/measures/pairs/placements.hpp"

namespace touchstone::measures {

Pose random_pose(Random& random) {
  return {random_rotation(random), {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)}};
}

Matrix3 turn_about_z(double t) {
  const double d = 1.0 + t * t, c = (1.0 - t * t) / d, s = 2.0 * t / d;
  Matrix3 R;
  R << c, -s, 0, s, c, 0, 0, 0, 1;
  return R;
}

}  // namespace touchstone::measures
