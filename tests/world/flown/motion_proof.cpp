#include "touchstone/tests/world/flown/motion_proof.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <numbers>
#include <optional>
#include <vector>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/adapters/exact/exact.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/motion/clear_stretch.hpp"
#include "touchstone/contact_core/motion/narrowphase_query.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/support/random_solid.hpp"
#include "touchstone/tests/world/near_spheres.hpp"
#include "touchstone/tests/world/world_fixture.hpp"

namespace touchstone {
namespace {

constexpr int kMovers = 5, kSolids = 8;
constexpr int kFramesOfAWorld = 25;
constexpr int kSamples = 6;  // of each part of a frame

using Poses = std::array<Pose, kSolids>;

struct Setting {
  ContactPolicy policy;
  bool is_cluster = false;  ///< see draw_cluster()
  double pace = 0.0;
  std::vector<Hexahedron> solids;
  Poses X_WO;
};

/// A frustum or a block of which the upper face is drawn in, along each axis for itself, and moved aside.
Hexahedron draw_sheared_solid(Random& random) {
  const Vector3 half(random.uniform(0.2, 0.7), random.uniform(0.2, 0.7), random.uniform(0.1, 0.5));
  const std::array<double, 2> taper{random.uniform(0.3, 1.0), random.uniform(0.3, 1.0)};
  const std::array<double, 2> shift{random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4)};
  std::array<Vector3, 8> v;
  for (int i = 0; i < 8; ++i) {
    const bool up = i & 1;
    const double x = (i & 4 ? 1 : -1) * half.x(), y = (i & 2 ? 1 : -1) * half.y();
    v[i] =
        up ? Vector3(taper[0] * x + shift[0], taper[1] * y + shift[1], half.z()) : Vector3(x, y, -half.z());
  }
  return Hexahedron::from_vertices(v, WarpPolicy::accept);
}

/// A sphere, a capsule, a box or plate with rounded edges, a padded solid of any shape.
Hexahedron draw_rounded(Random& random) {
  const double radius = random.uniform(0.05, 0.4);
  switch (random.below(4)) {
    case 0:
      return Hexahedron::sphere(radius);
    case 1:
      return Hexahedron::capsule(radius, random.uniform(0.2, 1.0));
    case 2: {
      const Vector3 size(random.uniform(0.2, 0.8), random.uniform(0.2, 0.8), random.uniform(0.1, 0.5));
      return Hexahedron::rounded_box(random.one_in(3) ? Vector3(size.x(), size.y(), 0.0) : size, radius);
    }
    default:
      return draw_sheared_solid(random).padded(0.5 * radius);
  }
}

/// Places solids one after the other in contact with one that stands already, as they turn up: edges across
/// each other, a corner on a face, tilted. Who finds no place that is clear of all others stands alone.
class ClusterBuilder {
 public:
  explicit ClusterBuilder(Setting& setting) : setting_(setting), native_(make_native()) {
    native_->build(setting.solids);
    query_.emplace(*native_, *native_, setting.solids.size());
  }

  void place(SolidIndex solid, Random& random) {
    Pose& X = setting_.X_WO[solid];
    for (int attempt = 0; attempt < 8 && !placed_.empty(); ++attempt) {
      const SolidIndex other = placed_[random.below(static_cast<std::uint32_t>(placed_.size()))];
      const Vector3 from = random.vector(1.0);
      if (!(norm(from) > 0.1)) continue;
      const Pose far =
          RigidPath::by(setting_.X_WO[other], (4.0 / norm(from)) * from, random.vector(2.0)).to();
      if (meet(solid, other, far, -4.0 / norm(from) * from, X) && is_clear(solid)) return keep(solid);
    }
    X = RigidPath::by(at(6.0 * solid, 0, 0), {0, 0, 0}, random.vector(2.0)).to();
    keep(solid);
  }

 private:
  void keep(SolidIndex solid) { placed_.push_back(solid); }
  /// Where the solid that goes `by` from `far` meets the other one. @returns false: it does not.
  bool meet(SolidIndex solid, SolidIndex other, const Pose& far, const Vector3& by, Pose& X) {
    const RigidPath path = RigidPath::by(far, by, {0, 0, 0}), stands(setting_.X_WO[other]);
    const MovingSolid a{&setting_.solids[solid], Pose{}, &path};
    const MovingSolid b{&setting_.solids[other], Pose{}, &stands};
    const bool is_first = solid < other;
    query_->set_pair(is_first ? SolidPair{solid, other} : SolidPair{other, solid});
    const Impact impact = find_impact(is_first ? a : b, is_first ? b : a, {kGap}, *query_);
    if (impact.status != ImpactStatus::blocked) return false;
    X = path.pose_at(impact.lo);
    return true;
  }
  bool is_clear(SolidIndex solid) {
    return std::all_of(placed_.begin(), placed_.end(), [&](SolidIndex other) {
      const SolidPair pair{std::min(solid, other), std::max(solid, other)};
      query_->set_pair(pair);
      PairGeometry geometry{};
      query_->separation(setting_.X_WO[pair.a], setting_.X_WO[pair.b], geometry);
      return geometry.separation > 0.25 * kGap;
    });
  }

  Setting& setting_;
  std::unique_ptr<Narrowphase> native_;
  std::optional<NarrowphaseQuery> query_;
  std::vector<SolidIndex> placed_;
};

/// Solids of any shape in contacts of any direction, to be moved and turned whichever way.
void draw_cluster(Random& random, bool rounded, Setting& setting) {
  setting.is_cluster = true;
  for (int i = 0; i < kSolids; ++i) {
    if (rounded && !random.one_in(3))
      setting.solids.push_back(draw_rounded(random));
    else
      setting.solids.push_back(random.one_in(2) ? draw_sheared_solid(random) : random_solid(random, 1.0));
  }
  ClusterBuilder builder(setting);
  for (int i = kSolids; i > 0; --i) builder.place(static_cast<SolidIndex>(i - 1), random);
}

Setting draw_setting(Random& random, bool rounded) {
  constexpr std::array kPolicies{ContactPolicy::hold, ContactPolicy::advance, ContactPolicy::slide};
  constexpr std::array kPaces{0.01, 0.05, 0.2, 0.5};
  Setting out;
  out.policy = kPolicies[random.below(3)];
  out.pace = kPaces[random.below(4)];
  if (random.one_in(2)) {
    draw_cluster(random, rounded, out);
    return out;
  }
  const double thin = random.one_in(3) ? 0.05 : 1.0;
  // Every fourth world starts with neighbours that overlap.
  const double spacing = random.one_in(4) ? 0.6 : 1.45;
  for (int i = 0; i < kMovers; ++i) {
    const bool is_rounded = rounded && !random.one_in(3);
    out.solids.push_back(is_rounded ? draw_rounded(random) : random_solid(random, thin));
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
    register_all_backends(registry);
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
    constexpr double kApart = kInfinity;
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

/// Of each mover the way into one of its contacts, or zero.
using Contacts = std::array<Vector3, kMovers>;

Contacts contacts_in(const Crowd& crowd, const FrameReport& report) {
  Contacts out;
  out.fill(Vector3::Zero());
  for (const ContactEvent& event : report.events)
    for (int i = 0; i < kMovers; ++i) {
      if (event.kind != EventKind::began && event.kind != EventKind::persists) continue;
      if (!(norm(event.geometry_at_end.n_AB_W) > 0.5)) continue;
      if (event.a == crowd.objects[i]) out[i] = event.geometry_at_end.n_AB_W;
      if (event.b == crowd.objects[i]) out[i] = -event.geometry_at_end.n_AB_W;
    }
  return out;
}

/// Any way; or, where it is in contact, along that and a little into it, while it turns.
MotionCommand draw_cluster_command(const Crowd& crowd, Random& random, int mover, const Vector3& into_W) {
  const auto any_size = [&](double least, double most) {
    return std::pow(10.0, random.uniform(least, most));
  };
  const ObjectHandle object = crowd.objects[mover];
  if (into_W == Vector3::Zero() || random.one_in(4)) {
    const double size = any_size(-2.5, 0.0);
    const Vector3 home = -crowd.world->actual_pose(object).p;
    const Vector3 by = random.vector(size) + (0.5 * size / (1.0 + norm(home))) * home;
    return crowd.world->move_by(object, by, random.vector(any_size(-2.5, 0.5)));
  }
  const double size = any_size(-1.0, 0.2);
  Vector3 by = random.vector(size);
  by += (size * any_size(-3.0, -0.5) - dot(by, into_W)) * into_W;
  return crowd.world->move_by(object, by, random.vector(any_size(-1.0, 0.3)));
}

std::vector<MotionCommand> draw_commands(const Crowd& crowd, Random& random, const Setting& setting,
                                         const Contacts& contact_of) {
  const double pace = setting.pace;
  std::vector<MotionCommand> commands;
  for (int i = 0; i < kMovers; ++i) {
    if (setting.is_cluster) {
      if (random.one_in(2)) commands.push_back(draw_cluster_command(crowd, random, i, contact_of[i]));
      continue;
    }
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
  // A crowd, and the same one registered the other way round.
  const Setting setting = draw_setting(random, figures.proof.rounded);
  Crowd crowd(setting, figures.proof, false), twin(setting, figures.proof, true);
  figures.is_sampled = crowd.world->capabilities().check == MotionCheck::sampled;
  Flight flight(setting, figures);
  bool agrees = true;
  Contacts contacts = contacts_in(crowd, crowd.world->frame({}));
  twin.world->frame({});
  for (int frame = 0; frame < kFramesOfAWorld && figures.motions < figures.proof.motions; ++frame) {
    // A frame, judged.
    std::vector<MotionCommand> commands = draw_commands(crowd, random, setting, contacts);
    const Poses before = crowd.poses();
    const FrameReport report = crowd.world->frame(commands);
    contacts = contacts_in(crowd, report);
    ++figures.frames;
    figures.motions += commands.size();
    figures.blocked += report.blocked_movers;
    figures.slid_frames += report.slide_steps > 0;
    figures.iteration_limits += report.iteration_limits;
    flight.judge_frame(crowd, before);
    // The twin's, with commands in reverse: the same poses.
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
