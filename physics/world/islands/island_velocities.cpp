#include "touchstone/physics/world/islands/island_velocities.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/physics/solver/contact_laws.hpp"
#include "touchstone/physics/solver/reserved.hpp"

namespace touchstone::physics::stepping {
namespace {

// The last step's forces hold what rests as long as its points move less than the tolerance. But forces that
// are off by their rounding move it faster from step to step; so beyond this share of the velocities that the
// impulses could make (the sum of sqrt(w) |x|, a little above rounding) it is not still.
constexpr double kStill = 0x1p-52;

/// Velocities that the island's impulses add to its units: RowUnit::change_v_W and change_w_W, or change.
void spread_impulses(const Islands& islands, const Island& island, ContactRows& rows) {
  const std::span<const std::uint32_t> units = islands.units_of(island);
  // The changes start at zero.
  for (const std::uint32_t member : units) {
    RowUnit& unit = rows.units[member];
    if (unit.is_body()) {
      unit.change_v_W = unit.change_w_W = Vector3::Zero();
    } else {
      std::fill(unit.change.begin(), unit.change.end(), 0.0);
    }
  }
  const auto add = [&](std::span<double> change, std::size_t first, double x) {
    for (std::size_t k = 0; k < change.size(); ++k) change[k] += rows.Y[first + k] * x;
  };
  for (const std::size_t block : islands.blocks_of(island)) {
    // A joint row acts on one or two units.
    if (block >= rows.contacts.size()) {
      const ContactRows::Joint& joint = rows.joints[block - rows.contacts.size()];
      const double x = rows.x[rows.first_row(block)];
      for (int part = 0; part < joint.count; ++part) {
        RowUnit& unit = rows.units[joint.units[part]];
        const std::size_t first = joint.first[part];
        if (unit.is_body())
          unit.change_v_W += x * rows.vector_at(first), unit.change_w_W += x * rows.vector_at(first + 3);
        else
          add(unit.change, first, x);
      }
      continue;
    }
    // A contact acts on both of its sides.
    const Vector3 impulse = rows.impulse_of(block);
    for (const ContactRows::Side& side : rows.contacts[block].sides) {
      if (side.unit == kNoUnit) continue;
      RowUnit& unit = rows.units[side.unit];
      if (unit.is_body()) {
        unit.change_v_W += side.sign * impulse;
        unit.change_w_W += cross(side.lever_W, side.sign * impulse);
        continue;
      }
      for (std::size_t r = 0; r < 3; ++r)
        add(unit.change, side.first + r * unit.change.size(), rows.x[3 * block + r]);
    }
  }
  // The bodies' impulses are divided by their inertias.
  for (const std::uint32_t member : units) {
    RowUnit& unit = rows.units[member];
    if (!unit.is_body()) continue;
    unit.change_v_W = unit.change_v_W / unit.mass;
    unit.change_w_W = rotate(unit.inverse_inertia_W, unit.change_w_W);
  }
}

/// Of a contact's block of W.
double trace_of(const ContactRows::Contact& contact, const ContactRows& rows) {
  double trace = 0.0;
  for (const ContactRows::Side& side : contact.sides) {
    if (side.unit == kNoUnit) continue;
    const RowUnit& unit = rows.units[side.unit];
    if (unit.is_body()) {
      const Matrix3& I = unit.inverse_inertia_W;
      trace += 3.0 / unit.mass + (((I(0, 0) + I(1, 1)) + I(2, 2)) * dot(side.lever_W, side.lever_W) -
                                  dot(side.lever_W, rotate(I, side.lever_W)));
      continue;
    }
    const std::size_t entries = 3 * unit.width();
    for (std::size_t k = side.first; k < side.first + entries; ++k) trace += rows.J[k] * rows.Y[k];
  }
  return trace;
}

/// Velocities of a contact after spread_impulses(). Returns its natural residual or more: the trace
/// of its block stands for the largest diagonal entry, and the residual grows with the scale (Gafni and
/// Bertsekas, Two-Metric Projection Methods, 1984, lemma 1).
double contact_velocities(std::size_t block, double trace, ContactRows& rows, double& scale) {
  const ContactRows::Contact& contact = rows.contacts[block];
  Vector3 v = Vector3::Zero();
  double* const u = &rows.u[3 * block];
  for (int i = 0; i < 3; ++i) u[i] = rows.b[3 * block + static_cast<std::size_t>(i)];
  // Each side adds its velocity.
  for (const ContactRows::Side& side : contact.sides) {
    if (side.unit == kNoUnit) continue;
    const RowUnit& unit = rows.units[side.unit];
    if (unit.is_body()) {
      v += side.sign * (unit.change_v_W + cross(unit.change_w_W, side.lever_W));
      continue;
    }
    const std::span<const double> change = unit.change;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t k = 0; k < change.size(); ++k)
        u[r] += rows.J[side.first + r * change.size() + k] * change[k];
  }
  // The bodies' velocity is resolved along the normal and the tangents.
  u[0] += dot(contact.n_W, v);
  u[1] += dot(contact.t1_W, v);
  u[2] += dot(contact.t2_W, v);
  scale = std::sqrt(trace);
  return trace <= 0.0 ? 0.0 : contact_residual(trace, rows.friction[block], &rows.x[3 * block], u);
}

/// The same of a joint row.
double joint_velocity(std::size_t block, ContactRows& rows, double& scale) {
  const std::size_t j = block - rows.contacts.size(), row = rows.first_row(block);
  const ContactRows::Joint& joint = rows.joints[j];
  double u = rows.b[row] + joint.compliance * rows.x[row];
  for (int part = 0; part < joint.count; ++part) {
    const RowUnit& unit = rows.units[joint.units[part]];
    const std::size_t first = joint.first[part];
    if (unit.is_body()) {
      u += dot(rows.vector_at(first), unit.change_v_W) + dot(rows.vector_at(first + 3), unit.change_w_W);
      continue;
    }
    for (std::size_t k = 0; k < unit.change.size(); ++k) u += rows.J[first + k] * unit.change[k];
  }
  const double w = rows.own_entry(j) + joint.compliance;
  rows.u[row] = u;
  scale = std::sqrt(w);
  return w <= 0.0 ? 0.0 : w * std::abs(rows.x[row] - clamped(rows.x[row] - u / w, rows.bounds[j]));
}

}  // namespace

void IslandVelocities::reserve(std::size_t blocks) {
  for (auto* vector : {&residuals_, &scales_, &traces_}) reserve_written(*vector, blocks);
}

void IslandVelocities::begin(const ContactRows& rows) {
  traces_.clear();
  for (const ContactRows::Contact& contact : rows.contacts) traces_.push_back(trace_of(contact, rows));
}

IslandResidual IslandVelocities::update(const Islands& islands, const Island& island, ContactRows& rows) {
  spread_impulses(islands, island, rows);
  const std::span<const std::size_t> blocks = islands.blocks_of(island);
  residuals_.resize(blocks.size());
  scales_.resize(blocks.size());
  double worst = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    residuals_[i] = i < island.contacts ? contact_velocities(blocks[i], traces_[blocks[i]], rows, scales_[i])
                                        : joint_velocity(blocks[i], rows, scales_[i]);
    worst = worse_of(worst, residuals_[i]);
    sum += scales_[i] * std::abs(rows.x[rows.first_row(blocks[i])]);
  }
  bool is_still = true;
  for (std::size_t i = 0; i < blocks.size(); ++i)
    is_still = is_still && residuals_[i] <= kStill * (scales_[i] * sum);
  return {worst, is_still};
}

}  // namespace touchstone::physics::stepping
