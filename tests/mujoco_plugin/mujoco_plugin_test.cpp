#include "touchstone/adapters/mujoco_plugin/mujoco_plugin.hpp"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <thread>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/mujoco_plugin/collision_scene.hpp"
#include "touchstone/tests/support/ask.hpp"
#include "touchstone/tests/support/counting_allocator.hpp"
#include "touchstone/tests/support/kept_pairs.hpp"
#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone::test {
namespace {

constexpr double kTolerance = 1e-14;
constexpr double kFloat = std::numeric_limits<float>::epsilon();

GeomText box_mesh(double x, double y, double z) { return mesh(Hexahedron::from_size({x, y, z}).vertices()); }

/// In an order that is not Hexahedron's.
std::array<Vector3, 8> shuffled_frustum() {
  std::array<Vector3, 8> v;
  for (int i = 0; i < 8; ++i) {
    const double w = (i & 1) != 0 ? 0.25 : 0.5;
    v[(5 * i + 3) % 8] = {(i & 4) != 0 ? w : -w, (i & 2) != 0 ? w : -w, (i & 1) != 0 ? 0.5 : -0.5};
  }
  return v;
}

TEST(MujocoPlugin, TheNormalPointsFromGeom1ToGeom2AndThePositionIsHalfWay) {
  const MujocoOverride native;
  const GeomText large[2] = {box(2, 2, 2), box_mesh(2, 2, 2)}, small[2] = {box(1, 1, 1), box_mesh(1, 1, 1)};
  for (const bool large_is_mesh : {false, true}) {
    for (const bool small_is_mesh : {false, true}) {
      CollisionScene scene({large[large_is_mesh], small[small_is_mesh]});
      scene.place(0, at(0, 0, 0));
      scene.place(1, at(1.25, 0, 0));
      const std::uint64_t before = mujoco_native_checks();
      const auto contacts = scene.collide();
      EXPECT_EQ(mujoco_native_checks() - before, 1u);
      ASSERT_EQ(contacts.size(), 4u);
      for (const mjContact& contact : contacts) {
        // A box comes before a mesh, whatever the numbers of the geoms.
        EXPECT_EQ(contact.geom1, large_is_mesh && !small_is_mesh ? 1 : 0);
        EXPECT_NEAR(contact.frame[0], contact.geom1 == 0 ? 1.0 : -1.0, kTolerance);
        EXPECT_NEAR(contact.dist, -0.25, kTolerance);
        EXPECT_NEAR(contact.pos[0], 0.875, kTolerance);
        EXPECT_NEAR(std::abs(contact.pos[1]), 0.5, kTolerance);
        // The engine has completed the frame.
        EXPECT_NEAR(std::abs(contact.frame[3]) + std::abs(contact.frame[6]), 0.0, kTolerance);
        EXPECT_NEAR(mju_norm3(contact.frame + 3), 1.0, kTolerance);
      }
    }
  }
}

TEST(MujocoPlugin, ContactsAreThoseWithinTheMargin) {
  const MujocoOverride native;
  for (const double margin : {0.0, 0.1}) {
    CollisionScene scene({box(1, 1, 1), box(1, 1, 1)}, margin);
    scene.place(0, at(0, 0, 0));
    scene.place(1, at(0, 0, 1.0625));
    EXPECT_EQ(scene.collide().size(), margin > 0.0 ? 4u : 0u);
    for (const mjContact& contact : scene.collide()) {
      EXPECT_NEAR(contact.dist, 0.0625, kTolerance);
      EXPECT_NEAR(contact.pos[2], 0.53125, kTolerance);
    }
    scene.place(1, at(0, 0, 1.25));  // later versions add the margins of both geoms
    EXPECT_EQ(scene.collide().size(), 0u);
  }
  // One edge is within it, the other is not.
  CollisionScene scene({box(1, 1, 1), box(1, 1, 1)}, 0.1);
  Pose tilted = at(0, 0, 1.15);
  tilted.R = rotation_from_quaternion(std::cos(0.1), 0.0, std::sin(0.1), 0.0);
  scene.place(0, at(0, 0, 0));
  scene.place(1, tilted);
  const auto contacts = scene.collide();
  EXPECT_EQ(contacts.size(), 2u);
  for (const mjContact& contact : contacts) EXPECT_LE(contact.dist, 0.1);
}

TEST(MujocoPlugin, TouchingIsContactAndAnythingApartIsNot) {
  const MujocoOverride native;
  CollisionScene scene({box(1, 1, 1), box(1, 1, 1)});
  scene.place(0, at(0, 0, 0));
  scene.place(1, at(1 + 0x1p-52, 0, 0));
  EXPECT_EQ(scene.collide().size(), 0u);
  scene.place(1, at(-1, 0, 0));
  EXPECT_EQ(scene.collide().size(), 4u);
  EXPECT_EQ(least_distance(scene.collide()), 0.0);
}

double area_of(std::span<const mjContact> contacts) {  // of the hull's shadow on z = 0, by its extreme pairs
  double area = 0.0;
  for (const mjContact& a : contacts)
    for (const mjContact& b : contacts)
      for (const mjContact& c : contacts)
        for (const mjContact& d : contacts)
          area = std::max(area, 0.5 * ((c.pos[0] - a.pos[0]) * (d.pos[1] - b.pos[1]) -
                                       (c.pos[1] - a.pos[1]) * (d.pos[0] - b.pos[0])));
  return area;
}

TEST(MujocoPlugin, FewerContactsKeepTheDeepestAndTheArea) {
  Pose turned = at(0, 0, 0.9);
  turned.R = rotation_from_quaternion(std::cos(0.3), 0.01, 0.02, std::sin(0.3));
  double deepest = 0.0, area = 0.0;
  for (int most = kMaxManifoldPoints; most >= 1; --most) {
    const MujocoOverride native({.most_contacts = most});
    CollisionScene scene({box(1, 1, 1), box(1, 1, 1)});
    scene.place(0, at(0, 0, 0));
    scene.place(1, turned);
    const auto contacts = scene.collide();
    ASSERT_GE(contacts.size(), 1u);
    ASSERT_LE(static_cast<int>(contacts.size()), most);
    if (most == kMaxManifoldPoints) {
      EXPECT_EQ(contacts.size(), 8u);
      deepest = *least_distance(contacts), area = area_of(contacts);
    }
    EXPECT_EQ(least_distance(contacts), deepest) << most;
    if (most >= 4) {
      EXPECT_GT(area_of(contacts), 0.7 * area) << most;
    }
  }
  EXPECT_THROW(MujocoOverride({.most_contacts = 0}), InputError);
  EXPECT_THROW(MujocoOverride({.most_contacts = 9}), InputError);
}

TEST(MujocoPlugin, AMeshsVerticesMayComeInAnyOrder) {
  const MujocoOverride native;
  CollisionScene scene({mesh(shuffled_frustum()), mesh(shuffled_frustum())});
  scene.place(0, at(0, 0, 0));
  scene.place(1, at(0, 0, 0.75));
  const std::uint64_t before = mujoco_native_checks();
  const auto contacts = scene.collide();
  EXPECT_EQ(mujoco_native_checks() - before, 1u);
  ASSERT_GE(contacts.size(), 4u);
  for (const mjContact& contact : contacts) {
    EXPECT_NEAR(contact.dist, -0.25, 4 * kFloat);
    EXPECT_NEAR(contact.frame[2], 1.0, kFloat);
  }
}

/// Bytes of what MuJoCo answers for all pairs.
std::vector<double> answers(CollisionScene& scene) {
  std::vector<double> all;
  for (const mjContact& contact : scene.collide()) {
    all.push_back(contact.dist);
    all.insert(all.end(), contact.pos, contact.pos + 3);
    all.insert(all.end(), contact.frame, contact.frame + 9);
  }
  return all;
}

std::vector<mjfCollision> table() {
  return {&mjCOLLISIONFUNC[0][0], &mjCOLLISIONFUNC[0][0] + mjNGEOMTYPES * mjNGEOMTYPES};
}

template <class Data>  // const in some versions
int no_contacts(const mjModel*, Data*, mujoco::EngineContact*, int, int, mjtNum) {
  return 0;
}

CollisionScene random_scene(unsigned seed, int count) {
  std::mt19937_64 random(seed);
  std::vector<GeomText> geoms;
  for (int i = 0; i < count; ++i)
    geoms.push_back(i % 3 == 0   ? mesh(shuffled_frustum())
                    : i % 3 == 1 ? box(1, uniform(random, 0.3, 1.5), 1)
                                 : box_mesh(0.5, 1.25, 0.75));
  CollisionScene scene(geoms);
  for (int i = 0; i < count; ++i) scene.place(i, random_pose(random, 1.0));
  return scene;
}

TEST(MujocoPlugin, WhatWasThereIsThereAgain) {
  CollisionScene scene = random_scene(11, 20);
  const auto engines_table = table();
  const auto engines = answers(scene);
  std::vector<double> ours;
  {
    const MujocoOverride outer;
    ours = answers(scene);
    EXPECT_NE(ours, engines);
    int changed = 0;
    for (std::size_t i = 0; i < engines_table.size(); ++i) changed += table()[i] != engines_table[i];
    EXPECT_EQ(changed, 3);
    { const MujocoOverride inner; }
    EXPECT_EQ(answers(scene), ours);
  }
  EXPECT_EQ(table(), engines_table);
  EXPECT_EQ(answers(scene), engines);
  // A program's own.
  mjfCollision& entry = mjCOLLISIONFUNC[mjGEOM_BOX][mjGEOM_MESH];
  const mjfCollision engines_entry = entry;
  entry = &no_contacts;
  const auto programs_table = table();
  const auto programs = answers(scene);
  EXPECT_NE(programs, engines);
  {
    const MujocoOverride native;
    EXPECT_EQ(answers(scene), ours);
  }
  EXPECT_EQ(table(), programs_table);
  EXPECT_EQ(answers(scene), programs);
  entry = engines_entry;
}

TEST(MujocoPlugin, AMeshThatIsNoHexahedronGoesToTheEngine) {
  const std::vector<Vector3> pyramid = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 1}};
  // 8 vertices, yet two squares turned against each other.
  std::vector<Vector3> antiprism;
  for (int i = 0; i < 8; ++i)
    antiprism.push_back({std::cos(0.25 * 3.14159265 * i), std::sin(0.25 * 3.14159265 * i), 1.0 * (i % 2)});
  for (const auto& vertices : {pyramid, antiprism}) {
    CollisionScene scene({mesh(vertices), box(1, 1, 1)});
    scene.place(0, at(0, 0, 0));
    scene.place(1, at(0.25, 0.5, 0.75));
    const auto engines = answers(scene);
    EXPECT_FALSE(engines.empty());
    const MujocoOverride native;
    const std::uint64_t before = mujoco_native_checks();
    EXPECT_EQ(answers(scene), engines);
    EXPECT_EQ(mujoco_native_checks(), before);
  }
}

TEST(MujocoPlugin, AnObserverIsToldOfBothChecksInOurTerms) {
  CollisionScene scene({box(2, 2, 2), box(1, 1, 1)}), with_margin({box(2, 2, 2), box(1, 1, 1)}, 0.125);
  scene.place(0, at(0, 0, 0));
  scene.place(1, at(1.25, 0, 0));
  with_margin.place(0, at(0, 0, 0));
  with_margin.place(1, at(1.5625, 0, 0));
  const auto engines = answers(scene);
  for (const EngineCheck check : {EngineCheck::own, EngineCheck::native}) {
    KeptPairs observer;
    const MujocoOverride native({.check = check, .observer = &observer});
    const auto contacts = answers(scene);
    ASSERT_EQ(observer.all.size(), 1u);
    const KeptPairs::Observation& observed = observer.all[0];
    EXPECT_EQ(observed.half_extents[0].x(), 1.0);
    EXPECT_EQ(observed.status, PairStatus::overlapping);
    // The engine's input: of its own check half the depth, in MuJoCo 2.2.2.
    const double given = contacts[0];
    EXPECT_LT(given, -0.12);
    EXPECT_NEAR(observed.geometry.separation, given, kTolerance);
    EXPECT_NEAR(observed.geometry.n_AB_W.x(), 1.0, kTolerance);
    ASSERT_EQ(observed.points.size(), contacts.size() / 13);
    for (const ContactPoint& point : observed.points) {
      EXPECT_NEAR(point.p_A_W.x(), 0.875 - 0.5 * given, kTolerance);
      EXPECT_NEAR(point.p_B_W.x(), 0.875 + 0.5 * given, kTolerance);
    }
    if (check == EngineCheck::own) {
      EXPECT_EQ(contacts, engines);  // the engine goes on as it was
    }
    EXPECT_FALSE(answers(with_margin).empty());
    EXPECT_EQ(observer.all.back().status, PairStatus::separated);
  }
}

TEST(MujocoPlugin, BadPosesHaveNoContacts) {
  const MujocoOverride native;
  CollisionScene scene({box(1, 1, 1), box(1, 1, 1)});
  scene.place(0, at(0, 0, 0));
  scene.place(1, at(0, 0, 0));
  mujoco::EngineContact contacts[mjMAXCONPAIR];
  const mjfCollision check = mjCOLLISIONFUNC[mjGEOM_BOX][mjGEOM_BOX];
  EXPECT_GT(check(scene.model.get(), scene.data.get(), contacts, 0, 1, 0.0), 0);
  for (const double bad : {kInfinity, kNaN}) {
    scene.data->geom_xpos[3] = bad;
    EXPECT_EQ(check(scene.model.get(), scene.data.get(), contacts, 0, 1, 0.0), 0);
  }
}

mujoco::ModelHandle stack_model() {
  std::string bodies;
  for (int i = 0; i < 5; ++i)
    bodies += "<body pos=\"0 0 " + std::to_string(0.5 + i) + "\"><freejoint/><geom mass=\"1\" " +
              (i % 2 == 0 ? "type=\"box\" size=\"0.5 0.5 0.5\"" : "type=\"mesh\" mesh=\"cube\"") +
              "/></body>";
  return mujoco::load_model(
      "<mujoco><size nconmax=\"100\" njmax=\"600\"/><asset><mesh name=\"cube\" vertex=\"" +
      box_mesh(1, 1, 1).numbers +
      "\"/></asset><worldbody><geom type=\"box\" size=\"5 5 1\" pos=\"0 0 -1\"/>" + bodies +
      "</worldbody></mujoco>");
}

TEST(MujocoPlugin, SteppingAllocatesNothing) {
  const MujocoOverride native;
  const mujoco::ModelHandle model = stack_model();
  const mujoco::DataHandle data(mj_makeData(model.get()));
  for (int i = 0; i < 20; ++i) mj_step(model.get(), data.get());
  const std::uint64_t checks = mujoco_native_checks();
  const std::size_t before = allocation_count();
  for (int i = 0; i < 200; ++i) mj_step(model.get(), data.get());
  EXPECT_EQ(allocation_count() - before, 0u);
  EXPECT_GE(mujoco_native_checks() - checks, 1000u);
  EXPECT_EQ(data->ncon, 20);
}

TEST(MujocoPlugin, ThreadsThatStepGetTheSameBits) {
  const MujocoOverride native;
  const mujoco::ModelHandle model = stack_model();
  constexpr std::size_t kThreads = 4;
  std::array<std::vector<double>, kThreads> ends;
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      const mujoco::DataHandle data(mj_makeData(model.get()));
      for (int i = 0; i < 300; ++i) mj_step(model.get(), data.get());
      ends[t].assign(data->qpos, data->qpos + model->nq);
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t t = 1; t < kThreads; ++t) EXPECT_EQ(ends[t], ends[0]);
  EXPECT_NEAR(ends[0][7 * 4 + 2], 4.5, 0.01);
}

}  // namespace
}  // namespace touchstone::test
