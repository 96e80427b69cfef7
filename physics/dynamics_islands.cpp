// Rows that have to do with each other, solved apart from those that have not.

#include <algorithm>
#include <cmath>

#include "touchstone/physics/contact_laws.hpp"
#include "touchstone/physics/dynamics_world.hpp"

namespace touchstone::physics {
namespace {

// What rests is held at rest by the last step's forces as long as its points move less than the tolerance.
// But forces that are off by their rounding move it faster from step to step; so beyond this share of the
// velocities that the impulses could make (the sum of sqrt(w) |x|, a little above rounding) they are found
// anew, though not more often than every kPatience steps: where rounding is larger than that, nothing is won.
constexpr double kStill = 0x1p-52;
constexpr std::uint8_t kPatience = 16;
// What a step's work counts beside linear systems: an entry of W, a row that is set up and tried.
constexpr double kCouplingWork = 10.0, kRowWork = 300.0;

}  // namespace

std::uint32_t DynamicsWorld::unit_of_block(std::size_t block) const {
  if (block >= active_.size())
    return static_cast<std::uint32_t>(bodies_.size()) + joint_rows_[block - active_.size()].mechanism;
  const Point& point = points_[active_[block]];
  return point.sides[0].unit != kNone ? point.sides[0].unit : point.sides[1].unit;
}

/// Rows of the group that do not meet, directly or through others, are problems of their own. Islands come in
/// the order of their first row, rows in theirs.
void DynamicsWorld::find_islands() {
  const auto for_units = [&](auto act) {
    for (const std::uint32_t i : group_.bodies) act(i);
    for (const std::uint32_t m : group_.mechanisms) act(static_cast<std::uint32_t>(bodies_.size()) + m);
  };
  leader_.resize(bodies_.size() + mechanisms_.size());
  island_of_unit_.resize(leader_.size());
  for_units([&](std::uint32_t unit) { leader_[unit] = unit, island_of_unit_[unit] = kNone; });
  for (const std::size_t i : active_) {
    const Side* const sides = points_[i].sides;
    if (sides[0].unit != kNone && sides[1].unit != kNone) join(sides[0].unit, sides[1].unit);
  }
  islands_.clear();
  const std::size_t blocks = active_.size() + joint_rows_.size();
  island_of_block_.resize(blocks);
  for (std::size_t i = 0; i < blocks; ++i) {
    std::uint32_t& island = island_of_unit_[leader_of(unit_of_block(i))];
    if (island == kNone) {
      island = static_cast<std::uint32_t>(islands_.size());
      islands_.push_back({});
    }
    island_of_block_[i] = island;
    ++(i < active_.size() ? islands_[island].contacts : islands_[island].joints);
  }
  for_units([&](std::uint32_t unit) {
    const std::uint32_t island = island_of_unit_[leader_of(unit)];
    if (island != kNone) ++islands_[island].units;
  });
  std::size_t first_block = 0, first_unit = 0;
  for (Island& island : islands_) {
    island.first_block = first_block, island.first_unit = first_unit;
    first_block += island.contacts + island.joints;
    first_unit += island.units;
    island.contacts = island.joints = island.units = 0;
  }
  block_order_.resize(first_block);
  unit_order_.resize(first_unit);
  for (std::size_t i = 0; i < blocks; ++i) {
    Island& island = islands_[island_of_block_[i]];
    block_order_[island.first_block + island.contacts + island.joints] = i;
    ++(i < active_.size() ? island.contacts : island.joints);
  }
  for_units([&](std::uint32_t unit) {
    const std::uint32_t island = island_of_unit_[leader_of(unit)];
    if (island != kNone) unit_order_[islands_[island].first_unit + islands_[island].units++] = unit;
  });
}

/// What the island's impulses change of its units' velocities.
void DynamicsWorld::spread_impulses(const Island& island) {
  const std::span<const std::uint32_t> units =
      std::span(unit_order_).subspan(island.first_unit, island.units);
  for (const std::uint32_t unit : units) {
    if (is_body(unit)) {
      bodies_[unit].change_v_W = bodies_[unit].change_w_W = Vector3::Zero();
    } else {
      std::fill(arm_of(unit).change.begin(), arm_of(unit).change.end(), 0.0);
    }
  }
  const auto add = [&](std::vector<double>& change, std::size_t first, double x) {
    for (std::size_t k = 0; k < change.size(); ++k) change[k] += Y_[first + k] * x;
  };
  for (std::size_t i = 0; i < island.contacts + island.joints; ++i) {
    const std::size_t block = block_order_[island.first_block + i];
    if (i >= island.contacts) {
      const JointRow& joint = joint_rows_[block - active_.size()];
      add(mechanisms_[joint.mechanism].change, joint.first, x_[first_row(block)]);
      continue;
    }
    const Vector3 impulse = impulse_of(block);
    for (const Side& side : points_[active_[block]].sides) {
      if (side.unit == kNone) continue;
      if (is_body(side.unit)) {
        Body& body = bodies_[side.unit];
        body.change_v_W += side.sign * impulse;
        body.change_w_W += cross(side.lever_W, side.sign * impulse);
        continue;
      }
      std::vector<double>& change = arm_of(side.unit).change;
      for (std::size_t r = 0; r < 3; ++r) add(change, side.first + r * change.size(), x_[3 * block + r]);
    }
  }
  for (const std::uint32_t unit : units) {
    if (!is_body(unit)) continue;
    Body& body = bodies_[unit];
    body.change_v_W = body.change_v_W / body.body.inertia().mass;
    body.change_w_W = rotate(body.row_inverse_W, body.change_w_W);
  }
}

/// Velocities of a contact after what spread_impulses() left. Returns its natural residual or more: the trace
/// of its block stands for the largest diagonal entry, and the residual grows with the scale (Gafni and
/// Bertsekas, Two-Metric Projection Methods, 1984, lemma 1).
double DynamicsWorld::contact_velocities(std::size_t block, double& scale) {
  const Point& point = points_[active_[block]];
  Vector3 v = Vector3::Zero();
  double* const u = &u_[3 * block];
  for (int i = 0; i < 3; ++i) u[i] = b_[3 * block + static_cast<std::size_t>(i)];
  double trace = 0.0;
  for (const Side& side : point.sides) {
    if (side.unit == kNone) continue;
    if (is_body(side.unit)) {
      const Body& body = bodies_[side.unit];
      v += side.sign * (body.change_v_W + cross(body.change_w_W, side.lever_W));
      const Matrix3& I = body.row_inverse_W;
      trace += 3.0 / body.body.inertia().mass +
               (((I(0, 0) + I(1, 1)) + I(2, 2)) * dot(side.lever_W, side.lever_W) -
                dot(side.lever_W, rotate(I, side.lever_W)));
      continue;
    }
    const std::vector<double>& change = arm_of(side.unit).change;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t k = 0; k < change.size(); ++k) {
        const std::size_t at = side.first + r * change.size() + k;
        u[r] += J_[at] * change[k];
        trace += J_[at] * Y_[at];
      }
  }
  u[0] += dot(point.contact->n_AB_W, v);
  u[1] += dot(point.t1_W, v);
  u[2] += dot(point.t2_W, v);
  scale = std::sqrt(trace);
  return trace <= 0.0 ? 0.0 : contact_residual(trace, friction_[block], &x_[3 * block], u);
}

double DynamicsWorld::joint_velocity(std::size_t block, double& scale) {
  const std::size_t j = block - active_.size(), row = first_row(block);
  const JointRow& joint = joint_rows_[j];
  const double u = b_[row] + joint.sign * mechanisms_[joint.mechanism].change[joint.value];
  const double w = joint.sign * Y_[joint.first + joint.value];
  u_[row] = u;
  scale = std::sqrt(w);
  return w <= 0.0 ? 0.0 : w * std::abs(x_[row] - clamped(x_[row] - u / w, bounds_[j]));
}

/// u = W x + b by way of the units' velocities, without W: what rows cost, not their square. Returns the
/// natural residual or a little more.
DynamicsWorld::Residual DynamicsWorld::update_velocities(const Island& island) {
  spread_impulses(island);
  const std::size_t blocks = island.contacts + island.joints;
  residuals_.resize(blocks);
  scales_.resize(blocks);
  double worst = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < blocks; ++i) {
    const std::size_t block = block_order_[island.first_block + i];
    const bool is_contact = i < island.contacts;
    residuals_[i] = is_contact ? contact_velocities(block, scales_[i]) : joint_velocity(block, scales_[i]);
    worst = worse_of(worst, residuals_[i]);
    sum += scales_[i] * std::abs(x_[first_row(block)]);
  }
  bool is_still = true;
  for (std::size_t i = 0; i < blocks; ++i)
    is_still = is_still && residuals_[i] <= kStill * (scales_[i] * sum);
  return {worst, is_still};
}

/// Rows of a contact or joint in full, after those of the mechanisms.
void DynamicsWorld::write_out(std::size_t block, std::size_t i) {
  Row& row = rows_.emplace_back();
  row.count = 0;
  if (block >= active_.size()) {
    row.units[0] = unit_of_block(block);
    row.first[0] = joint_rows_[block - active_.size()].first;
    row.count = 1;
    return;
  }
  const Point& point = points_[active_[block]];
  const Vector3 direction = i == 0 ? point.contact->n_AB_W : i == 1 ? point.t1_W : point.t2_W;
  for (const Side& side : point.sides) {
    if (side.unit == kNone) continue;
    row.units[row.count] = side.unit;
    if (!is_body(side.unit)) {
      const std::size_t n = arm_of(side.unit).q.size(), first = side.first + i * n;
      if (row.count == 1 && row.units[0] == side.unit) {  // two links of one mechanism
        const std::size_t other = row.first[0];
        row.first[0] = J_.size();
        for (std::size_t k = 0; k < n; ++k) {
          J_.push_back(J_[other + k] + J_[first + k]);
          Y_.push_back(Y_[other + k] + Y_[first + k]);
        }
        continue;
      }
      row.first[row.count++] = first;
      continue;
    }
    const Body& body = bodies_[side.unit];
    const Vector3 linear = side.sign * direction, angular = cross(side.lever_W, linear);
    const Vector3 v = linear / body.body.inertia().mass, w = rotate(body.row_inverse_W, angular);
    row.first[row.count++] = J_.size();
    for (const Vector3& part : {linear, angular}) J_.insert(J_.end(), part.data(), part.data() + 3);
    for (const Vector3& part : {v, w}) Y_.insert(Y_.end(), part.data(), part.data() + 3);
  }
}

/// Its rows, one after the other.
void DynamicsWorld::load_island(const Island& island) {
  rows_.clear();
  local_rows_.clear();
  local_friction_.clear();
  local_bounds_.clear();
  for (std::size_t k = 0; k < island.contacts + island.joints; ++k) {
    const std::size_t block = block_order_[island.first_block + k];
    const bool is_contact = block < active_.size();
    for (std::size_t i = 0; i < (is_contact ? 3U : 1U); ++i) {
      local_rows_.push_back(first_row(block) + i);
      write_out(block, i);
    }
    if (is_contact) {
      local_friction_.push_back(friction_[block]);
    } else {
      local_bounds_.push_back(bounds_[block - active_.size()]);
    }
  }
  const std::size_t n = local_rows_.size();
  local_b_.resize(n);
  local_x_.resize(n);
  for (std::size_t r = 0; r < n; ++r) {
    local_b_[r] = b_[local_rows_[r]];
    local_x_[r] = x_[local_rows_[r]];
  }
}

/// J M^-1 J^T of the loaded rows: those meet that act on the same body or mechanism, and the rows of one
/// contact all act on the same.
void DynamicsWorld::load_couplings() {
  const std::size_t n = local_rows_.size(), contact_rows = 3 * local_friction_.size();
  W_.assign(n * n, 0.0);
  const auto size_at = [&](std::size_t row) { return row < contact_rows ? 3U : 1U; };
  for (std::size_t r = 0; r < n; r += size_at(r))
    for (std::size_t s = 0; s <= r; s += size_at(s)) {
      if (!meet(rows_[r], rows_[s])) continue;
      for (std::size_t i = r; i < r + size_at(r); ++i)
        for (std::size_t k = s; k < s + size_at(s) && k <= i; ++k)
          W_[i * n + k] = W_[k * n + i] = coupling(rows_[i], rows_[k]);
    }
}

bool DynamicsWorld::meet(const Row& r, const Row& s) {
  for (int i = 0; i < r.count; ++i)
    for (int k = 0; k < s.count; ++k)
      if (r.units[i] == s.units[k]) return true;
  return false;
}

double DynamicsWorld::coupling(const Row& r, const Row& s) const {
  double sum = 0.0;
  for (int i = 0; i < r.count; ++i)
    for (int k = 0; k < s.count; ++k) {
      if (r.units[i] != s.units[k]) continue;
      const std::size_t size = is_body(r.units[i]) ? 6 : arm_of(r.units[i]).q.size();
      for (std::size_t c = 0; c < size; ++c) sum += J_[r.first[i] + c] * Y_[s.first[k] + c];
    }
  return sum;
}

void DynamicsWorld::solve(StepReport& report) {
  u_ = b_;
  // Not all that came to rest together at the same time.
  for (std::size_t i = patience_.size(); i < bodies_.size() + mechanisms_.size(); ++i)
    patience_.push_back(static_cast<std::uint8_t>(i % (kPatience - 1)));
  find_islands();
  for (const Island& island : islands_) solve_island(island, report);
}

SolveReport DynamicsWorld::solve_loaded(const Island& island, WorkBudget* budget) {
  const SolveReport solved =
      solver_.solve({island.contacts, local_friction_, local_bounds_, W_, local_b_}, local_x_, budget);
  for (std::size_t k = 0; k < local_rows_.size(); ++k) x_[local_rows_[k]] = local_x_[k];
  return solved;
}

/// Once more, with what W x + b lacks of the velocities that the units will have.
void DynamicsWorld::refine(const Island& island) {
  update_velocities(island);
  // In place: each row's own b is read once, by itself.
  for (std::size_t k = 0; k < local_rows_.size(); ++k)
    local_b_[k] += u_[local_rows_[k]] - row_velocity(W_, local_b_, local_x_, k);
  solve_loaded(island, nullptr);
}

/// Two steps on end: the first stops what moves, the second finds the forces without what stopped it.
bool DynamicsWorld::may_refine(const Island& island) {
  bool may = true;
  const std::span<const std::uint32_t> units =
      std::span(unit_order_).subspan(island.first_unit, island.units);
  for (const std::uint32_t unit : units) {
    may = may && (patience_[unit] == 0 || patience_[unit] == kPatience);
    if (patience_[unit] > 0) --patience_[unit];
  }
  if (may)
    for (const std::uint32_t unit : units)
      patience_[unit] = patience_[unit] == kPatience - 1 ? kPatience - 1 : kPatience;
  return may;
}

/// Small islands by ContactSolver, which is exact; larger ones, and what its first steps leave, by
/// ConvexContacts; what that leaves by the solver's other means, as long as the step's work lasts.
SolveReport DynamicsWorld::solve_afresh(const Island& island, double warm, StepReport& report) {
  const std::size_t mechanism_rows = J_.size();
  load_island(island);
  const std::size_t rows = local_rows_.size();
  const bool is_exact = settings_.accuracy == Accuracy::exact;
  const double tolerance = tolerance_of(island, rows <= settings_.solver.most_path_rows);
  SolveReport solved;
  solved.converged = false;
  const bool is_small =
      rows <= (is_exact ? settings_.solver.most_newton_rows : settings_.solver.most_path_rows);
  warm_x_ = local_x_;
  if (is_small && !is_contradicted(island)) {
    load_couplings();
    budget_.spend(kCouplingWork * static_cast<double>(rows * rows));
    solved = solve_loaded(island, is_exact ? nullptr : &budget_);
    if (warm <= tolerance && solved.converged) refine(island);
    update_velocities(island);
  }
  if (!solved.converged) {
    local_x_ = warm_x_;
    const SolveReport tried = solved;
    solved = solve_convex(island, report);
    solved.sweeps += tried.sweeps;
    solved.newton_steps += tried.newton_steps;
  }
  J_.resize(mechanism_rows);
  Y_.resize(mechanism_rows);
  return solved;
}

/// Figures that are not finite even without impulses: the step ends here, and the first that they would move
/// is named.
void DynamicsWorld::fail_solve(const Island& island, StepReport& report) const {
  const std::uint32_t unit = unit_order_[island.first_unit];
  if (is_body(unit))
    fail(StepFailure::body, unit, report);
  else
    fail(StepFailure::mechanism, unit - bodies_.size(), report);
}

void DynamicsWorld::solve_island(const Island& island, StepReport& report) {
  // Most of what rests goes on resting: what held it in the last step does in this.
  Residual warm = update_velocities(island);
  if (!std::isfinite(warm.worst)) {
    for (std::size_t i = 0; i < island.contacts + island.joints; ++i) {
      const std::size_t block = block_order_[island.first_block + i];
      std::fill_n(&x_[first_row(block)], i < island.contacts ? 3 : 1, 0.0);
    }
    warm = update_velocities(island);
  }
  if (!std::isfinite(warm.worst)) return fail_solve(island, report);
  const std::size_t rows = 3 * island.contacts + island.joints;
  const bool holds = warm.worst <= tolerance_of(island, rows <= settings_.solver.most_path_rows);
  budget_.spend(kRowWork * static_cast<double>(rows));
  const bool is_refined = rows <= settings_.solver.most_path_rows || settings_.accuracy == Accuracy::exact;
  SolveReport solved;
  solved.residual = warm.worst;
  if (!holds || (is_refined && !warm.is_still && may_refine(island)))
    solved = solve_afresh(island, warm.worst, report);
  ++report.solves;
  report.unconverged += solved.converged ? 0 : 1;
  report.sweeps += static_cast<std::uint32_t>(solved.sweeps);
  report.newton_steps += static_cast<std::uint32_t>(solved.newton_steps);
  report.worst_residual = worse_of(report.worst_residual, solved.residual);
}

}  // namespace touchstone::physics
