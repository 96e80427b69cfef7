#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/vector.hpp"
#include "touchstone/physics/solver/block_cholesky.hpp"
#include "touchstone/physics/solver/body_contact.hpp"
#include "touchstone/physics/solver/contact_problem.hpp"
#include "touchstone/physics/solver/fixed_point_mixing.hpp"
#include "touchstone/physics/solver/work_budget.hpp"

/// @file
/// Contact problems of any size in the velocities of what they move.

namespace touchstone::physics {

/// A ContactProblem written out: W = J M^-1 J^T in its parts.
struct SparseContacts {
  /// Of what it moves: one unit or two different ones.
  struct Row {
    std::uint32_t units[2];
    std::size_t first[2];  ///< of its part in J and Y
    int count;
  };
  /// Of a contact between bodies: its rows of J are a direction, and the lever's product with it; they need
  /// not be written out.
  struct Levers {
    bool are_of_bodies = false;
    Vector3 of[2] = {Vector3::Zero(), Vector3::Zero()};  ///< by unit of the row
    Vector3 directions[3] = {Vector3::Zero(), Vector3::Zero(),
                             Vector3::Zero()};  ///< as the first unit's rows have them
  };

  /// A unit as a body; mass 0: it is none.
  struct Body {
    double mass;
    Matrix3 inverse_inertia_W;
  };

  std::span<const std::uint32_t> sizes;  ///< rates of each unit
  std::span<const double> masses;        ///< of each unit, size x size, one after the other
  std::size_t contacts = 0;
  std::span<const double> friction;
  std::span<const ContactProblem::Bounds> bounds;
  std::span<const Row> rows;  ///< 3 a contact, 1 a joint row
  std::span<const double> J;
  std::span<const double> Y;  ///< M^-1 J^T, by row
  std::span<const double> b;
  /// One a joint row, >= 0: u = W x + b + compliance x, as of drives with a stiffness. Empty: all 0.
  std::span<const double> compliance = {};
  std::span<const Levers> levers = {};  ///< by contact, so that less is multiplied. Empty: not known
  std::span<const Body> bodies = {};    ///< by unit, as levers
  /// By block: what b of a contact's normal or a joint row would be if all units stood still. What moves as
  /// commanded is in it, and room. Empty: nothing is commanded, so that standing still is a solution.
  std::span<const double> commanded = {};
  /// Nothing of it moves, but for what gravity made in the last steps. Impulses that hold it are worth their
  /// Newton steps, however many its contacts are: found once, they hold it in the steps that follow.
  bool is_resting = false;

  double compliance_of(std::size_t joint) const { return compliance.empty() ? 0.0 : compliance[joint]; }
};

/// How a solve went.
struct ConvexReport {
  double residual = 0.0;  ///< natural_residual() of what is returned, or a little more [m/s]
  int newton_steps = 0;
  bool converged = false;
  /// No impulses satisfy all contacts; the result is the soft answer, which yields as little as it can.
  bool is_contradictory = false;
  /// That was proven during the solve: impulses press against commands and move nothing (Farkas). True alone
  /// where the work ended before the soft answer was found.
  bool is_certain = false;
  /// The result is a soft answer that did not come to its end: of a contradiction nothing new is known.
  bool is_undecided = false;
};

/// Solves contact problems by convex ones that always have one solution. Around impulses x_k and for slips s
/// it minimises, in the rates V of what moves, with P the projection on the cone,
///
///     1/2 V^T M V + sum over contacts of R/2 |P(x_k - (J V + b + s n) / R)|^2,
///
/// by Newton's method with exact line search on the sparse M + J^T G J (Castro, Permenter, Han, An
/// Unconstrained Convex Formulation of Compliant Contact, 2022, equations 18 to 26; R a share of each
/// contact's W). The projections are the next x_k (proximal point method, Rockafellar 1976), which takes the
/// softness R out, and s = friction |u_t| the next s, which takes the convex formulation's gliding apart out
/// (Acary, Cadoux, Lemarechal, Malick, A Formulation of the Linear Discrete Coulomb Friction Problem via
/// Convex Optimization, 2011). Where these slips grow from round to round, as under what a wedge lifts along
/// a wall, the rounds' results are mixed (FixedPointMixing). Each of these problems takes energy, whatever
/// x_k and s are, unless x_k itself gives some. Contacts that contradict each other have no x_k to come to:
/// what is returned is then the soft answer around 0. Owns its memory; no allocation while no problem is
/// larger than reserved for or seen.
class ConvexContacts {
 public:
  /// When the soft answer is tried, of contacts that may contradict each other.
  enum class Softness : std::uint8_t {
    last,   ///< where others prove the contradiction
    maybe,  ///< first, and taken where it proves the contradiction itself
    first,  ///< first: a contradiction was proven recently; kept while the residual speeds confirm it
  };
  void reserve(std::size_t units, std::size_t rows, std::size_t widest);
  /// @param x in: to start from; out: the best found. @param tolerance of the residual [m/s].
  /// @param soft when the soft answer is tried. @param most_soft_steps Newton steps of one that comes first,
  /// which is then the answer, whatever it proves; 0: other answers follow one that proves nothing.
  ConvexReport solve(const SparseContacts& problem, std::span<double> x, double tolerance, WorkBudget& budget,
                     Softness soft = Softness::last, int most_soft_steps = 0);
  /// The soft answer around 0 alone, as far as the budget and the number of Newton steps go: it yields to
  /// contradictions by no more than kSoftAnswer of each contact's W.
  /// @param x in: where to start from; out. @param tolerance of the velocities [m/s].
  /// @param carries_loads whether it is harder by the spread of masses, so that a light body yields to a
  /// heavy one's weight no faster than alike ones do; it takes more Newton steps then.
  ConvexReport solve_softly(const SparseContacts& problem, std::span<double> x, double tolerance,
                            WorkBudget& budget, int most_steps, bool carries_loads = false);

  /// The softness R of contacts that contradict each other, beside their own W, of alike masses.
  static constexpr double kSoftAnswer = 1e-3;

 private:
  enum class Outcome : std::uint8_t { solved, spent, stuck };
  /// The largest and least part that a side of a contact or joint has of a diagonal entry of W.
  struct Entries {
    double most, least;
  };

  /// Rounds that are mixed: on from the first that leads away.
  struct Mixing {
    bool is_on = false;
    double least = 0.0;  // residual so far [m/s]
    int idle = 0;        // rounds since the last that left much less
  };

  void load(const SparseContacts& problem, std::span<const double> x);
  void find_body_contacts();
  void place_others();
  void add_lane(std::size_t contact);
  void find_scales();
  static double spread_of(const Entries& entries);
  double entry_of(const SparseContacts::Row& row, int side) const;
  Entries with_others(Entries entries);
  Entries with_joints(Entries entries);
  void find_pairs();
  Outcome minimise(double tolerance, WorkBudget& budget, int most_steps);
  void add(const SparseContacts::Row& row, std::span<const double> of, double factor,
           std::vector<double>& to) const;
  double product(const SparseContacts::Row& row, std::span<const double> of, const std::vector<double>& with,
                 double start) const;
  void spread(std::span<const double> impulses, std::vector<double>& V) const;
  void find_velocities(const std::vector<double>& V, std::vector<double>& u, bool with_b) const;
  void set_softness(double softness);
  void project(const std::vector<double>& u);
  void project_others(const std::vector<double>& u);
  void multiply_by_masses(const std::vector<double>& V, std::vector<double>& to) const;
  void find_gradient();
  void assemble();
  bool find_stiffness();
  void find_stiffness_of_others();
  void add_rows(std::size_t first, std::size_t count, const double* G);
  std::size_t add_pair(std::size_t first);
  void divide_by_masses(std::vector<double>& V) const;
  double slope_at(double along, double& curvature) const;
  double line_search();
  void go_along(double along);
  void find_slips();
  double missed();
  double residual_of(std::span<const double> x);
  double residual_of_others(std::span<const double> x);
  double fastest(std::span<const double> of) const;
  bool presses_on_commands() const;
  void press_others(std::span<const double> x, double& pressed, double& fastest_commanded);
  bool proves_contradiction(std::span<const double> x, double times);
  bool take_energy(std::span<double> x, double most_given);
  double judge(std::span<double> x);
  void start();
  void go_on_from(std::span<const double> x);
  void begin_mixing(double softness, Mixing& mixing);
  bool mix(double residual, Mixing& mixing);
  bool soften(double tolerance, bool is_proven, WorkBudget& budget, int most_steps);
  bool softens_first(std::span<const double> x, double tolerance, WorkBudget& budget, Softness first,
                     int most_soft_steps);

  // Places: rows of body_contacts_, by block, direction and lane, then those of others. Figures of contacts
  // and joints: by block and lane, then others.
  std::size_t first_other() const { return BodyContacts::kRows * body_contacts_.size(); }
  std::size_t first_other_contact() const { return BodyContacts::kLanes * body_contacts_.size(); }
  std::size_t joint_place(std::size_t joint) const { return first_other() + 3 * other_contacts_ + joint; }
  std::size_t first_joint() const { return first_other_contact() + other_contacts_; }
  std::size_t first_other_stiffness() const;
  /// Of mechanisms and joints: rows that body_contacts_ do not hold, and their places.
  template <class Visit>
  void for_other_rows(const Visit& visit) const {
    for (std::size_t i = 0; i < other_rows_.size(); ++i) visit(other_rows_[i], first_other() + i);
  }

  SparseContacts problem_;
  std::vector<BodyContacts> body_contacts_;
  std::vector<std::size_t> place_;       // by row
  std::vector<std::size_t> other_rows_;  // of contacts that body_contacts_ do not hold, then of joints
  std::size_t other_contacts_ = 0;
  BlockCholesky cholesky_;
  std::vector<BlockCholesky::Pair> pairs_;
  std::vector<std::size_t> first_, first_mass_;  // by unit
  std::vector<double> scale_, hardness_;         // of each contact or joint: w, 1 / R where R = softness w
  std::vector<double> friction_, commanded_;     // likewise
  std::vector<double> anchor_share_;  // by joint row: of the anchor that its projection starts from
  FixedPointMixing mixing_;
  std::vector<double> mixed_from_;      // the anchor that the mixed round began with
  std::vector<double> slip_;            // s, by contact
  std::vector<double> b_;               // by place, as what follows
  std::vector<double> anchor_, gamma_;  // x_k and the projections
  std::vector<double> asked_;           // what is projected
  std::vector<double> impulses_;        // that give V_: gamma_ in the end
  std::vector<double> u_, du_, best_;
  std::vector<double> V_, step_, gradient_, trial_V_;  // by rate
  std::vector<double> reach_;                          // by rate: the most that it moves any row by
  std::vector<double> blocks_;                         // G J of the rows being added
  std::vector<double> stiffness_, last_stiffness_;     // G: by body_contacts_, contact, joint
  bool is_factored_ = false;                           // with the last stiffness
  double softness_ = 0.0;
  double hardest_ = 0.0;      // softness that rounds may come to
  double soft_answer_ = 0.0;  // softness of the soft answer
  double price_ = 1.0;        // of work: masses that differ take more rounds
  ConvexReport report_;
};

}  // namespace touchstone::physics
