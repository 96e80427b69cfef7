// Any narrowphase of ours inside every engine: it is asked, its answers decide, and one without manifolds is
// refused by name.

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/engines/engine_suite.hpp"

namespace touchstone {
namespace {

using namespace engine_tests;
using physics::DynamicScene;
using physics::DynamicsEngine;
using physics::EngineChoice;

/// Native's answers by another name; or none, and every pair is apart.
class Other final : public Narrowphase {
 public:
  Other(bool is_blind, std::atomic<int>& asked) : is_blind_(is_blind), asked_(asked) {}
  std::string_view name() const noexcept override { return is_blind_ ? "blind" : "other"; }
  const Capabilities& capabilities() const noexcept override { return native_->capabilities(); }
  void build(std::span<const Hexahedron> solids) override { native_->build(solids); }
  std::unique_ptr<Workspace> make_workspace() const override { return native_->make_workspace(); }
  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override {
    asked_ += static_cast<int>(input.pairs.size());
    for (const SolidPair& pair : input.pairs) EXPECT_LT(pair.a, pair.b);
    if (!is_blind_) return native_->evaluate(input, output, workspace);
    for (std::size_t i = 0; i < input.pairs.size(); ++i) {
      output.status[i] = PairStatus::separated;
      output.geometry[i] = no_geometry(kInfinity);
    }
  }

 private:
  bool is_blind_;
  std::atomic<int>& asked_;
  std::unique_ptr<Narrowphase> native_ = make_native();
};

/// All of ours, `other` and `blind`, and every engine with them.
struct WithOthers {
  BackendRegistry backends;
  physics::EngineRegistry engines;
  std::atomic<int> asked = 0;

  WithOthers() {
    register_all_backends(backends);
    for (const bool is_blind : {false, true})
      backends.add(BackendRegistry::NarrowphaseEntry{
          is_blind ? "blind" : "other",
          "",
          [this, is_blind] { return std::make_unique<Other>(is_blind, asked); },
          {}});
    physics::register_all_engines(engines, backends);
  }
};

/// A frustum beside a stack of two boxes, a little tilted, and a box that slides.
DynamicScene some_of_all() {
  DynamicScene scene = empty_scene(0.2);
  add_ground(scene);
  add_box(scene, "low", {0.2, 0.2, 0.2}, {0, 0, 0.1001}, 1.0);
  add_box(scene, "high", {0.1, 0.3, 0.1}, {0.01, 0.02, 0.2502}, 1.0);
  const std::size_t frustum = add_box(scene, "frustum", {0.2, 0.2, 0.2}, {0.5, 0, 0.101}, 1.0);
  std::array<Vector3, 8> v = Hexahedron::from_size({0.2, 0.2, 0.2}).vertices();
  for (Vector3& p : v)
    if (p.z() > 0.0) p.x() *= 0.5, p.y() *= 0.5;
  scene.scene.objects[frustum].tree = HexahedronTree({{"box", Hexahedron::from_vertices(v), {}}}, "frustum");
  const std::size_t slides = add_box(scene, "slides", {0.2, 0.2, 0.1}, {-0.5, 0, 0.05}, 1.0);
  scene.bodies[slides].v_W = {-0.3, 0.1, 0};
  return scene;
}

std::unique_ptr<DynamicsEngine> run_in(const WithOthers& with, const EngineChoice& choice,
                                       const DynamicScene& scene) {
  auto engine = with.engines.make(choice, scene);
  while (!engine->is_over()) {
    engine->begin_step();
    const physics::EngineStep step = engine->step();
    EXPECT_TRUE(step.failure.empty()) << choice.text() << ": " << step.failure;
    EXPECT_EQ(step.failed, 0u) << choice.text();
    if (!step.failure.empty()) break;
  }
  return engine;
}

std::vector<std::string> others(const WithOthers& with) {
  std::vector<std::string> names;
  for (const auto& entry : with.engines.engines())
    if (entry.name != "own") names.push_back(entry.name);
  return names;
}

TEST(EngineChecks, AnotherNarrowphaseIsAskedAndDecides) {
  WithOthers with;
  const DynamicScene scene = some_of_all();
  for (const std::string& engine : others(with)) {
    const auto native = run_in(with, {engine, "native"}, scene);
    with.asked = 0;
    const auto other = run_in(with, {engine, "other"}, scene);
    EXPECT_GT(with.asked.load(), 4 * 100) << engine;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      EXPECT_EQ(native->object_pose(i).p, other->object_pose(i).p) << engine << " " << i;
      EXPECT_EQ(native->object_pose(i).R, other->object_pose(i).R) << engine << " " << i;
    }
    const auto blind = run_in(with, {engine, "blind"}, scene);
    for (std::size_t i = 1; i < scene.bodies.size(); ++i)
      EXPECT_NEAR(blind->object_pose(i).p.z() - scene.scene.objects[i].X_WO.p.z(),
                  -0.5 * kGravity * 0.2 * 0.2, 0.5 * kGravity * kStep * 0.2 + 1e-9)
          << engine;
  }
}

/// Every one there is, in every engine: what rests rests.
TEST(EngineChecks, WithAnyOfThemABoxRests) {
  WithOthers with;
  DynamicScene scene = empty_scene(0.2);
  add_ground(scene);
  add_box(scene, "box", {0.2, 0.2, 0.2}, {0, 0, 0.1}, 1.0);
  for (const std::string& engine : others(with))
    for (const std::string& check : with.engines.engine(engine).checks) {
      if (check == "blind") continue;
      const auto run = run_in(with, {engine, check}, scene);
      const double moved = norm(run->object_pose(1).p - scene.scene.objects[1].X_WO.p);
      std::printf("  %-20s moved %.2e m\n", (engine + ":" + check).c_str(), moved);
      EXPECT_LT(moved, 2e-3) << engine << ":" << check;
    }
}

TEST(EngineChecks, ExactInsideIsNativeInsideToRounding) {
  WithOthers with;
  if (!has_backend("exact")) GTEST_SKIP() << "this build has no exact";
  const DynamicScene scene = some_of_all();
  for (const std::string& engine : others(with)) {
    const auto native = run_in(with, {engine, "native"}, scene),
               exact = run_in(with, {engine, "exact"}, scene);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const double off = norm(native->object_pose(i).p - exact->object_pose(i).p);
      EXPECT_LT(off, 1e-4) << engine << " " << scene.scene.objects[i].tree.name();
    }
  }
}

TEST(EngineChecks, OneWithoutManifoldsIsRefusedByName) {
  WithOthers with;
  const DynamicScene scene = some_of_all();
  for (const std::string& engine : others(with)) try {
      with.engines.make({engine, "edge_face"}, scene);
      ADD_FAILURE() << engine << " took edge_face";
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()),
                "engine '" + engine + "': unsupported: check 'edge_face': it has no manifolds");
    }
}

/// Bullet's pairs go at a reset and at a restore, and come again with other numbers of their solids, by which
/// another check is asked in one order or the other.
TEST(EngineChecks, ResetAndRestoredRunsTakeTheirStepsAgain) {
  DynamicScene scene = empty_scene(0.3);
  add_ground(scene);
  for (int i = 0; i < 4; ++i)
    add_box(scene, "box " + std::to_string(i), {0.2 + 0.01 * i, 0.3 - 0.02 * i, 0.1},
            {0.04 * i, 0.02 * i, 0.06 + 0.11 * i}, 2.0);
  const auto engine = engines().make({"bullet", "exact"}, scene);
  /// Where the boxes are at the end.
  const auto end_of_run = [&](double end) {
    while (engine->time() < end - 0.5 * kStep) {
      engine->begin_step();
      const std::string failure = engine->step().failure;
      EXPECT_EQ(failure, "");
      if (!failure.empty()) break;  // time would stand still
    }
    std::vector<Pose> poses;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) poses.push_back(engine->object_pose(i));
    return poses;
  };
  const auto expect_same = [](const std::vector<Pose>& poses, const std::vector<Pose>& first) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      EXPECT_EQ(poses[i].p, first[i].p) << i;
      EXPECT_EQ(poses[i].R, first[i].R) << i;
    }
  };
  const std::vector<Pose> first = end_of_run(0.3);
  engine->reset();
  expect_same(end_of_run(0.3), first);
  // The contacts that Bullet keeps go at a restore, so that restored runs are like each other.
  engine->reset();
  end_of_run(0.15);
  const auto kept = engine->snapshot();
  end_of_run(0.2);
  engine->restore(*kept);
  const std::vector<Pose> restored = end_of_run(0.3);
  engine->restore(*kept);
  expect_same(end_of_run(0.3), restored);
}

}  // namespace
}  // namespace touchstone
