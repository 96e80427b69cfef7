#include "contact_core/motion/slide.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace touchstone {
namespace {

using Row6 = std::array<double, kTwistSize>;

/// Rows closer than this to the span of others [rad] count as in it.
constexpr double kDependent = 0x1p-30;
/// A row is fulfilled to so many times the length of the goal twist; one that contradicts those that hold by
/// less than the second does so by their rounding, where they are nearly dependent.
constexpr double kFulfilled = 0x1p-50;
constexpr double kNearlyFulfilled = 0x1p-36;
constexpr int kIterations = 256;
/// Longer turns are taken in several sub-steps [rad].
constexpr double kLongestTurn = 0.25;
constexpr int kLiftRounds = 4;
constexpr int kHalvings = 3;

double dot6(const Row6& a, const Row6& b) {
  double sum = a[0] * b[0];
  for (int i = 1; i < kTwistSize; ++i) sum += a[i] * b[i];
  return sum;
}

/// J = L L^T, lower. What is not positive by rounding (a needle's own axis) is taken as its trace's share.
Matrix3 cholesky(const Matrix3& J) {
  const double least = 0x1p-60 * ((J(0, 0) + J(1, 1)) + J(2, 2));
  Matrix3 L = Matrix3::Zero();
  for (int j = 0; j < 3; ++j) {
    for (int i = j; i < 3; ++i) {
      double rest = J(i, j);
      for (int k = 0; k < j; ++k) rest -= L(i, k) * L(j, k);
      L(i, j) = i == j ? std::sqrt(std::max(rest, least)) : rest / L(j, j);
    }
  }
  return L;
}

/// Twists as (v, L^T w): there the metric is Euclid's.
class Scaling {
 public:
  explicit Scaling(const Matrix3& J_W) : L_(cholesky(J_W)) {}

  Row6 to_scaled(const Twist& u) const {
    Row6 x{u.v.x(), u.v.y(), u.v.z(), 0.0, 0.0, 0.0};
    for (int i = 0; i < 3; ++i)
      for (int k = i; k < 3; ++k) x[3 + i] += L_(k, i) * u.w[k];
    return x;
  }
  Twist from_scaled(const Row6& x) const {
    Twist u;
    u.v = {x[0], x[1], x[2]};
    for (int i = 2; i >= 0; --i) {
      double rest = x[3 + i];
      for (int k = i + 1; k < 3; ++k) rest -= L_(k, i) * u.w[k];
      u.w[i] = rest / L_(i, i);
    }
    return u;
  }
  /// Of a moment: L^-1 m.
  Row6 row(const Vector3& n, const Vector3& moment) const {
    Row6 g{n.x(), n.y(), n.z(), 0.0, 0.0, 0.0};
    for (int i = 0; i < 3; ++i) {
      double rest = moment[i];
      for (int k = 0; k < i; ++k) rest -= L_(i, k) * g[3 + k];
      g[3 + i] = rest / L_(i, i);
    }
    return g;
  }

 private:
  Matrix3 L_;
};

/// g . x >= -slack, g unit.
struct Rows {
  int count = 0;
  std::array<Row6, kMostSlideRows> g;
  std::array<double, kMostSlideRows> slack;
  std::array<bool, kMostSlideRows> is_left_out{};
};

/// The active rows' span as an orthonormal basis Q with g = Q R (Gram, Schmidt, each row twice).
struct Span {
  int rank = 0;
  std::array<Row6, kTwistSize> q;
  std::array<std::array<double, kTwistSize>, kTwistSize> R;  ///< R[k][j], k <= j

  /// Splits g into coefficients on Q and what stands on it.
  Row6 split(const Row6& g, std::array<double, kTwistSize>& coefficient) const {
    Row6 rest = g;
    coefficient.fill(0.0);
    for (int pass = 0; pass < 2; ++pass) {
      for (int k = 0; k < rank; ++k) {
        const double c = dot6(q[k], rest);
        coefficient[k] += c;
        for (int i = 0; i < kTwistSize; ++i) rest[i] -= c * q[k][i];
      }
    }
    return rest;
  }
  void add(const Row6& g) {
    std::array<double, kTwistSize> coefficient{};
    const Row6 rest = split(g, coefficient);
    const double length = std::sqrt(dot6(rest, rest));
    for (int k = 0; k < rank; ++k) R[k][rank] = coefficient[k];
    R[rank][rank] = length;
    for (int i = 0; i < kTwistSize; ++i) q[rank][i] = rest[i] / length;
    ++rank;
  }
  /// R^T y = left: the coefficients on Q of the step that changes what the rows have left by so much.
  std::array<double, kTwistSize> solve_transposed(const std::array<double, kTwistSize>& left) const {
    std::array<double, kTwistSize> y{};
    for (int j = 0; j < rank; ++j) {
      double rest = left[j];
      for (int k = 0; k < j; ++k) rest -= R[k][j] * y[k];
      y[j] = rest / R[j][j];
    }
    return y;
  }
  /// R y = coefficient.
  std::array<double, kTwistSize> solve(const std::array<double, kTwistSize>& coefficient) const {
    std::array<double, kTwistSize> y{};
    for (int j = rank - 1; j >= 0; --j) {
      double rest = coefficient[j];
      for (int k = j + 1; k < rank; ++k) rest -= R[j][k] * y[k];
      y[j] = rest / R[j][j];
    }
    return y;
  }
};

struct DualState {
  Row6 x{};
  ActiveRows active;
  std::array<double, kTwistSize> multiplier{};

  void drop(int k) {
    for (int i = k; i + 1 < active.count; ++i) {
      active.row[i] = active.row[i + 1];
      multiplier[i] = multiplier[i + 1];
    }
    --active.count;
  }
};

/// Takes the rounding of many steps out: what active rows have left becomes 0 again.
void settle(const Rows& rows, DualState& s) {
  Span span;
  std::array<double, kTwistSize> left{};
  for (int k = 0; k < s.active.count; ++k) {
    const Row6& g = rows.g[s.active.row[k]];
    span.add(g);
    left[k] = dot6(g, s.x) + rows.slack[s.active.row[k]];
  }
  const auto step = span.solve_transposed(left);
  for (int k = 0; k < span.rank; ++k)
    for (int i = 0; i < kTwistSize; ++i) s.x[i] -= step[k] * span.q[k][i];
}

int most_violated(const Rows& rows, const Row6& x, double tolerance) {
  int worst = -1;
  double least = -tolerance;
  for (int i = 0; i < rows.count; ++i) {
    if (rows.is_left_out[i]) continue;
    const double left = dot6(rows.g[i], x) + rows.slack[i];
    if (left < least) least = left, worst = i;
  }
  return worst;
}

/// Makes row p hold, dropping active rows that it replaces. False: it contradicts them.
bool take_in(const Rows& rows, int p, DualState& s, int& iterations) {
  double own = 0.0;
  for (; iterations < kIterations; ++iterations) {
    Span span;
    for (int k = 0; k < s.active.count; ++k) span.add(rows.g[s.active.row[k]]);
    std::array<double, kTwistSize> coefficient{};
    const Row6 z = span.split(rows.g[p], coefficient);
    const auto r = span.solve(coefficient);
    const double square = dot6(z, z);
    const double lacking = -(dot6(rows.g[p], s.x) + rows.slack[p]);
    double longest = std::numeric_limits<double>::infinity();
    int blocking = -1;
    for (int k = 0; k < s.active.count; ++k)
      if (r[k] > 0.0 && s.multiplier[k] / r[k] < longest) longest = s.multiplier[k] / r[k], blocking = k;
    const bool free = s.active.count < kTwistSize && square > kDependent * kDependent;
    const double whole = free ? std::max(lacking, 0.0) / square : std::numeric_limits<double>::infinity();
    const double step = std::min(longest, whole);
    if (!(step < std::numeric_limits<double>::infinity())) return false;
    if (free)
      for (int i = 0; i < kTwistSize; ++i) s.x[i] += step * z[i];
    for (int k = 0; k < s.active.count; ++k) s.multiplier[k] = std::max(s.multiplier[k] - step * r[k], 0.0);
    own += step;
    if (whole <= longest) {
      s.active.row[s.active.count] = p;
      s.multiplier[s.active.count++] = own;
      settle(rows, s);
      return true;
    }
    s.drop(blocking);
  }
  return false;
}

bool closest_point(Rows& rows, DualState& s) {
  const double length = std::sqrt(dot6(s.x, s.x));
  for (int iterations = 0; iterations < kIterations; ++iterations) {
    const int p = most_violated(rows, s.x, kFulfilled * length);
    if (p < 0) return true;
    if (take_in(rows, p, s, iterations)) continue;
    if (dot6(rows.g[p], s.x) + rows.slack[p] < -kNearlyFulfilled * length) return false;
    rows.is_left_out[p] = true;
  }
  return false;
}

using Lifts = std::array<double, kMostSlideRows>;

/// How far the rows have to be raised for a twist's path to stay above; false where `lift` already does.
bool raise(std::span<const SlideRow> rows, const Twist& twist, Lifts& lift) {
  bool raised = false;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double needed = 0.5 * bend_of(rows[i], twist) - rows[i].room;
    if (needed <= lift[i]) continue;
    lift[i] = needed;
    raised = true;
  }
  return raised;
}

/// False where the rows cannot be raised so far.
bool project_lifted(const Twist& goal, const Matrix3& J_W, std::span<const SlideRow> rows,
                    bool translation_only, SlidePlan& plan) {
  Lifts lift{};
  const std::span<const double> lifts = std::span(lift).first(rows.size());
  for (int round = 0; round < kLiftRounds; ++round) {
    if (!project(goal, J_W, rows, lifts, translation_only, plan.twist, plan.active)) return false;
    if (!raise(rows, plan.twist, lift)) return true;
  }
  return true;
}

/// As far as the distance to the goal shrinks.
Twist shortened(const Twist& goal, const Matrix3& J_W, const Twist& u) {
  const double forward = inner_product(J_W, u, goal), square = inner_product(J_W, u, u);
  if (!(forward > 0.0) || !(square > 0.0)) return {};
  return forward < square ? (forward / square) * u : u;
}

}  // namespace

bool operator<(const SlideRow& a, const SlideRow& b) {
  if (a.slack != b.slack) return a.slack < b.slack;
  for (int i = 0; i < 3; ++i)
    if (a.n[i] != b.n[i]) return a.n[i] < b.n[i];
  for (int i = 0; i < 3; ++i)
    if (a.r[i] != b.r[i]) return a.r[i] < b.r[i];
  return a.turns < b.turns;
}

double bend_of(const SlideRow& row, const Twist& twist) {
  const double tilt = norm(cross(twist.w, row.n));
  const double around = norm(cross(twist.w, row.r));
  if (!row.turns) return tilt * around;
  return tilt * (around + norm(cross(twist.w, twist.v))) + 2.0 * tilt * norm(twist.v);
}

bool project(const Twist& goal, const Matrix3& J_W, std::span<const SlideRow> rows,
             std::span<const double> lift, bool translation_only, Twist& out, ActiveRows& active) {
  const Scaling scaling(J_W);
  const Twist wanted{goal.v, translation_only ? Vector3(Vector3::Zero()) : goal.w};
  Rows scaled;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Vector3 moment = translation_only ? Vector3(Vector3::Zero()) : cross(rows[i].r, rows[i].n);
    Row6 g = scaling.row(rows[i].n, moment);
    const double length = std::sqrt(dot6(g, g));
    for (double& component : g) component /= length;
    scaled.g[scaled.count] = g;
    scaled.slack[scaled.count++] = (rows[i].slack - lift[i]) / length;
  }
  DualState state;
  state.x = scaling.to_scaled(wanted);
  const bool found = closest_point(scaled, state);
  active = state.active;
  out = found ? scaling.from_scaled(state.x) : Twist{};
  return found;
}

SlidePlan plan_slide(const Twist& goal, const Matrix3& J_W, std::span<const SlideRow> rows,
                     bool translation_only) {
  const double turn = translation_only ? 0.0 : norm(goal.w);
  const Twist wanted = turn > kLongestTurn ? (kLongestTurn / turn) * goal : goal;
  SlidePlan plan;
  // Where the bends of a long motion cannot be cleared, those of one half as long are a quarter.
  double part = 1.0;
  for (int i = 0; i <= kHalvings; ++i, part *= 0.5) {
    if (!project_lifted(part * wanted, J_W, rows, translation_only, plan)) continue;
    plan.twist = shortened(part * wanted, J_W, plan.twist);
    if (inner_product(J_W, plan.twist, plan.twist) > 0.0) return plan;
  }
  // Nothing but to keep contact to first order, as far as that goes.
  std::array<SlideRow, kMostSlideRows> kept;
  std::copy(rows.begin(), rows.end(), kept.begin());
  for (SlideRow& row : kept) row.slack = std::max(row.slack, 0.0);
  const Lifts none{};
  const std::span<const SlideRow> kept_rows = std::span(kept).first(rows.size());
  if (!project(wanted, J_W, kept_rows, std::span(none).first(rows.size()), translation_only, plan.twist,
               plan.active))
    return {};
  plan.twist = shortened(wanted, J_W, plan.twist);
  return plan;
}

}  // namespace touchstone
