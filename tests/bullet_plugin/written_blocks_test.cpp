#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "touchstone/examples/measures/pairs/written_block.hpp"
#include "touchstone/tests/bullet_plugin/collision_scene.hpp"
#include "touchstone/tests/support/ask.hpp"
#include "touchstone/tests/support/random_poses.hpp"

// Blocks whose corners come from a file, bent by its digits and by the engine's own floats, at rest on a
// slab.

namespace touchstone::test {
namespace {

constexpr int kBlocks = 40;

struct Block {
  WrittenBlock written;
  double mass;
};

/// Turned about its middle in its file's frame, level in the world, 1 mm deep in what is below z = 0.
Block random_block(std::mt19937_64& random, Written how) {
  const Vector3 size = random_vector(random, 0.3, 1.2);
  Pose X_SF, X_WF;
  X_SF.R = random_rotation(random);
  X_SF.p = rotate(X_SF.R, {0, 0, -0.5 * size.z()});
  const double yaw = uniform(random, -3.0, 3.0);
  X_WF.R = rotation_from_quaternion(std::cos(yaw / 2), 0, 0, std::sin(yaw / 2));
  X_WF.p = {uniform(random, -0.2, 0.2), uniform(random, -0.2, 0.2), -1e-3};
  return {written_block(box_corners(size), X_SF, X_WF, how), 1000.0 * size.x() * size.y() * size.z()};
}

struct Rest {
  int contacts = 0;
  double drift = 0.0;  ///< of the middle along x and y [m]
};

class Dynamics {
 public:
  explicit Dynamics(bool native) {
    if (native) plugin_.emplace(dispatcher_);
    world_.getSolverInfo().m_numIterations = 50;
    world_.setGravity({0, 0, to_engine(-9.81)});
    slab_.initializePolyhedralFeatures();
  }

  /// Ten seconds.
  Rest run(const Block& block) {
    const auto hull = make_hull(block.written.corners_S);
    hull->initializePolyhedralFeatures();
    btVector3 inertia;
    hull->calculateLocalInertia(to_engine(block.mass), inertia);
    using Construction = btRigidBody::btRigidBodyConstructionInfo;
    btRigidBody floor(Construction(0, nullptr, &slab_));
    btRigidBody body(Construction(to_engine(block.mass), nullptr, hull.get(), inertia));
    floor.setWorldTransform(to_engine(at(0, 0, -0.5)));
    body.setWorldTransform(to_engine(block.written.X_WS));
    body.setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(&floor), world_.addRigidBody(&body);
    const btVector3 start = body.getWorldTransform().getOrigin();
    for (int i = 0; i < 600; ++i) world_.stepSimulation(to_engine(1.0 / 60), 0, to_engine(1.0 / 60));
    const btVector3 way = body.getWorldTransform().getOrigin() - start;
    Rest out{0, std::hypot(static_cast<double>(way.x()), static_cast<double>(way.y()))};
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i)
      out.contacts += dispatcher_.getManifoldByIndexInternal(i)->getNumContacts();
    world_.removeRigidBody(&body), world_.removeRigidBody(&floor);
    return out;
  }

 private:
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  std::optional<BulletPlugin> plugin_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  btBoxShape slab_{btVector3(5, 5, btScalar(0.5))};
};

struct Stand {
  int on_four = 0;
  double median_drift = 0.0, worst_drift = 0.0;
};

Stand stand(Written how, bool native) {
  std::mt19937_64 random(41);
  Stand out;
  std::vector<double> drifts;
  for (int i = 0; i < kBlocks; ++i) {
    const Rest rest = Dynamics(native).run(random_block(random, how));
    out.on_four += rest.contacts == 4;
    drifts.push_back(rest.drift);
  }
  std::sort(drifts.begin(), drifts.end());
  out.median_drift = drifts[kBlocks / 2], out.worst_drift = drifts.back();
  return out;
}

/// The last digit of a file [m].
double rounding_of(Written how) {
  return how == Written::with_four_decimals ? 1e-4 : how == Written::with_six_decimals ? 1e-6 : 0.0;
}

TEST(TOUCHSTONE_SUITE, BlocksAsFilesWriteThemRestOnFourPointsAndDriftNoMoreThanWithBulletsCheck) {
  for (const Written how : kAllWritten) {
    const Stand ours = stand(how, true), own = stand(how, false);
    std::printf("%-10s on four points: ours %d, own %d; drift: ours %.2g (worst %.2g), own %.2g (%.2g) m\n",
                to_string(how), ours.on_four, own.on_four, ours.median_drift, ours.worst_drift,
                own.median_drift, own.worst_drift);
    EXPECT_EQ(ours.on_four, kBlocks) << to_string(how);
    // A block settles on the corners that its file wrote lowest, by as much as they were rounded.
    EXPECT_LE(ours.median_drift, std::max(own.median_drift, rounding_of(how))) << to_string(how);
    EXPECT_LE(ours.worst_drift, own.worst_drift) << to_string(how);
  }
}

}  // namespace
}  // namespace touchstone::test
