#include "touchstone/contact_core/mechanism/mechanism.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/mechanism/reference_overlaps.hpp"
#include "touchstone/contact_core/mechanism/round_parts.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/mechanism/random_chain.hpp"
#include "touchstone/tests/support/degree.hpp"

namespace touchstone {
namespace {

PlacedHexahedron box(const std::string& name, const Vector3& centre, const Vector3& size) {
  Pose X;
  X.p = centre;
  return {name, Hexahedron::from_size(size), X};
}

JointDescription joint(const std::string& name, JointKind kind, const std::string& parent,
                       const std::string& child, const Vector3& origin, const Vector3& axis) {
  JointDescription out;
  out.name = name;
  out.kind = kind;
  out.parent = parent;
  out.child = child;
  out.X_PJ.p = origin;
  out.axis_J = axis;
  return out;
}

/// A cart on a rail along x that carries two arms of two boxes each, turning about z.
MechanismDescription two_armed() {
  MechanismDescription out;
  out.name = "robot";
  out.links.push_back({"rail", {box("beam", {0, 0, -0.5}, {20, 0.4, 0.4})}, {}});
  out.links.push_back({"cart", {box("body", {0, 0, 0}, {0.8, 0.8, 0.4})}, {}});
  out.joints.push_back(joint("drive", JointKind::prismatic, "rail", "cart", {0, 0, 0}, {1, 0, 0}));
  for (const std::string side : {"left", "right"}) {
    const double sign = side == "left" ? 1 : -1;
    out.links.push_back({side + "_upper", {box("boom", {0, sign * 1, 0}, {0.2, 1.8, 0.2})}, {}});
    out.links.push_back({side + "_lower", {box("boom", {0, sign * 1, 0}, {0.2, 1.8, 0.2})}, {}});
    out.joints.push_back(joint(side + "_shoulder", JointKind::revolute, "cart", side + "_upper",
                               {0, sign * 0.4, 0}, {0, 0, 1}));
    out.joints.push_back(joint(side + "_elbow", JointKind::revolute, side + "_upper", side + "_lower",
                               {0, sign * 2, 0}, {0, 0, 1}));
  }
  return out;
}

std::vector<Pose> poses_of(const Mechanism& mechanism, const std::vector<double>& q, const Pose& X_WB = {}) {
  std::vector<Pose> poses(mechanism.links().size());
  mechanism.link_poses(X_WB, q, poses);
  return poses;
}

TEST(Mechanism, ForwardKinematicsOfTwoArmsOnARail) {
  const Mechanism mechanism(two_armed());
  ASSERT_EQ(mechanism.value_count(), 5u);
  const double a = 30 * kDegree, b = 50 * kDegree;
  const std::vector<Pose> X = poses_of(mechanism, {3, a, b, 0, -90 * kDegree});
  EXPECT_EQ(X[mechanism.find_link("cart")].p, Vector3(3, 0, 0));
  const Vector3 left = transform(X[mechanism.find_link("left_lower")], Vector3(0, 2, 0));
  EXPECT_NEAR(left.x(), 3 - 2 * std::sin(a) - 2 * std::sin(a + b), 1e-14);
  EXPECT_NEAR(left.y(), 0.4 + 2 * std::cos(a) + 2 * std::cos(a + b), 1e-14);
  const Vector3 right = transform(X[mechanism.find_link("right_lower")], Vector3(0, -2, 0));
  EXPECT_NEAR(right.x(), 3 - 2, 1e-14);
  EXPECT_NEAR(right.y(), -2.4, 1e-14);
}

TEST(Mechanism, AnyLinkMayBeTheBase) {
  test::Draw draw(5);
  for (int i = 0; i < 100; ++i) {
    const Mechanism mechanism(draw.mechanism());
    std::vector<double> q;
    for (std::uint32_t k = 0; k < mechanism.value_count(); ++k) q.push_back(draw.real(-3, 3));
    const std::vector<Pose> X = poses_of(mechanism, q, draw.pose(2));
    const auto held = static_cast<std::uint32_t>(draw.integer(0, static_cast<int>(X.size()) - 1));
    const Mechanism other = mechanism.with_base(mechanism.links()[held].name);
    EXPECT_EQ(other.base(), held);
    const std::vector<Pose> Y = poses_of(other, q, X[held]);
    for (std::size_t link = 0; link < X.size(); ++link) {
      EXPECT_LE(norm(X[link].p - Y[link].p), 1e-13);
      EXPECT_LE((X[link].R - Y[link].R).cwiseAbs().maxCoeff(), 1e-14);
    }
  }
}

TEST(Mechanism, ALinkDependsOnItsOwnChainOnly) {
  const Mechanism mechanism(two_armed());
  const std::vector<Pose> X = poses_of(mechanism, {0.3, 0.1, 0.2, 0.3, 0.4});
  const std::vector<Pose> Y = poses_of(mechanism, {0.3, 0.1, 0.2, 1.3, -0.4});
  for (const char* same : {"rail", "cart", "left_upper", "left_lower"}) {
    const std::uint32_t link = mechanism.find_link(same);
    EXPECT_TRUE(X[link].R == Y[link].R && X[link].p == Y[link].p) << same;
  }
  EXPECT_EQ(mechanism.chain(mechanism.find_link("left_lower")).size(), 3u);
  EXPECT_TRUE(mechanism.chain(mechanism.base()).empty());
}

TEST(Mechanism, AdjacentAndListedPairsAreExemptAndNothingElse) {
  MechanismDescription description = two_armed();
  description.exempt_pairs = {{"rail/beam", "left_upper"}, {"rail", "right_upper"}};
  const Mechanism mechanism(description);
  const auto solid = [&](const char* link) {
    return mechanism.links()[mechanism.find_link(link)].first_solid;
  };
  EXPECT_TRUE(mechanism.is_exempt(solid("rail"), solid("cart")));
  EXPECT_TRUE(mechanism.is_exempt(solid("cart"), solid("left_upper")));
  EXPECT_TRUE(mechanism.is_exempt(solid("left_upper"), solid("rail")));
  EXPECT_TRUE(mechanism.is_exempt(solid("right_upper"), solid("rail")));
  EXPECT_FALSE(mechanism.is_exempt(solid("rail"), solid("left_lower")));
  EXPECT_FALSE(mechanism.is_exempt(solid("left_upper"), solid("right_upper")));
  EXPECT_EQ(mechanism.solid_name(solid("rail")), "rail/beam");
}

TEST(Mechanism, OverlapsInTheReferencePoseAreReportedUntilListed) {
  MechanismDescription description = two_armed();
  const auto native = make_native();
  EXPECT_TRUE(find_reference_overlaps(Mechanism(description), *native).empty());
  // The left upper boom points along x, beside the beam; the lower one, hung low, across it.
  description.links[3].solids[0].X_OS.p.z() = -0.4;
  description.reference = {0, -90 * kDegree, -90 * kDegree, 0, 0};
  const Mechanism mechanism(description);
  const std::vector<ReferenceOverlap> overlaps = find_reference_overlaps(mechanism, *native);
  ASSERT_EQ(overlaps.size(), 1u);
  EXPECT_EQ(overlaps[0].status, PairStatus::overlapping);
  // Up is the shortest way out: the boom's underside is at -0.5, the beam's top at -0.3.
  EXPECT_NEAR(overlaps[0].separation, -0.2, 1e-12);
  EXPECT_THAT(to_string(overlaps[0], mechanism), testing::HasSubstr("'rail/beam' and 'left_lower/boom'"));
  description.exempt_pairs = {{"rail/beam", "left_lower/boom"}};
  EXPECT_TRUE(find_reference_overlaps(Mechanism(description), *native).empty());
}

TEST(Mechanism, LimitsAreData) {
  MechanismDescription description = two_armed();
  description.joints[0].lower = -8, description.joints[0].upper = 8;
  const Mechanism mechanism(description);
  EXPECT_TRUE(mechanism.is_within_limits(std::vector<double>{8, 0, 0, 0, 0}));
  EXPECT_FALSE(mechanism.is_within_limits(std::vector<double>{8.001, 0, 0, 0, 0}));
  EXPECT_FALSE(mechanism.is_within_limits(std::vector<double>{std::nan(""), 0, 0, 0, 0}));
  EXPECT_FALSE(mechanism.is_within_limits(std::vector<double>{0, 0}));
}

void expect_rejected(const std::function<void(MechanismDescription&)>& spoil, const std::string& message) {
  MechanismDescription description = two_armed();
  spoil(description);
  try {
    const Mechanism mechanism(description);
    ADD_FAILURE() << "accepted; expected: " << message;
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(message));
  }
}

TEST(Mechanism, BadInputIsRejectedByName) {
  using D = MechanismDescription;
  const double nan = std::nan("");
  // Links and joints have names, each once, that are found.
  expect_rejected([](D& d) { d.name.clear(); }, "mechanism: no name");
  expect_rejected([](D& d) { d.links.clear(); }, "mechanism 'robot': no link");
  expect_rejected([](D& d) { d.links[1].name = "rail"; },
                  "mechanism 'robot', link 'rail': the name occurs twice");
  expect_rejected([](D& d) { d.links[1].name = "a/b"; }, "'/' in its name 'a/b'");
  expect_rejected([](D& d) { d.joints[2].name = "drive"; }, "joint 'drive': the name occurs twice");
  expect_rejected([](D& d) { d.joints[0].child = "wagon"; },
                  "mechanism 'robot', joint 'drive': no link 'wagon'");
  expect_rejected([](D& d) { d.joints[0].child = "rail"; }, "joins link 'rail' to itself");
  // Axes, frames and limits.
  expect_rejected([](D& d) { d.joints[0].axis_J *= 0.9; },
                  "mechanism 'robot', joint 'drive': the axis has length 0.9, not 1");
  expect_rejected([&](D& d) { d.joints[0].axis_J.x() = nan; }, "the axis has length nan");
  expect_rejected([](D& d) { d.joints[0].X_PJ.R *= 2; },
                  "mechanism 'robot', joint 'drive', X_PJ: not a rotation");
  expect_rejected([](D& d) { d.joints[0].lower = 2, d.joints[0].upper = 1; },
                  "limits from 2 to 1 hold no value");
  expect_rejected([&](D& d) { d.joints[0].upper = nan; }, "limits from -inf to nan");
  expect_rejected([](D& d) { d.joints[0].rate = -1; }, "the rate is -1, not >= 0");
  expect_rejected([](D& d) { d.joints[0].effort = -3; }, "the effort is -3, not >= 0");
  // The tree and its base.
  expect_rejected([](D& d) { d.joints.pop_back(); },
                  "mechanism 'robot', link 'right_lower': no joint leads to it from base 'rail'");
  expect_rejected(
      [](D& d) {
        d.joints.push_back(
            joint("strut", JointKind::fixed, "left_lower", "right_lower", {0, 0, 0}, {0, 0, 1}));
      },
      "joint 'strut': closes a loop");
  expect_rejected([](D& d) { d.base = "ceiling"; }, "mechanism 'robot', base: no link 'ceiling'");
  // Reference values, exempt pairs and masses.
  expect_rejected([](D& d) { d.reference = {1}; }, "1 reference values for 5 joints that move");
  expect_rejected(
      [](D& d) {
        d.joints[0].upper = 1, d.reference = {2, 0, 0, 0, 0};
      },
      "joint 'drive': reference value 2 is not within -inf and 1");
  expect_rejected([](D& d) { d.exempt_pairs = {{"rail", "moon"}}; }, "exempt pair: no link 'moon'");
  expect_rejected(
      [](D& d) {
        d.exempt_pairs = {{"rail/tail", "cart"}};
      },
      "link 'rail' has no hexahedron 'tail'");
  expect_rejected([](D& d) { d.exempt_pairs = {{"rail", "rail/beam"}}; }, "are of one link");
  expect_rejected([](D& d) { d.links[0].mass.mass = -1; }, "link 'rail': the mass is -1 kg");
  expect_rejected([](D& d) { d.links[0].mass.inertia_L(0, 1) = 1; },
                  "link 'rail': inertia entry (0, 1) is 1");
}

TEST(RoundParts, SlicesFillThePolygonAndTheErrorIsStated) {
  for (const bool inscribed : {true, false}) {
    const RoundPart part = make_cylinder(0.175, 2, 12, inscribed, {}, "boom");
    ASSERT_EQ(part.solids.size(), 5u);
    double innermost = 1, outermost = 0, volume = 0;
    for (const PlacedHexahedron& slice : part.solids) {
      for (const Vector3& v : slice.solid.vertices())
        outermost = std::max(outermost, std::hypot(v.x(), v.y()));
      // Only faces on the outside are not shared: those along the polygon's edges are nearest the axis there.
      const auto& v = slice.solid.vertices();
      Vector3 centre = Vector3::Zero();
      for (const Vector3& p : v) centre += p / 8;
      for (int face = 0; face < 6; ++face) {
        const auto& loop = Hexahedron::kFaceVertices[face];
        for (int k = 1; k < 3; ++k)
          volume += dot(v[loop[0]] - centre, cross(v[loop[k]] - centre, v[loop[k + 1]] - centre)) / 6;
        const Plane& plane = slice.solid.face_plane(face);
        if (std::abs(plane.normal.z()) < 0.5 && std::abs(plane.normal.y()) > 0.1)
          innermost = std::min(innermost, std::abs(plane.offset));
      }
    }
    const double error = part.figures.at(0).error;
    EXPECT_NEAR(inscribed ? outermost : innermost, 0.175, 1e-15);
    EXPECT_NEAR(std::max(outermost - 0.175, 0.175 - innermost), error, 1e-15);
    const double r = inscribed ? 0.175 : 0.175 / std::cos(std::numbers::pi / 12);
    EXPECT_NEAR(volume, 2 * 6 * r * r * std::sin(2 * std::numbers::pi / 12), 1e-14);
  }
  EXPECT_EQ(make_tube(0.208, 0.1, 1, 8, false, {}, "bore").solids.size(), 8u);
  EXPECT_THROW(make_cylinder(0.1, 1, 7, true, {}, "odd"), InputError);
  EXPECT_THROW(make_cylinder(-0.1, 1, 8, true, {}, "negative"), InputError);
  EXPECT_THROW(make_tube(0.1, 0.2, 1, 8, true, {}, "inside out"), InputError);
}

}  // namespace
}  // namespace touchstone
