#include "touchstone/tests/world/progress/path_finder.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>

#include "touchstone/adapters/exact/exact.hpp"
#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/tests/world/near_spheres.hpp"

namespace touchstone {
namespace {

constexpr int kHalvings = 7;
constexpr int kCorrections = 4;
constexpr int kSweeps = 400;
/// Poses judged on each step, its end among them.
constexpr int kSamples = 3;
/// A step that gains less than this share of its length does not count.
constexpr double kLeastGain = 1e-3;
/// Of finite differences.
constexpr double kDifference = 1e-6;

/// Lower L with J = L L^T: |L^T w|^2 is w . J w.
Matrix3 root_of(const Matrix3& J) {
  Matrix3 L = Matrix3::Zero();
  for (int j = 0; j < 3; ++j)
    for (int i = j; i < 3; ++i) {
      double rest = J(i, j);
      for (int k = 0; k < j; ++k) rest -= L(i, k) * L(j, k);
      L(i, j) = i == j ? std::sqrt(rest) : rest / L(j, j);
    }
  return L;
}

double product(std::span<const double> a, std::span<const double> b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

double length(std::span<const double> a) { return std::sqrt(product(a, a)); }

/// Whether `visit` returns true for every checked pair that may be as close as `within`, by its spheres; it
/// is not asked for more after a false.
template <typename Visit>
bool all_near_pairs(const MoverModel& model, const std::vector<Pose>& X_WS, double within,
                    const Visit& visit) {
  const std::vector<Hexahedron>& solids = model.solids();
  for (SolidIndex a = 0; a < model.own_count(); ++a)
    for (SolidIndex b = a + 1; b < solids.size(); ++b) {
      if (!model.is_checked(a, b)) continue;
      if (!may_be_within(solids[a], X_WS[a], solids[b], X_WS[b], within)) continue;
      if (!visit(SolidPair{a, b})) return false;
    }
  return true;
}

}  // namespace

MoverModel::MoverModel(std::vector<Hexahedron> own, std::vector<Pose> X_OS, std::vector<Hexahedron> obstacles,
                       std::vector<Pose> X_WB)
    : solids_(std::move(own)), fixed_(std::move(X_OS)), own_count_(solids_.size()) {
  MassMoments moments;
  for (std::size_t i = 0; i < own_count_; ++i) moments += transform(fixed_[i], mass_moments(solids_[i]));
  metric_ = mass_metric(moments);
  metric_.J = Matrix3::Identity();  // as a hand holds it by default: a radian weighs as a metre
  solids_.insert(solids_.end(), obstacles.begin(), obstacles.end());
  fixed_.insert(fixed_.end(), X_WB.begin(), X_WB.end());
  find_reach();
}

MoverModel::MoverModel(std::shared_ptr<const Mechanism> arm, const Pose& X_WB,
                       std::vector<Hexahedron> obstacles, std::vector<Pose> X_WO)
    : arm_(std::move(arm)), X_WBase_(X_WB), solids_(arm_->solids()), own_count_(solids_.size()) {
  for (std::uint32_t i = 0; i < own_count_; ++i) fixed_.push_back(arm_->placed(i).X_OS);
  solids_.insert(solids_.end(), obstacles.begin(), obstacles.end());
  fixed_.insert(fixed_.end(), X_WO.begin(), X_WO.end());
  find_reach();
}

void MoverModel::hold(const ArmHandStiffness& hand) {
  hand_ = hand;
  const auto values = static_cast<std::size_t>(size());
  if (hand.joints.empty()) hand_->joints.assign(values, 0.01 * hand.translation.minCoeff());
  // A step's length is at least the root of the least of these times that of the values' change.
  reach_ /= std::sqrt(*std::min_element(hand_->joints.begin(), hand_->joints.end()));
}

Pose MoverModel::tool_pose(const Configuration& at) const {
  std::vector<Pose> X_WL(arm_->links().size());
  arm_->link_poses(X_WBase_, at.q, X_WL);
  return compose(X_WL[arm_->find_link(hand_->link)], hand_->X_LT);
}

void MoverModel::weigh_at(const Configuration& at) {
  if (!hand_) return;
  const Pose X_WT = tool_pose(at);
  const int values = size();
  Eigen::MatrixXd J(6, values);
  for (int k = 0; k < values; ++k) {
    Configuration less = at, more = at;
    less.q[static_cast<std::size_t>(k)] -= kDifference, more.q[static_cast<std::size_t>(k)] += kDifference;
    const Pose X_less = tool_pose(less), X_more = tool_pose(more);
    const Vector3 v = (X_more.p - X_less.p) / (2.0 * kDifference);
    const Vector3 w = RigidPath::between(X_less, X_more).at(0, 0.0).angular_velocity_W / (2.0 * kDifference);
    J.col(k) << rotate_back(X_WT.R, v), rotate_back(X_WT.R, w);
  }
  Eigen::VectorXd stiffness(6);
  stiffness << hand_->translation, hand_->turning;
  Eigen::MatrixXd M = J.transpose() * stiffness.asDiagonal() * J;
  for (int k = 0; k < values; ++k) M(k, k) += hand_->joints[static_cast<std::size_t>(k)];
  root_ = M.llt().matrixL();
}

const Mechanism::Joint* MoverModel::joint_of(std::size_t value) const {
  for (std::size_t j = 0; arm_ && j < arm_->joints().size(); ++j)
    if (arm_->joints()[j].value == value) return &arm_->joints()[j];
  return nullptr;
}

void MoverModel::find_reach() {
  if (!arm_) {
    double furthest = 0.0;
    for (std::size_t i = 0; i < own_count_; ++i) {
      const Sphere& sphere = solids_[i].bounding_sphere();
      furthest =
          std::max(furthest, norm(transform(fixed_[i], sphere.centre) - metric_.centre) + sphere.radius);
    }
    reach_ = 1.0 + furthest / std::sqrt(least_inertia(metric_.J));
    return;
  }
  // Every joint as far from the arm's end as all frames and solids in a row.
  double span = 0.0, widest = 0.0;
  for (const Mechanism::Joint& joint : arm_->joints()) span += norm(joint.X_PJ.p) + norm(joint.X_JC.p);
  for (std::size_t i = 0; i < own_count_; ++i) {
    const Sphere& sphere = solids_[i].bounding_sphere();
    widest = std::max(widest, norm(transform(fixed_[i], sphere.centre)) + sphere.radius);
  }
  reach_ = (span + widest) * std::sqrt(static_cast<double>(size()));
}

bool MoverModel::is_checked(SolidIndex a, SolidIndex b) const {
  if (a >= own_count_ && b >= own_count_) return false;
  if (a >= own_count_ || b >= own_count_) return true;
  return arm_ != nullptr && !arm_->is_exempt(a, b);
}

void MoverModel::place(const Configuration& at, std::vector<Pose>& X_WS) const {
  X_WS = fixed_;
  if (!arm_) {
    for (std::size_t i = 0; i < own_count_; ++i) X_WS[i] = compose(at.X_WO, fixed_[i]);
    return;
  }
  std::vector<Pose> X_WL(arm_->links().size());
  arm_->link_poses(X_WBase_, at.q, X_WL);
  for (std::uint32_t i = 0; i < own_count_; ++i) X_WS[i] = compose(X_WL[arm_->link_of(i)], fixed_[i]);
}

std::vector<double> MoverModel::step_between(const Configuration& from, const Configuration& to) const {
  std::vector<double> out;
  if (arm_) {
    for (std::size_t k = 0; k < from.q.size(); ++k) out.push_back(to.q[k] - from.q[k]);
    if (hand_)
      Eigen::Map<Eigen::VectorXd>(out.data(), size()) =
          root_.transpose() * Eigen::VectorXd::Map(out.data(), size());
    return out;
  }
  const Vector3 v = transform(to.X_WO, metric_.centre) - transform(from.X_WO, metric_.centre);
  const Vector3 w = RigidPath::between(from.X_WO, to.X_WO).at(0, 0.0).angular_velocity_W;
  const Matrix3 L = root_of(turned(from.X_WO.R, metric_.J));
  for (int i = 0; i < 3; ++i) out.push_back(v[i]);
  for (int i = 0; i < 3; ++i) out.push_back(L(0, i) * w[0] + L(1, i) * w[1] + L(2, i) * w[2]);
  return out;
}

Configuration MoverModel::moved(const Configuration& from, std::span<const double> by) const {
  Configuration out = from;
  if (arm_) {
    Eigen::VectorXd change = Eigen::VectorXd::Map(by.data(), size());
    if (hand_) root_.transpose().triangularView<Eigen::Upper>().solveInPlace(change);
    for (std::size_t k = 0; k < by.size(); ++k) out.q[k] += change[static_cast<Eigen::Index>(k)];
    return out;
  }
  const Matrix3 L = root_of(turned(from.X_WO.R, metric_.J));
  Vector3 w;
  for (int i = 2; i >= 0; --i) {
    double rest = by[3 + i];
    for (int k = i + 1; k < 3; ++k) rest -= L(k, i) * w[k];
    w[i] = rest / L(i, i);
  }
  out.X_WO = RigidPath::by(from.X_WO, {by[0], by[1], by[2]}, w, metric_.centre).to();
  return out;
}

double MoverModel::distance(const Configuration& from, const Configuration& to) const {
  return length(step_between(from, to));
}

struct PathFinder::Judge {
  std::unique_ptr<Narrowphase> exact, native;
  std::unique_ptr<Narrowphase::Workspace> of_exact, of_native;
};

PathFinder::PathFinder(const MoverModel& model, double gap)
    : model_(model), gap_(gap), judge_(std::make_unique<Judge>()) {
  BackendRegistry registry;
  register_core(registry);
  register_exact(registry);
  judge_->exact = registry.make_narrowphase("exact"), judge_->native = registry.make_narrowphase("native");
  judge_->exact->build(model.solids()), judge_->native->build(model.solids());
  judge_->of_exact = judge_->exact->make_workspace(), judge_->of_native = judge_->native->make_workspace();
}

PathFinder::~PathFinder() = default;

/// At X_WS_.
bool PathFinder::are_apart() {
  return all_near_pairs(model_, X_WS_, 0.0, [&](const SolidPair& pair) {
    PairStatus status{};
    PairGeometry geometry{};
    judge_->exact->evaluate({{&pair, 1}, X_WS_, Query{}}, {{&status, 1}, {&geometry, 1}, {}},
                            *judge_->of_exact);
    return status == PairStatus::separated;
  });
}

bool PathFinder::is_apart(const Configuration& at) {
  model_.place(at, X_WS_);
  return are_apart();
}

void PathFinder::find_rows(const Configuration& at, double band) {
  rows_.clear();
  model_.place(at, X_WS_);
  Query query;
  query.kind = QueryKind::manifold;
  query.max_separation = query.max_point_separation = band;
  all_near_pairs(model_, X_WS_, band, [&](const SolidPair& pair) {
    PairStatus status{};
    PairGeometry geometry{};
    std::array<ContactPoint, kMaxManifoldPoints> points;
    judge_->native->evaluate({{&pair, 1}, X_WS_, query}, {{&status, 1}, {&geometry, 1}, points},
                             *judge_->of_native);
    if (!(geometry.separation <= band)) return true;
    for (int i = 0; i < geometry.point_count; ++i)
      rows_.push_back({pair.a, pair.b, -geometry.n_AB_W, transform(inverse(X_WS_[pair.a]), points[i].p_A_W),
                       transform(inverse(X_WS_[pair.b]), points[i].p_B_W), points[i].separation});
    return true;
  });
}

/// At X_WS_, to first order in how far that is from where the row was found.
double PathFinder::height(const Row& row) const {
  return dot(row.n, transform(X_WS_[row.mover], row.p_M) - transform(X_WS_[row.other], row.p_O));
}

/// min |step - wanted| so that gradients . step >= lacking: Gauss-Seidel on the multipliers.
void PathFinder::solve(std::span<const double> wanted, std::span<const double> lacking,
                       std::vector<double>& step) const {
  step.assign(wanted.begin(), wanted.end());
  std::vector<double> multiplier(lacking.size(), 0.0);
  const double enough = 1e-13 * length(wanted);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double most = 0.0;
    for (std::size_t i = 0; i < lacking.size(); ++i) {
      const std::vector<double>& g = gradients_[i];
      const double square = product(g, g);
      if (!(square > 0.0)) continue;
      const double change = std::max((lacking[i] - product(g, step)) / square, -multiplier[i]);
      multiplier[i] += change;
      for (std::size_t k = 0; k < step.size(); ++k) step[k] += change * g[k];
      most = std::max(most, std::abs(change) * std::sqrt(square));
    }
    if (most <= enough) return;
  }
}

bool PathFinder::path_is_apart(const Configuration& from, std::span<const double> by) {
  std::vector<double> part(by.size());
  for (int i = kSamples; i >= 1; --i) {
    for (std::size_t k = 0; k < by.size(); ++k) part[k] = by[k] * i / kSamples;
    if (!is_apart(model_.moved(from, part))) return false;
  }
  return true;
}

/// Within this rows may hold a step. Held by a tool an arm could swing far aside where the tool does not
/// move: rows are found as far as the wanted step goes four times over; `exact` judges what goes beyond.
double PathFinder::band_of(const Configuration& from, std::span<const double> wanted) {
  const double proven = 2.0 * length(wanted) * model_.reach() + 2.0 * gap_;
  if (!model_.is_held()) return proven;
  model_.place(from, X_WS_);
  std::vector<Pose> X_moved;
  model_.place(model_.moved(from, wanted), X_moved);
  double furthest = 0.0;
  for (std::size_t i = 0; i < model_.own_count(); ++i)
    for (int k = 0; k < Hexahedron::kVertices; ++k) {
      const Vector3& p = model_.solids()[i].vertices()[static_cast<std::size_t>(k)];
      furthest = std::max(furthest, norm(transform(X_moved[i], p) - transform(X_WS_[i], p)));
    }
  return std::min(proven, 4.0 * furthest + 2.0 * gap_);
}

/// Of the rows, by central differences.
void PathFinder::find_gradients(const Configuration& at) {
  const auto size = static_cast<std::size_t>(model_.size());
  gradients_.assign(rows_.size(), std::vector<double>(size));
  for (std::size_t k = 0; k < size; ++k) {
    std::vector<double> by(size, 0.0);
    for (const double sign : {1.0, -1.0}) {
      by[k] = sign * kDifference;
      model_.place(model_.moved(at, by), X_WS_);
      for (std::size_t i = 0; i < rows_.size(); ++i)
        gradients_[i][k] += sign * height(rows_[i]) / (2.0 * kDifference);
    }
  }
}

/// Of an arm's values those that end, to either side, and their gradients.
void PathFinder::find_limits(const Configuration& at) {
  limits_.clear();
  const auto size = static_cast<std::size_t>(model_.size());
  for (std::size_t value = 0; value < at.q.size(); ++value) {
    const Mechanism::Joint& joint = *model_.joint_of(value);
    if (joint.lower == -kInfinity && joint.upper == kInfinity) continue;
    std::vector<double> rate(size);
    for (std::size_t k = 0; k < size; ++k) {
      std::vector<double> by(size, 0.0);
      by[k] = 1.0;
      rate[k] = model_.moved(at, by).q[value] - at.q[value];
    }
    limits_.push_back(at.q[value] - joint.lower), gradients_.push_back(rate);
    for (double& component : rate) component = -component;
    limits_.push_back(joint.upper - at.q[value]), gradients_.push_back(rate);
  }
}

bool PathFinder::step_to(const Configuration& from, const Configuration& goal, double longest,
                         Configuration& out) {
  std::vector<double> wanted = model_.step_between(from, goal);
  const double left = length(wanted);
  for (double& component : wanted) component *= std::min(1.0, longest / left);
  find_rows(from, band_of(from, wanted));
  find_gradients(from);
  find_limits(from);
  std::vector<double> lacking(gradients_.size()), step;
  for (std::size_t i = 0; i < limits_.size(); ++i) lacking[rows_.size() + i] = -limits_[i];
  for (int halving = 0; halving <= kHalvings; ++halving) {
    for (std::size_t i = 0; i < rows_.size(); ++i) lacking[i] = 0.75 * gap_ - rows_[i].separation;
    for (int correction = 0; correction < kCorrections; ++correction) {
      solve(wanted, lacking, step);
      // The step's second-order remainder is asked for as well; never less than to first order.
      model_.place(model_.moved(from, step), X_WS_);
      for (std::size_t i = 0; i < rows_.size(); ++i) {
        const double missed = rows_[i].separation + product(gradients_[i], step) - height(rows_[i]);
        lacking[i] = 0.75 * gap_ - rows_[i].separation + std::max(missed, 0.0);
      }
    }
    out = model_.moved(from, step);
    const double gain = left - model_.distance(out, goal);
    if (gain >= kLeastGain * length(wanted) && path_is_apart(from, step)) return true;
    for (double& component : wanted) component *= 0.5;
  }
  return false;
}

double PathFinder::reached(const Configuration& from, const Configuration& goal, int steps) {
  Configuration at = from, next;
  const double start = model_.distance(from, goal), longest = start / steps;
  for (int i = 0; i < 2 * steps && step_to(at, goal, longest, next); ++i) at = next;
  return std::min(start, model_.distance(at, goal));
}

double PathFinder::clear_until(const MotionPath& path, int samples) {
  for (int i = 1; i <= samples; ++i) {
    const double s = static_cast<double>(i) / samples;
    Configuration at;
    at.X_WO = path.at(0, s).X_WO;
    if (!is_apart(at)) return static_cast<double>(i - 1) / samples;
  }
  return 1.0;
}

}  // namespace touchstone
