#pragma once

#include <Eigen/Core>

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "touchstone/contact_core/mechanism/mechanism.hpp"
#include "touchstone/contact_core/motion/mass_metric.hpp"
#include "touchstone/contact_core/motion/path.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"

// How far a mover could come towards where it is commanded to go: found in small steps by other means than
// the world's slides (finite differences for rates, a projected Gauss-Seidel for the closest step, sampled
// poses judged by `exact`), so that a world that stands still where it could go on is found out.

namespace touchstone {

/// Joint values of an arm, or the pose of one rigid body.
struct Configuration {
  std::vector<double> q;
  Pose X_WO;
};

/// One mover and what stands around it. Solids are the mover's first, then the obstacles.
class MoverModel {
 public:
  /// A rigid body of one solid or several.
  MoverModel(std::vector<Hexahedron> own, std::vector<Pose> X_OS, std::vector<Hexahedron> obstacles,
             std::vector<Pose> X_WB);
  /// An arm; weights are all 1.
  MoverModel(std::shared_ptr<const Mechanism> arm, const Pose& X_WB, std::vector<Hexahedron> obstacles,
             std::vector<Pose> X_WO);

  /// An arm held by its tool: from now on the metric is that of the hand, where weigh_at() was called last.
  void hold(const ArmHandStiffness& hand);
  void weigh_at(const Configuration& at);
  bool is_held() const { return hand_.has_value(); }
  /// An arm's joint that has the value; null: a rigid body.
  const Mechanism::Joint* joint_of(std::size_t value) const;

  int size() const { return arm_ ? static_cast<int>(arm_->value_count()) : 6; }
  const std::vector<Hexahedron>& solids() const { return solids_; }
  std::size_t own_count() const { return own_count_; }
  bool is_checked(SolidIndex a, SolidIndex b) const;
  void place(const Configuration& at, std::vector<Pose>& X_WS) const;
  /// In coordinates in which the metric is Euclid's.
  std::vector<double> step_between(const Configuration& from, const Configuration& to) const;
  Configuration moved(const Configuration& from, std::span<const double> by) const;
  double distance(const Configuration& from, const Configuration& to) const;
  /// No point of a solid goes further for a step of length 1 [m].
  double reach() const { return reach_; }

 private:
  void find_reach();
  Pose tool_pose(const Configuration& at) const;

  std::shared_ptr<const Mechanism> arm_;
  Pose X_WBase_;
  std::optional<ArmHandStiffness> hand_;
  Eigen::MatrixXd root_;  // L of the hand's metric L L^T
  std::vector<Hexahedron> solids_;
  std::vector<Pose> fixed_;  // X_OS of the mover's own, X_WB of obstacles
  std::size_t own_count_ = 0;
  MassMetric metric_;
  double reach_ = 0.0;
};

/// Finds paths and judges poses.
class PathFinder {
 public:
  /// @param gap pairs are to stay as far apart, or half of it, as the world keeps them [m].
  PathFinder(const MoverModel& model, double gap);
  ~PathFinder();

  /// The distance to the goal where small steps lead from `from`; never more than it is there.
  /// @param steps as many to the goal, if nothing stood between.
  double reached(const Configuration& from, const Configuration& goal, int steps);
  /// The same along the path that is given alone: the largest s up to which all of `samples` poses are apart.
  double clear_until(const MotionPath& path, int samples);
  /// Whether no two solids touch, by `exact`.
  bool is_apart(const Configuration& at);

 private:
  struct Row {
    SolidIndex mover, other;
    Vector3 n, p_M, p_O;  // points in the solids' frames
    double separation;
  };
  struct Judge;

  bool are_apart();
  void find_rows(const Configuration& at, double band);
  double height(const Row& row) const;
  double band_of(const Configuration& from, std::span<const double> wanted);
  void find_gradients(const Configuration& at);
  void find_limits(const Configuration& at);
  bool step_to(const Configuration& from, const Configuration& goal, double length, Configuration& out);
  void solve(std::span<const double> wanted, std::span<const double> lacking,
             std::vector<double>& step) const;
  bool path_is_apart(const Configuration& from, std::span<const double> by);

  const MoverModel& model_;
  double gap_;
  std::unique_ptr<Judge> judge_;
  std::vector<Pose> X_WS_;
  std::vector<Row> rows_;
  std::vector<double> limits_;                  // what an arm's values have left to their limits, one a row
  std::vector<std::vector<double>> gradients_;  // of rows_, then of limits_
};

}  // namespace touchstone
