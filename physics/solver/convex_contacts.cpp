#include "touchstone/physics/solver/convex_contacts.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/physics/solver/cone_lanes.hpp"
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
// them and finds the slips no better. Of what rests they do: left unfinished, its slips go on as a creep.
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
// The most by which softness falls for it, far above the rounding of impulses. A side of a contact that has
// no more than 1 / kMostSpread of the largest entry of W cannot move there.
constexpr double kMostSpread = 1e9;
// Impulses prove a contradiction where commands could only be met at kNoWayOut times their speed: a
// wedge of one in fifty is pressed out, a narrower one is held. Where that was proven lately, a few times do.
constexpr double kNoWayOut = 50.0, kNoWayOutStill = 3.0;
// A start from the last step may give this share of the energy that it moves: a tenth too much of what
// rests.
constexpr double kStale = -0.4;
// A round that leaves more than this share of the residual of the one before brings nothing.
constexpr double kStuck = 0.7;
// Mixed rounds end after so many that did not get below kStuck of the least residual: with three results a
// mix is whole.
constexpr int kMostIdleMixes = 4;

}  // namespace

void ConvexContacts::reserve(std::size_t units, std::size_t rows, std::size_t widest) {
  cholesky_.reserve(units, rows, widest);
  reserve_written(pairs_, rows);
  // Of contacts in lanes: each may be alone in its block.
  const std::size_t contacts = rows / 3, places = BodyContacts::kRows * contacts;
  reserve_written(body_contacts_, contacts);
  for (auto* vector : {&first_, &first_mass_}) reserve_written(*vector, units + 1);
  for (auto* vector : {&place_, &other_rows_}) reserve_written(*vector, rows);
  for (auto* vector : {&scale_, &hardness_, &slip_, &friction_, &commanded_})
    reserve_written(*vector, BodyContacts::kLanes * contacts + rows, 2 * rows);
  reserve_written(anchor_share_, rows);
  const std::size_t mixed = BodyContacts::kRows * std::min(contacts, kFew) + rows;
  mixing_.reserve(mixed);
  reserve_written(mixed_from_, mixed);
  for (auto* vector : {&b_, &anchor_, &asked_, &gamma_, &impulses_, &u_, &du_, &best_})
    reserve_written(*vector, places + rows, 2 * rows);
  for (auto* vector : {&V_, &step_, &gradient_, &trial_V_}) reserve_written(*vector, units * widest);
  reserve_written(reach_, units * widest);
  reserve_written(blocks_, 6 * widest);
  for (auto* vector : {&stiffness_, &last_stiffness_})
    reserve_written(*vector, kStiffnessLanes * contacts + 3 * rows, 3 * rows);
}

/// w: the largest diagonal entry of W of each contact or joint; and the least softness, by the spread of
/// masses.
void ConvexContacts::find_scales() {
  scale_.assign(first_joint() + problem_.bounds.size(), 0.0);
  // Entries of bodies' contacts, and the most and least of a side's inverse mass.
  Four most_of = in_all(0.0), least_of = in_all(kInfinity);
  for (std::size_t i = 0; i < body_contacts_.size(); ++i) {
    const BodyContacts& contacts = body_contacts_[i];
    Four scale = in_all(0.0);
    for (const auto& direction : contacts.directions) {
      const FourVectors d = vectors_at(direction);
      Four entry = in_all(0.0);
      for (int side = 0; side < contacts.count; ++side) {
        const SparseContacts::Body& body = problem_.bodies[contacts.units[side]];
        const FourVectors turn = cross(vectors_at(contacts.levers[side]), d);
        const Four part = dot(d, d) / in_all(body.mass) + dot(turn, rotated(body.inverse_inertia_W, turn));
        entry += part;
        most_of = select(most_of < part, part, most_of);
        least_of = select((in_all(0.0) < part) & (part < least_of), part, least_of);
      }
      scale = select(scale < entry, entry, scale);
    }
    put(scale, &scale_[BodyContacts::kLanes * i]);
  }
  const Entries of_contacts = with_others({largest_of(most_of), -largest_of(-least_of)});
  const Entries of_all = with_joints(of_contacts);
  soft_answer_ = kSoftAnswer / spread_of(of_contacts);
  hardest_ = kSoftness / spread_of(of_all);
  price_ = 1.0 / (1.0 + std::ilogb(spread_of(of_all)) / kRoundBits);  // the same bits from every C library
}

/// A contact's W is that of its lighter side, which may carry the heaviest body: as soft as for alike masses,
/// it would yield to that one's weight by g h times kSoftAnswer times the masses' ratio.
double ConvexContacts::spread_of(const Entries& entries) {
  return entries.most > 0.0 ? std::clamp(kAlike * entries.most / entries.least, 1.0, kMostSpread) : 1.0;
}

/// A side's part of a diagonal entry of W.
double ConvexContacts::entry_of(const SparseContacts::Row& row, int side) const {
  double entry = 0.0;
  for (std::size_t k = 0; k < problem_.sizes[row.units[side]]; ++k)
    entry += problem_.J[row.first[side] + k] * problem_.Y[row.first[side] + k];
  return entry;
}

/// With those of mechanisms' contacts, which set their scales. A side's entry is its largest in any
/// direction: a link has rounding alone along its hinge's axis, and in all directions on it, which then does
/// not count.
ConvexContacts::Entries ConvexContacts::with_others(Entries entries) {
  const auto for_sides = [&](const auto& visit) {
    for (std::size_t i = 0; i < other_contacts_; ++i) {
      const std::size_t* const rows = &other_rows_[3 * i];
      for (int side = 0; side < problem_.rows[rows[0]].count; ++side) {
        double largest = 0.0;
        for (int d = 0; d < 3; ++d) largest = std::max(largest, entry_of(problem_.rows[rows[d]], side));
        visit(largest);
      }
    }
  };
  for (std::size_t i = 0; i < 3 * other_contacts_; ++i) {
    const SparseContacts::Row& row = problem_.rows[other_rows_[i]];
    double sum = 0.0, &scale = scale_[first_other_contact() + i / 3];
    for (int side = 0; side < row.count; ++side) sum += entry_of(row, side);
    scale = std::max(scale, sum);
  }
  for_sides([&](double entry) { entries.most = std::max(entries.most, entry); });
  for_sides([&](double entry) {
    if (entry > entries.most / kMostSpread) entries.least = std::min(entries.least, entry);
  });
  return entries;
}

/// With those of joint rows, which set their scales.
ConvexContacts::Entries ConvexContacts::with_joints(Entries entries) {
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const SparseContacts::Row& row = problem_.rows[3 * problem_.contacts + j];
    double sum = 0.0;
    for (int side = 0; side < row.count; ++side) {
      const double entry = entry_of(row, side);
      sum += entry;
      entries.most = std::max(entries.most, entry);
      if (entry > 0.0) entries.least = std::min(entries.least, entry);
    }
    scale_[first_joint() + j] = sum;
  }
  return entries;
}

void ConvexContacts::find_pairs() {
  pairs_.clear();
  const auto add = [&](const std::uint32_t* units, int count) {
    if (count < 2) return;
    const auto [a, b] = std::minmax(units[0], units[1]);
    if (pairs_.empty() || pairs_.back() != BlockCholesky::Pair(a, b)) pairs_.emplace_back(a, b);
  };
  for (const BodyContacts& contacts : body_contacts_) add(contacts.units, contacts.count);
  for (const std::size_t row : other_rows_) add(problem_.rows[row].units, problem_.rows[row].count);
  std::sort(pairs_.begin(), pairs_.end());
  pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
  cholesky_.analyse(problem_.sizes, pairs_);
}

/// Takes a contact up among those of the same bodies before it.
void ConvexContacts::add_lane(std::size_t contact) {
  const SparseContacts::Row& row = problem_.rows[3 * contact];
  const SparseContacts::Levers& levers = problem_.levers[contact];
  const auto is_of = [&](const BodyContacts& last) {
    return last.contacts < BodyContacts::kLanes && last.count == row.count && last.units[0] == row.units[0] &&
           (row.count < 2 || last.units[1] == row.units[1]);
  };
  // The first of its bodies, or the fifth of them, begins a block.
  if (body_contacts_.empty() || !is_of(body_contacts_.back())) {
    BodyContacts& added = body_contacts_.emplace_back();
    added.count = row.count;
    for (int side = 0; side < row.count; ++side)
      added.units[side] = row.units[side], added.first[side] = first_[row.units[side]];
    friction_.resize(first_other_contact(), 0.0);
    commanded_.resize(first_other_contact(), 0.0);
  }
  BodyContacts& contacts = body_contacts_.back();
  const std::size_t lane = contacts.contacts++, block = body_contacts_.size() - 1;
  // Its directions and levers, and where its rows and figures are.
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<int>(i);
    for (int d = 0; d < 3; ++d) contacts.directions[d][i][lane] = levers.directions[d][k];
    for (int side = 0; side < row.count; ++side) contacts.levers[side][i][lane] = levers.of[side][k];
    place_[3 * contact + i] = BodyContacts::kRows * block + BodyContacts::kLanes * i + lane;
  }
  friction_[BodyContacts::kLanes * block + lane] = problem_.friction[contact];
  if (!problem_.commanded.empty())
    commanded_[BodyContacts::kLanes * block + lane] = problem_.commanded[contact];
}

/// The contacts between bodies, side by side.
void ConvexContacts::find_body_contacts() {
  body_contacts_.clear();
  other_rows_.clear();
  friction_.clear();
  commanded_.clear();
  place_.resize(problem_.rows.size());
  for (std::size_t c = 0; c < problem_.contacts; ++c) {
    const bool is_of_bodies = !problem_.levers.empty() && !problem_.bodies.empty() &&
                              problem_.levers[c].are_of_bodies && problem_.rows[3 * c].count > 0;
    if (is_of_bodies)
      add_lane(c);
    else
      for (std::size_t r = 3 * c; r < 3 * c + 3; ++r) other_rows_.push_back(r);
  }
  place_others();
}

/// Contacts that are not between bodies, then joint rows.
void ConvexContacts::place_others() {
  other_contacts_ = other_rows_.size() / 3;
  for (std::size_t r = 3 * problem_.contacts; r < problem_.rows.size(); ++r) other_rows_.push_back(r);
  for_other_rows([&](std::size_t row, std::size_t place) {
    place_[row] = place;
    const bool is_contact = row < 3 * problem_.contacts;
    if (is_contact && row % 3 != 0) return;
    const std::size_t block = is_contact ? row / 3 : row - 2 * problem_.contacts;
    friction_.push_back(is_contact ? problem_.friction[block] : 0.0);
    commanded_.push_back(problem_.commanded.empty() ? 0.0 : problem_.commanded[block]);
  });
}

std::size_t ConvexContacts::first_other_stiffness() const { return kStiffnessLanes * body_contacts_.size(); }

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
  find_body_contacts();
  const std::size_t places = first_other() + other_rows_.size();
  for (auto* vector : {&asked_, &gamma_, &impulses_, &u_, &du_, &best_}) vector->resize(places);
  for (auto* vector : {&V_, &step_, &gradient_, &trial_V_}) vector->resize(rates);
  blocks_.resize(6 * widest);
  slip_.resize(first_joint());
  for (auto* vector : {&anchor_, &b_}) vector->assign(places, 0.0);
  for (std::size_t r = 0; r < place_.size(); ++r) anchor_[place_[r]] = x[r], b_[place_[r]] = problem.b[r];
  is_factored_ = false;
  find_scales();
  find_pairs();
}

/// The natural residual, by the rates that x gives; u_ are the velocities.
double ConvexContacts::residual_of(std::span<const double> x) {
  spread(x, trial_V_);
  find_velocities(trial_V_, u_, true);
  Four worst = in_all(0.0);
  for (std::size_t i = 0; i < body_contacts_.size(); ++i) {
    const std::size_t first = BodyContacts::kRows * i, contact = BodyContacts::kLanes * i;
    const Four w = four_at(&scale_[contact]);
    const Four residual =
        contact_residuals(w, four_at(&friction_[contact]), lanes_at(&x[first]), lanes_at(&u_[first]));
    worst = worse_of(worst, select(in_all(0.0) < w, residual, in_all(0.0)));
  }
  return worse_of(worst_of(worst), residual_of_others(x));
}

double ConvexContacts::residual_of_others(std::span<const double> x) {
  double worst = 0.0;
  for (std::size_t i = 0; i < other_contacts_; ++i) {
    const std::size_t contact = first_other_contact() + i, place = first_other() + 3 * i;
    if (scale_[contact] > 0.0)
      worst = worse_of(worst, contact_residual(scale_[contact], friction_[contact], &x[place], &u_[place]));
  }
  for (std::size_t j = 0; j < problem_.bounds.size(); ++j) {
    const std::size_t r = joint_place(j);
    const double compliance = problem_.compliance_of(j), w = scale_[first_joint() + j] + compliance;
    u_[r] += compliance * x[r];
    if (w > 0.0) worst = worse_of(worst, w * std::abs(x[r] - clamped(x[r] - u_[r] / w, problem_.bounds[j])));
  }
  return worst;
}

/// Of velocities by place.
double ConvexContacts::fastest(std::span<const double> of) const {
  Four most = in_all(0.0);
  for (std::size_t i = 0; i < first_other(); i += BodyContacts::kLanes)
    most = worse_of(most, magnitude(four_at(&of[i])));
  double speed = worst_of(most);
  for (const double v : of.subspan(first_other())) speed = worse_of(speed, std::abs(v));
  return speed;
}

/// Of the velocities u_.
void ConvexContacts::find_slips() {
  for (std::size_t i = 0; i < body_contacts_.size(); ++i) {
    const ContactLanes u = lanes_at(&u_[BodyContacts::kRows * i]);
    const std::size_t contact = BodyContacts::kLanes * i;
    put(four_at(&friction_[contact]) * square_root(u.t1 * u.t1 + u.t2 * u.t2), &slip_[contact]);
  }
  for (std::size_t i = 0; i < other_contacts_; ++i) {
    const std::size_t contact = first_other_contact() + i, place = first_other() + 3 * i;
    slip_[contact] = friction_[contact] * length_of(u_[place + 1], u_[place + 2]);
  }
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
  for (std::size_t i = 0; i < body_contacts_.size(); ++i) {
    const BodyContacts& contacts = body_contacts_[i];
    const ContactLanes impulses = lanes_at(&x[BodyContacts::kRows * i]);
    const Four commanded = four_at(&commanded_[BodyContacts::kLanes * i]);
    pressed -= sum_of(impulses.n * commanded);
    fastest_commanded = std::max(fastest_commanded, largest_of(-commanded));
    add_impulses(contacts, impulses, 1.0, y.data());
    raise_reach(contacts, reach_.data());
  }
  press_others(x, pressed, fastest_commanded);
  // Impulses that press much and move little are the proof.
  double moved = 0.0;
  for (std::size_t k = 0; k < y.size(); ++k)
    if (reach_[k] > 0.0) moved += std::abs(y[k]) / reach_[k];
  return pressed > times * fastest_commanded * moved;
}

/// proves_contradiction() of the other rows.
void ConvexContacts::press_others(std::span<const double> x, double& pressed, double& fastest_commanded) {
  for_other_rows([&](std::size_t r, std::size_t place) {
    const bool is_contact = r < 3 * problem_.contacts;
    const std::size_t block = is_contact ? r / 3 : r - 2 * problem_.contacts;
    if (!is_contact) {  // a row that is bounded or compliant is no direction
      const std::size_t j = r - 3 * problem_.contacts;
      const double end = x[place] > 0.0 ? problem_.bounds[j].upper : problem_.bounds[j].lower;
      if (std::isfinite(end) || problem_.compliance_of(j) > 0.0) return;
    }
    // Normals and joint rows press against commanded velocities.
    if (!is_contact || r % 3 == 0) {
      const double commanded = problem_.commanded[block];
      pressed -= x[place] * commanded;
      fastest_commanded = std::max(fastest_commanded, is_contact ? -commanded : std::abs(commanded));
    }
    const SparseContacts::Row& row = problem_.rows[r];
    if (x[place] != 0.0) add(row, problem_.J, x[place], trial_V_);
    for (int i = 0; i < row.count; ++i)
      for (std::size_t k = 0; k < problem_.sizes[row.units[i]]; ++k) {
        double& reach = reach_[first_[row.units[i]] + k];
        reach = std::max(reach, std::abs(problem_.J[row.first[i] + k]));
      }
  });
}

/// Impulses x with u_ = W x + b give the energy x (u + b) / 2. Where that is more than `most_given` of what
/// they move, as unsolved ones may, the share of them that takes most is left: -x b / x W x.
/// @return whether x is another now.
bool ConvexContacts::take_energy(std::span<double> x, double most_given) {
  double by_b = 0.0, by_W = 0.0;
  for (std::size_t r = 0; r < x.size(); ++r) {
    by_b += x[r] * b_[r];
    by_W += x[r] * (u_[r] - b_[r]);
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
  set_softness(soft_answer_);
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
                                          double tolerance, WorkBudget& budget, int most_steps,
                                          bool carries_loads) {
  load(problem, x);
  set_softness(carries_loads ? soft_answer_ : kSoftAnswer);
  start();
  for (auto* vector : {&anchor_, &slip_}) std::fill(vector->begin(), vector->end(), 0.0);
  const Outcome outcome = minimise(tolerance, budget, most_steps);
  report_.converged = outcome == Outcome::solved;
  // The start may be far off: without a step from it nothing is known of it.
  if (outcome == Outcome::stuck) std::fill(impulses_.begin(), impulses_.end(), 0.0);
  for (std::size_t r = 0; r < place_.size(); ++r) x[r] = impulses_[place_[r]];
  return report_;
}

/// Starts from impulses that held in a step of other velocities, scaled so that they take most energy.
void ConvexContacts::start() {
  report_.residual = residual_of(anchor_);
  if (take_energy(anchor_, kStale)) report_.residual = residual_of(anchor_);
  best_ = impulses_ = anchor_;
  V_ = trial_V_;
}

/// The next round is about impulses x.
void ConvexContacts::go_on_from(std::span<const double> x) {
  std::copy(x.begin(), x.end(), impulses_.begin());
  residual_of(impulses_);
  anchor_ = impulses_;
  V_ = trial_V_;
}

/// From the best so far, softer: the last round led away from it.
void ConvexContacts::begin_mixing(double softness, Mixing& mixing) {
  mixing = {true, report_.residual, 0};
  mixing_.restart();
  go_on_from(best_);
  set_softness(softness);
}

/// The next round's start, of the results of this and the ones before. @return whether another is worth it.
bool ConvexContacts::mix(double residual, Mixing& mixing) {
  mixing.idle = residual <= kStuck * mixing.least ? 0 : mixing.idle + 1;
  mixing.least = std::min(mixing.least, residual);
  if (mixing.idle == kMostIdleMixes) return false;
  mixing_.mix(mixed_from_, anchor_);
  go_on_from(anchor_);
  return true;
}

/// Of contacts that may contradict each other. @return whether that is the best answer. Else rounds are to go
/// on: without contradiction x serves better than the soft answer; with it, that goes on to grow.
bool ConvexContacts::softens_first(std::span<const double> x, double tolerance, WorkBudget& budget,
                                   Softness first, int most_soft_steps) {
  if (first == Softness::last || !presses_on_commands()) return false;
  find_slips();
  if (soften(tolerance, first == Softness::first, budget, most_soft_steps)) return true;
  if (first == Softness::first) {
    for (std::size_t r = 0; r < place_.size(); ++r) anchor_[place_[r]] = x[r];
    start();
  }
  return false;
}

ConvexReport ConvexContacts::solve(const SparseContacts& problem, std::span<double> x, double tolerance,
                                   WorkBudget& budget, Softness first, int most_soft_steps) {
  load(problem, x);
  start();
  // The less the start leaves, the less soft the first round is.
  double last = report_.residual;
  const double left = last > 0.0 ? last / std::max(fastest(b_), last) : 0.0;
  const bool is_far_of_many = !(left < kFar) && problem.contacts > kFew && !problem.is_resting;
  const Rounds& rounds = is_far_of_many ? kFromFarOfMany : left < kFar ? kFromRest : kFromFar;
  const double first_softness = std::clamp(rounds.softness * (left / kHolds), kSoftness, rounds.softness);
  bool is_first = true;
  bool is_over = report_.residual <= tolerance;
  // The soft answer comes first where a contradiction is likely.
  if (!is_over) is_over = softens_first(x, tolerance, budget, first, most_soft_steps);
  if (!is_over) set_softness(first == Softness::maybe ? rounds.harder * soft_answer_ : first_softness);
  // Each round minimises the softened potential about the impulses of the one before.
  const bool is_bounded = budget.left() < WorkBudget::kNoEnd;
  // Of few contacts of alike masses that something commanded presses, slips that grow are mixed.
  const bool may_mix = problem.contacts <= kFew && hardest_ >= kSoftness && presses_on_commands();
  Mixing mixing;
  const int most_rounds = is_far_of_many && !is_bounded ? kMostKeptRounds : kMostRounds;
  for (int round = 0; round < most_rounds && !is_over; ++round) {
    find_slips();
    if (mixing.is_on) mixed_from_ = anchor_;
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
    if (mixing.is_on && !mix(residual, mixing)) break;
    if (!mixing.is_on && may_mix && !is_first && !(residual <= last))
      begin_mixing(softness_ / rounds.harder, mixing);
    if (mixing.is_on) {
      last = std::min(last, residual);
      continue;
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
  for (std::size_t r = 0; r < place_.size(); ++r) x[r] = best_[place_[r]];
  return report_;
}

}  // namespace touchstone::physics
