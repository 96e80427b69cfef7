#include "touchstone/physics/solver/contact_solver.hpp"

#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/physics/solver/reserved.hpp"
#include "touchstone/tests/physics/random_contact_sets.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"

using namespace touchstone;
using namespace touchstone::physics;

namespace {

/// Each law for itself, written out, beside the natural map. What a residual r leaves of them, w the block's
/// scale, x_t and u_t the tangents' impulse and velocity, c the cone's radius f x_n: where w x_t - u_t lies
/// in the disc of radius w c, |u_t| <= r. Else w x_t = w c d + e and u_t = (w c - k) d + e for a unit d, |e|
/// <= r and k = |w x_t - u_t| >= w c, so that w (c - |x_t|) <= r, and what x_t u_t lacks of -|x_t| |u_t| is
/// 2 r (k + r) / w at most, with k <= w |x_t| + |u_t|.
/// @param r the residual, with what rounding makes of u here and there.
void expect_laws(const ContactProblem& problem, const std::vector<double>& x, double r) {
  const std::size_t n = problem.rows();
  for (std::size_t c = 0; c < problem.contacts; ++c) {
    double u[3], w = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t row = 3 * c + i;
      u[i] = problem.b[row];
      for (std::size_t k = 0; k < n; ++k) u[i] += problem.W[row * n + k] * x[k];
      w = std::max(w, problem.W[row * n + row]);
    }
    const double normal = x[3 * c], t1 = x[3 * c + 1], t2 = x[3 * c + 2];
    const double length = std::sqrt(t1 * t1 + t2 * t2), cone = problem.friction[c] * normal;
    const double slip = std::sqrt(u[1] * u[1] + u[2] * u[2]), along = t1 * u[1] + t2 * u[2];
    EXPECT_GE(u[0], -r);
    EXPECT_GE(w * normal, -r);
    EXPECT_LE(std::min(u[0], w * normal), r);  // apart: no force
    EXPECT_LE(w * (length - cone), r);
    EXPECT_LE(std::min(slip, w * (cone - length)), r);                          // within the cone: no slip
    EXPECT_LE(w * (along + slip * length), 2 * r * ((w * length + slip) + r));  // against the slip
    if (slip > 1e-3 && w * length > 1e-3) {
      EXPECT_LE(along, -(1 - 1e-6) * slip * length);
    }
  }
}

/// How many laws an answer breaks, of one contact with W = 1 and friction 0.5 that arrives at -1.
int broken_laws(const std::vector<double>& arrives, const std::vector<double>& x) {
  const std::vector<double> W = {1, 0, 0, 0, 1, 0, 0, 0, 1}, friction = {0.5};
  testing::TestPartResultArray failures;
  {
    const testing::ScopedFakeTestPartResultReporter quiet(
        testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &failures);
    expect_laws({1, friction, {}, W, arrives}, x, 2e-9);
  }
  return failures.size();
}

TEST(ContactLaws, AWrongAnswerBreaksThem) {
  EXPECT_EQ(broken_laws({-1, 1, 0}, {1, -0.5, 0}), 0);                 // slips against the whole cone
  EXPECT_EQ(broken_laws({-1, 0.8, 0}, {1, -0.3, 0}), 1);               // slips, with 60 % of the cone
  EXPECT_GE(broken_laws({-1, 1, 0}, {1, -0.5 * 0.999998, -1e-3}), 1);  // 2e-3 rad aside
  EXPECT_GE(broken_laws({-1, 1, 0}, {1, -0.5 + 1e-8, 0}), 1);          // 1e-8 short of the cone
  EXPECT_GE(broken_laws({-1, 1, 0}, {1, 0.5, 0}), 1);                  // along the slip
  EXPECT_GE(broken_laws({-1, 0, 0}, {0.5, 0, 0}), 1);                  // goes on into the other
  EXPECT_GE(broken_laws({-1, 0, 0}, {2, 0, 0}), 1);                    // is thrown back
}

void solve_random_sets(double mu, int count) {
  std::mt19937_64 random(61);
  ContactSolver solver;
  solver.reserve(RandomSet::kRows);
  std::vector<double> u(RandomSet::kRows);
  double worst = 0.0;
  int failed = 0, rounding = 0;
  for (int i = 0; i < count; ++i) {
    // A set is solved without allocations.
    const RandomSet set(random, mu, i % 2 == 1);
    const ContactProblem problem = set.problem();
    std::vector<double> x(RandomSet::kRows, 0.0);
    const std::size_t allocations = allocation_count();
    const SolveReport report = solver.solve(problem, x);
    EXPECT_EQ(allocation_count(), allocations);
    // The residual is as reported; the laws hold where it is small.
    const double residual = natural_residual(problem, x, u);
    EXPECT_LT(std::abs(residual - report.residual), 1e-9 + 1e-9 * residual);
    worst = std::max(worst, residual);
    if (residual <= 1e-9) {
      expect_laws(problem, x, 2e-9);
    } else {
      ++failed;
      EXPECT_FALSE(report.converged);  // and says so
      rounding += residual < 1e-8 ? 1 : 0;
    }
  }
  std::printf("friction %.1f: %d of %d above 1e-9 m/s (%d of them below 1e-8), worst %.1e\n", mu, failed,
              count, rounding, worst);
  EXPECT_EQ(failed, 0);
}

TEST(ContactSolver, RandomSetsOfFriction3) { solve_random_sets(0.3, 1000); }
TEST(ContactSolver, RandomSetsOfFriction5) { solve_random_sets(0.5, 1000); }
TEST(ContactSolver, RandomSetsOfFriction9) { solve_random_sets(0.9, 1000); }

TEST(ContactSolver, WhatOneRoundDoesNotSolveIsSaid) {
  std::mt19937_64 random(61);
  ContactSolver::Settings settings;
  settings.rounds = 1;
  ContactSolver solver(settings);
  std::vector<double> u(RandomSet::kRows);
  int left = 0;
  constexpr int kCount = 200;
  for (int i = 0; i < kCount; ++i) {
    const RandomSet set(random, 0.9, i % 2 == 1);
    std::vector<double> x(RandomSet::kRows, 0.0);
    const SolveReport report = solver.solve(set.problem(), x);
    const double residual = natural_residual(set.problem(), x, u);
    EXPECT_LE(report.rounds, 1);
    EXPECT_NEAR(report.residual, residual, 1e-9 * residual + 1e-11);
    EXPECT_EQ(report.converged, residual <= settings.tolerance + 1e-11) << residual;
    left += report.converged ? 0 : 1;
  }
  std::printf("%d of %d are left after one round\n", left, kCount);
  EXPECT_GE(left, 10);  // or nothing was tried
  EXPECT_LE(left, kCount / 2);
}

/// Without Newton's method and restarts: the path alone ends at a solution.
TEST(ContactSolver, WithinAWorkBudgetItGivesUpWhereNothingBetterIsFound) {
  std::mt19937_64 random(1611);
  ContactSolver solver;
  int unsolved = 0, steps = 0;
  for (int i = 0; i < 300; ++i) {
    const RandomSet set(random, 0.9, i % 2 == 0);
    std::vector<double> x(RandomSet::kRows, 0.0);
    WorkBudget budget;
    budget.start(1e9);
    const SolveReport report = solver.solve(set.problem(), x, &budget);
    if (report.converged) continue;
    ++unsolved;
    steps += report.newton_steps;
  }
  ASSERT_GT(unsolved, 20);
  EXPECT_LT(steps, 12 * unsolved);  // all 15 each, if it did not
}

/// Of a few bodies W's parts are to give what W does, with as many Newton steps.
TEST(ContactSolver, InPartsAsByW) {
  std::mt19937_64 random(2911);
  ContactSolver solver;
  std::vector<double> u(RandomSet::kRows);
  int solved[2] = {0, 0}, steps[2] = {0, 0};
  for (int i = 0; i < 400; ++i) {
    const RandomSet set(random, 0.3, i % 2 == 0);
    std::vector<double> x[2];
    SolveReport reports[2];
    for (int k = 0; k < 2; ++k) {
      x[k].assign(RandomSet::kRows, 0.0);
      WorkBudget budget;
      budget.start(1e9);
      reports[k] = solver.solve(k == 0 ? set.problem() : set.by_rates(), x[k], &budget);
      if (!reports[k].converged) continue;
      ++solved[k];
      expect_laws(set.problem(), x[k], 2e-9);
      EXPECT_LE(natural_residual(set.by_rates(), x[k], u), 1e-9);
    }
    for (int k = 0; k < 2; ++k)
      if (reports[0].converged && reports[1].converged) steps[k] += reports[k].newton_steps;
  }
  std::printf("by W %d of 400 solved, in parts %d; Newton steps where both are: %d, %d\n", solved[0],
              solved[1], steps[0], steps[1]);
  EXPECT_GE(solved[0], 200);  // or nothing was tried
  EXPECT_NEAR(solved[1], solved[0], 8);
  EXPECT_NEAR(steps[1], steps[0], 0.02 * steps[0]);
}

/// What moves needs no last digits: a step less, for a residual within the tolerance all the same.
TEST(ContactSolver, AGoodSolutionIsImprovedWhereAskedFor) {
  std::mt19937_64 random(1612);
  ContactSolver solver;
  int solved = 0, fewer = 0;
  for (int i = 0; i < 100; ++i) {
    const RandomSet set(random, 0.5, i % 2 == 0);
    std::vector<double> x(RandomSet::kRows, 0.0), plain_x = x, u = x;
    WorkBudget budget;
    budget.start(1e9);
    const SolveReport improved = solver.solve(set.problem(), x, &budget);
    const SolveReport plain = solver.solve(set.problem(), plain_x, &budget, false);
    EXPECT_EQ(plain.converged, improved.converged) << i;
    if (!plain.converged) continue;
    EXPECT_LE(natural_residual(set.problem(), plain_x, u), solver.settings().tolerance) << i;
    ++solved;
    fewer += plain.newton_steps < improved.newton_steps ? 1 : 0;
  }
  ASSERT_GT(solved, 20);
  EXPECT_GT(3 * fewer, solved);  // none, if both did the same
}

/// Of this process.
std::size_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::size_t all = 0, resident = 0;
  statm >> all >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

TEST(ReservedMemory, IsWrittenUpToABoundAndChangesNothing) {
  // Of 128 MiB, more than any heap keeps for later, so that none of it was written before.
  constexpr std::size_t kCount = std::size_t{1} << 24;
  std::vector<double> values = {1.0, 2.0};
  const std::size_t before = resident_bytes();
  if (before == 0) GTEST_SKIP() << "the system does not say how much memory is resident";
  reserve_written(values, kCount);
  const std::size_t written = resident_bytes() - before;
  EXPECT_EQ(values, (std::vector<double>{1.0, 2.0}));
  EXPECT_GE(values.capacity(), kCount);
  // Resident memory is counted in batches, and sanitizers keep notes of what is reserved.
  EXPECT_GT(written, kMostWritten / 4 * 3);
  EXPECT_LT(written, kCount * sizeof(double) / 2);
}

TEST(ContactPath, EndsAtASolution) {
  std::mt19937_64 random(5);
  int arrived = 0;
  constexpr int kCount = 50;
  for (int i = 0; i < kCount; ++i) {
    // The set with its diagonal scaled to one.
    const RandomSet set(random, 0.5, i % 2 == 1);
    std::vector<double> scale(RandomSet::kRows), W = set.W, b = set.b, x(RandomSet::kRows), u = x;
    for (std::size_t r = 0; r < RandomSet::kRows; ++r) {
      const std::size_t block = r - r % 3;
      double w = 0.0;
      for (std::size_t k = block; k < block + 3; ++k) w = std::max(w, set.W[k * RandomSet::kRows + k]);
      scale[r] = 1.0 / std::sqrt(w);
    }
    for (std::size_t r = 0; r < RandomSet::kRows; ++r) {
      b[r] *= scale[r];
      for (std::size_t k = 0; k < RandomSet::kRows; ++k) W[r * RandomSet::kRows + k] *= scale[r] * scale[k];
    }
    // Along the path to the hard contacts.
    ContactPath path;
    path.reserve(RandomSet::kRows);
    ASSERT_TRUE(path.start({RandomSet::kContacts, set.friction, {}, W, b}));
    while (path.softness() > 1e-9 && path.linear_solves() < 2000 && path.advance()) {
    }
    // The solution of the set as it was.
    for (std::size_t r = 0; r < RandomSet::kRows; ++r) x[r] = path.y()[r] * scale[r];
    arrived += natural_residual(set.problem(), x, u) < 1e-6 ? 1 : 0;  // softness times impulses of up to 1e3
  }
  EXPECT_GE(arrived, kCount - 1);  // a path may be lost to rounding: the solver has others
}

TEST(ContactSolver, OneContactIsTheClosedForm) {
  // A unit mass point: W = 1. It arrives at (-1, 2, 0): friction 0.5 takes 0.5 of the sliding; 3 would take
  // all.
  const std::vector<double> W = {1, 0, 0, 0, 1, 0, 0, 0, 1}, b = {-1, 2, 0};
  ContactSolver solver;
  for (const double mu : {0.0, 0.5, 3.0}) {
    std::vector<double> x(3, 0.0);
    const std::vector<double> friction = {mu};
    const SolveReport report = solver.solve({1, friction, {}, W, b}, x);
    EXPECT_TRUE(report.converged);
    EXPECT_NEAR(x[0], 1.0, 1e-10);
    EXPECT_NEAR(x[1], -std::min(mu, 2.0), 1e-10);
    EXPECT_NEAR(x[2], 0.0, 1e-10);
  }
}

TEST(ContactSolver, JointRowsKeepTheirBounds) {
  const std::vector<double> W = {2, 1, 1, 2}, b = {-3, 1};
  const std::vector<ContactProblem::Bounds> bounds = {{-1, 1}, {-10, 10}};
  std::vector<double> x(2, 0.0);
  ContactSolver solver;
  EXPECT_TRUE(solver.solve({0, {}, bounds, W, b}, x).converged);
  EXPECT_NEAR(x[0], 1.0, 1e-10);   // at its bound: -3 + 2 + x1 < 0
  EXPECT_NEAR(x[1], -1.0, 1e-10);  // 1 + 1 + 2 x1 = 0
}

TEST(ContactSolver, WhatIsNoNumberIsNotSolved) {
  std::mt19937_64 random(3);
  const RandomSet good(random, 0.5, false);
  ContactSolver solver;
  const double nan = kNaN, inf = kInfinity;
  std::vector<double> x(RandomSet::kRows), u = x;
  const auto expect_unsolved = [&](const RandomSet& set) {
    std::fill(x.begin(), x.end(), 0.0);
    EXPECT_TRUE(std::isnan(natural_residual(set.problem(), x, u)));
    const SolveReport report = solver.solve(set.problem(), x);
    EXPECT_FALSE(report.converged);
    EXPECT_TRUE(std::isnan(report.residual));
    EXPECT_EQ(x, std::vector<double>(RandomSet::kRows, 0.0));
  };
  for (const std::size_t row : {4u, 5u, 6u, 23u})  // normals and tangents, first and last
    for (const double bad : {nan, inf}) {
      RandomSet set = good;
      set.W[row * RandomSet::kRows + row] = bad;
      expect_unsolved(set);
      if (bad == inf) continue;
      set = good;
      set.b[row] = bad;
      expect_unsolved(set);
    }
  std::vector<double> warm(RandomSet::kRows, nan);
  EXPECT_TRUE(std::isnan(natural_residual(good.problem(), warm, u)));
  EXPECT_TRUE(solver.solve(good.problem(), warm).converged);
  EXPECT_LE(natural_residual(good.problem(), warm, u), 1e-10);
  // Joint rows.
  const std::vector<ContactProblem::Bounds> bounds = {{-1, 1}, {-1, 1}};
  std::vector<double> joints(2, 0.0);
  EXPECT_FALSE(
      solver.solve({0, {}, bounds, std::vector<double>{nan, 0, 0, 1}, std::vector<double>{1, 0}}, joints)
          .converged);
}

TEST(ContactSolver, RedundantContactsShareTheLoad) {
  // Four equal rows of one mass: singular, solvable.
  const std::size_t n = 12;
  std::vector<double> W(n * n, 0.0), b(n, 0.0), x(n, 0.0), u(n);
  for (std::size_t r = 0; r < n; ++r)
    for (std::size_t s = 0; s < n; ++s) W[r * n + s] = r % 3 == s % 3 ? 1.0 : 0.0;
  for (std::size_t c = 0; c < 4; ++c) b[3 * c] = -1.0;
  const std::vector<double> friction(4, 0.5);
  ContactSolver solver;
  const SolveReport report = solver.solve({4, friction, {}, W, b}, x);
  EXPECT_TRUE(report.converged);
  EXPECT_NEAR(((x[0] + x[3]) + x[6]) + x[9], 1.0, 1e-10);
}

}  // namespace
