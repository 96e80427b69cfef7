#include "motion_proof.hpp"

#include <algorithm>
#include <array>
#include <iomanip>
#include <iostream>
#include <numbers>
#include <vector>

#include "touchstone/adapters/exact/exact.hpp"
#include "touchstone/contact_core/motion/clear_stretch.hpp"
#include "touchstone/examples/measures/all_backends.hpp"
#include "touchstone/tests/support/random_solid.hpp"
#include "touchstone/tests/world/near_spheres.hpp"
#include "world_fixture.hpp"

namespace touchstone {
namespace {

constexpr int kMovers = 5, kSolids = 8;
constexpr int kFramesOfAWorld = 25;
constexpr int kSamples = 6;  // of each part of a frame

using Poses = std::array<Pose, kSolids>;

struct Setting {
  ContactPolicy policy;
  double pace;
  std::vector<Hexahedron> solids;
  Poses X_WO;
};

Setting draw_setting(Random& random) {
  constexpr std::array kPolicies{ContactPolicy::hold, ContactPolicy::advance, ContactPolicy::slide};
  constexpr std::array kPaces{0.01, 0.05, 0.2, 0.5};
  Setting out;
  out.policy = kPolicies[random.below(3)];
  out.pace = kPaces[random.below(4)];
  const double thin = random.one_in(3) ? 0.05 : 1.0;
  // Every fourth world starts with neighbours that overlap.
  const double spacing = random.one_in(4) ? 0.6 : 1.45;
  for (int i = 0; i < kMovers; ++i) {
    out.solids.push_back(random_solid(random, thin));
    out.X_WO[i] = at(spacing * (i - 2), random.uniform(-0.3, 0.3), 0.05);
  }
  out.solids.push_back(Hexahedron::from_size({30, 30, 1})), out.X_WO[5] = at(0, 0, -1.2);
  out.solids.push_back(Hexahedron::from_size({30, 1, 6})), out.X_WO[6] = at(0, 1.6, 0);
  out.solids.push_back(Hexahedron::from_size({30, 1, 6})), out.X_WO[7] = at(0, -1.6, 0);
  return out;
}

struct Crowd {
  std::unique_ptr<ContactWorld> world;
  std::array<ObjectHandle, kSolids> objects;

  Crowd(const Setting& setting, const MotionProof& proof, bool reversed) {
    BackendRegistry registry;
    comparison::register_all_backends(registry);
    world = std::make_unique<ContactWorld>(registry.make_narrowphase(proof.narrowphase),
                                           registry.make_broadphase(proof.broadphase), kGap);
    world->set_default_rule(rule(setting.policy));
    for (int k = 0; k < kSolids; ++k) {
      const int i = reversed ? kSolids - 1 - k : k;
      const auto tree = std::make_shared<HexahedronTree>(
          std::vector<PlacedHexahedron>{{"solid", setting.solids[i], Pose{}}}, "solid " + std::to_string(i));
      objects[i] = world->add({tree, setting.X_WO[i], i >= kMovers});
    }
  }

  Poses poses() const {
    Poses out;
    for (int i = 0; i < kSolids; ++i) out[i] = world->actual_pose(objects[i]);
    return out;
  }
};

/// `exact` over one setting's solids.
class Judge {
 public:
  explicit Judge(const Setting& setting) : solids_(setting.solids) {
    BackendRegistry registry;
    register_exact(registry);
    exact_ = registry.make_narrowphase("exact");
    exact_->build(solids_);
    workspace_ = exact_->make_workspace();
  }

  /// The signed distance where they overlap or touch; +inf where they do not.
  double depth(SolidPair pair, const Poses& poses) {
    constexpr double kApart = std::numeric_limits<double>::infinity();
    if (!may_be_within(solids_[pair.a], poses[pair.a], solids_[pair.b], poses[pair.b])) return kApart;
    if (ask(pair, poses, QueryKind::overlap).first == PairStatus::separated) return kApart;
    return ask(pair, poses, QueryKind::distance).second;
  }

 private:
  std::pair<PairStatus, double> ask(SolidPair pair, const Poses& poses, QueryKind kind) {
    PairStatus status{};
    PairGeometry geometry{};
    Query query;
    query.kind = kind;
    exact_->evaluate({{&pair, 1}, poses, query}, {{&status, 1}, {&geometry, 1}, {}}, *workspace_);
    return {status, geometry.separation};
  }

  const std::vector<Hexahedron>& solids_;
  std::unique_ptr<Narrowphase> exact_;
  std::unique_ptr<Narrowphase::Workspace> workspace_;
};

std::vector<MotionCommand> draw_commands(const Crowd& crowd, Random& random, double pace) {
  std::vector<MotionCommand> commands;
  for (int i = 0; i < kMovers; ++i) {
    const Vector3 home = -crowd.world->actual_pose(crowd.objects[i]).p;
    const Vector3 by = 0.4 * pace * (home + Vector3(0, 0, -1)) + random.vector(pace);
    Vector3 turn = random.vector(1.5 * pace);
    if (random.one_in(50)) turn *= 2.0 * std::numbers::pi / std::max(norm(turn), 1e-9);
    commands.push_back(crowd.world->move_by(crowd.objects[i], by, turn));
  }
  return commands;
}

std::vector<SolidPair> all_pairs() {
  std::vector<SolidPair> pairs;
  for (SolidIndex a = 0; a < kMovers; ++a)
    for (SolidIndex b = a + 1; b < kSolids; ++b) pairs.push_back({a, b});
  return pairs;
}

/// One world's frames, judged.
class Flight {
 public:
  Flight(const Setting& setting, MotionFigures& figures) : judge_(setting), figures_(figures) {}

  void judge_frame(const Crowd& crowd, const Poses& before) {
    const std::size_t parts = crowd.world->executed_parts();
    for (std::size_t i = 0; i < pairs_.size(); ++i) start_[i] = judge_.depth(pairs_[i], before);
    for (const double start : start_) figures_.overlapping_starts += start <= 0.0;
    for (std::size_t part = 0; part < parts; ++part) {
      // The rounding of find_impact, once for each stretch of motion.
      const double room = kSeparationRounding * 50 * static_cast<double>(part + 1);
      for (int k = 1; k <= kSamples; ++k) {
        Poses poses;
        for (int i = 0; i < kSolids; ++i)
          poses[i] = crowd.world->executed_pose(crowd.objects[i], part, k / double{kSamples});
        judge_poses(poses, part + 1 == parts && k == kSamples, room);
      }
    }
  }

 private:
  void judge_poses(const Poses& poses, bool is_actual, double room) {
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      ++figures_.poses_judged;
      const double depth = judge_.depth(pairs_[i], poses);
      if (!(depth <= 0.0)) continue;
      if (start_[i] <= 0.0) {
        figures_.deepest_growth = std::max(figures_.deepest_growth, start_[i] - depth);
        figures_.deepened += depth < start_[i] - room;
        continue;
      }
      ++(is_actual ? figures_.actual_overlaps : figures_.path_overlaps);
      figures_.deepest = std::min(figures_.deepest, depth);
    }
  }

  Judge judge_;
  MotionFigures& figures_;
  std::vector<SolidPair> pairs_ = all_pairs();
  std::vector<double> start_ = std::vector<double>(pairs_.size());
};

bool same(const Poses& x, const Poses& y) {
  for (int i = 0; i < kSolids; ++i)
    if (!(x[i].p == y[i].p && x[i].R == y[i].R)) return false;
  return true;
}

void fly_world(Random& random, MotionFigures& figures) {
  const Setting setting = draw_setting(random);
  Crowd crowd(setting, figures.proof, false), twin(setting, figures.proof, true);
  figures.is_sampled = crowd.world->capabilities().check == MotionCheck::sampled;
  Flight flight(setting, figures);
  bool agrees = true;
  for (int frame = 0; frame < kFramesOfAWorld && figures.motions < figures.proof.motions; ++frame) {
    std::vector<MotionCommand> commands = draw_commands(crowd, random, setting.pace);
    const Poses before = crowd.poses();
    const FrameReport report = crowd.world->frame(commands);
    ++figures.frames;
    figures.motions += commands.size();
    figures.blocked += report.blocked_movers;
    figures.slid_frames += report.slide_steps > 0;
    figures.iteration_limits += report.iteration_limits;
    flight.judge_frame(crowd, before);
    if (!agrees) continue;  // they have parted
    std::reverse(commands.begin(), commands.end());
    for (MotionCommand& command : commands)
      for (int i = 0; i < kMovers; ++i)
        if (command.object == crowd.objects[i]) {
          command.object = twin.objects[i];
          break;
        }
    twin.world->frame(commands);
    agrees = same(crowd.poses(), twin.poses());
    figures.order_shows += !agrees;
  }
}

}  // namespace

MotionFigures prove_motions(const MotionProof& proof) {
  MotionFigures figures;
  figures.proof = proof;
  Random random(proof.seed);
  while (figures.motions < proof.motions) fly_world(random, figures);
  return figures;
}

void print_table(std::ostream& out, std::span<const MotionFigures> figures) {
  out << std::left << std::setw(11) << "backend" << std::setw(9) << "check" << std::right << std::setw(9)
      << "motions" << std::setw(9) << "blocked" << std::setw(8) << "slid" << std::setw(11) << "judged"
      << std::setw(9) << "overlap:" << std::setw(8) << "actual" << std::setw(9) << "on path" << std::setw(12)
      << "deepest [m]" << std::setw(10) << "deepened" << std::setw(11) << "by [m]" << std::setw(8) << "of"
      << std::setw(7) << "order" << std::setw(8) << "limits" << '\n';
  for (const MotionFigures& f : figures)
    out << std::left << std::setw(11) << f.proof.narrowphase << std::setw(9)
        << to_string(f.is_sampled ? MotionCheck::sampled : MotionCheck::proven) << std::right << std::setw(9)
        << f.motions << std::setw(9) << f.blocked << std::setw(8) << f.slid_frames << std::setw(11)
        << f.poses_judged << std::setw(9) << "" << std::setw(8) << f.actual_overlaps << std::setw(9)
        << f.path_overlaps << std::setw(12) << std::setprecision(3) << f.deepest << std::setw(10)
        << f.deepened << std::setw(11) << f.deepest_growth << std::setw(8) << f.overlapping_starts
        << std::setw(7) << f.order_shows << std::setw(8) << f.iteration_limits << '\n';
}

}  // namespace touchstone
