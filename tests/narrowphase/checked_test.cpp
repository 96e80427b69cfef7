// Broken calls are named with index and figure, and a checked narrowphase is the one that it wraps.

#include "touchstone/contact_core/narrowphase/checked.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/narrowphase/validate.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/support/ask.hpp"

namespace touchstone {
namespace {

using testing::HasSubstr;

constexpr std::size_t kSolids = 4;

// A sound call about two pairs of four boxes, to be broken.
struct Call {
  std::vector<SolidPair> pairs = {{0, 1}, {2, 3}};
  std::vector<Pose> poses = {at(0, 0, 0), at(1.5, 0.25, 0), at(0, 5, 0), at(0, 9, 1)};
  Query query = {.kind = QueryKind::manifold, .max_points = 4};
  std::vector<PairCacheEntry> cache;
  std::vector<PairStatus> status = std::vector<PairStatus>(2, PairStatus::unsupported);
  std::vector<PairGeometry> geometry = std::vector<PairGeometry>(2);
  std::vector<ContactPoint> points = std::vector<ContactPoint>(8);

  NarrowphaseInput input() { return {pairs, poses, query, cache}; }
  NarrowphaseOutput output() { return {status, geometry, points}; }
};

std::string what_is_broken(Call call) {
  try {
    validate(call.input(), call.output(), kSolids);
  } catch (const InputError& error) {
    return error.what();
  }
  return "sound";
}

template <class Break>
std::string what_is_broken_by(Break broken) {
  Call call;
  broken(call);
  return what_is_broken(call);
}

TEST(Validate, EveryBrokenPreconditionIsNamedWithIndexAndFigure) {
  const double nan = kNaN;
  // Pairs are in order and of solids that there are; lists have the lengths asked for.
  EXPECT_EQ(what_is_broken({}), "sound");
  EXPECT_EQ(what_is_broken_by([](Call& c) { c.pairs[1] = {3, 2}; }), "pair 1: (3, 2) is not a < b");
  EXPECT_EQ(what_is_broken_by([](Call& c) { c.pairs[1] = {2, 2}; }), "pair 1: (2, 2) is not a < b");
  EXPECT_EQ(what_is_broken_by([](Call& c) { c.pairs[1].b = 4; }),
            "pair 1: solid 4 is out of range, build() was given 4");
  EXPECT_EQ(what_is_broken_by([](Call& c) { c.poses.pop_back(); }), "poses: has 3 entries, needs 4");
  EXPECT_EQ(what_is_broken_by([](Call& c) { c.status.pop_back(); }), "status: has 1 entries, needs 2");
  EXPECT_EQ(what_is_broken_by([](Call& c) { c.geometry.pop_back(); }), "geometry: has 1 entries, needs 2");
  EXPECT_EQ(what_is_broken_by([](Call& c) { c.points.pop_back(); }), "points: has 7 entries, needs 8");
  EXPECT_EQ(what_is_broken_by([](Call& c) { c.cache.resize(1); }),
            "cache: has 1 entries, must be empty or have 2, one a pair");
  // The query's limits are numbers in range, and its kind is known.
  EXPECT_EQ(what_is_broken_by([](Call& c) { c.query.max_points = 0; }),
            "query: max_points is 0, must be 1 to 8");
  EXPECT_EQ(what_is_broken_by([](Call& c) { c.query.max_points = 9; }),
            "query: max_points is 9, must be 1 to 8");
  EXPECT_EQ(what_is_broken_by([](Call& c) { c.query.max_separation = -0.5; }),
            "query: max_separation is -0.5, must be >= 0");
  EXPECT_EQ(what_is_broken_by([&](Call& c) { c.query.max_separation = nan; }),
            "query: max_separation is nan, must be >= 0");
  EXPECT_EQ(what_is_broken_by([&](Call& c) { c.query.max_point_separation = nan; }),
            "query: max_point_separation is nan");
  EXPECT_EQ(what_is_broken_by([](Call& c) { c.query.kind = static_cast<QueryKind>(7); }),
            "query: kind 7 is none");
  // Poses are finite rotations.
  EXPECT_EQ(what_is_broken_by([&](Call& c) { c.poses[3].p.y() = nan; }),
            "pair 1: pose 3: a pose entry is not finite");
  EXPECT_THAT(what_is_broken_by([](Call& c) { c.poses[2].R *= 2.0; }),
              HasSubstr("pair 1: pose 2: not a rotation: columns are off orthonormal by 3"));
  EXPECT_THAT(what_is_broken_by([](Call& c) { c.poses[0].R.col(1) *= -1.0; }),
              HasSubstr("pair 0: pose 0: not a rotation: a reflection"));
}

TEST(Validate, WhatTheQueryDoesNotAskForMayBeLeftOut) {
  EXPECT_EQ(what_is_broken_by([](Call& c) {
              c.query = {.kind = QueryKind::distance, .max_points = 0};
              c.points.clear();
            }),
            "sound");
  EXPECT_EQ(what_is_broken_by([](Call& c) {
              c.query.kind = QueryKind::overlap;
              c.geometry.clear(), c.points.clear();
            }),
            "sound");
  // A pose of a solid in no pair is not read.
  EXPECT_EQ(what_is_broken_by([](Call& c) {
              c.pairs = {{0, 1}};
              c.poses[3].p.x() = kInfinity;
            }),
            "sound");
  EXPECT_EQ(what_is_broken_by([](Call& c) { c.pairs.clear(); }), "sound");
}

TEST(Validate, FitsIsFalseExactlyWhereMemoryWouldBeMissed) {
  const auto fits_after = [](auto broken) {
    Call call;
    broken(call);
    return fits(call.input(), call.output(), kSolids);
  };
  EXPECT_TRUE(fits_after([](Call&) {}));
  EXPECT_TRUE(fits_after([](Call& c) { c.pairs[0] = {1, 0}; }));
  EXPECT_TRUE(fits_after([](Call& c) { c.poses[0].p.x() = NAN; }));
  EXPECT_FALSE(fits_after([](Call& c) { c.pairs[0].b = 4; }));
  EXPECT_FALSE(fits_after([](Call& c) { c.poses.pop_back(); }));
  EXPECT_FALSE(fits_after([](Call& c) { c.status.pop_back(); }));
  EXPECT_FALSE(fits_after([](Call& c) { c.geometry.pop_back(); }));
  EXPECT_FALSE(fits_after([](Call& c) { c.points.pop_back(); }));
  EXPECT_FALSE(fits_after([](Call& c) { c.cache.resize(1); }));
  EXPECT_FALSE(fits_after([](Call& c) { c.query.max_points = 9; }));
}

std::vector<Hexahedron> boxes() { return std::vector<Hexahedron>(kSolids, Hexahedron::from_size({2, 2, 2})); }

TEST(Checked, AnswersAreThoseOfTheWrappedOneToTheBit) {
  const auto plain = make_native();
  const auto wrapped = checked(make_native());
  EXPECT_EQ(wrapped->name(), "native");
  EXPECT_EQ(wrapped->capabilities().manifold, plain->capabilities().manifold);
  plain->build(boxes());
  wrapped->build(boxes());
  for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance, QueryKind::manifold}) {
    Call a, b;
    std::memset(static_cast<void*>(a.geometry.data()), 0, a.geometry.size() * sizeof(PairGeometry));
    std::memset(static_cast<void*>(b.geometry.data()), 0, b.geometry.size() * sizeof(PairGeometry));
    a.query.kind = b.query.kind = kind;
    const auto workspace_a = plain->make_workspace(), workspace_b = wrapped->make_workspace();
    plain->evaluate(a.input(), a.output(), *workspace_a);
    wrapped->evaluate(b.input(), b.output(), *workspace_b);
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.status[0], PairStatus::overlapping);
    for (int i = 0; i < 2; ++i) {
      EXPECT_EQ(std::memcmp(&a.geometry[i].separation, &b.geometry[i].separation, sizeof(double)), 0);
      EXPECT_EQ(std::memcmp(&a.geometry[i].n_AB_W, &b.geometry[i].n_AB_W, sizeof(Vector3)), 0);
      EXPECT_EQ(std::memcmp(&a.geometry[i].p_A_W, &b.geometry[i].p_A_W, sizeof(Vector3)), 0);
      EXPECT_EQ(a.geometry[i].point_count, b.geometry[i].point_count);
    }
  }
}

TEST(Checked, ABrokenCallGoesToTheHandlerAndItsPairsFail) {
  std::vector<std::string> complaints;
  const auto wrapped =
      checked(make_native(), [&complaints](std::string_view what) { complaints.emplace_back(what); });
  wrapped->build(boxes());
  const auto workspace = wrapped->make_workspace();
  Call call;
  call.pairs[1].b = 7;
  wrapped->evaluate(call.input(), call.output(), *workspace);
  ASSERT_EQ(complaints.size(), 1u);
  EXPECT_EQ(complaints[0], "pair 1: solid 7 is out of range, build() was given 4");
  EXPECT_EQ(call.status[0], PairStatus::failed);
  EXPECT_TRUE(std::isnan(call.geometry[1].separation));
  call.pairs[1].b = 3;
  wrapped->evaluate(call.input(), call.output(), *workspace);
  EXPECT_EQ(complaints.size(), 1u);
  EXPECT_EQ(call.status[0], PairStatus::overlapping);
  EXPECT_THROW(checked(nullptr), InputError);
  EXPECT_THROW(checked(make_native(), nullptr), InputError);
}

TEST(CheckedDeathTest, ByDefaultItSaysWhatIsBrokenAndAborts) {
  const auto wrapped = checked(make_native());
  wrapped->build(boxes());
  const auto workspace = wrapped->make_workspace();
  Call call;
  call.pairs[1] = {3, 2};
  EXPECT_DEATH(wrapped->evaluate(call.input(), call.output(), *workspace),
               "touchstone: broken call of Narrowphase::evaluate\\(\\): pair 1: \\(3, 2\\) is not a < b");
}

#ifndef NDEBUG
TEST(EvaluateDeathTest, BuildsWithAssertionsAssertIndicesAndSpans) {
  const auto native = make_native();
  native->build(boxes());
  const auto workspace = native->make_workspace();
  Call call;
  call.pairs[1].b = 9;
  EXPECT_DEATH(native->evaluate(call.input(), call.output(), *workspace), "fits");
}
#endif

}  // namespace
}  // namespace touchstone
