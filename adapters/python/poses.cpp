#include "touchstone/adapters/python/poses.hpp"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "touchstone/adapters/python/widest.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/finite.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::python {
namespace {

std::string nth(std::size_t i) { return "pose " + std::to_string(i); }

/// Four doubles: a row of a 4 x 4 matrix, or one entry of four poses.
using Row = double __attribute__((vector_size(32)));
using RowMask = decltype(Row{} == Row{});

#define TOUCHSTONE_IN_PLACE inline __attribute__((always_inline))

TOUCHSTONE_IN_PLACE void load(const double* from, Row& to) { std::memcpy(&to, from, sizeof to); }
TOUCHSTONE_IN_PLACE void store(const Row& from, double* to) { std::memcpy(to, &from, sizeof from); }
TOUCHSTONE_IN_PLACE void transpose(Row (&m)[4]) {
  const Row even_01 = __builtin_shufflevector(m[0], m[1], 0, 4, 2, 6);
  const Row odd_01 = __builtin_shufflevector(m[0], m[1], 1, 5, 3, 7);
  const Row even_23 = __builtin_shufflevector(m[2], m[3], 0, 4, 2, 6);
  const Row odd_23 = __builtin_shufflevector(m[2], m[3], 1, 5, 3, 7);
  m[0] = __builtin_shufflevector(even_01, even_23, 0, 1, 4, 5);
  m[1] = __builtin_shufflevector(odd_01, odd_23, 0, 1, 4, 5);
  m[2] = __builtin_shufflevector(even_01, even_23, 2, 3, 6, 7);
  m[3] = __builtin_shufflevector(odd_01, odd_23, 2, 3, 6, 7);
}
TOUCHSTONE_IN_PLACE bool all_of(const RowMask& mask) { return (mask[0] & mask[1] & mask[2] & mask[3]) != 0; }

static_assert(sizeof(Pose) == 12 * sizeof(double));

TOUCHSTONE_IN_PLACE Row magnitudes(const Row& of) {
  constexpr std::int64_t kNoSign = std::numeric_limits<std::int64_t>::max();
  return reinterpret_cast<Row>(reinterpret_cast<RowMask>(of) & RowMask{kNoSign, kNoSign, kNoSign, kNoSign});
}

/// Writes matrices, row by row, as poses. Returns true where each is a rigid transform: is_valid_pose(), its
/// sums in the same order, and a last row of 0 0 0 1. False, too, where sums of coordinates or products
/// overflow.
TOUCHSTONE_WIDEST bool write_matrices(const double* rows, std::size_t count, double* poses) {
  // The fourth column is no part of a rotation: squares of its entries may be anything.
  const Row most = {kRotationTolerance, kRotationTolerance, kRotationTolerance, kInfinity};
  const Row unit = {1.0, 1.0, 1.0, 0.0}, last = {0.0, 0.0, 0.0, 1.0};
  // Of orthonormal rows the products of x and y cross z are the squares of x's entries, or in a mirror image
  // their negatives, of which one is -1/3 or less.
  const Row least = {-0.1, -0.1, -0.1, -kInfinity};
  RowMask is_rigid = {-1, -1, -1, -1};
  for (std::size_t i = 0; i < count; ++i, rows += 16, poses += 12) {
    Row x, y, z, w;
    load(rows, x), load(rows + 4, y), load(rows + 8, z), load(rows + 12, w);
    // Products of columns with themselves, then with the next ones.
    const Row x_next = __builtin_shufflevector(x, x, 1, 2, 0, 3);
    const Row y_next = __builtin_shufflevector(y, y, 1, 2, 0, 3);
    const Row z_next = __builtin_shufflevector(z, z, 1, 2, 0, 3);
    const Row lengths = ((x * x + y * y) + z * z) - unit;
    const Row angles = (x * x_next + y * y_next) + z * z_next;
    const Row across = __builtin_shufflevector(x, x, 2, 0, 1, 3) * (y * z_next - y_next * z);
    const Row sums = (x + y) + z;  // less itself it is NaN where one is not finite
    is_rigid &= (magnitudes(lengths) <= most) & (magnitudes(angles) <= most) & (across > least) &
                (sums - sums == Row{}) & (w == last);
    // Column after column.
    for (std::size_t k = 0; k < 4; ++k)
      for (std::size_t row = 0; row < 3; ++row) poses[3 * k + row] = rows[4 * row + k];
  }
  return all_of(is_rigid);
}

TOUCHSTONE_IN_PLACE Row roots(const Row& of) {
#ifdef __SSE2__
  const __m128d low = _mm_sqrt_pd(__m128d{of[0], of[1]}), high = _mm_sqrt_pd(__m128d{of[2], of[3]});
  return Row{low[0], low[1], high[0], high[1]};
#else
  return Row{std::sqrt(of[0]), std::sqrt(of[1]), std::sqrt(of[2]), std::sqrt(of[3])};
#endif
}

/// Writes four poses from positions and quaternions w x y z, the bits of rotation_from_quaternion(). Returns
/// false, and nothing is written, where one is not finite, or has to be scaled first.
TOUCHSTONE_IN_PLACE bool write_four(const double* p, const double* q, double* poses) {
  Row m[4];
  for (std::size_t k = 0; k < 4; ++k) load(q + 4 * k, m[k]);
  transpose(m);
  Row w = m[0], x = m[1], y = m[2], z = m[3];
  const Row squared = ((w * w + x * x) + y * y) + z * z;
  // Positions are finite, and squares are far from where they would overflow or lose digits.
  const Row px = {p[0], p[3], p[6], p[9]}, py = {p[1], p[4], p[7], p[10]}, pz = {p[2], p[5], p[8], p[11]};
  const Row zero = (px - px) + (py - py) + (pz - pz), least = {0x1p-900, 0x1p-900, 0x1p-900, 0x1p-900},
            most = {0x1p900, 0x1p900, 0x1p900, 0x1p900};
  if (!all_of((squared >= least) & (squared <= most) & (zero == zero))) return false;
  // Of unit length.
  const Row length = roots(squared);
  w /= length, x /= length, y /= length, z /= length;
  // rotation_matrix(), column by column, four entries at a time of each pose.
  Row entries[3][4] = {{((w * w + x * x) - y * y) - z * z, 2.0 * (x * y + w * z), 2.0 * (x * z - w * y),
                        2.0 * (x * y - w * z)},
                       {((w * w - x * x) + y * y) - z * z, 2.0 * (y * z + w * x), 2.0 * (x * z + w * y),
                        2.0 * (y * z - w * x)},
                       {((w * w - x * x) - y * y) + z * z, px, py, pz}};
  for (std::size_t part = 0; part < 3; ++part) {
    transpose(entries[part]);
    for (std::size_t k = 0; k < 4; ++k) store(entries[part][k], poses + 12 * k + 4 * part);
  }
  return true;
}

/// Writes poses by fours up to the first that write_four() does not take. Returns how many.
TOUCHSTONE_WIDEST std::size_t write_fours(const double* p, const double* q, std::size_t count,
                                          double* poses) {
  std::size_t i = 0;
  while (i + 4 <= count && write_four(p + 3 * i, q + 4 * i, poses + 12 * i)) i += 4;
  return i;
}

Pose checked_pose(const double* p, const double* q, std::size_t i) {
  const Vector3 position(p[0], p[1], p[2]);
  if (!is_finite(position)) reject(nth(i), "position is not finite");
  const bool is_sound = std::any_of(q, q + 4, [](double x) { return x != 0.0; }) && all_finite({q, 4});
  return {is_sound ? rotation_from_quaternion(q[0], q[1], q[2], q[3])
                   : rotation_from_quaternion(q[0], q[1], q[2], q[3], nth(i)),
          position};
}

/// Writes poses from positions and quaternions. @throws InputError: one is not finite, or no rotation.
void write_turned(const double* p, const double* q, std::span<Pose> poses) {
  for (std::size_t i = 0; i < poses.size();) {
    i += write_fours(p + 3 * i, q + 4 * i, poses.size() - i, reinterpret_cast<double*>(poses.data() + i));
    for (const std::size_t end = std::min(i + 4, poses.size()); i < end; ++i)
      poses[i] = checked_pose(p + 3 * i, q + 4 * i, i);
  }
}

}  // namespace

void Poses::convert(const py::handle& matrices_or_positions, const py::handle& quaternions,
                    std::vector<Pose>& out) {
  if (quaternions.is_none()) {
    const Doubles rows = doubles(matrices_or_positions, "poses", {-1, 4, 4}, "(n, 4, 4)");
    out.resize(static_cast<std::size_t>(rows.shape(0)));
    if (write_matrices(rows.data(), out.size(), reinterpret_cast<double*>(out.data()))) return;
    for (std::size_t i = 0; i < out.size(); ++i)
      pose_from_rows(rows.data() + 16 * i, nth(i));  // which says what is wrong
    return;
  }
  const Doubles p = doubles(matrices_or_positions, "positions", {-1, 3}, "(n, 3)");
  const Doubles q = doubles(quaternions, "quaternions", {-1, 4}, "(n, 4)");
  if (p.shape(0) != q.shape(0))
    reject("quaternions", "are " + std::to_string(q.shape(0)) + ", positions " + std::to_string(p.shape(0)));
  out.resize(static_cast<std::size_t>(p.shape(0)));
  write_turned(p.data(), q.data(), out);
}

void Poses::update(const py::handle& matrices_or_positions, const py::handle& quaternions,
                   std::size_t first) {
  std::vector<Pose>& poses = spare_;
  convert(matrices_or_positions, quaternions, poses);
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
