#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/broadphase/broadphase.hpp"
#include "touchstone/contact_core/threads/thread_team.hpp"

namespace touchstone {

/// The scene of a frame, and what is asked.
struct Mix {
  double spacing = 1.7;     ///< [m]; 1.7 gives a box about five candidate partners
  double decades = 0.0;     ///< sizes are scaled by 10^0 down to 10^-decades
  double stationary = 0.0;  ///< share of objects that never move
  bool flagged = false;     ///< they are built as static
  int solids = 1;           ///< an object, side by side
  int threads = 1;
  bool swept = false;          ///< paths from each frame's poses to the next's
  bool first_contact = false;  ///< the lowest contact only, by the native narrowphase
  bool moved_pairs = false;    ///< those of what moved only
  bool by_place = false;       ///< all pairs in an order of places
  bool overlap = false;        ///< and whether they overlap, by the native narrowphase
  bool manifold = false;       ///< and their manifolds, of those apart the distance
  bool contacts = false;       ///< of those apart the class alone
};

/// Boxes with sides of 0.5 to 1.5 m.
struct MovingBoxes {
  std::vector<HexahedronTree> trees;
  std::vector<const HexahedronTree*> pointers;
  std::vector<Pose> poses;
  std::vector<Vector3> velocities;  ///< one an object, like moved
  std::vector<std::uint32_t> moved;
  std::vector<std::uint8_t> is_static;
  int solids;
  int frame = 0;

  MovingBoxes(int count, const Mix& mix);

  /// To and fro, so that the density stays however many frames are run.
  void step();
  std::vector<Hexahedron> all_solids() const;
};

/// This thread's time, so that other work on the machine counts little; of several threads, the wall's [s].
double frame_seconds(const Mix& mix);

/// The caller's side of one frame of a broadphase: step(), then update(), then all of find().
struct BroadphaseFrame {
  MovingBoxes boxes;
  Mix mix;
  ThreadTeam team;
  std::unique_ptr<Broadphase> broadphase;
  std::unique_ptr<Narrowphase> narrowphase;
  std::unique_ptr<Narrowphase::Workspace> workspace;
  std::vector<Pose> before;
  std::vector<SolidPair> block;
  std::vector<PairStatus> status;
  std::vector<PairGeometry> geometry;
  std::vector<ContactPoint> points;
  std::size_t pairs = 0;
  std::vector<SolidPair> listed;  ///< where all pairs come at once

  BroadphaseFrame(const std::string& name, int count, const Mix& wanted);

  void step();
  void update();
  void find();

 private:
  void find_listed();
  void check(std::span<const SolidPair> some);
};

}  // namespace touchstone
