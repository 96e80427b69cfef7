#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "touchstone/contact_core/motion/narrowphase_query.hpp"
#include "touchstone/contact_core/threads/task_runner.hpp"

namespace touchstone {

/// The lanes of a frame: they ask about pairs side by side, each with its own query. Work outside of lanes
/// uses the first lane's query. While several lanes have work, no query remembers answers: results, and the
/// number of narrowphase calls, then depend neither on how many lanes there are nor on their order.
class FrameLanes {
 public:
  static constexpr std::size_t kMost = 64;

  /// Borrowed; null: the caller's thread alone. In force from the next build() on.
  void set_runner(TaskRunner* runner) { runner_ = runner; }
  TaskRunner* runner() const { return runner_; }

  /// Keeps references. Where the narrowphases may not be asked on several threads there is one lane.
  void build(const Narrowphase& narrowphase, const Narrowphase& planner, std::size_t solids);
  /// See NarrowphaseQuery::take_up().
  void take_up(std::size_t solids);

  std::size_t count() const { return queries_.size(); }
  NarrowphaseQuery& first() { return *queries_.front(); }
  /// Which lane asks by this query: for what a lane keeps besides. @pre it is one of the lanes'.
  std::size_t lane_of(const NarrowphaseQuery& query) const {
    std::size_t lane = 0;
    while (queries_[lane].get() != &query) ++lane;
    return lane;
  }
  /// Narrowphase calls of all lanes.
  std::uint64_t calls() const;

  /// Signed distances of pairs at the current poses. Answers of a short list are remembered; those of a long
  /// one would push each other out.
  /// @param poses X_WS of every solid. @param out one a pair.
  void ask(std::span<const SolidPair> pairs, std::span<const Pose> poses,
           std::span<SeparationMemo::Answer> out);

  /// Calls body(query, i) for each i below `items`, once each, in any order. body() writes what is the i-th's
  /// alone, and allocates nothing.
  /// @param chunk how many a lane takes at once; below two chunks no other thread is woken.
  template <class Body>
  void for_each(std::size_t items, std::size_t chunk, const Body& body);

 private:
  void pause_notes(bool pause);

  TaskRunner* runner_ = nullptr;
  std::vector<std::unique_ptr<NarrowphaseQuery>> queries_;  // by lane
};

template <class Body>
void FrameLanes::for_each(std::size_t items, std::size_t chunk, const Body& body) {
  if (items < 2 * chunk) {
    for (std::size_t i = 0; i < items; ++i) body(first(), i);
    return;
  }
  pause_notes(true);
  const std::size_t lanes = std::min(count(), items / chunk);
  if (lanes == 1) {
    for (std::size_t i = 0; i < items; ++i) body(first(), i);
  } else {
    std::atomic<std::size_t> next{0};
    auto work = [&](std::size_t lane) {
      for (std::size_t begin; (begin = next.fetch_add(chunk, std::memory_order_relaxed)) < items;)
        for (std::size_t i = begin; i < std::min(items, begin + chunk); ++i) body(*queries_[lane], i);
    };
    run_tasks(runner_, lanes, work);
  }
  pause_notes(false);
}

}  // namespace touchstone
