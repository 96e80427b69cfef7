#include "touchstone/tests/world/progress/tight_trials.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "touchstone/contact_core/mechanism/resolved_rate.hpp"
#include "touchstone/tests/world/progress/trial_parts.hpp"

namespace touchstone {
namespace {

/// A square peg a millimetre in a hole of 1e-6 m play, commanded to go to the bottom and somewhat beside it,
/// and turned; all lengths, and the gap, times `scale`.
ProgressTrial pegs(double rate, double gap, double scale, Random& random) {
  const double play = 1e-6 * scale, deep = 0.2 * scale, wall = 0.1 * scale, wide = scale;
  const double width = random.uniform(0.02, 0.2) * scale;
  Obstacles hole;
  for (const double side : {1.0, -1.0}) {
    const double out = side * (0.5 * width + play + 0.5 * wall);
    hole.add(Vector3(wall, wide, deep), at(out, 0, -0.5 * deep));
    hole.add(Vector3(wide, wall, deep), at(0, out, -0.5 * deep));
  }
  hole.add(Vector3(wide, wide, wall), at(0, 0, -deep - 0.5 * wall));
  const double height = random.uniform(0.5, 1.5) * deep;
  ProgressTrial out =
      body_trial(Hexahedron::from_size({width, width, height}), at(0, 0, 0.5 * height - 1e-3 * scale), hole,
                 gap * scale, ContactPolicy::slide);
  const Vector3 turn = random.vector(1e-2);
  Vector3 end = random.vector(1e-3) * scale;
  end.z() = 0.5 * height - deep;
  command_path_to(out, turned_at(end, rotation_about(turn / norm(turn), norm(turn))), rate);
  return out;
}

/// As a file with six digits has it.
double six_digits(double value) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return std::strtod(text.data(), nullptr);
}

/// The solid at a pose, its corners in the world to six digits.
Hexahedron from_file(const Hexahedron& solid, const Pose& X) {
  std::array<Vector3, 8> corners;
  for (int i = 0; i < 8; ++i) {
    const Vector3 p = transform(X, solid.vertices()[i]);
    corners[i] = {six_digits(p.x()), six_digits(p.y()), six_digits(p.z())};
  }
  return Hexahedron::from_vertices(corners);
}

/// A drawer in its shell somewhere at some attitude; pulled by a hand.
ProgressTrial file_drawers(double rate, double gap, Random& random) {
  const Vector3 size(random.uniform(0.2, 0.8), random.uniform(0.1, 0.6), random.uniform(0.05, 0.4));
  const double play = std::pow(10.0, random.uniform(-4.0, std::log10(2e-2)));
  const Vector3 turn = random.vector(3.0);
  const Pose X_WF = turned_at(random.vector(2.0), rotation_about(turn / norm(turn), norm(turn)));
  const Obstacles straight = shell(size, play);
  Obstacles walls;
  for (std::size_t i = 0; i < straight.solids.size(); ++i)
    walls.add(from_file(straight.solids[i], compose(X_WF, straight.X_WO[i])), Pose{});
  ProgressTrial out =
      body_trial(from_file(Hexahedron::from_size(size), X_WF), {}, walls, gap, ContactPolicy::slide);
  Vector3 end_F = random.vector(0.05);
  end_F.x() = random.uniform(0.5, 0.9) * size.x();
  const Vector3 end = rotate(X_WF.R, end_F), tilt = random.vector(0.15);
  out.command = [end, tilt, rate](const Configuration& at, int) {
    return Configuration{{}, RigidPath::by(at.X_WO, end / (2.0 * rate), tilt / (2.0 * rate)).to()};
  };
  out.frames = static_cast<int>(2 * rate);
  return out;
}

/// Three bars that turn about z, the second and the third a centimetre at most from a box each.
ProgressTrial two_links(double rate, double gap, Random& random) {
  const auto arm = make_arm("arm", 3);
  const std::vector<double> q = {random.uniform(-0.5, 0.5), random.uniform(0.1, 0.8),
                                 random.uniform(0.1, 0.8)};
  std::vector<Pose> X_WL(arm->links().size());
  arm->link_poses({}, q, X_WL);
  Obstacles obstacles;
  for (const char* link : {"2", "3"}) {
    // In the bar's frame its flank is at y = 0.1.
    const double tilt = random.uniform(0.2, 1.3), half = 0.2 * (std::cos(tilt) + std::sin(tilt));
    const Vector3 p(random.uniform(0.5, 1.8), 0.1 + random.uniform(1e-4, 1e-2) + half, 0);
    obstacles.add(Vector3(0.4, 0.4, 2.0),
                  compose(X_WL[arm->find_link(link)], turned_at(p, rotation_about(Vector3::UnitZ(), tilt))));
  }
  ProgressTrial out = arm_trial(arm, {}, q, obstacles, gap);
  command_rates(out, {random.uniform(0.02, 0.07), random.uniform(-0.02, 0.07), random.uniform(-0.02, 0.07)},
                rate);
  out.frames = static_cast<int>(3 * rate);
  return out;
}

/// The SSRMS-type arm that stands on what is left of it, with `tool` fixed to its tip.
struct ToolArm {
  std::shared_ptr<const Mechanism> with_tool, plain;
  std::vector<double> q;
  Pose X_WB;  // so that the tip is at X_WT
};

ToolArm arm_with(const std::vector<PlacedHexahedron>& tool, const Pose& X_WT, Random& random) {
  ToolArm out;
  MechanismDescription description = make_ssrms();
  description.base = "base_lee";
  out.plain = std::make_shared<const Mechanism>(description);
  description.links.push_back({"tool", tool, {}});
  JointDescription held;
  held.name = "held", held.parent = "tip", held.child = "tool";
  description.joints.push_back(held);
  // The part in the bore is held there.
  description.exempt_pairs.push_back({"tip_lee", "tool"});
  out.with_tool = std::make_shared<const Mechanism>(description);
  for (const double degrees : {10, 25, -70, 110, -35, 20, 15})
    out.q.push_back((degrees + random.uniform(-5, 5)) * kDegree);
  std::vector<Pose> X_BL(out.plain->links().size());
  out.plain->link_poses({}, out.q, X_BL);
  out.X_WB = rigid_frame(compose(X_WT, inverse(X_BL[out.plain->find_link("tip")])));
  return out;
}

/// By resolved rates of the tip's frame, from wherever it is.
void command_tip(ProgressTrial& trial, const ToolArm& arm, const Twist& rate_W, double rate) {
  const std::uint32_t tip = arm.plain->find_link("tip");
  trial.command = [=, plain = arm.plain, X_WB = arm.X_WB,
                   control = std::make_shared<ResolvedRate>(*arm.plain, tip)](const Configuration& at, int) {
    std::vector<Pose> X_WL(plain->links().size());
    plain->link_poses(X_WB, at.q, X_WL);
    Configuration goal = at;
    std::vector<double> rates(at.q.size());
    control->solve(X_WL, X_WL[tip].p, rate_W, rates);
    for (std::size_t k = 0; k < rates.size(); ++k) goal.q[k] += rates[k] / rate;
    return goal;
  };
  trial.frames = static_cast<int>(3 * rate);
}

void hold_by_tool(ProgressTrial& trial, const std::string& link) {
  ArmHandStiffness hand;
  hand.link = link;
  trial.world->set_hand(trial.arm, hand);
  trial.model->hold(hand);
}

/// x of the tip down.
Matrix3 downwards() { return rotation_about(Vector3::UnitY(), 0.5 * std::numbers::pi); }

/// Four bars about a square bore, a millimetre over a stem already, and commanded down and somewhat aside.
ProgressTrial fit_bore(double rate, double gap, Random& random) {
  constexpr double kPlay = 1e-6, kLong = 0.15, kWall = 0.03;
  const double width = random.uniform(0.03, 0.1), out = 0.5 * (width + kWall) + kPlay;
  std::vector<PlacedHexahedron> bars;
  for (const double side : {1.0, -1.0}) {
    bars.push_back({side > 0 ? "left" : "right", Hexahedron::from_size({kLong, kWall, width + 2 * kPlay}),
                    at(0.05 + 0.5 * kLong, side * out, 0)});
    bars.push_back({side > 0 ? "upper" : "lower", Hexahedron::from_size({kLong, width, kWall}),
                    at(0.05 + 0.5 * kLong, 0, side * out)});
  }
  // The stem ends a millimetre within the bore, whose mouth is 0.2 m from the tip.
  const ToolArm arm = arm_with(bars, turned_at({0, 0, 0.199}, downwards()), random);
  Obstacles stem;
  stem.add(Vector3(width, width, 0.3), at(0, 0, -0.15));
  ProgressTrial trial = arm_trial(arm.with_tool, arm.X_WB, arm.q, stem, gap);
  hold_by_tool(trial, "tool");
  Twist wanted{random.vector(2e-3), random.vector(1e-2)};
  wanted.v.z() = -0.02;
  command_tip(trial, arm, wanted, rate);
  return trial;
}

/// Blocks of three by five by two, which the arm carries into a slot that opens upwards.
ProgressTrial payload(double rate, double gap, Random& random) {
  constexpr double kPlay = 1e-3, kWall = 0.05, kDeep = 0.5;
  const Vector3 block(0.1, 0.12, 0.15), half(0.1, 0.3, 0.225);  // along the tip's axes
  std::vector<PlacedHexahedron> blocks;
  for (int i = 0; i < 30; ++i) {
    const Vector3 p(0.1 + block.x() * (i % 2 + 0.5), block.y() * (i / 2 % 5 - 2), block.z() * (i / 10 - 1));
    blocks.push_back({"block " + std::to_string(i), Hexahedron::from_size(block), at(p.x(), p.y(), p.z())});
  }
  // The tip's z is along x, and its y is y: the payload's lower face is 5 mm above the slot.
  const ToolArm arm = arm_with(blocks, turned_at({0, 0, 0.305}, downwards()), random);
  Obstacles slot;
  for (const double side : {1.0, -1.0}) {
    slot.add(Vector3(kWall, 1.0, kDeep), at(side * (half.z() + kPlay + 0.5 * kWall), 0, -0.5 * kDeep));
    slot.add(Vector3(1.0, kWall, kDeep), at(0, side * (half.y() + kPlay + 0.5 * kWall), -0.5 * kDeep));
  }
  ProgressTrial trial;
  trial.is_arm = true;
  trial.world = world_with(slot, gap, ContactPolicy::slide);
  trial.arm = trial.world->add_mechanism({arm.plain, arm.X_WB, arm.q, {}, {}});
  const auto tree = std::make_shared<HexahedronTree>(blocks, "payload");
  const ObjectHandle load = trial.world->add({tree, turned_at({0, 0, 0.305}, downwards())});
  const ObjectHandle end = trial.world->link(trial.arm, "tip_lee");
  trial.world->latch(end, load, {{end, load}});
  trial.model = std::make_unique<MoverModel>(arm.with_tool, arm.X_WB, slot.solids, slot.X_WO);
  hold_by_tool(trial, "tip");
  Twist wanted{random.vector(5e-3), random.vector(2e-2)};
  wanted.v.z() = -0.05;
  command_tip(trial, arm, wanted, rate);
  return trial;
}

}  // namespace

std::optional<ProgressTrial> make_tight_trial(std::string_view scene, double rate, double gap,
                                              Random& random) {
  if (scene == "pegs") return pegs(rate, gap, 1.0, random);
  if (scene == "pegs_large") return pegs(rate, gap, 1e3, random);
  if (scene == "pegs_small") return pegs(rate, gap, 1e-3, random);
  if (scene == "file_drawers") return file_drawers(rate, gap, random);
  if (scene == "two_links") return two_links(rate, gap, random);
  if (scene == "fit_bore") return fit_bore(rate, gap, random);
  if (scene == "payload") return payload(rate, gap, random);
  return std::nullopt;
}

}  // namespace touchstone
