#include "touchstone/adapters/python/poses.hpp"

#include <algorithm>

#include "touchstone/contact_core/geometry/finite.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::python {
namespace {

std::string nth(std::size_t i) { return "pose " + std::to_string(i); }

Pose checked_pose(const double* m, std::size_t i) {
  Pose X;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) X.R(row, column) = m[4 * row + column];
    X.p(row) = m[4 * row + 3];
  }
  const bool is_affine = m[12] == 0.0 && m[13] == 0.0 && m[14] == 0.0 && m[15] == 1.0;
  if (is_affine && is_valid_pose(X)) return X;
  return pose_from_rows(m, nth(i));  // which says what is wrong
}

Pose checked_pose(const double* p, const double* q, std::size_t i) {
  const Vector3 position(p[0], p[1], p[2]);
  if (!is_finite(position)) reject(nth(i), "position is not finite");
  const bool is_sound = std::any_of(q, q + 4, [](double x) { return x != 0.0; }) && all_finite({q, 4});
  return {is_sound ? rotation_from_quaternion(q[0], q[1], q[2], q[3])
                   : rotation_from_quaternion(q[0], q[1], q[2], q[3], nth(i)),
          position};
}

}  // namespace

std::vector<Pose> Poses::from(const py::handle& matrices_or_positions, const py::handle& quaternions) {
  std::vector<Pose> made;
  if (quaternions.is_none()) {
    const Doubles rows = doubles(matrices_or_positions, "poses", {-1, 4, 4}, "(n, 4, 4)");
    made.reserve(static_cast<std::size_t>(rows.shape(0)));
    for (std::size_t i = 0; i < static_cast<std::size_t>(rows.shape(0)); ++i)
      made.push_back(checked_pose(rows.data() + 16 * i, i));
    return made;
  }
  const Doubles p = doubles(matrices_or_positions, "positions", {-1, 3}, "(n, 3)");
  const Doubles q = doubles(quaternions, "quaternions", {-1, 4}, "(n, 4)");
  if (p.shape(0) != q.shape(0))
    reject("quaternions", "are " + std::to_string(q.shape(0)) + ", positions " + std::to_string(p.shape(0)));
  const auto count = static_cast<std::size_t>(p.shape(0));
  made.reserve(count);
  for (std::size_t i = 0; i < count; ++i) made.push_back(checked_pose(p.data() + 3 * i, q.data() + 4 * i, i));
  return made;
}

void Poses::update(std::vector<Pose> poses, std::size_t first) {
  if (readers_ > 0) throw std::runtime_error("poses: are being read by another thread");
  if (first > poses_.size() || poses.size() > poses_.size() - first)
    reject("poses", std::to_string(poses.size()) + " from " + std::to_string(first) + " on do not fit in " +
                        std::to_string(poses_.size()));
  if (poses.size() == poses_.size())
    poses_.swap(poses);
  else
    std::copy(poses.begin(), poses.end(), poses_.begin() + static_cast<std::ptrdiff_t>(first));
}

Doubles Poses::matrices() const {
  Doubles made({static_cast<py::ssize_t>(poses_.size()), py::ssize_t{4}, py::ssize_t{4}});
  double* out = made.mutable_data();
  for (const Pose& X : poses_) {
    write_rows(X, out);
    out += 16;
  }
  return made;
}

}  // namespace touchstone::python
