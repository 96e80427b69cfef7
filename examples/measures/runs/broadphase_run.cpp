#include "touchstone/examples/measures/runs/broadphase_run.hpp"

#include <algorithm>
#include <chrono>

#include "touchstone/examples/measures/common/allocations.hpp"

namespace touchstone::measures {
namespace {

using Clock = std::chrono::steady_clock;

struct Runner {
  std::unique_ptr<Broadphase> broadphase;
  std::unique_ptr<Narrowphase> narrowphase;  // of the same name; may be none
  std::unique_ptr<Narrowphase::Workspace> workspace;
  std::vector<PairStatus> status;
  std::vector<double> times;
  std::vector<double> whole_times;  // with the narrowphase
  std::vector<SolidPair> last_pairs;
  std::size_t candidates = 0;
  std::uint64_t allocations = 0;
};

void run_frame(Runner& runner, const Swarm& swarm, std::size_t frame, std::vector<SolidPair>& block,
               bool counts, bool keeps) {
  runner.last_pairs.clear();
  const std::uint64_t allocated = thread_allocations().value_or(0);
  const auto begin = Clock::now();
  runner.broadphase->update(swarm.frames[frame], swarm.all);
  PairCursor cursor;
  std::size_t candidates = 0;
  std::uint64_t kept = 0;
  while (!cursor.done) {
    const std::size_t written = runner.broadphase->find_pairs(cursor, block);
    candidates += written;
    if (keeps) {
      const std::uint64_t before = thread_allocations().value_or(0);
      runner.last_pairs.insert(runner.last_pairs.end(), block.begin(),
                               block.begin() + static_cast<std::ptrdiff_t>(written));
      kept += thread_allocations().value_or(0) - before;
    }
  }
  const auto end = Clock::now();
  if (!counts) return;
  runner.times.push_back(std::chrono::duration<double, std::nano>(end - begin).count());
  runner.candidates += candidates;
  runner.allocations += thread_allocations().value_or(0) - allocated - kept;
}

/// The narrowphase on the frame's pairs, as one batch; they were just found, and are collected here untimed.
void run_overlap(Runner& runner, const Swarm& swarm, std::size_t frame, std::vector<SolidPair>& block) {
  runner.last_pairs.clear();
  PairCursor cursor;
  while (!cursor.done) {
    const std::size_t written = runner.broadphase->find_pairs(cursor, block);
    runner.last_pairs.insert(runner.last_pairs.end(), block.begin(),
                             block.begin() + static_cast<std::ptrdiff_t>(written));
  }
  runner.status.resize(runner.last_pairs.size());
  const auto begin = Clock::now();
  runner.narrowphase->evaluate({runner.last_pairs, swarm.frames[frame], Query{}}, {runner.status, {}, {}},
                               *runner.workspace);
  const auto end = Clock::now();
  runner.whole_times.push_back(runner.times.back() +
                               std::chrono::duration<double, std::nano>(end - begin).count());
}

std::unique_ptr<Narrowphase> narrowphase_named(const BackendRegistry& registry, const std::string& name) {
  for (const BackendRegistry::NarrowphaseEntry& entry : registry.narrowphases())
    if (entry.name == name) return entry.make();
  return nullptr;
}

std::size_t frames_for(std::size_t hexahedra) { return hexahedra <= 1000 ? 60 : hexahedra <= 10000 ? 20 : 8; }

/// All broadphases on one swarm.
class SwarmRun {
 public:
  SwarmRun(const BackendRegistry& registry, const BroadphaseOptions& options, const SwarmSize& size)
      : entries_(registry.broadphases()),
        options_(options),
        size_(size),
        frames_(frames_for(size.hexahedra())),
        swarm_(make_swarm(size, frames_ + 1, options.seed)),
        runners_(entries_.size()) {
    for (std::size_t b = 0; b < entries_.size(); ++b)
      if (!is_skipped(b)) build(registry, b);
  }

  void run(const Progress& progress) {
    std::vector<SolidPair> block(4096);
    for (std::size_t f = 0; f <= frames_; ++f) {
      for (Runner& runner : runners_) {
        if (!runner.broadphase) continue;
        run_frame(runner, swarm_, f, block, f > 0 && f < frames_, f == frames_);
        if (runner.narrowphase && f > 0 && f < frames_) run_overlap(runner, swarm_, f, block);
      }
      if (progress) progress(static_cast<double>(f) / static_cast<double>(frames_));
    }
  }

  void append_results(const Oracle* oracle, std::vector<BroadphaseResult>& results) {
    std::optional<std::vector<SolidPair>> truth;
    if (oracle != nullptr) truth = truth_of_last_frame(*oracle);
    for (std::size_t b = 0; b < entries_.size(); ++b) {
      BroadphaseResult result = is_skipped(b) ? BroadphaseResult{} : measured(runners_[b]);
      result.name = entries_[b].name;
      result.description = entries_[b].description;
      result.size = size_;
      if (is_skipped(b)) result.gap = "not run: its cost grows with the square of the count";
      if (truth && !is_skipped(b)) count_missed(*truth, runners_[b], result);
      results.push_back(std::move(result));
    }
  }

 private:
  bool is_skipped(std::size_t b) const {
    // brute_force looks at every two hexahedra, the paper's at every two objects.
    const std::size_t squared = entries_[b].name == "brute_force" ? size_.hexahedra()
                                : entries_[b].name == "edge_face" ? size_.objects
                                                                  : 0;
    return squared > options_.largest_quadratic;
  }
  bool is_checked_whole() const { return size_.hexahedra() <= options_.largest_checked; }

  void build(const BackendRegistry& registry, std::size_t b) {
    Runner& runner = runners_[b];
    runner.broadphase = entries_[b].make();
    runner.times.reserve(frames_);
    runner.broadphase->build({swarm_.pointers, options_.margin});
    runner.narrowphase = narrowphase_named(registry, entries_[b].name);
    if (!runner.narrowphase) return;
    runner.narrowphase->build(swarm_.solids);
    runner.workspace = runner.narrowphase->make_workspace();
  }

  std::vector<SolidPair> truth_of_last_frame(const Oracle& oracle) const {
    const std::vector<Pose>& poses = swarm_.frames[frames_];
    if (is_checked_whole()) return true_pairs(swarm_, poses, options_.margin, oracle, options_.threads);
    std::vector<SolidPair> candidates;
    for (const Runner& runner : runners_)
      candidates.insert(candidates.end(), runner.last_pairs.begin(), runner.last_pairs.end());
    return confirmed_pairs(swarm_, poses, options_.margin, std::move(candidates), oracle, options_.threads);
  }

  // Sorts the runner's times.
  static BroadphaseResult measured(Runner& runner) {
    BroadphaseResult result;
    result.frames = runner.times.size();
    result.frame = summarise_blocks(runner.times);
    if (!runner.whole_times.empty()) result.with_overlap = summarise_blocks(runner.whole_times);
    result.candidates = static_cast<double>(runner.candidates) / static_cast<double>(result.frames);
    if (thread_allocations())
      result.allocations = static_cast<double>(runner.allocations) / static_cast<double>(result.frames);
    return result;
  }

  void count_missed(const std::vector<SolidPair>& truth, const Runner& runner,
                    BroadphaseResult& result) const {
    result.true_pairs = truth.size();
    result.from_candidates = !is_checked_whole();
    result.missed = static_cast<std::size_t>(std::count_if(truth.begin(), truth.end(), [&](SolidPair pair) {
      return !std::binary_search(runner.last_pairs.begin(), runner.last_pairs.end(), pair);
    }));
  }

  const std::vector<BackendRegistry::BroadphaseEntry>& entries_;
  const BroadphaseOptions& options_;
  SwarmSize size_;
  std::size_t frames_;
  Swarm swarm_;
  std::vector<Runner> runners_;
};

}  // namespace

std::vector<BroadphaseResult> run_broadphases(const BackendRegistry& registry,
                                              const BroadphaseOptions& options, const Oracle* oracle,
                                              const Progress& progress) {
  std::vector<BroadphaseResult> results;
  for (std::size_t s = 0; s < options.swarms.size(); ++s) {
    SwarmRun run(registry, options, options.swarms[s]);
    run.run([&](double done) {
      if (progress) progress((static_cast<double>(s) + done) / static_cast<double>(options.swarms.size()));
    });
    run.append_results(oracle, results);
  }
  return results;
}

}  // namespace touchstone::measures
