#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "touchstone/contact_core/geometry/constants.hpp"

// The point closest to a given one that fulfils linear inequalities, by a dual active set method (Goldfarb,
// Idnani 1983) in N dimensions, of which any number may be unused (zero throughout). Of equal rows the first
// one is taken.

namespace touchstone {

inline constexpr int kMostRows = 96;

template <int N>
struct RowProjection {
  using Row = std::array<double, N>;

  /// Rows closer than this to the span of others [rad] count as in it.
  static constexpr double kDependent = 0x1p-30;
  /// A row is fulfilled to this many times the length of the goal twist; one that contradicts those that hold
  /// by less than the second does so by their rounding, where they are nearly dependent.
  static constexpr double kFulfilled = 0x1p-50;
  static constexpr double kNearlyFulfilled = 0x1p-36;
  static constexpr int kIterations = 256;

  static double row_product(const Row& a, const Row& b) {
    double sum = a[0] * b[0];
    for (int i = 1; i < N; ++i) sum += a[i] * b[i];
    return sum;
  }

  /// g . x >= -slack, g unit.
  struct Rows {
    int count = 0;
    std::array<Row, kMostRows> g;
    std::array<double, kMostRows> slack;
    std::array<bool, kMostRows> is_left_out{};
  };

  /// The active rows' span as an orthonormal basis Q with g = Q R (Gram, Schmidt, each row twice).
  struct Span {
    int rank = 0;
    std::array<Row, N> q;
    std::array<std::array<double, N>, N> R;  ///< R[k][j], k <= j

    /// Splits g into coefficients on Q and what stands on it.
    Row split(const Row& g, std::array<double, N>& coefficient) const {
      Row rest = g;
      coefficient.fill(0.0);
      for (int pass = 0; pass < 2; ++pass) {
        for (int k = 0; k < rank; ++k) {
          const double c = row_product(q[k], rest);
          coefficient[k] += c;
          for (int i = 0; i < N; ++i) rest[i] -= c * q[k][i];
        }
      }
      return rest;
    }
    /// @param rest, coefficient as split() gave them.
    void add(const Row& rest, const std::array<double, N>& coefficient) {
      const double length = std::sqrt(row_product(rest, rest));
      for (int k = 0; k < rank; ++k) R[k][rank] = coefficient[k];
      R[rank][rank] = length;
      for (int i = 0; i < N; ++i) q[rank][i] = rest[i] / length;
      ++rank;
    }
    void add(const Row& g) {
      std::array<double, N> coefficient;
      const Row rest = split(g, coefficient);
      add(rest, coefficient);
    }
    /// R^T y = left: the coefficients on Q of the step that changes what the rows have left by so much.
    std::array<double, N> solve_transposed(const std::array<double, N>& left) const {
      std::array<double, N> y{};
      for (int j = 0; j < rank; ++j) {
        double rest = left[j];
        for (int k = 0; k < j; ++k) rest -= R[k][j] * y[k];
        y[j] = rest / R[j][j];
      }
      return y;
    }
    /// R y = coefficient.
    std::array<double, N> solve(const std::array<double, N>& coefficient) const {
      std::array<double, N> y{};
      for (int j = rank - 1; j >= 0; --j) {
        double rest = coefficient[j];
        for (int k = j + 1; k < rank; ++k) rest -= R[j][k] * y[k];
        y[j] = rest / R[j][j];
      }
      return y;
    }
  };

  struct State {
    Row x{};
    int count = 0;
    std::array<int, N> active{};  ///< rows that hold
    std::array<double, N> multiplier{};
    Span span;  ///< of these, in their order
    int steps = 0;

    void take(int row, double force, const Row& rest, const std::array<double, N>& coefficient) {
      active[count] = row;
      multiplier[count++] = force;
      span.add(rest, coefficient);
    }
    void drop(int k, const Rows& rows) {
      for (int i = k; i + 1 < count; ++i) {
        active[i] = active[i + 1];
        multiplier[i] = multiplier[i + 1];
      }
      --count;
      // The span of the rows before it stays as it is.
      span.rank = k;
      for (int i = k; i < count; ++i) span.add(rows.g[active[i]]);
    }
  };

  /// Takes the rounding of many steps out: what active rows have left becomes 0 again.
  static void settle(const Rows& rows, State& s) {
    std::array<double, N> left{};
    for (int k = 0; k < s.count; ++k)
      left[k] = row_product(rows.g[s.active[k]], s.x) + rows.slack[s.active[k]];
    const auto step = s.span.solve_transposed(left);
    for (int k = 0; k < s.count; ++k)
      for (int i = 0; i < N; ++i) s.x[i] -= step[k] * s.span.q[k][i];
  }

  static int most_violated(const Rows& rows, const Row& x, double tolerance) {
    int worst = -1;
    double least = -tolerance;
    for (int i = 0; i < rows.count; ++i) {
      if (rows.is_left_out[i]) continue;
      const double left = row_product(rows.g[i], x) + rows.slack[i];
      if (left < least) least = left, worst = i;
    }
    return worst;
  }

  /// Makes row p hold, dropping active rows that it replaces. False: it contradicts them.
  static bool take_in(const Rows& rows, int p, State& s, int& iterations) {
    double taken = 0.0;
    for (; iterations < kIterations; ++iterations) {
      // The direction that leaves the active rows as they are, and what that costs each.
      ++s.steps;
      std::array<double, N> coefficient;
      const Row z = s.span.split(rows.g[p], coefficient);
      const auto r = s.span.solve(coefficient);
      const double square = row_product(z, z);
      const double lacking = -(row_product(rows.g[p], s.x) + rows.slack[p]);
      // As far as no multiplier falls below 0, and no further than row p needs.
      double longest = kInfinity;
      int blocking = -1;
      for (int k = 0; k < s.count; ++k)
        if (r[k] > 0.0 && s.multiplier[k] / r[k] < longest) longest = s.multiplier[k] / r[k], blocking = k;
      const bool free = s.count < N && square > kDependent * kDependent;
      const double whole = free ? std::max(lacking, 0.0) / square : kInfinity;
      const double step = std::min(longest, whole);
      if (!(step < kInfinity)) return false;
      // The step; then p is active, or the row that blocked it no longer is.
      if (free)
        for (int i = 0; i < N; ++i) s.x[i] += step * z[i];
      for (int k = 0; k < s.count; ++k) s.multiplier[k] = std::max(s.multiplier[k] - step * r[k], 0.0);
      taken += step;
      if (whole <= longest) {
        s.take(p, taken, z, coefficient);
        settle(rows, s);
        return true;
      }
      s.drop(blocking, rows);
    }
    return false;
  }

  /// The sets of rows that were active, one after the other. Each moves the point further from the goal, so
  /// that a set can come again only by rounding; then it would do so without end.
  class ActiveSets {
   public:
    /// @returns false: it was noted before.
    bool note(const State& s) {
      Set set{};
      for (int k = 0; k < s.count; ++k) set[s.active[k] / 64] |= std::uint64_t{1} << (s.active[k] % 64);
      for (int i = 0; i < count_; ++i)
        if (sets_[i] == set) return false;
      sets_[count_++] = set;
      return true;
    }

    void forget() { count_ = 0; }

   private:
    using Set = std::array<std::uint64_t, (kMostRows + 63) / 64>;

    int count_ = 0;
    std::array<Set, kIterations> sets_;
  };

  /// Moves s.x, the given point, to the closest one. False where no point fulfils the rows (to rounding), or
  /// none was found.
  static bool find(Rows& rows, State& s) {
    const double length = std::sqrt(row_product(s.x, s.x));
    ActiveSets sets;
    for (int iterations = 0; iterations < kIterations; ++iterations) {
      const int p = most_violated(rows, s.x, kFulfilled * length);
      if (p < 0) return are_nearly_fulfilled(rows, s.x, length);
      const double lacking = row_product(rows.g[p], s.x) + rows.slack[p];
      const bool is_taken = take_in(rows, p, s, iterations);
      if (is_taken && sets.note(s)) continue;
      const double left = is_taken ? lacking : row_product(rows.g[p], s.x) + rows.slack[p];
      if (left < -kNearlyFulfilled * length) return false;
      rows.is_left_out[p] = true;
      // A row that was left out may have moved the point for others, so sets may come again.
      if (!is_taken) sets.forget();
    }
    return false;
  }

  /// Whether x fulfils the rows that were left out: later rows may have moved the point away from them.
  static bool are_nearly_fulfilled(const Rows& rows, const Row& x, double length) {
    for (int i = 0; i < rows.count; ++i)
      if (rows.is_left_out[i] && row_product(rows.g[i], x) + rows.slack[i] < -kNearlyFulfilled * length)
        return false;
    return true;
  }
};

}  // namespace touchstone
