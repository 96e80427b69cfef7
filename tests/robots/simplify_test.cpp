#include "touchstone/adapters/robots/simplify.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "touchstone/contact_core/native/native.hpp"

namespace touchstone {
namespace {

PlacedHexahedron cube(const char* name, const Vector3& p) {
  return {name, Hexahedron::from_size({1, 1, 1}, name), {Matrix3::Identity(), p}};
}

JointDescription joint(const char* name, JointKind kind, const char* parent, const char* child,
                       const Vector3& p) {
  return {name, kind, parent, child, {Matrix3::Identity(), p}};
}

/// world - base | turns | boom - flange - tool.
MechanismDescription robot() {
  MechanismDescription out;
  out.name = "robot";
  out.links = {{"world"},
               {"base", {cube("a", {0, 0, 0})}},
               {"boom", {cube("b", {5, 0, 0})}},
               {"flange"},
               {"tool", {cube("t", {1, 0, 0})}}};
  const Matrix3 ball = 0.4 * Matrix3::Identity();
  out.links[2].mass = {2.0, {5, 0, 0}, 2.0 * ball, {5, 0, 0}};
  out.links[4].mass = {1.0, {1, 0, 0}, ball, {1, 0, 0}};
  out.joints = {joint("w", JointKind::fixed, "world", "base", {0, 0, 1}),
                joint("turn", JointKind::revolute, "base", "boom", {0, 0, 2}),
                joint("f", JointKind::fixed, "boom", "flange", {8, 0, 0}),
                joint("t", JointKind::fixed, "flange", "tool", {2, 0, 0})};
  out.exempt_pairs = {{"base", "tool"}};
  return out;
}

TEST(Simplify, FixedJointsVanishAndNothingMoves) {
  const Mechanism before(robot()), after(without_fixed_joints(robot()));
  ASSERT_EQ(after.links().size(), 2u);
  ASSERT_EQ(after.joints().size(), 1u);
  const std::vector<double> q = {0.7};
  std::vector<Pose> X(5), Y(2);
  before.link_poses({}, q, X);
  after.link_poses({}, q, Y);
  const Vector3 expected = transform(X[4], before.placed(2).X_OS.p);
  ASSERT_EQ(after.solid_name(2), "boom/tool.t");
  EXPECT_LE(norm(transform(Y[1], after.placed(2).X_OS.p) - expected), 1e-14);
  EXPECT_LE(norm(transform(Y[0], after.placed(0).X_OS.p) - Vector3(0, 0, 1)), 1e-15);
  EXPECT_TRUE(after.is_exempt(0, 2));
}

TEST(Simplify, MassesAddUpAboutTheCommonCentre) {
  const MassProperties mass = Mechanism(without_fixed_joints(robot())).links()[1].mass;
  EXPECT_EQ(mass.mass, 3.0);
  EXPECT_LE(norm(mass.centre_L - Vector3(7, 0, 0)), 1e-14);  // 2 kg at 5 m, 1 kg at 11 m
  EXPECT_EQ(mass.inertia_about_L, mass.centre_L);
  EXPECT_NEAR(mass.inertia_L(0, 0), 1.2, 1e-13);
  EXPECT_NEAR(mass.inertia_L(1, 1), 1.2 + 2.0 * 4.0 + 1.0 * 16.0, 1e-12);
}

TEST(Simplify, LinksThatOverlapInTheReferencePoseAreExemptAndNamed) {
  MechanismDescription arm = robot();
  arm.exempt_pairs.clear();
  arm.links[4].solids[0].X_OS.p = {-9.6, 0, -1.5};  // back at the base
  const auto native = make_native();
  const std::vector<std::string> lines = exempt_reference_overlaps(arm, *native);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_THAT(lines[0], testing::HasSubstr("'base' and 'tool' overlap by 0.5"));
  ASSERT_EQ(arm.exempt_pairs.size(), 1u);
  EXPECT_TRUE(exempt_reference_overlaps(arm, *native).empty());
}

}  // namespace
}  // namespace touchstone
