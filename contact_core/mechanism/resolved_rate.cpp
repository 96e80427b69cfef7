#include "touchstone/contact_core/mechanism/resolved_rate.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

constexpr int kRows = 6;
using Column = std::array<double, kRows>;
using Square = std::array<Column, kRows>;  // [row][column], lower triangle

Column weighed(const Twist& twist, double length) {
  return {twist.v.x(),          twist.v.y(),          twist.v.z(),
          length * twist.w.x(), length * twist.w.y(), length * twist.w.z()};
}

/// M += c c^T.
void add_square(const Column& c, Square& M) {
  for (int row = 0; row < kRows; ++row)
    for (int k = 0; k <= row; ++k) M[row][k] += c[row] * c[k];
}

/// M = L L^T, of the first `size` rows. False where M is singular to rounding: a pivot below 2^-40 of the
/// largest diagonal entry.
bool factorise(const Square& M, Square& L, int size = kRows) {
  double largest = 0.0;
  for (int i = 0; i < size; ++i) largest = std::max(largest, M[i][i]);
  const double least = 0x1p-40 * largest;
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = M[i][j];
      for (int k = 0; k < j; ++k) sum -= L[i][k] * L[j][k];
      if (i == j) {
        if (!(sum > least)) return false;
        L[i][i] = std::sqrt(sum);
      } else {
        L[i][j] = sum / L[j][j];
      }
    }
  }
  return true;
}

/// trace((L L^T)^-1): the sum of the squares of L^-1.
double trace_of_inverse(const Square& L, int size = kRows) {
  double trace = 0.0;
  for (int column = 0; column < size; ++column) {
    Column x{};
    for (int i = column; i < size; ++i) {
      double sum = i == column ? 1.0 : 0.0;
      for (int k = column; k < i; ++k) sum -= L[i][k] * x[k];
      x[i] = sum / L[i][i];
      trace += x[i] * x[i];
    }
  }
  return trace;
}

void solve_factored(const Square& L, Column& b) {
  for (int i = 0; i < kRows; ++i) {
    for (int k = 0; k < i; ++k) b[i] -= L[i][k] * b[k];
    b[i] /= L[i][i];
  }
  for (int i = kRows - 1; i >= 0; --i) {
    for (int k = i + 1; k < kRows; ++k) b[i] -= L[k][i] * b[k];
    b[i] /= L[i][i];
  }
}

}  // namespace

ResolvedRate::ResolvedRate(const Mechanism& mechanism, std::uint32_t link,
                           const ResolvedRateSettings& settings, std::span<const std::uint32_t> held_values)
    : mechanism_(&mechanism), link_(link), settings_(settings) {
  const std::string who = "mechanism '" + mechanism.name() + "': resolved rates: ";
  if (!std::isfinite(settings.length) || !(settings.length > 0.0))
    throw InputError(who + "the length that weighs turns is not above 0");
  if (!std::isfinite(settings.damping) || !(settings.damping > 0.0))
    throw InputError(who + "the damping is not above 0");
  if (!std::isfinite(settings.damped_below) || !(settings.damped_below >= 0.0))
    throw InputError(who + "the singular value where damping sets in is not 0 or more");
  columns_.resize(mechanism.value_count());
  joint_of_.assign(mechanism.value_count(), Mechanism::kNone);
  bool moves = false;
  for (const std::uint32_t j : mechanism.chain(link)) {
    const std::uint32_t value = mechanism.joints()[j].value;
    if (value == Mechanism::kNone) continue;
    if (std::find(held_values.begin(), held_values.end(), value) != held_values.end()) continue;
    joint_of_[value] = j;
    moves = true;
  }
  if (!moves) throw InputError(who + "no joint moves link '" + mechanism.links()[link].name + "'");
}

Twist ResolvedRate::column(std::span<const Pose> X_WL, const Vector3& p_W,
                           std::uint32_t value) const noexcept {
  if (joint_of_[value] == Mechanism::kNone) return {};
  const Mechanism::Joint& joint = mechanism_->joints()[joint_of_[value]];
  const Pose& X_WP = X_WL[joint.inner];
  const Vector3 axis_W = rotate(X_WP.R, joint.axis_P);
  if (joint.kind == JointKind::prismatic) return {axis_W, Vector3::Zero()};
  return {cross(axis_W, p_W - transform(X_WP, joint.X_PJ.p)), axis_W};
}

double ResolvedRate::regularity(std::span<const Pose> X_WL, const Vector3& p_W) const noexcept {
  // J J^T and J^T J have the same singular values but for zeros; the smaller one is taken.
  Square M{}, L{};
  std::array<Column, kRows> kept{};
  std::size_t moving = 0;
  for (std::uint32_t j = 0; j < columns_.size(); ++j) {
    if (joint_of_[j] == Mechanism::kNone) continue;
    const Column c = weighed(column(X_WL, p_W, j), settings_.length);
    if (moving < kRows) kept[moving] = c;
    ++moving;
    add_square(c, M);
  }
  if (moving < kRows) {
    M = {};
    for (std::size_t i = 0; i < moving; ++i)
      for (std::size_t k = 0; k <= i; ++k)
        for (int row = 0; row < kRows; ++row) M[i][k] += kept[i][row] * kept[k][row];
  }
  const int size = static_cast<int>(std::min<std::size_t>(moving, kRows));
  return factorise(M, L, size) ? 1.0 / std::sqrt(trace_of_inverse(L, size)) : 0.0;
}

ResolvedRate::Outcome ResolvedRate::solve(std::span<const Pose> X_WL, const Vector3& p_W, const Twist& wanted,
                                          std::span<double> rates) noexcept {
  // M is the sum of the products of weighed columns.
  Square M{}, L{};
  for (std::uint32_t j = 0; j < columns_.size(); ++j) {
    columns_[j] = column(X_WL, p_W, j);
    add_square(weighed(columns_[j], settings_.length), M);
  }
  // Near a singularity M is damped, the more the nearer it is.
  Outcome outcome;
  const bool regular = factorise(M, L);
  const double s = regular ? 1.0 / std::sqrt(trace_of_inverse(L)) : 0.0;
  if (!regular || s < settings_.damped_below) {
    const double share = s / std::max(settings_.damped_below, s + 0x1p-1000);
    const double square = settings_.damping * settings_.damping * (1.0 - share * share);
    outcome.lambda = std::sqrt(square);
    for (int row = 0; row < kRows; ++row) M[row][row] += square;
    // Damping far below what rounding leaves of M cannot make it regular: then nothing moves.
    if (!factorise(M, L)) {
      std::fill(rates.begin(), rates.end(), 0.0);
      outcome.error = -1.0 * wanted;
      return outcome;
    }
  }
  // The rates follow from the solution; the joint furthest beyond its limit sets the scale.
  Column b = weighed(wanted, settings_.length);
  solve_factored(L, b);
  for (std::uint32_t j = 0; j < columns_.size(); ++j) {
    const Column c = weighed(columns_[j], settings_.length);
    double rate = 0.0;
    for (int row = 0; row < kRows; ++row) rate += c[row] * b[row];
    rates[j] = rate;
    if (joint_of_[j] == Mechanism::kNone) continue;
    const double limit = mechanism_->joints()[joint_of_[j]].rate;
    if (std::abs(rate) * outcome.scale > limit) outcome.scale = limit / std::abs(rate);
  }
  // The error is the twist of the scaled rates less the wanted one.
  outcome.error = -1.0 * wanted;
  for (std::uint32_t j = 0; j < columns_.size(); ++j) {
    rates[j] *= outcome.scale;
    outcome.error.v += rates[j] * columns_[j].v;
    outcome.error.w += rates[j] * columns_[j].w;
  }
  return outcome;
}

}  // namespace touchstone
