#include "touchstone/tests/benchmarks/pairs/cost_goals.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <span>
#include <tuple>
#include <vector>

#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/examples/program/options/shell_text.hpp"
#include "touchstone/tests/benchmarks/pairs/cost_timing.hpp"
#include "touchstone/tests/benchmarks/pairs/moving_pairs.hpp"
#include "touchstone/tests/benchmarks/pairs/world_costs.hpp"

namespace touchstone {
namespace {

constexpr QueryKind kOverlap = QueryKind::overlap, kDistance = QueryKind::distance,
                    kManifold = QueryKind::manifold;
constexpr bool kLone = false, kBatch = true;

/// A figure of a row.
enum class Of { hot, hot_p99, hot_worst, cold, cold_worst };

constexpr std::array<const char*, 5> kNamesOf = {"hot", "hot 99 %", "hot worst", "cold", "cold worst"};

double figure(const RowCosts& costs, Of of) {
  switch (of) {
    case Of::hot:
      return costs.hot.mean;
    case Of::hot_p99:
      return costs.hot.p99;
    case Of::hot_worst:
      return costs.hot.worst;
    case Of::cold:
      return costs.cold.mean;
    case Of::cold_worst:
      return costs.cold.worst;
  }
  return NAN;
}

/// Not slower than the fastest of the peers that are right in the whole family.
constexpr double kFastestPeer = 0.0;

struct Asked {
  Of of;
  double ns;
};

struct Goal {
  const char* family;
  QueryKind kind;
  bool is_batch;
  std::vector<Asked> asked;
  const char* reason;  ///< where a figure is missed
  bool is_contacts_only = false;
};

constexpr const char* kAhead =
    "the peer keeps no bound; of contacts 1 000 instructions find and certify the depth, 1 070 clip faces, "
    "and each step waits for the one before";
constexpr const char* kAligned = "coordinates are compared after the filter for boxes at any turn";
constexpr const char* kAxes = "780 instructions find the axis of a lone pair, 950 its nearest points";
// Instructions are a pair's, counted in four lanes (AVX2).
constexpr const char* kDepth =
    "1 140 to 1 190 instructions, of which the depth's certificate, which tells the class, takes 680 to 730";
constexpr const char* kClip =
    "2 270 instructions, of which the depth's certificate takes 690 to 730, clipping 890 to 900";
constexpr const char* kClipFlush =
    "3 080 instructions in a wall, of which clipping with edges that coincide takes 1 170, the depth's "
    "certificate 720, the class of what touches 280";
constexpr const char* kCold = "cold data; kernels that leave few pairs open come first";
constexpr const char* kFlushBlocks =
    "a search finds the common plane, heights over it and a second search decide; 2 % go to integers";
constexpr const char* kFlushBoxes =
    "heights over the common plane and a search decide; 3 %, whose edges lie on each other, go to integers, "
    "and one in 16 384, of which guesses fail, has all directions tried: 4.9 us hot";
constexpr const char* kHullClass = "740 instructions, of which the search takes 650";
constexpr const char* kHullDepth =
    "3 220 instructions: faces 1 120, edges and witness points 1 850 where the pair overlaps, a search 1 220 "
    "where it is apart; cold, 19 cache lines, of which below stands what reading them alone takes";
constexpr const char* kHullClip =
    "5 090 instructions, of which distance and depth take 3 220, clipping in lanes 1 010, its points 860; "
    "cold, "
    "as distance";
constexpr const char* kLanes = "two lanes do in four steps what eight do in one";
constexpr const char* kOpen = "pairs that touch to rounding leave the lanes";
constexpr const char* kTouching =
    "405 instructions where boxes rest: the filter's two passes take 250, a third one, for what touches, 100";
constexpr const char* kParallel =
    "the search for the depth, the class of what touches, one pass for the distance and the clock take 250 "
    "ns; edges at small angles take another in exact products, 125 on average";
constexpr const char* kPlaced = "all vertices of both are placed before any coordinates are compared";
constexpr const char* kWallDepth =
    "the search for the depth and the clock take 130 ns by themselves; a ninth, which rounding leaves apart, "
    "takes 490 in all";

/// Goals for pairs.
const std::vector<Goal>& pair_goals() {
  // Limits that several rows share [ns].
  static const std::vector<Asked> kFlushAsked = {
      {Of::cold, 400}, {Of::hot_p99, 1500}, {Of::hot_worst, 5000}, {Of::cold_worst, 5000}};
  static const std::vector<Asked> kPeersAsked = {{Of::hot, kFastestPeer}, {Of::cold, kFastestPeer}};
  static const std::vector<Asked> kClipAsked = {{Of::hot, 90}, {Of::cold, 130}};
  // The rows: family, query, calls, what is asked, and why it is not met where it is not.
  static const std::vector<Goal> kGoals = {
      {"wall", kOverlap, kLone, {{Of::hot, 100}}, kAligned},
      {"wall", kDistance, kLone, {{Of::hot, 100}}, kWallDepth},
      {"aligned_tapered", kOverlap, kLone, {{Of::hot, 150}}, kPlaced},
      {"wall_turned", kOverlap, kLone, kFlushAsked, kFlushBoxes},
      {"blocks_turned", kOverlap, kLone, kFlushAsked, kFlushBlocks},
      {"touching", kOverlap, kLone, {{Of::cold, 250}}, kCold},
      {"touching", kOverlap, kBatch, {{Of::cold, 120}}, kCold},
      {"far", kDistance, kLone, {{Of::hot, 250}}, kAxes},
      {"near_parallel", kDistance, kLone, {{Of::hot, 250}}, kParallel},
      {"resting", kOverlap, kBatch, {{Of::hot, 18}}, kTouching},
      {"near_1e-7", kOverlap, kBatch, {{Of::hot, 18}}, kOpen},
      {"slabs_needles", kOverlap, kBatch, {{Of::hot, 18}}, kOpen},
      {"near_parallel", kOverlap, kBatch, {{Of::hot, 26}}, kOpen},
      {"random", kManifold, kLone, kPeersAsked, kAhead},
      {"near_1e-3", kManifold, kLone, kPeersAsked, kAhead},
      {"near_1e-7", kManifold, kLone, kPeersAsked, kAhead},
      {"resting", kManifold, kLone, kPeersAsked, kAhead},
      {"slabs_needles", kManifold, kLone, kPeersAsked, kAhead},
      {"far", kManifold, kLone, kPeersAsked, kAhead},
      {"wall", kManifold, kLone, kPeersAsked, kAhead},
      {"wall_turned", kManifold, kLone, kPeersAsked, kAhead},
      {"near_parallel", kManifold, kLone, kPeersAsked, kAhead},
      {"touching", kManifold, kLone, kPeersAsked, kAhead},
      {"random", kManifold, kBatch, kClipAsked, kClip},
      {"resting", kManifold, kBatch, kClipAsked, kClip},
      {"wall", kManifold, kBatch, kClipAsked, kClipFlush},
      {"near_parallel", kManifold, kBatch, kClipAsked, kOpen},
      {"touching", kManifold, kBatch, kClipAsked, kOpen},
      {"random", kManifold, kBatch, kClipAsked, kClip, true},
      {"near_1e-3", kManifold, kBatch, kClipAsked, kClip, true},
      {"random", kDistance, kLone, {{Of::hot, 120}}, kAxes},
      {"near_1e-3", kDistance, kLone, {{Of::hot, 120}}, kAxes},
      {"random", kDistance, kBatch, {{Of::hot, 60}}, kDepth},
      {"near_1e-3", kDistance, kBatch, {{Of::hot, 60}}, kDepth},
      {"resting", kDistance, kBatch, {{Of::hot, 35}}, kDepth},
      {"tapered", kOverlap, kBatch, {{Of::hot, 60}}, kHullClass},
      {"tapered", kDistance, kBatch, {{Of::hot, 150}, {Of::cold, 300}}, kHullDepth},
      {"tapered", kManifold, kBatch, {{Of::hot, 250}, {Of::cold, 500}}, kHullClip},
  };
  return kGoals;
}

/// And of machines with two lanes: SSE2, arm64.
const std::vector<Goal>& two_lane_goals() {
  static const std::vector<Goal> kGoals = {
      {"resting", kDistance, kLone, {{Of::hot, 350}}, kLanes},
      {"resting", kManifold, kLone, {{Of::hot, 450}}, kLanes},
  };
  return kGoals;
}

struct Peer {
  std::string name = "-";
  double hot = INFINITY, cold = INFINITY;
};

/// The fastest of the other libraries' checks that have every class of the hot set right.
class Peers {
 public:
  explicit Peers(const BackendRegistry& registry) : registry_(registry) {}

  const Peer& best(const std::string& family, QueryKind kind) {
    const auto [at, is_new] = best_.try_emplace({family, kind});
    if (!is_new) return at->second;
    for (const std::string& name : raw_peers(registry_, kind)) {
      const RowCosts costs = measure_row(registry_, {family, kind, name});
      if (costs.wrong != 0 || !(costs.hot.mean < at->second.hot)) continue;
      at->second = {name, costs.hot.mean, costs.cold.mean};
    }
    return at->second;
  }

 private:
  const BackendRegistry& registry_;
  std::map<std::pair<std::string, QueryKind>, Peer> best_;
};

std::string cell(const Costs& costs, bool is_batch) {
  std::array<char, 80> out;
  if (is_batch)
    std::snprintf(out.data(), out.size(), "%.0f", costs.mean);
  else
    std::snprintf(out.data(), out.size(), "%.0f / %.0f / %.0f / %.0f", costs.mean, costs.median, costs.p99,
                  costs.worst);
  return out.data();
}

/// "hot 100, cold 250" and "met", or which are missed and why.
struct Verdict {
  std::string asked, verdict;
};

Verdict judge(const Goal& goal, const RowCosts& costs, const Peer& peer) {
  Verdict out;
  std::string missed;
  for (const Asked& asked : goal.asked) {
    const std::string of = kNamesOf[static_cast<std::size_t>(asked.of)];
    const double peers = asked.of == Of::cold ? peer.cold : peer.hot;
    const double limit = asked.ns != kFastestPeer ? asked.ns : peers;
    const std::string figure_asked =
        asked.ns != kFastestPeer ? std::to_string(static_cast<int>(asked.ns)) : std::string("ahead");
    out.asked += (out.asked.empty() ? "" : ", ") + of + " " + figure_asked;
    if (!(std::round(figure(costs, asked.of)) <= limit)) missed += (missed.empty() ? "" : ", ") + of;
  }
  out.verdict = missed.empty() ? "met" : "missed: " + missed;
  if (!missed.empty() && *goal.reason != '\0') out.verdict += std::string(" (") + goal.reason + ")";
  return out;
}

/// Peers' manifolds tell nothing of pairs that are apart: beside them, native is asked for contacts alone.
bool is_beside_peers(const Goal& goal) { return goal.asked.front().ns == kFastestPeer; }

void print_pairs(const BackendRegistry& registry, Peers& peers, std::span<const Goal> goals,
                 const char* calls) {
  for (const Goal& goal : goals) {
    const bool is_contacts_only = is_beside_peers(goal) || goal.is_contacts_only;
    const RowCosts costs =
        measure_row(registry, {goal.family, goal.kind, "native", goal.is_batch, is_contacts_only});
    const Peer peer = peers.best(goal.family, goal.kind);
    const auto [asked, verdict] = judge(goal, costs, peer);
    std::printf("| `%s` | %s | %s%s%s | %s | %s | %s | %d |", goal.family,
                std::string(to_string(goal.kind)).c_str(), goal.is_batch ? "batch" : "lone",
                is_contacts_only ? ", contacts" : "", calls, cell(costs.hot, goal.is_batch).c_str(),
                cell(costs.streamed, goal.is_batch).c_str(), cell(costs.cold, goal.is_batch).c_str(),
                costs.wrong);
    if (std::isfinite(peer.hot))
      std::printf(" `%s` %.0f; %.0f |", peer.name.c_str(), peer.hot, peer.cold);
    else
      std::printf(" - |");
    std::printf(" %s | %s |\n", asked.c_str(), verdict.c_str());
    std::fflush(stdout);
  }
}

/// A floor of what data that are not in the cache cost.
void print_reading() {
  const ReadingCosts reading = measure_reading("tapered");
  std::printf(
      "\nReading the poses, vertices and normals of a pair of `tapered` in batches, a number a cache line "
      "and ");
  std::printf("nothing else, takes %.0f ns hot and %.0f ns cold.\n", reading.hot, reading.cold);
}

void print_moving(const BackendRegistry& registry) {
  std::printf("\nOverlap of 4 096 pairs in a batch whose solids move by so much a frame [ns a pair]:\n\n");
  std::printf("| family | a frame | without the pair cache | with it |\n|---|---|---|---|\n");
  for (const char* const family : {"tapered", "near_1e-3"}) {
    for (const double step : {0.001, 0.01, 0.1}) {
      const MovingCost cost = measure_moving_pairs(registry, family, step);
      std::printf("| `%s` | %.0f mm | %.0f | %.0f |\n", family, 1e3 * step, cost.without_cache,
                  cost.with_cache);
    }
  }
}

/// Names, libraries and versions.
void print_peers(const BackendRegistry& registry) {
  for (const auto& entry : registry.narrowphases())
    if (entry.make_raw) std::printf("- `%s`: %s\n", entry.name.c_str(), entry.description.c_str());
  std::printf("\n");
}

void print_worlds() {
  std::printf("\n| work | figure | asked | verdict |\n|---|---|---|---|\n");
  for (const WorldCost& cost : measure_worlds()) {
    std::printf("| %s | %.3g %s | %.3g %s | %s |\n", cost.work.c_str(), cost.figure, cost.unit, cost.asked,
                cost.unit, cost.figure <= cost.asked ? "met" : ("missed: " + cost.reason).c_str());
    std::fflush(stdout);
  }
}

/// Runs that part in a process of its own, with `setting` in its environment: the choice of kernels, and
/// memory, are a process's.
void print_apart(const std::string& program, const std::string& part, const std::string& setting = "") {
  std::fflush(stdout);
  if (std::system((setting + " " + program::shell_word(program) + " goals " + part).c_str()) != 0)
    std::printf("%s: not measured\n", part.c_str());
}

}  // namespace

void print_goals(const BackendRegistry& registry, const std::string& program, const std::string& part) {
  Peers peers(registry);
  if (part == "two_lanes") {
    print_pairs(registry, peers, two_lane_goals(), ", two lanes");
    return;
  }
  if (part == "reading") {
    print_reading();
    return;
  }
  if (part == "worlds") {
    print_worlds();
    return;
  }
  print_peers(registry);
  std::printf("| family | query | calls | hot [ns] | streamed [ns] | cold [ns] | wrong | ");
  std::printf("fastest right peer, hot; cold [ns] | asked [ns] | verdict |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|\n");
  print_pairs(registry, peers, pair_goals(), "");
  print_apart(program, "two_lanes", "TOUCHSTONE_ISA=generic");
  print_reading();
  print_moving(registry);
  print_apart(program, "worlds");
}

}  // namespace touchstone
