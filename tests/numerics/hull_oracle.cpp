#include "touchstone/tests/numerics/hull_oracle.hpp"

#include <gmpxx.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <stdexcept>

namespace touchstone::numerics {
namespace {

constexpr int kRows = 5;                       // x, y, z, sum over A, sum over B
constexpr int kPoints = 16;                    // unknowns: the vertices' weights
constexpr int kColumns = kPoints + kRows + 1;  // and the rows' artificial variables, and the right-hand side
constexpr int kRight = kPoints + kRows;
constexpr int kCost = kRows;  // the row of reduced costs

using Matrix = std::array<std::array<mpz_class, kColumns>, kRows + 1>;

int lowest_bit_exponent(double value) {
  int exponent = 0;
  const double fraction = std::frexp(value, &exponent);
  const mpz_class mantissa(std::ldexp(fraction, 53));
  return exponent - 53 + static_cast<int>(mpz_scan1(mantissa.get_mpz_t(), 0));
}

int common_exponent(std::span<const Vector3> points) {
  int lowest = 2000;
  for (const Vector3& p : points)
    for (int axis = 0; axis < 3; ++axis)
      if (p(axis) != 0.0) lowest = std::min(lowest, lowest_bit_exponent(p(axis)));
  return lowest;
}

mpz_class integer_of(double value, int unit_exponent) {
  if (value == 0.0) return 0;
  int exponent = 0;
  mpz_class out(std::ldexp(std::frexp(value, &exponent), 53));
  const int shift = exponent - 53 - unit_exponent;
  if (shift >= 0) return out << static_cast<mp_bitcnt_t>(shift);
  return out >> static_cast<mp_bitcnt_t>(-shift);
}

/// Minimises the sum of the artificial variables over sum_i A_i p_i - sum_j B_j q_j = 0, sum A_i = 1, sum B_j
/// = 1.
Matrix make_tableau(std::span<const Vector3> points) {
  Matrix t;
  const int unit_exponent = common_exponent(points);
  for (int column = 0; column < kPoints; ++column) {
    const bool in_a = column < 8;
    for (int axis = 0; axis < 3; ++axis)
      t[axis][column] = (in_a ? 1 : -1) * integer_of(points[column](axis), unit_exponent);
    t[in_a ? 3 : 4][column] = 1;
  }
  for (int row = 0; row < kRows; ++row) t[row][kPoints + row] = 1;
  t[3][kRight] = t[4][kRight] = 1;
  for (int column = 0; column < kColumns; ++column) {
    if (column >= kPoints && column != kRight) continue;
    for (int row = 0; row < kRows; ++row) t[kCost][column] -= t[row][column];
  }
  return t;
}

struct Optimum {
  Matrix tableau;  // times `denominator`
  mpz_class denominator;
  std::array<int, kRows> basis;  // column of each row's variable
};

/// Edmonds' integer pivoting: all divisions are exact. Bland's rule: terminates.
Optimum solve(const Matrix& start) {
  Optimum s{start, 1, {kPoints, kPoints + 1, kPoints + 2, kPoints + 3, kPoints + 4}};
  Matrix& t = s.tableau;
  // The first column that lowers the cost enters (Bland's rule: no cycles).
  for (;;) {
    const auto& cost = t[kCost];
    const int entering = static_cast<int>(
        std::find_if(cost.begin(), cost.begin() + kPoints, [](const mpz_class& c) { return c < 0; }) -
        cost.begin());
    if (entering == kPoints) return s;
    // The row that reaches its bound first leaves.
    int leaving = -1;
    for (int row = 0; row < kRows; ++row) {
      if (t[row][entering] <= 0) continue;
      if (leaving < 0) {
        leaving = row;
        continue;
      }
      const mpz_class lead = t[row][kRight] * t[leaving][entering] - t[leaving][kRight] * t[row][entering];
      if (lead < 0 || (lead == 0 && s.basis[row] < s.basis[leaving])) leaving = row;
    }
    if (leaving < 0) throw std::logic_error("unbounded, though the weights are bounded");
    // Every row in integers: the division is exact.
    const mpz_class pivot = t[leaving][entering];
    for (int row = 0; row <= kRows; ++row) {
      if (row == leaving) continue;
      const mpz_class factor = t[row][entering];
      for (int column = 0; column < kColumns; ++column) {
        mpz_class value = t[row][column] * pivot - factor * t[leaving][column];
        mpz_divexact(t[row][column].get_mpz_t(), value.get_mpz_t(), s.denominator.get_mpz_t());
      }
    }
    s.denominator = pivot;
    s.basis[leaving] = entering;
  }
}

void prove_common_point(const Matrix& start, const Optimum& s) {
  std::array<mpz_class, kPoints> weight;
  for (int row = 0; row < kRows; ++row)
    if (s.basis[row] < kPoints) weight[s.basis[row]] = s.tableau[row][kRight];
  if (s.denominator <= 0) throw std::logic_error("denominator not positive");
  for (const mpz_class& w : weight)
    if (w < 0) throw std::logic_error("negative weight");
  for (int row = 0; row < kRows; ++row) {
    mpz_class sum = 0;
    for (int column = 0; column < kPoints; ++column) sum += start[row][column] * weight[column];
    if (sum != start[row][kRight] * s.denominator) throw std::logic_error("not a common point");
  }
}

/// The optimal dual variables y: n . p_A + y3 <= 0 for all of A, -n . p_B + y4 <= 0 for all of B, y3 + y4 >
/// 0.
void prove_separating_plane(const Matrix& start, const Optimum& s) {
  std::array<mpz_class, kRows> y;
  for (int row = 0; row < kRows; ++row) y[row] = s.denominator - s.tableau[kCost][kPoints + row];
  for (int column = 0; column < kPoints; ++column) {
    mpz_class sum = 0;
    for (int row = 0; row < kRows; ++row) sum += y[row] * start[row][column];
    if (sum > 0) throw std::logic_error("vertex on the wrong side");
  }
  if (y[3] + y[4] <= 0) throw std::logic_error("plane does not separate");
}

}  // namespace

bool hulls_intersect_by_linear_program(const WorldVertices& a, const WorldVertices& b) {
  std::array<Vector3, kPoints> points;
  for (int i = 0; i < 8; ++i) points[i] = a.vertex(i), points[8 + i] = b.vertex(i);
  const Matrix start = make_tableau(points);
  const Optimum optimum = solve(start);
  const bool feasible = optimum.tableau[kCost][kRight] == 0;
  if (feasible)
    prove_common_point(start, optimum);
  else
    prove_separating_plane(start, optimum);
  return feasible;
}

int orient3d_sign_in_integers(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  const std::array points = {a, b, c, d};
  const int unit_exponent = common_exponent(points);
  std::array<std::array<mpz_class, 3>, 3> m;
  for (int row = 0; row < 3; ++row)
    for (int axis = 0; axis < 3; ++axis)
      m[row][axis] = integer_of(points[row + 1](axis), unit_exponent) - integer_of(a(axis), unit_exponent);
  const mpz_class det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                        m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                        m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  return sgn(det);
}

}  // namespace touchstone::numerics
