#include "touchstone/tests/proof/long_run/long_run.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <mutex>
#include <thread>
#include <tuple>

#include "touchstone/adapters/exact/signed_distance.hpp"
#include "touchstone/tests/proof/long_run/class_settler.hpp"
#include "touchstone/tests/proof/pairs/families.hpp"

namespace touchstone::proof {
namespace {

/// Pairs built and asked together.
constexpr std::size_t kBlock = 512;

/// Doubles in their order as integers.
std::int64_t ordered(double value) {
  const auto bits = std::bit_cast<std::int64_t>(value);
  return bits >= 0 ? bits : std::numeric_limits<std::int64_t>::min() - bits;
}

std::uint64_t ulps_between(double p, double q) {
  const std::int64_t low = std::min(ordered(p), ordered(q)), high = std::max(ordered(p), ordered(q));
  return static_cast<std::uint64_t>(high) - static_cast<std::uint64_t>(low);
}

std::size_t ulp_bin(std::uint64_t ulps) {
  return static_cast<std::size_t>(std::lower_bound(kUlpLimits.begin(), kUlpLimits.end(), ulps) -
                                  kUlpLimits.begin());
}

struct Answers {
  std::vector<PairStatus> overlap, distance;
  std::vector<PairGeometry> geometry;
};

Answers ask(const std::vector<PosedSolids>& block, Narrowphase& narrowphase) {
  std::vector<Hexahedron> solids;
  std::vector<Pose> poses;
  std::vector<SolidPair> pairs;
  for (const PosedSolids& each : block) {
    const auto first = static_cast<SolidIndex>(solids.size());
    solids.push_back(each.a), solids.push_back(each.b);
    poses.push_back(each.X_WA), poses.push_back(each.X_WB);
    pairs.push_back({first, first + 1});
  }
  narrowphase.build(solids);
  const auto workspace = narrowphase.make_workspace();
  Answers answers{std::vector<PairStatus>(pairs.size()), std::vector<PairStatus>(pairs.size()),
                  std::vector<PairGeometry>(pairs.size())};
  narrowphase.evaluate({pairs, poses, {.kind = QueryKind::overlap}}, {.status = answers.overlap}, *workspace);
  narrowphase.evaluate({pairs, poses, {.kind = QueryKind::distance}},
                       {.status = answers.distance, .geometry = answers.geometry}, *workspace);
  return answers;
}

/// One thread's findings.
class Findings {
 public:
  Findings() : tallies(families().size()) {}

  void judge_class(std::size_t family, std::uint64_t index, const SettledClass& settled, PairStatus overlap,
                   PairStatus distance, double separation) {
    // Counts by class.
    FamilyTally& tally = tallies[family];
    ++tally.pairs;
    tally.by_filter += settled.directions_in_integers == 0;
    if (!settled.pair_class) {
      ++tally.unsettled;
      return;
    }
    tally.separated += *settled.pair_class == PairClass::separated;
    tally.touching += *settled.pair_class == PairClass::touching;
    tally.penetrating += *settled.pair_class == PairClass::penetrating;
    // A fault of the class, or of the separation's sign.
    const bool contact = *settled.pair_class != PairClass::separated;
    const PairStatus right = contact ? PairStatus::overlapping : PairStatus::separated;
    const bool wrong = overlap != right || distance != right;
    if (wrong) {
      ++(contact ? tally.missed : tally.phantom);
      keep(family, index,
           std::string(to_string(*settled.pair_class)) + ", yet overlap says " +
               std::string(to_string(overlap)) + " and distance " + std::string(to_string(distance)));
    } else if ((separation > 0.0) == contact) {  // a NaN is no distance either
      ++tally.wrong_sign;
      keep(family, index, std::string(to_string(right)) + " with separation " + std::to_string(separation));
    } else if (std::isnan(separation)) {
      ++tally.wrong_sign;
      keep(family, index, "separation is not a number");
    }
  }

  void judge_distance(std::size_t family, std::uint64_t index, const PosedSolids& solids,
                      const SettledClass& settled, double separation) {
    FamilyTally& tally = tallies[family];
    WorldVertices a, b;
    world_vertices(solids.a, solids.X_WA, a), world_vertices(solids.b, solids.X_WB, b);
    const ExactResult exact = exact_signed_distance(a, b);
    const double S =
        std::max({solids.a.size(), solids.b.size(), largest_coordinate(a), largest_coordinate(b)});
    ++tally.distances;
    ++tally.ulps[ulp_bin(ulps_between(separation, exact.separation))];
    const double error = std::abs(separation - exact.separation) / S;
    tally.worst_over_S = std::max(tally.worst_over_S, error);
    if (!(error <= bound_over_S(families()[family].name))) {
      ++tally.beyond_bound;
      keep(family, index, "distance off by " + std::to_string(error * 1e16) + "e-16 S");
    }
    if (settled.pair_class && *settled.pair_class != exact.pair_class) {
      ++tally.truths_differ;
      keep(family, index,
           "the second method says " + std::string(to_string(*settled.pair_class)) + ", exact " +
               std::string(to_string(exact.pair_class)));
    }
  }

  std::vector<FamilyTally> tallies;
  std::vector<Fault> faults;

 private:
  void keep(std::size_t family, std::uint64_t index, std::string what) {
    if (faults.size() < kFaultsKept) faults.push_back({family, index, std::move(what)});
  }
};

/// Consecutive blocks of every family in turn, so that an early end has seen them all.
class Blocks {
 public:
  explicit Blocks(const LongRunOptions& options) : families_(options.families) {
    if (families_.empty())
      for (std::size_t i = 0; i < families().size(); ++i) families_.push_back(i);
    const std::size_t count = families_.size();
    per_family_ = (options.count + count - 1) / count;
    const std::size_t distances = std::max<std::size_t>(1, (options.distances + count - 1) / count);
    stride_ = options.distances == 0 ? 0 : std::max<std::size_t>(1, per_family_ / distances);
  }

  std::size_t count() const { return (per_family_ + kBlock - 1) / kBlock * families_.size(); }

  std::size_t run(std::size_t block, const LongRunOptions& options, Narrowphase& narrowphase,
                  Findings& findings) const {
    const std::size_t family = families_[block % families_.size()], first = block / families_.size() * kBlock;
    const std::size_t size = std::min(kBlock, per_family_ - first);
    std::vector<PosedSolids> solids;
    for (std::size_t i = 0; i < size; ++i) solids.push_back(make_pair(family, options.seed, first + i));
    const Answers answers = ask(solids, narrowphase);
    for (std::size_t i = 0; i < size; ++i) {
      const SettledClass settled = settle_class(solids[i]);
      const double separation = answers.geometry[i].separation;
      findings.judge_class(family, first + i, settled, answers.overlap[i], answers.distance[i], separation);
      if (stride_ > 0 && (first + i) % stride_ == 0)
        findings.judge_distance(family, first + i, solids[i], settled, separation);
    }
    return size;
  }

 private:
  std::vector<std::size_t> families_;
  std::size_t per_family_, stride_;
};

}  // namespace

void FamilyTally::add(const FamilyTally& other) {
  pairs += other.pairs;
  separated += other.separated, touching += other.touching, penetrating += other.penetrating;
  unsettled += other.unsettled, by_filter += other.by_filter;
  missed += other.missed, phantom += other.phantom, wrong_sign += other.wrong_sign;
  distances += other.distances, beyond_bound += other.beyond_bound, truths_differ += other.truths_differ;
  for (std::size_t i = 0; i < ulps.size(); ++i) ulps[i] += other.ulps[i];
  worst_over_S = std::max(worst_over_S, other.worst_over_S);
}

double bound_over_S(std::string_view family) {
  // Two of the families hold pairs of near_parallel too.
  const bool near_parallel = family == "near_parallel" || family == "scaled" || family == "single_precision";
  return near_parallel ? 1e-13 : 1e-14;
}

FamilyTally LongRunResult::total() const {
  FamilyTally all;
  for (const FamilyTally& family : families) all.add(family);
  return all;
}

LongRunResult long_run(const LongRunOptions& options,
                       const std::function<std::unique_ptr<Narrowphase>()>& make,
                       const std::function<void(std::size_t)>& progress) {
  // Threads take block after block; each adds up what it found.
  const auto start = std::chrono::steady_clock::now();
  const Blocks blocks(options);
  std::atomic<std::size_t> next{0}, done{0};
  LongRunResult result;
  result.families.resize(families().size());
  std::mutex merging;
  const auto work = [&](bool reports) {
    Findings findings;
    const auto narrowphase = make();
    for (std::size_t block; (block = next.fetch_add(1)) < blocks.count();) {
      if (options.stop && *options.stop) break;
      done += blocks.run(block, options, *narrowphase, findings);
      if (reports && progress) progress(done);
    }
    const std::lock_guard lock(merging);
    for (std::size_t i = 0; i < findings.tallies.size(); ++i) result.families[i].add(findings.tallies[i]);
    result.faults.insert(result.faults.end(), findings.faults.begin(), findings.faults.end());
  };
  // The caller is one of them.
  {
    std::vector<std::jthread> others;
    for (int i = 1; i < options.threads; ++i) others.emplace_back(work, false);
    work(true);
  }
  // The first faults of all.
  std::sort(result.faults.begin(), result.faults.end(), [](const Fault& p, const Fault& q) {
    return std::tie(p.family, p.index) < std::tie(q.family, q.index);
  });
  if (result.faults.size() > kFaultsKept) result.faults.resize(kFaultsKept);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace touchstone::proof
