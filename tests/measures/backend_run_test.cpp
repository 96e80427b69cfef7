// How rows are timed, without timing them: which pairs go where, in which order.

#include "touchstone/examples/measures/runs/backend_run.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "touchstone/tests/measures/fake_backends.hpp"

namespace touchstone::measures {
namespace {

using ::testing::Each;

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

/// Right until it was asked a thousand times.
class Tiring final : public testing::PairByPair {
 public:
  Tiring() : PairByPair("tiring", {}) {}

 private:
  void answer(const NarrowphaseInput&, std::size_t i, const NarrowphaseOutput& output) const override {
    output.status[i] = ++asked_ > 1000 ? PairStatus::overlapping : PairStatus::separated;
  }
  mutable int asked_ = 0;
};

TEST(Answers, AreThoseAfterTheTimingWhereTheyDiffer) {
  const BackendRegistry::NarrowphaseEntry entry{"tiring", "", [] { return std::make_unique<Tiring>(); }, {}};
  const BackendRegistry::NarrowphaseEntry* const entries[] = {&entry};
  MeasureOptions options;
  options.perturb = false;
  options.tail_seconds = 1e3;  // all pairs, however slow the machine
  for (const bool is_timed : {false, true}) {
    options.time_pairs = is_timed;
    const PairSet set = testing::cubes(std::vector<double>(kPairs, 0.5));
    const auto answers = run_backends(entries, set, options);
    EXPECT_THAT(answers[0].queries[index_of(QueryKind::overlap)].status,
                Each(is_timed ? PairStatus::overlapping : PairStatus::separated));
  }
}

}  // namespace
}  // namespace touchstone::measures
