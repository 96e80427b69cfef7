#pragma once

#include <memory>
#include <vector>

#include "touchstone/tests/world/arms/arm_fixture.hpp"
#include "touchstone/tests/world/progress/progress_trial.hpp"

// Of which the scenes of trials are made.

namespace touchstone {

struct Obstacles {
  std::vector<Hexahedron> solids;
  std::vector<Pose> X_WO;

  void add(const Vector3& size, const Pose& X) { add(Hexahedron::from_size(size), X); }
  void add(const Hexahedron& solid, const Pose& X) { solids.push_back(solid), X_WO.push_back(X); }
};

inline Pose turned_at(const Vector3& p, const Matrix3& R) {
  Pose X;
  X.R = R, X.p = p;
  return X;
}

std::unique_ptr<ContactWorld> world_with(const Obstacles& obstacles, double gap, ContactPolicy policy);

ProgressTrial arm_trial(std::shared_ptr<const Mechanism> arm, const Pose& X_WB, const std::vector<double>& q,
                        const Obstacles& obstacles, double gap);
ProgressTrial body_trial(const Hexahedron& solid, const Pose& X_WO, const Obstacles& obstacles, double gap,
                         ContactPolicy policy);

/// Held rates, from wherever it is.
void command_rates(ProgressTrial& trial, std::vector<double> rates, double rate);
/// Told to go evenly to X_end within two seconds, and to stay.
void command_path_to(ProgressTrial& trial, const Pose& X_end, double rate);

/// A drawer's shell, open at +x: the drawer of `size` stands in it about the origin with `play` on every side
/// but that.
Obstacles shell(const Vector3& size, double play);

}  // namespace touchstone
