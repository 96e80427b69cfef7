#include <cmath>
#include <cstring>
#include <random>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/tests/backend_suite/suite.hpp"

// An invalid pose gives no number: its pair has failed, and the batch's other pairs are answered as without
// it.

namespace touchstone::suite {
namespace {

class BadPoseSuite : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { narrowphase = backends().make_narrowphase(GetParam()); }

  std::unique_ptr<Narrowphase> narrowphase;
};

// Pair i is of the solids 2i and 2i + 1.
struct Batch {
  std::vector<Hexahedron> solids;
  std::vector<Pose> poses;
  std::vector<SolidPair> pairs;
};

Hexahedron tapered() {
  std::array<Vector3, 8> vertices = Hexahedron::from_size({1, 2, 1.5}).vertices();
  for (Vector3& v : vertices)
    if (v.z() > 0.0) v.x() *= 0.5, v.y() *= 0.75;
  return Hexahedron::from_vertices(vertices);
}

// Boxes, sheared boxes and tapered ones, apart and deep, at poses written with few bits.
Batch mixed_batch(std::size_t count) {
  const std::array solids = {Hexahedron::from_size({1, 2, 1.5}), sheared_cube(0.25, {}).solid, tapered()};
  const std::array rotations = {rotation_from_quaternion(1, 0, 0, 0),
                                rotation_from_quaternion(0.8, 0.3, -0.4, 0.2),
                                rotation_from_quaternion(0.1, 0.7, 0.7, -0.3)};
  Batch batch;
  for (std::size_t i = 0; i < count; ++i) {
    const double apart = i % 2 == 0 ? 4.5 : 0.75;
    const Vector3 p_W(0.25 * static_cast<double>(i % 5), -1.0, 0.5);
    batch.solids.push_back(solids[i % 3]);
    batch.poses.push_back({rotations[i % 3], p_W});
    batch.solids.push_back(solids[i / 3 % 3]);
    batch.poses.push_back({rotations[i / 2 % 3], p_W + Vector3(apart, 0.125, 0.25)});
    const auto first = static_cast<SolidIndex>(2 * i);
    batch.pairs.push_back({first, first + 1});
  }
  return batch;
}

double& entry(Pose& X, int which) { return which < 9 ? X.R.data()[which] : X.p(which - 9); }

bool is_nan(const Vector3& v) { return std::isnan(v.x()) && std::isnan(v.y()) && std::isnan(v.z()); }

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0 || (a != a && b != b); }

bool same_bits(const Vector3& a, const Vector3& b) {
  return same_bits(a.x(), b.x()) && same_bits(a.y(), b.y()) && same_bits(a.z(), b.z());
}

void expect_failed(const Answers& answers, std::size_t i, const Query& query) {
  ASSERT_EQ(answers.status[i], PairStatus::failed) << to_string(answers.status[i]);
  if (query.kind == QueryKind::overlap) return;
  const PairGeometry& geometry = answers.geometry[i];
  ASSERT_TRUE(std::isnan(geometry.separation)) << geometry.separation;
  ASSERT_TRUE(is_nan(geometry.n_AB_W) && is_nan(geometry.p_A_W) && is_nan(geometry.p_B_W));
  ASSERT_EQ(geometry.point_count, 0);
}

void expect_same(const Answers& good, const Answers& bad, std::size_t i, const Query& query) {
  ASSERT_EQ(good.status[i], bad.status[i]) << i;
  if (query.kind == QueryKind::overlap) return;
  ASSERT_TRUE(same_bits(good.geometry[i].separation, bad.geometry[i].separation)) << i;
  ASSERT_TRUE(same_bits(good.geometry[i].n_AB_W, bad.geometry[i].n_AB_W)) << i;
  ASSERT_TRUE(same_bits(good.geometry[i].p_A_W, bad.geometry[i].p_A_W)) << i;
  ASSERT_EQ(good.geometry[i].point_count, bad.geometry[i].point_count) << i;
  const auto first = i * static_cast<std::size_t>(query.max_points);
  for (int k = 0; k < good.geometry[i].point_count; ++k) {
    ASSERT_TRUE(same_bits(good.points[first + k].separation, bad.points[first + k].separation)) << i;
    ASSERT_TRUE(same_bits(good.points[first + k].p_A_W, bad.points[first + k].p_A_W)) << i;
  }
}

void evaluate_cached(const Narrowphase& narrowphase, const Batch& batch, const Query& query,
                     std::vector<PairCacheEntry>& cache, Answers& out) {
  out.status.assign(batch.pairs.size(), PairStatus::unsupported);
  out.geometry.assign(batch.pairs.size(), PairGeometry{});
  out.points.resize(batch.pairs.size() * static_cast<std::size_t>(query.max_points));
  const auto workspace = narrowphase.make_workspace();
  narrowphase.evaluate({batch.pairs, batch.poses, query, cache}, {out.status, out.geometry, out.points},
                       *workspace);
}

// Asks `bad`, where pair i has an invalid pose, in one batch, with a cache, and the pair alone.
void expect_only_failed(const Narrowphase& narrowphase, const Batch& bad, std::size_t i, const Query& query,
                        const Answers& good, std::vector<PairCacheEntry> cache) {
  const bool deterministic = narrowphase.capabilities().deterministic;
  // A query that the backend answers for no pose may stay unsupported.
  const bool supported = good.status[i] != PairStatus::unsupported;
  for (const bool cached : {false, true}) {
    Answers answers;
    if (cached)
      evaluate_cached(narrowphase, bad, query, cache, answers);
    else
      answers = ask(narrowphase, bad.pairs, bad.poses, query);
    if (supported || answers.status[i] != PairStatus::unsupported) expect_failed(answers, i, query);
    for (std::size_t k = 0; k < bad.pairs.size() && deterministic; ++k)
      if (k != i) expect_same(good, answers, k, query);
    if (testing::Test::HasFatalFailure()) return;
  }
  const Answers alone = ask(narrowphase, std::span(bad.pairs).subspan(i, 1), bad.poses, query);
  if (supported || alone.status[0] != PairStatus::unsupported) expect_failed(alone, 0, query);
}

TEST_P(BadPoseSuite, NoNumberFromAPoseThatIsNone) {
  const Batch batch = mixed_batch(19);
  narrowphase->build(batch.solids);
  for (const QueryKind kind : {QueryKind::overlap, QueryKind::distance, QueryKind::manifold}) {
    for (const double limit : {0.0, kInfinity}) {
      const Query query{.kind = kind, .max_separation = limit};
      std::vector<PairCacheEntry> cache(batch.pairs.size());
      Answers good;
      evaluate_cached(*narrowphase, batch, query, cache, good);
      // The first pair is of two boxes that are apart, the others of other kinds, apart and deep.
      for (const std::size_t i : {std::size_t{0}, std::size_t{1}, std::size_t{9}, std::size_t{12},
                                  std::size_t{17}, std::size_t{18}}) {
        for (int which = 0; which < 12; ++which) {
          for (const SolidIndex solid : {batch.pairs[i].a, batch.pairs[i].b}) {
            const double value =
                std::array{double(NAN), kInfinity, double(NAN), -kInfinity}[(which + i + solid) % 4];
            Batch bad = batch;
            entry(bad.poses[solid], which) = value;
            SCOPED_TRACE(std::string(to_string(kind)) + " up to " + std::to_string(limit) + ", pair " +
                         std::to_string(i) + ", solid " + std::to_string(solid) + ", entry " +
                         std::to_string(which) + " is " + std::to_string(value));
            expect_only_failed(*narrowphase, bad, i, query, good, cache);
            if (HasFatalFailure()) return;
          }
        }
      }
    }
  }
}

TEST_P(BadPoseSuite, BadPosesInEveryBlockOfALargeBatchFailAlone) {
  const Batch batch = mixed_batch(600);
  narrowphase->build(batch.solids);
  const Query query{.kind = QueryKind::overlap};
  const Answers good = ask(*narrowphase, batch.pairs, batch.poses, query);
  Batch bad = batch;
  for (std::size_t i = 0; i < batch.pairs.size(); i += 7)
    entry(bad.poses[2 * i + i % 2], static_cast<int>(i % 12)) = i % 3 == 0 ? NAN : INFINITY;
  const Answers answers = ask(*narrowphase, bad.pairs, bad.poses, query);
  for (std::size_t i = 0; i < batch.pairs.size(); ++i) {
    if (i % 7 != 0)
      expect_same(good, answers, i, query);
    else if (good.status[i] != PairStatus::unsupported)
      expect_failed(answers, i, query);
    if (HasFatalFailure()) return;
  }
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(BadPoseSuite);  // a program may have none
INSTANTIATE_TEST_SUITE_P(AllBackends, BadPoseSuite, testing::ValuesIn(narrowphase_names()),
                         [](const auto& test) { return test.param; });

}  // namespace

void link_bad_pose_suite() {}

}  // namespace touchstone::suite
