// How rows are timed, without timing them: which pairs go where, in which order; and what is asked once more.

#include "touchstone/examples/measures/runs/backend_run.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>

#include "touchstone/examples/measures/accuracy/accuracy.hpp"
#include "touchstone/tests/measures/fake_backends.hpp"

namespace touchstone::measures {
namespace {

constexpr std::size_t kPairs = 256;
constexpr std::size_t kBlock = 32;

using Block = std::vector<std::pair<SolidIndex, SolidIndex>>;

/// Keeps what it is asked, call by call.
class Listening final : public RawCheck {
 public:
  explicit Listening(std::vector<Block>& calls) : calls_(&calls) {}
  void build(std::span<const Hexahedron> solids) override { solids_ = solids.size(); }
  bool supports(QueryKind kind) const noexcept override { return kind == QueryKind::overlap; }
  void set_poses(std::span<const Pose> poses) override { EXPECT_EQ(poses.size(), solids_); }
  std::size_t run(std::span<const SolidPair> pairs, QueryKind kind) noexcept override {
    EXPECT_EQ(kind, QueryKind::overlap);
    Block& call = calls_->emplace_back();
    for (const SolidPair& pair : pairs) call.emplace_back(pair.a, pair.b);
    return 0;
  }

 private:
  std::vector<Block>* calls_;
  std::size_t solids_ = 0;
};

struct Listened {
  std::vector<Block> calls;
  std::vector<BackendAnswers> answers;
};

Listened listen(int repetitions) {
  Listened listened;
  BackendRegistry registry;
  testing::register_fakes(registry);
  BackendRegistry::NarrowphaseEntry entry = registry.narrowphase("right");
  entry.make_raw = [&] { return std::make_unique<Listening>(listened.calls); };
  MeasureOptions options;
  options.repetitions = repetitions;
  options.block = kBlock;
  options.batch = kBlock;
  options.perturb = false;
  options.slow_seconds = 1e3;  // no row is cut short, however slow the machine
  const BackendRegistry::NarrowphaseEntry* const entries[] = {&entry};
  listened.answers = run_backends(entries, testing::cubes(std::vector<double>(kPairs, 0.5)), options);
  return listened;
}

TEST(RawRows, EachBlockIsRunOnceUntimedRightBefore) {
  // The engine's call on what is in the cache: each call but the warm-up is of the same pairs as the one
  // before.
  const Listened listened = listen(3);
  ASSERT_FALSE(listened.calls.empty());
  ASSERT_EQ(listened.calls.size() % 2, 0u);
  for (std::size_t i = 0; i < listened.calls.size(); i += 2)
    EXPECT_EQ(listened.calls[i], listened.calls[i + 1]) << i;
}

TEST(RawRows, AreOfTheSamePairsAsThoseThroughTheInterface) {
  const int repetitions = 3;
  const Listened listened = listen(repetitions);
  const QueryAnswers& overlap = listened.answers[0].queries[index_of(QueryKind::overlap)];
  ASSERT_TRUE(overlap.raw && overlap.single && overlap.cached);
  EXPECT_EQ(overlap.raw->block, overlap.single->block);
  EXPECT_EQ(overlap.raw->block, overlap.cached->block);
  EXPECT_EQ(overlap.raw->blocks, overlap.single->blocks);
  EXPECT_EQ(overlap.raw->blocks, repetitions * kPairs / kBlock);
  // Every pair once a repetition, as the interface is asked.
  std::multiset<std::pair<SolidIndex, SolidIndex>> timed;
  for (std::size_t i = 1; i < listened.calls.size(); i += 2)
    if (listened.calls[i].size() == kBlock) timed.insert(listened.calls[i].begin(), listened.calls[i].end());
  EXPECT_EQ(timed.size(), repetitions * kPairs);
  for (SolidIndex p = 0; p < kPairs; ++p)
    EXPECT_EQ(timed.count({2 * p, 2 * p + 1}), static_cast<std::size_t>(repetitions)) << p;
}

/// What changes after so many questions as are asked before the timing.
enum class Figure { nothing, status, separation, normal, witness_on_a, witness_on_b, count, point };

/// Answers in one way, then in another that differs from it in one figure.
class Turning final : public testing::PairByPair {
 public:
  /// @param is_wrong_first whether the figure is off before rather than after.
  Turning(Figure figure, bool is_wrong_first, std::size_t pairs)
      : PairByPair("turning", {}),
        figure_(figure),
        is_wrong_first_(is_wrong_first),
        before_timing_(kQueryKinds.size() * pairs) {}

 private:
  void answer(const NarrowphaseInput& input, std::size_t i, const NarrowphaseOutput& output) const override {
    const bool is_off = (++asked_ > before_timing_) != is_wrong_first_;
    const auto off = [&](Figure figure) { return is_off && figure == figure_; };
    output.status[i] = off(Figure::status) ? PairStatus::separated : PairStatus::overlapping;
    if (input.query.kind == QueryKind::overlap) return;
    const Vector3 n = Vector3::UnitX(), p_A = input.poses[input.pairs[i].a].p + 0.5 * n;
    const double separation = -0.5;
    output.geometry[i] = {separation, n, p_A, p_A + n * separation, 0};
    if (off(Figure::separation)) output.geometry[i].separation += 1e-3;
    if (off(Figure::normal)) output.geometry[i].n_AB_W = Vector3::UnitY();
    if (off(Figure::witness_on_a)) output.geometry[i].p_A_W.x() += 1e-3;
    if (off(Figure::witness_on_b)) output.geometry[i].p_B_W.x() += 1e-3;
    if (input.query.kind != QueryKind::manifold) return;
    output.geometry[i].point_count = off(Figure::count) ? 3 : 4;
    for (int c = 0; c < 4; ++c) {
      const Vector3 corner =
          p_A + Vector3(off(Figure::point) && c == 3 ? 1e-3 : 0.0, c & 1 ? 1 : 0, c & 2 ? 1 : 0) -
          Vector3(0, 0.5, 0.5);
      output.points[i * kMaxManifoldPoints + static_cast<std::size_t>(c)] = {corner, corner + n * separation,
                                                                             separation, 0};
    }
  }

  Figure figure_;
  bool is_wrong_first_;
  std::size_t before_timing_;
  mutable std::size_t asked_ = 0;
};

BackendAnswers answers_of(const PairSet& set, Figure figure, bool is_wrong_first, bool is_timed = true) {
  const BackendRegistry::NarrowphaseEntry entry{
      "turning", "", [&] { return std::make_unique<Turning>(figure, is_wrong_first, set.pairs.size()); }, {}};
  const BackendRegistry::NarrowphaseEntry* const entries[] = {&entry};
  MeasureOptions options;
  options.perturb = false;
  options.repetitions = 1;
  options.time_pairs = is_timed;
  options.tail_seconds = 1e-9;  // what is asked again is no question of time
  return run_backends(entries, set, options)[0];
}

TEST(LaterAnswers, AreKeptOfEveryPairWhateverFigureDiffers) {
  const PairSet set = testing::cubes(std::vector<double>(kPairs, -0.5));
  const auto kept = [&](Figure figure, bool is_timed = true) {
    const BackendAnswers answers = answers_of(set, figure, false, is_timed);
    std::array<std::size_t, 3> counts{};
    for (const QueryKind kind : kQueryKinds)
      counts[index_of(kind)] = answers.queries[index_of(kind)].later.size();
    return counts;
  };
  using Counts = std::array<std::size_t, 3>;
  EXPECT_EQ(kept(Figure::status), (Counts{kPairs, kPairs, kPairs}));
  EXPECT_EQ(kept(Figure::status, false), Counts{}) << "without timing nothing is asked again";
  for (const Figure figure : {Figure::separation, Figure::normal, Figure::witness_on_a, Figure::witness_on_b})
    EXPECT_EQ(kept(figure), (Counts{0, kPairs, kPairs})) << static_cast<int>(figure);
  EXPECT_EQ(kept(Figure::count), (Counts{0, 0, kPairs}));
  EXPECT_EQ(kept(Figure::point), (Counts{0, 0, kPairs}));
  EXPECT_EQ(kept(Figure::nothing), Counts{});
}

TEST(LaterAnswers, ThatAreNoNumbersAreTheSame) {
  BackendRegistry registry;
  testing::register_fakes(registry);
  const BackendRegistry::NarrowphaseEntry* const entries[] = {&registry.narrowphase("not_a_number"),
                                                              &registry.narrowphase("failing")};
  for (const BackendAnswers& answers : run_backends(entries, testing::cubes({0.5, -0.5}), {}))
    for (const QueryAnswers& query : answers.queries) EXPECT_TRUE(query.later.empty()) << answers.name;
}

TEST(LaterAnswers, TheWorseOfTwoIsJudgedWhicheverCameFirst) {
  const testing::CubeOracle oracle;
  const PairSet set = testing::cubes(std::vector<double>(4, -0.5));
  const std::vector<PairTruth> truth = compute_truth(set, oracle, 2);
  const auto judged = [&](Figure figure, bool is_wrong_first) {
    BackendAnswers answers = answers_of(set, figure, is_wrong_first);
    take_worse_answers(set, truth, oracle, answers, 2);
    for (const QueryAnswers& query : answers.queries) EXPECT_TRUE(query.later.empty());
    return judge(set, truth, oracle, answers, 2);
  };
  for (const bool is_wrong_first : {false, true}) {
    for (const Wrongness& each : judged(Figure::status, is_wrong_first).wrongness)
      EXPECT_EQ(each.missed, 4u) << is_wrong_first;
    for (const Figure figure :
         {Figure::separation, Figure::normal, Figure::witness_on_a, Figure::witness_on_b}) {
      const Judgement off = judged(figure, is_wrong_first);
      EXPECT_GE(off.cost[index_of(QueryKind::distance)].worst, 1e-4) << static_cast<int>(figure);
    }
    EXPECT_GE(judged(Figure::point, is_wrong_first).cost[index_of(QueryKind::manifold)].worst, 1e-4);
    EXPECT_LT(judged(Figure::nothing, is_wrong_first).cost[index_of(QueryKind::manifold)].worst, 1e-12);
  }
}

}  // namespace
}  // namespace touchstone::measures
