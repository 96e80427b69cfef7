// Solids whose corners were read from files, in any order: `native` answers for their hulls as `exact` does.

#include "touchstone/tests/support/file_corners.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "touchstone/adapters/exact/exact.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/support/ask.hpp"
#include "touchstone/tests/support/scale_of.hpp"

namespace touchstone {
namespace {

/// Of separation, over the larger of S and of the corners' largest coordinate in the file: world vertices
/// round by the products R v, however near to the world's origin they end.
constexpr double kSeparationBound = 4e-15;
constexpr std::size_t kPairs = 200;  // of each format

/// The solid's sphere centred at p, any rotation.
Pose with_centre_at(const Hexahedron& solid, const Vector3& p, std::mt19937_64& random) {
  Pose X{random_rotation(random), Vector3::Zero()};
  X.p = p - transform(X, solid.bounding_sphere().centre);
  return X;
}

double largest_in_file(const Hexahedron& solid) {
  double largest = 0.0;
  for (const Vector3& p : solid.vertices())
    largest = std::max({largest, std::abs(p.x()), std::abs(p.y()), std::abs(p.z())});
  return largest;
}

struct Pairs {
  std::vector<Hexahedron> solids;
  std::vector<Pose> poses;
  std::vector<SolidPair> pairs;
};

Pairs pairs_of(const file_corners::Format& format, std::mt19937_64& random) {
  Pairs out;
  for (std::size_t i = 0; i < 2 * kPairs; ++i) {
    const file_corners::Corners written =
        file_corners::in_file(file_corners::block(random, static_cast<int>(i)), format, random);
    out.solids.push_back(Hexahedron::from_vertices(file_corners::shuffled(written, random)));
  }
  for (std::size_t i = 0; i < kPairs; ++i) {
    const Hexahedron &a = out.solids[2 * i], &b = out.solids[2 * i + 1];
    const double reach = a.bounding_sphere().radius + b.bounding_sphere().radius;
    Vector3 towards = random_vector(random, 1.0);
    towards *= uniform(random, 0.1, 1.0) * reach / norm(towards);
    out.poses.push_back(with_centre_at(a, Vector3::Zero(), random));
    out.poses.push_back(with_centre_at(b, towards, random));
    const auto first = static_cast<SolidIndex>(2 * i);
    out.pairs.push_back({first, first + 1});
  }
  return out;
}

TEST(FileCorners, NativeAnswersAsExactDoesForSolidsOfAnyDigits) {
  BackendRegistry registry;
  register_exact(registry);
  const auto exact = registry.make_narrowphase("exact");
  const auto native = make_native();
  std::mt19937_64 random(29);
  std::size_t warped = 0, overlapping = 0, count = 0;
  double worst = 0.0;
  for (const file_corners::Format& format : file_corners::formats()) {
    // Pairs whose corners are written with few digits.
    const Pairs pairs = pairs_of(format, random);
    exact->build(pairs.solids);
    native->build(pairs.solids);
    const Answers truth = ask(*exact, pairs.pairs, pairs.poses, {.kind = QueryKind::distance});
    const Answers classes = ask(*native, pairs.pairs, pairs.poses, {.kind = QueryKind::overlap});
    const Answers found = ask(*native, pairs.pairs, pairs.poses, {.kind = QueryKind::manifold});
    // Classes are right, and separations within the bound.
    for (std::size_t i = 0; i < kPairs; ++i) {
      ASSERT_EQ(classes.status[i], truth.status[i]) << format.name << " " << i;
      ASSERT_EQ(found.status[i], truth.status[i]) << format.name << " " << i;
      const Hexahedron &a = pairs.solids[2 * i], &b = pairs.solids[2 * i + 1];
      const double S = std::max({scale_of(a, pairs.poses[2 * i], b, pairs.poses[2 * i + 1]),
                                 largest_in_file(a), largest_in_file(b)});
      const double error = std::abs(found.geometry[i].separation - truth.geometry[i].separation) / S;
      ASSERT_LE(error, kSeparationBound) << format.name << " " << i;
      worst = std::max(worst, error);
      overlapping += truth.status[i] == PairStatus::overlapping;
      ++count;
    }
    for (const Hexahedron& solid : pairs.solids) warped += solid.is_warped();
  }
  // Many are warped, and neither class is rare.
  EXPECT_GT(warped, 3 * count / 2);  // of two solids a pair
  EXPECT_GT(overlapping, count / 5);
  EXPECT_LT(overlapping, 4 * count / 5);
  RecordProperty("pairs", static_cast<int>(count));
  RecordProperty("overlapping", static_cast<int>(overlapping));
  RecordProperty("worst_over_S", std::to_string(worst * 1e16) + "e-16");
}

}  // namespace
}  // namespace touchstone
