#include "touchstone/physics/solver/convex_contacts.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/physics/solver/contact_laws.hpp"
#include "touchstone/physics/solver/reserved.hpp"

namespace touchstone::physics {
namespace {

/// How the rounds go. R, beside a contact's diagonal block of W, is soft at first, since that takes fewest
/// steps, then harder from round to round. Far above rounding, as impulses are differences of velocities over
/// R.
struct Rounds {
  double softness;  // of the first
  double harder;    // share of the softness that the next has
  double inexact;   // share of the least that was left before which a round may leave
};
// From a start that holds few rounds take the softness out.
constexpr Rounds kFromRest = {1e-2, 0.03, 0.01};
// Where the start is far off, each round goes on by what the next two or three Newton steps solve: one that
// starts from much softer impulses takes more steps than it saves, and is left unfinished where work ends.
constexpr Rounds kFromFar = {1.0, 0.3, 0.1};
// More contacts than kFew seldom come to an end from there. What is left are slips: the softness stays as
// long as a round takes more than kCheapSteps Newton steps and is not stuck, since a harder one takes more of
// them and finds the slips no better.
constexpr Rounds kFromFarOfMany = {1.0, 0.3, 0.5};
constexpr std::size_t kFew = 64;
constexpr int kCheapSteps = 1;
// Rounds that keep their softness find a share of what was left each: where work has no end (exact)
// kMostRounds of them leave some that twice as many solve.
constexpr int kMostKeptRounds = 80;
// Shares of the speeds: a start that leaves less than kHolds holds already: the less it leaves, the less soft
// the first round is. One that leaves more than kFar is far off.
constexpr double kHolds = 1e-5, kFar = 1e-3, kSoftness = 1e-5;
constexpr int kMostRounds = 40, kMostSteps = 40;
// Masses that differ by less than 1 / kAlike are alike; beyond, each kRoundBits of their ratio take as much
// work again.
constexpr double kAlike = 0.03, kRoundBits = 5.0;
// Impulses prove a contradiction where commands could only be met at kNoWayOut times their speed: a
// wedge of one in fifty is pressed out, a narrower one is held. Where that was proven lately, a few times do.
constexpr double kNoWayOut = 50.0, kNoWayOutStill = 3.0;
// A start from the last step may give this share of the energy that it moves: a tenth too much of what
// rests.
constexpr double kStale = -0.4;
// A round that leaves more than this share of the residual of the one before brings nothing.
constexpr double kStuck = 0.7;

}  // namespace

void ConvexContacts::reserve(std::size_t units, std::size_t rows, std::size_t widest) {
  cholesky_.reserve(units, rows, widest);
  reserve_written(pairs_, rows);
  reserve_written(body_contacts_, rows / 3);
  for (auto* vector : {&first_, &first_mass_}) reserve_written(*vector, units + 1);
  for (auto* vector : {&scale_, &hardness_, &slip_, &anchor_, &asked_, &gamma_, &impulses_, &u_, &du_, &best_,
                       &anchor_share_})
    reserve_written(*vector, rows);
  for (auto* vector : {&V_, &step_, &gradient_, &trial_V_}) reserve_written(*vector, units * widest);
  reserve_written(reach_, units * widest);
  reserve_written(blocks_, 6 * widest);
  for (auto* vector : {&stiffness_, &last_stiffness_}) reserve_written(*vector, 3 * rows);
}

/// w: the largest diagonal entry of W of each block; and the least softness, by the spread of masses.
void ConvexContacts::find_scales() {
  double most = 0.0, least = kInfinity;  // of a side's inverse mass
  const auto diagonal_entry = [&](std::size_t row) {
    const SparseContacts::Row& r = problem_.rows[row];
    double sum = 0.0;
    for (int i = 0; i < r.count; ++i) {
      double part = 0.0;
      for (std::size_t k = 0; k < problem_.sizes[r.units[i]]; ++k)
        part += problem_.J[r.first[i] + k] * problem_.Y[r.first[i] + k];
      sum += part;
      most = std::max(most, part);
      if (part > 0.0) least = std::min(least, part);
    }
    return sum;
  };
  scale_.clear();
  for (std::size_t c = 0; c < problem_.contacts; ++c)
    scale_.push_back(std::max({diagonal_entry(3 * c), diagonal_entry(3 * c + 1), diagonal_entry(3 * c + 2)}));
  for (std::size_t r = 3 * problem_.contacts; r < problem_.rows.size(); ++r)
    scale_.push_back(diagonal_entry(r));
  // A contact's W is that of its lighter side, which may carry the heaviest body.
  const double spread = std::max(1.0, kAlike * most / least);
  hardest_ = kSoftness / spread;
  price_ = 1.0 / (1.0 + std::ilogb(spread) / kRoundBits);  // the same bits from every C library
}

void ConvexContacts::find_pairs() {
  pairs_.clear();
  for (const SparseContacts::Row& row : problem_.rows) {
    if (row.count < 2) continue;
    const auto [a, b] = std::minmax(row.units[0], row.units[1]);
    if (pairs_.empty() || pairs_.back() != BlockCholesky::Pair(a, b)) pairs_.emplace_back(a, b);
  }
  std::sort(pairs_.begin(), pairs_.end());
  pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
  cholesky_.analyse(problem_.sizes, pairs_);
}

/// The contacts between bodies, side by side.
void ConvexContacts::find_body_contacts() {
  body_contacts_.resize(problem_.contacts);
  other_contacts_ = 0;
  for (std::size_t c = 0; c < problem_.contacts; ++c) {
    BodyContact& contact = body_contacts_[c];
    const bool is_of_bodies =
        !problem_.levers.empty() && !problem_.bodies.empty() && problem_.levers[c].are_of_bodies;
    contact.count = is_of_bodies ? problem_.rows[3 * c].count : 0;
    contact.first[0] = contact.first[1] = 0;
    if (contact.count == 0) ++other_contacts_;
    for (std::size_t i = 0; i < 3 && is_of_bodies; ++i)
      contact.directions[i] = vector_at(&problem_.J[problem_.rows[3 * c + i].first[0]]);
    for (int side = 0; side < contact.count; ++side) {
      contact.levers[side] = problem_.levers[c].of[side];
      contact.first[side] = first_[problem_.rows[3 * c].units[side]];
    }
  }
}

void ConvexContacts::load(const SparseContacts& problem, std::span<const double> x) {
  problem_ = problem;
  report_ = {};
  first_.clear();
  first_mass_.clear();
  std::size_t rates = 0, entries = 0, widest = 0;
  for (const std::size_t size : problem.sizes) {
    first_.push_back(rates);
    first_mass_.push_back(entries);
    rates += size;
    entries += size * size;
    widest = std::max(widest, size);
  }
  const std::size_t rows = problem.rows.size();
  for (auto* vector : {&anchor_, &asked_, &gamma_, &impulses_, &u_, &du_, &best_}) vector->resize(rows);
  for (auto* vector : {&V_, &step_, &gradient_, &trial_V_}) vector->resize(rates);
  blocks_.resize(6 * widest);
  slip_.resize(problem.contacts);
  std::copy(x.begin(), x.end(), anchor_.begin());
  is_factored_ = false;
  find_body_contacts();
  find_scales();
  find_pairs();
}

/// The natural residual, by the rates that x gives; u_ are the velocities.
double ConvexContacts::residual_of(std::span<const double> x) {
  spread(x, trial_V_);
  find_velocities(trial_V_, u_, true);
  double worst = 0.0;
  for (std::size_t c = 0; c < problem_.contacts; ++c)
    if (scale_[c] > 0.0)
      worst = worse_of(worst, contact_residual(scale_[c], problem_.friction[c], &x[3 * c], &u_[3 * c]));
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const std::size_t r = 3 * problem_.contacts + j;
    const double compliance = problem_.compliance_of(j), w = scale_[problem_.contacts + j] + compliance;
    u_[r] += compliance * x[r];
    if (w > 0.0) worst = worse_of(worst, w * std::abs(x[r] - clamped(x[r] - u_[r] / w, problem_.bounds[j])));
  }
  return worst;
}

/// Of the velocities without impulses.
double ConvexContacts::fastest() const {
  double speed = 0.0;
  for (const double b : problem_.b) speed = std::max(speed, std::abs(b));
  return speed;
}

/// Of the velocities u_.
void ConvexContacts::find_slips() {
  for (std::size_t c = 0; c < problem_.contacts; ++c)
    slip_[c] = problem_.friction[c] * length_of(u_[3 * c + 1], u_[3 * c + 2]);
}

/// Else standing still is a solution.
bool ConvexContacts::presses_on_commands() const {
  for (std::size_t c = 0; c < problem_.commanded.size(); ++c)
    if (problem_.commanded[c] < 0.0 || (c >= problem_.contacts && problem_.commanded[c] > 0.0)) return true;
  return false;
}

/// Farkas' lemma: impulses in their cones with J^T x = 0 and x commanded < 0 say that no velocities V meet
/// the laws' J V + commanded. Of impulses that grow without end (as in Banjac, Goulart, Stellato, Boyd,
/// Infeasibility Detection in the Alternating Direction Method of Multipliers, 2019) J^T x is small beside x,
/// and V would have to be larger than -x commanded / |J^T x|. That does not depend on masses: a heavy body on
/// a light one presses hard, and is moved by as much.
bool ConvexContacts::proves_contradiction(std::span<const double> x, double times) {
  if (!presses_on_commands()) return false;
  // y = J^T x is summed up, and the largest entry of J for each rate.
  std::vector<double>& y = trial_V_;
  std::fill(y.begin(), y.end(), 0.0);
  reach_.assign(y.size(), 0.0);
  double pressed = 0.0, fastest_commanded = 0.0;
  for (std::size_t r = 0; r < x.size(); ++r) {
    const bool is_contact = r < 3 * problem_.contacts;
    const std::size_t block = is_contact ? r / 3 : r - 2 * problem_.contacts;
    if (!is_contact) {  // a row that is bounded or compliant is no direction
      const std::size_t j = r - 3 * problem_.contacts;
      const double end = x[r] > 0.0 ? problem_.bounds[j].upper : problem_.bounds[j].lower;
      if (std::isfinite(end) || problem_.compliance_of(j) > 0.0) continue;
    }
    // Normals and joint rows press against commanded velocities.
    if (!is_contact || r % 3 == 0) {
      pressed -= x[r] * problem_.commanded[block];
      fastest_commanded = std::max(
          fastest_commanded, is_contact ? -problem_.commanded[block] : std::abs(problem_.commanded[block]));
    }
    const SparseContacts::Row& row = problem_.rows[r];
    if (x[r] != 0.0) add(row, problem_.J, x[r], y);
    for (int i = 0; i < row.count; ++i)
      for (std::size_t k = 0; k < problem_.sizes[row.units[i]]; ++k) {
        double& reach = reach_[first_[row.units[i]] + k];
        reach = std::max(reach, std::abs(problem_.J[row.first[i] + k]));
      }
  }
  // Impulses that press much and move little are the proof.
  double moved = 0.0;
  for (std::size_t k = 0; k < y.size(); ++k)
    if (reach_[k] > 0.0) moved += std::abs(y[k]) / reach_[k];
  return pressed > times * fastest_commanded * moved;
}

/// Impulses x with u_ = W x + b give the energy x (u + b) / 2. Where that is more than `most_given` of what
/// they move, as unsolved ones may, the share of them that takes most is left: -x b / x W x.
/// @return whether x is another now.
bool ConvexContacts::take_energy(std::span<double> x, double most_given) {
  double by_b = 0.0, by_W = 0.0;
  for (std::size_t r = 0; r < x.size(); ++r) {
    by_b += x[r] * problem_.b[r];
    by_W += x[r] * (u_[r] - problem_.b[r]);
  }
  if (!(by_b + 0.5 * by_W > most_given * by_W)) return false;
  const double share = by_W > 0.0 && by_b < 0.0 ? -by_b / by_W : 0.0;
  for (double& impulse : x) impulse *= share;
  return true;
}

/// The residual of impulses that give no energy. @param x in: any.
double ConvexContacts::judge(std::span<double> x) {
  const double residual = residual_of(x);
  return take_energy(x, 0.0) ? residual_of(x) : residual;
}

/// The soft answer around 0, which is the anchor from then on. @param is_proven that the contacts contradict
/// each other, lately. @param most_steps Newton steps; the answer is then the best, whatever it proves. 0: as
/// many as a round takes, and other answers may follow. @return whether the answer is the best: as
/// `most_steps` says, as it proves a contradiction, or as no work is left for another.
bool ConvexContacts::soften(double tolerance, bool is_proven, WorkBudget& budget, int most_steps) {
  set_softness(kSoftAnswer);
  std::fill(anchor_.begin(), anchor_.end(), 0.0);
  const Outcome outcome = minimise(tolerance, budget, most_steps > 0 ? most_steps : kMostSteps);
  if (outcome == Outcome::stuck) {
    if (most_steps == 0) return false;
    // The last step's impulses may press without end: none are the answer.
    std::fill(impulses_.begin(), impulses_.end(), 0.0);
  }
  anchor_ = outcome == Outcome::solved ? gamma_ : impulses_;
  // Where the work ends here it is the best there is: other answers may press without end.
  const bool is_last = most_steps > 0 || (outcome == Outcome::spent && budget.is_spent());
  // Impulses of an unsolved problem are in no cone, and prove nothing.
  const bool is_solved = outcome == Outcome::solved;
  report_.is_certain = is_solved && proves_contradiction(anchor_, kNoWayOut);
  report_.is_contradictory =
      report_.is_certain || (is_solved && is_proven && proves_contradiction(anchor_, kNoWayOutStill));
  if (!report_.is_contradictory && !is_last) return false;
  report_.is_undecided = !is_solved;
  best_ = anchor_;
  report_.residual = judge(best_);
  return true;
}

ConvexReport ConvexContacts::solve_softly(const SparseContacts& problem, std::span<double> x,
                                          double tolerance, WorkBudget& budget, int most_steps) {
  load(problem, x);
  set_softness(kSoftAnswer);
  start();
  for (auto* vector : {&anchor_, &slip_}) std::fill(vector->begin(), vector->end(), 0.0);
  const Outcome outcome = minimise(tolerance, budget, most_steps);
  report_.converged = outcome == Outcome::solved;
  // The start may be far off: without a step from it nothing is known of it.
  if (outcome == Outcome::stuck) std::fill(impulses_.begin(), impulses_.end(), 0.0);
  std::copy(impulses_.begin(), impulses_.end(), x.begin());
  return report_;
}

/// Starts from impulses that held in a step of other velocities, scaled so that they take most energy.
void ConvexContacts::start() {
  report_.residual = residual_of(anchor_);
  if (take_energy(anchor_, kStale)) report_.residual = residual_of(anchor_);
  best_ = impulses_ = anchor_;
  V_ = trial_V_;
}

ConvexReport ConvexContacts::solve(const SparseContacts& problem, std::span<double> x, double tolerance,
                                   WorkBudget& budget, Softness first, int most_soft_steps) {
  load(problem, x);
  start();
  // The less the start leaves, the less soft the first round is.
  double last = report_.residual;
  const double left = last > 0.0 ? last / std::max(fastest(), last) : 0.0;
  const bool is_far_of_many = !(left < kFar) && problem.contacts > kFew;
  const Rounds& rounds = is_far_of_many ? kFromFarOfMany : left < kFar ? kFromRest : kFromFar;
  const double first_softness = std::clamp(rounds.softness * (left / kHolds), kSoftness, rounds.softness);
  bool is_first = true;
  bool is_over = report_.residual <= tolerance;
  // The soft answer comes first where a contradiction is likely.
  if (first != Softness::last && !is_over && presses_on_commands()) {
    find_slips();
    is_over = soften(tolerance, first == Softness::first, budget, most_soft_steps);
  }
  if (!is_over) {
    // Without contradiction the given start serves better than the soft answer; with it, that goes on to
    // grow.
    if (first == Softness::first) std::copy(x.begin(), x.end(), anchor_.begin()), start();
    set_softness(first == Softness::maybe ? rounds.harder * kSoftAnswer : first_softness);
  }
  // Each round minimises the softened potential about the impulses of the one before.
  const bool is_bounded = budget.left() < WorkBudget::kNoEnd;
  const int most_rounds = is_far_of_many && !is_bounded ? kMostKeptRounds : kMostRounds;
  for (int round = 0; round < most_rounds && !is_over; ++round) {
    find_slips();
    const int steps_before = report_.newton_steps;
    const Outcome outcome = minimise(std::max(0.1 * tolerance, rounds.inexact * last), budget, kMostSteps);
    if (outcome == Outcome::stuck) break;
    if (outcome == Outcome::solved) impulses_ = gamma_;
    anchor_ = impulses_;
    const double residual = judge(anchor_);
    // The first round's is better than the start, whatever its residual, where that was for other
    // velocities.
    const bool is_new = is_first && left >= kHolds;
    if (is_new || residual < report_.residual) report_.residual = residual, best_ = anchor_;
    if (outcome == Outcome::spent || report_.residual <= tolerance) break;
    // A proven contradiction ends the rounds; otherwise the softness decreases.
    const bool is_stuck = !is_first && !(residual <= kStuck * last);
    if (proves_contradiction(anchor_, kNoWayOut)) {
      report_.is_certain = soften(tolerance, true, budget, 0);
      break;
    }
    if (is_stuck && softness_ <= hardest_) break;
    is_first = false;
    const bool is_kept =
        is_far_of_many && report_.newton_steps - steps_before > kCheapSteps && residual <= kStuck * last;
    const double next = is_kept ? softness_ : rounds.harder * softness_;
    set_softness(std::max(is_stuck ? hardest_ : std::min(kSoftness, softness_), next));
    last = std::min(last, residual);
  }
  report_.converged = report_.residual <= tolerance;
  std::copy(best_.begin(), best_.end(), x.begin());
  return report_;
}

}  // namespace touchstone::physics
