#include "touchstone/tests/world/progress/progress_trial.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "touchstone/contact_core/mechanism/resolved_rate.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/support/random.hpp"
#include "touchstone/tests/world/progress/motion_progress.hpp"
#include "touchstone/tests/world/progress/tight_trials.hpp"
#include "touchstone/tests/world/progress/trial_parts.hpp"

namespace touchstone {
namespace {

constexpr std::array<std::string_view, 19> kScenes{
    "flat",     "edge",         "corner",     "post",         "bore",   "blocks",    "drawer",
    "drawers",  "hand_drawers", "pegs",       "advance",      "arms",   "held_arms", "two_links",
    "fit_bore", "pegs_large",   "pegs_small", "file_drawers", "payload"};

/// Two bars that turn about z, commanded to go on against something at the second one's flank, or at its end.
ProgressTrial planar(std::string_view scene, double rate, double gap, Random& random) {
  const auto arm = make_arm("arm", 2);
  const std::vector<double> q = {random.uniform(-0.5, 0.5), random.uniform(0.4, 1.6)};
  std::vector<Pose> X_WL(arm->links().size());
  arm->link_poses({}, q, X_WL);
  const Pose& X_WL2 = X_WL[arm->find_link("2")];
  const double along = random.uniform(0.4, 1.9), apart = random.uniform(0.002, 0.02);
  Obstacles obstacles;
  // In the second bar's frame its flank is at y = 0.1.
  const auto place = [&](const Vector3& size, const Vector3& p, const Matrix3& R) {
    obstacles.add(size, compose(X_WL2, turned_at(p, R)));
  };
  const auto about = [](const Vector3& axis, double angle) { return rotation_about(axis, angle); };
  if (scene == "flat") {
    // The end's corner comes to its face.
    const Matrix3 R = about(Vector3::UnitZ(), random.uniform(-0.5, -0.1));
    place({1.5, 0.5, 2}, Vector3(2, 0.1, 0) + (0.25 + apart) * R.col(1), R);
  } else if (scene == "edge") {
    const double tilt = random.uniform(0.3, 1.2);
    place({0.5, 0.5, 2}, {along, 0.1 + apart + 0.25 * (std::cos(tilt) + std::sin(tilt)), 0},
          about(Vector3::UnitZ(), tilt));
  } else if (scene == "corner") {
    // The cube's corner (-, -, -) points along -y.
    const Vector3 diagonal = Vector3(1, 1, 1) / std::sqrt(3.0), axis = cross(diagonal, Vector3::UnitY());
    const Matrix3 R = product(about(Vector3::UnitY(), random.uniform(0, 6)),
                              about(axis / norm(axis), std::acos(diagonal.y())));
    place({0.4, 0.4, 0.4}, {along, 0.1 + apart + 0.2 * std::sqrt(3.0), random.uniform(-0.05, 0.05)}, R);
  } else {
    const double tilt = random.uniform(0.1, 0.7);
    place({0.05, 0.05, 2}, {along, 0.1 + apart + 0.025 * (std::cos(tilt) + std::sin(tilt)), 0},
          about(Vector3::UnitZ(), tilt));
  }
  ProgressTrial out = arm_trial(arm, {}, q, obstacles, gap);
  // Both turn towards it, so that the flank goes up as a whole.
  command_rates(out, {random.uniform(0.02, 0.07), random.uniform(0.0, 0.07)}, rate);
  out.frames = static_cast<int>(3 * rate);
  return out;
}

/// The SSRMS-type arm's end effector over a grapple probe (the bundled scene), its bore about to meet the
/// stem.
ProgressTrial bore(double rate, double gap, Random& random) {
  // The bundled arm over the bore, shortly before its rim meets the stem.
  const auto arm = make_ssrms_arm();
  std::vector<double> q;
  for (const double degrees : {10, 25, -70, 110, -35, 20, 15}) q.push_back(degrees * kDegree);
  const double time = 16.5;
  const Matrix3 down = rotation_about(Vector3::UnitY(), 0.5 * std::numbers::pi);
  std::vector<Pose> X_BL(arm->links().size());
  arm->link_poses({}, q, X_BL);
  const std::uint32_t tip = arm->find_link("tip");
  const Vector3 start(0.09 - 0.01 * time, random.uniform(-0.001, 0.001), 0.5 - 0.02 * time);
  const Pose X_WB = rigid_frame(compose(turned_at(start, down), inverse(X_BL[tip])));
  // Plate, stem and taper.
  Obstacles obstacles;
  obstacles.add(Vector3(0.8, 0.8, 0.05), at(0, 0, -0.025));
  obstacles.add(Vector3(0.038, 0.038, 0.25443), at(0, 0, 0.127215));
  std::array<Vector3, 8> taper;
  for (int i = 0; i < 8; ++i) {
    const double half = i & 1 ? 0.005 : 0.019;
    taper[i] = {(i & 4 ? 1 : -1) * half, (i & 2 ? 1 : -1) * half, i & 1 ? 0.019 : 0.0};
  }
  obstacles.add(Hexahedron::from_vertices(taper), at(0, 0, 0.25443));
  // Resolved rates drive the tip aside and down.
  ProgressTrial out = arm_trial(arm, X_WB, q, obstacles, gap);
  out.command = [arm, tip, rate, X_WB, control = std::make_shared<ResolvedRate>(*arm, tip)](
                    const Configuration& at, int) {
    std::vector<Pose> X_WL(arm->links().size());
    arm->link_poses(X_WB, at.q, X_WL);
    Configuration goal = at;
    std::vector<double> rates(at.q.size());
    control->solve(X_WL, X_WL[tip].p, {{-0.01, 0, -0.02}, Vector3::Zero()}, rates);
    for (std::size_t k = 0; k < rates.size(); ++k) goal.q[k] += rates[k] / rate;
    return goal;
  };
  out.frames = static_cast<int>(6 * rate);
  return out;
}

/// The first `count` that are a centimetre away from all of `solids`.
Obstacles clear_of(std::vector<Hexahedron> solids, std::vector<Pose> X_WS, const Obstacles& all,
                   std::size_t count) {
  const auto own = static_cast<SolidIndex>(solids.size());
  solids.insert(solids.end(), all.solids.begin(), all.solids.end());
  X_WS.insert(X_WS.end(), all.X_WO.begin(), all.X_WO.end());
  const auto native = make_native();
  native->build(solids);
  const auto workspace = native->make_workspace();
  Query query;
  query.kind = QueryKind::distance;
  Obstacles out;
  for (SolidIndex b = own; b < solids.size() && out.solids.size() < count; ++b) {
    bool is_clear = true;
    for (SolidIndex a = 0; a < own && is_clear; ++a) {
      const SolidPair pair{a, b};
      PairStatus status{};
      PairGeometry geometry{};
      native->evaluate({{&pair, 1}, X_WS, query}, {{&status, 1}, {&geometry, 1}, {}}, *workspace);
      is_clear = geometry.separation > 0.01;
    }
    if (is_clear) out.add(solids[b], X_WS[b]);
  }
  return out;
}

/// The same arm among 500 blocks, its joints commanded at random rates for two seconds each.
ProgressTrial blocks(double rate, double gap, Random& random) {
  // The bundled arm in a random posture.
  const auto arm = make_ssrms_arm();
  std::vector<double> q;
  for (const double degrees : {10, 25, -70, 110, -35, 20, 15})
    q.push_back((degrees + random.uniform(-30, 30)) * kDegree);
  std::vector<Pose> X_WL(arm->links().size());
  arm->link_poses({}, q, X_WL);
  std::vector<Pose> X_WS;
  for (std::uint32_t i = 0; i < arm->solids().size(); ++i)
    X_WS.push_back(compose(X_WL[arm->link_of(i)], arm->placed(i).X_OS));
  // Blocks about it, clear of its links.
  Obstacles all;
  for (int i = 0; i < 800; ++i) {
    const Vector3 size(random.uniform(0.3, 1.5), random.uniform(0.3, 1.5), random.uniform(0.3, 1.5));
    const Vector3 turn = random.vector(3.0);
    all.add(size, turned_at(random.vector(14.0), rotation_about(turn / norm(turn), norm(turn))));
  }
  const Obstacles obstacles = clear_of(arm->solids(), X_WS, all, 500);
  // Spells of random joint rates.
  ProgressTrial out = arm_trial(arm, {}, q, obstacles, gap);
  constexpr int kSpells = 10;
  std::vector<std::vector<double>> rates(kSpells);
  for (auto& spell : rates)
    for (int k = 0; k < 7; ++k) spell.push_back(random.uniform(-4, 4) * kDegree);
  out.command = [rates, rate](const Configuration& at, int frame) {
    const auto& spell = rates[static_cast<std::size_t>(frame / (2 * rate)) % rates.size()];
    Configuration goal = at;
    for (std::size_t k = 0; k < spell.size(); ++k) goal.q[k] += spell[k] / rate;
    return goal;
  };
  out.frames = static_cast<int>(2 * kSpells * rate);
  return out;
}

/// Two to seven bars in a row, the axes of a third of them parallel; every other joint ends somewhere.
std::shared_ptr<const Mechanism> random_arm(Random& random) {
  MechanismDescription out;
  out.name = "arm";
  out.links.push_back({"base", {}, {}});
  const bool is_planar = random.one_in(3);
  const int bars = 2 + static_cast<int>(random.below(6));
  double before = 0.0;
  for (int k = 1; k <= bars; ++k) {
    const double length = random.uniform(0.4, 1.5), width = random.uniform(0.1, 0.25);
    JointDescription joint;
    joint.name = "j" + std::to_string(k);
    joint.kind = JointKind::revolute;
    joint.parent = out.links.back().name, joint.child = std::to_string(k);
    joint.X_PJ = at(before, 0, 0);
    joint.axis_J = is_planar ? Vector3::UnitZ() : Vector3::Unit(static_cast<int>(random.below(3)));
    if (random.one_in(2)) joint.lower = -random.uniform(0.3, 2.5), joint.upper = random.uniform(0.3, 2.5);
    out.links.push_back(
        {joint.child, {{"bar", Hexahedron::from_size({length, width, width}), at(0.5 * length, 0, 0)}}, {}});
    out.joints.push_back(joint);
    before = length + 0.05;  // so that the bars may turn about any axis
  }
  return std::make_shared<const Mechanism>(out);
}

/// Such an arm among boxes, moved by up to 6 rad/s a joint: at 10 Hz by 0.6 rad a frame. Held by its last
/// link's end, with the default stiffness there, or by its joints.
ProgressTrial random_arm_trial(double rate, double gap, bool is_held, Random& random) {
  // A random arm in a random posture.
  const auto arm = random_arm(random);
  const std::size_t values = arm->value_count();
  std::vector<double> q(values);
  for (double& value : q) value = random.uniform(-0.25, 0.25);
  std::vector<Pose> X_WL(arm->links().size()), X_WS;
  arm->link_poses({}, q, X_WL);
  for (std::uint32_t i = 0; i < arm->solids().size(); ++i)
    X_WS.push_back(compose(X_WL[arm->link_of(i)], arm->placed(i).X_OS));
  // Blocks about it, clear of its links.
  Obstacles all;
  for (int i = 0; i < 60; ++i) {
    const Vector3 size(random.uniform(0.1, 1.5), random.uniform(0.1, 1.5), random.uniform(0.1, 1.5));
    const Vector3 turn = random.vector(3.0);
    all.add(size, turned_at(random.vector(4.0), rotation_about(turn / norm(turn), norm(turn))));
  }
  ProgressTrial out = arm_trial(arm, {}, q, clear_of(arm->solids(), X_WS, all, 30), gap);
  // A hand holds its last link.
  if (is_held) {
    ArmHandStiffness hand;
    hand.link = arm->links().back().name;
    hand.X_LT = at(random.uniform(0.0, 1.0), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1));
    out.world->set_hand(out.arm, hand);
    out.model->hold(hand);
  }
  // Five spells of random joint rates, within the limits.
  std::vector<std::vector<double>> ways(5, std::vector<double>(values));
  for (auto& way : ways)
    for (double& change : way) change = random.uniform(-6.0, 6.0) / rate;
  out.frames = static_cast<int>(2 * rate);
  const int spell = std::max(1, out.frames / static_cast<int>(ways.size()));
  out.command = [=, model = out.model.get()](const Configuration& at, int frame) {
    const std::vector<double>& way = ways[static_cast<std::size_t>(frame / spell) % ways.size()];
    Configuration goal = at;
    for (std::size_t k = 0; k < values; ++k) {
      const Mechanism::Joint& joint = *model->joint_of(k);
      goal.q[k] = std::clamp(at.q[k] + way[k], joint.lower, joint.upper);
    }
    return goal;
  };
  return out;
}

ProgressTrial drawer(double rate, double gap) {
  const Vector3 size(0.5, 0.4, 0.1);
  ProgressTrial out =
      body_trial(Hexahedron::from_size(size), {}, shell(size, 1e-3), gap, ContactPolicy::slide);
  command_path_to(out, at(0.45, 0.02, 0), rate);
  return out;
}

ProgressTrial drawers(double rate, double gap, Random& random, bool by_hand) {
  const Vector3 size(random.uniform(0.2, 0.8), random.uniform(0.1, 0.6), random.uniform(0.05, 0.4));
  const double play = std::pow(10.0, random.uniform(-4.0, std::log10(2e-2)));
  ProgressTrial out =
      body_trial(Hexahedron::from_size(size), {}, shell(size, play), gap, ContactPolicy::slide);
  const double pull = random.uniform(0.5, 0.9) * size.x();
  Vector3 end = random.vector(0.05);
  Vector3 turn = random.vector(0.15);
  end.x() = pull;
  if (!by_hand) {
    command_path_to(out, turned_at(end, rotation_about(turn / norm(turn), norm(turn))), rate);
    return out;
  }
  out.command = [end, turn, rate](const Configuration& at, int) {
    return Configuration{{}, RigidPath::by(at.X_WO, end / (2.0 * rate), turn / (2.0 * rate)).to()};
  };
  out.frames = static_cast<int>(2 * rate);
  return out;
}

/// A tool turned about the edge that it rests on: its own on a floor, or another's under one of its faces.
ProgressTrial advance(double rate, double gap, Random& random) {
  const Vector3 size(random.uniform(0.1, 0.6), random.uniform(0.1, 0.6), random.uniform(0.05, 0.4));
  const double yaw = random.uniform(-3, 3), rest = random.uniform(0.6, 1.0) * gap;
  const bool on_own_edge = random.one_in(2);
  const Matrix3 about_z = rotation_about(Vector3::UnitZ(), yaw);
  Obstacles obstacles;
  Pose X_WO = turned_at(Vector3::Zero(), about_z);
  Vector3 pivot_O(0, 0, -0.5 * size.z());
  if (on_own_edge) {
    obstacles.add(Vector3(4, 4, 1), at(0, 0, -0.5 - 0.5 * size.z() - rest));
    pivot_O.y() = -0.5 * size.y();
  } else {
    // A beam on its edge, along the tool's x.
    const Matrix3 R = product(about_z, rotation_about(Vector3::UnitX(), 0.25 * std::numbers::pi));
    obstacles.add(Vector3(2, 0.5, 0.5), turned_at({0, 0, -0.5 * size.z() - rest - 0.25 * std::sqrt(2.0)}, R));
  }
  ProgressTrial out = body_trial(Hexahedron::from_size(size), X_WO, obstacles, gap, ContactPolicy::advance);
  const double speed = random.uniform(0.05, 0.5) * (on_own_edge || random.one_in(2) ? 1.0 : -1.0);
  const bool by_pose = random.one_in(2);
  out.open_path = [=](const Pose& X, int) {
    return RigidPath::by(X, Vector3::Zero(), (speed / rate) * rotate(X.R, Vector3::UnitX()), pivot_O);
  };
  // A pose alone does not show the edge.
  out.path = [=, open = out.open_path](const Pose& X, int frame) {
    return by_pose ? RigidPath::between(X, open(X, frame).to()) : open(X, frame);
  };
  out.frames = static_cast<int>(0.6 * rate / std::abs(speed));
  return out;
}

}  // namespace

std::span<const std::string_view> progress_scenes() { return kScenes; }

ProgressTrial make_trial(std::string_view scene, double rate, double gap, std::uint64_t seed) {
  Random random(seed);
  if (scene == "flat" || scene == "edge" || scene == "corner" || scene == "post")
    return planar(scene, rate, gap, random);
  if (scene == "bore") return bore(rate, gap, random);
  if (scene == "blocks") return blocks(rate, gap, random);
  if (scene == "drawer") return drawer(rate, gap);
  if (scene == "drawers" || scene == "hand_drawers")
    return drawers(rate, gap, random, scene == "hand_drawers");
  if (scene == "advance") return advance(rate, gap, random);
  if (scene == "arms" || scene == "held_arms")
    return random_arm_trial(rate, gap, scene == "held_arms", random);
  if (std::optional<ProgressTrial> tight = make_tight_trial(scene, rate, gap, random))
    return std::move(*tight);
  throw std::invalid_argument("no scene '" + std::string(scene) + "'");
}

}  // namespace touchstone
