#include "touchstone/examples/compare_backends/run/scenes/pair_choice.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/measures/common/parallel.hpp"

namespace touchstone::comparison {
namespace {

// Frames that one pass follows: fixed, so that the threads do not show in the choice among equals.
constexpr std::size_t kFramesAPass = 200;

// How far a hull's points moved at most: as far as one of its vertices.
double moved(const WorldVertices& from, const WorldVertices& to) {
  double most = 0.0;
  for (int i = 0; i < 8; ++i) {
    const Vector3 d = to.vertex(i) - from.vertex(i);
    most = std::max(most, dot(d, d));
  }
  return std::sqrt(most) * (1 + 1e-12);  // generous to rounding
}

// The pairs' separations along consecutive frames: a pair is asked about again only once the motion since its
// last answer could have brought it within reach or made it the closest.
class Follower {
 public:
  Follower(const PairSet& set, double reach, const Oracle& oracle)
      : set_(set), reach_(reach), oracle_(oracle), memory_(set.pairs.size()), needed_(set.pairs.size()) {}

  void frame(std::size_t f) {
    const auto poses = set_.frame_poses(f);
    vertices_.resize(poses.size());
    for (std::size_t i = 0; i < poses.size(); ++i) world_vertices(set_.solids[i], poses[i], vertices_[i]);
    order_.clear();
    for (std::size_t p = 0; p < memory_.size(); ++p) order_.emplace_back(lower_bound(p), p);
    std::sort(order_.begin(), order_.end());
    double least = kInfinity;
    std::vector<std::size_t> closest;
    for (const auto& [bound, p] : order_) {
      if (bound > least && bound > reach_) break;
      const double separation = ask(p);
      if (separation <= reach_) needed_[p] = true;
      if (separation < least) closest.clear();
      if (separation <= least) closest.push_back(p);
      least = std::min(least, separation);
    }
    const bool has_one =
        std::any_of(closest.begin(), closest.end(), [&](std::size_t p) { return needed_[p]; });
    if (!has_one && !closest.empty()) needed_[*std::min_element(closest.begin(), closest.end())] = true;
  }

  const std::vector<bool>& needed() const { return needed_; }

 private:
  struct Memory {
    bool asked = false;
    double separation = 0;
    WorldVertices a, b;  // where it was asked
  };

  double lower_bound(std::size_t p) const {
    const Memory& memory = memory_[p];
    if (!memory.asked) return -kInfinity;
    const auto [a, b] = set_.pairs[p];
    return memory.separation - moved(memory.a, vertices_[a]) - moved(memory.b, vertices_[b]);
  }

  double ask(std::size_t p) {
    const auto [a, b] = set_.pairs[p];
    memory_[p] = {true, oracle_.truth(vertices_[a], vertices_[b]).separation, vertices_[a], vertices_[b]};
    return memory_[p].separation;
  }

  const PairSet& set_;
  double reach_;
  const Oracle& oracle_;
  std::vector<Memory> memory_;
  std::vector<bool> needed_;
  std::vector<WorldVertices> vertices_;
  std::vector<std::pair<double, std::size_t>> order_;
};

}  // namespace

std::vector<std::size_t> pairs_that_decide(const PairSet& set, double reach, const Oracle& oracle,
                                           int threads) {
  std::vector<bool> needed(set.pairs.size());
  std::mutex mutex;
  parallel_chunks(set.frames(), kFramesAPass, threads, [&](std::size_t begin, std::size_t end) {
    Follower follower(set, reach, oracle);
    for (std::size_t f = begin; f < end; ++f) follower.frame(f);
    const std::lock_guard lock(mutex);
    for (std::size_t p = 0; p < needed.size(); ++p)
      if (follower.needed()[p]) needed[p] = true;
  });
  std::vector<std::size_t> chosen;
  for (std::size_t p = 0; p < needed.size(); ++p)
    if (needed[p]) chosen.push_back(p);
  return chosen;
}

}  // namespace touchstone::comparison
