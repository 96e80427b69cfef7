#include "touchstone/contact_core/world/model/frame_lanes.hpp"

namespace touchstone {

void FrameLanes::build(const Narrowphase& narrowphase, const Narrowphase& planner, std::size_t solids) {
  const bool may_share = narrowphase.capabilities().thread_safe && planner.capabilities().thread_safe;
  const std::size_t lanes =
      runner_ == nullptr || !may_share ? 1 : std::clamp<std::size_t>(runner_->threads(), 1, kMost);
  queries_.clear();
  for (std::size_t lane = 0; lane < lanes; ++lane)
    queries_.push_back(std::make_unique<NarrowphaseQuery>(narrowphase, planner, solids));
  first().remember();
  for (std::size_t lane = 1; lane < lanes; ++lane) {
    queries_[lane]->look_up_in(first());
    queries_[lane]->warm_up();
  }
}

void FrameLanes::take_up(std::size_t solids) {
  for (const auto& query : queries_) query->take_up(solids);
}

std::uint64_t FrameLanes::calls() const {
  std::uint64_t sum = 0;
  for (const auto& query : queries_) sum += query->calls();
  return sum;
}

void FrameLanes::ask(std::span<const SolidPair> pairs, std::span<const Pose> poses,
                     std::span<SeparationMemo::Answer> out) {
  constexpr std::size_t kBatch = NarrowphaseQuery::kBatch;
  const std::size_t batches = (pairs.size() + kBatch - 1) / kBatch;
  for_each(batches, 2, [&](NarrowphaseQuery& asking, std::size_t i) {
    const std::size_t begin = i * kBatch, count = std::min(kBatch, pairs.size() - begin);
    asking.separations_at(pairs.subspan(begin, count), poses, out.subspan(begin, count));
  });
  if (pairs.size() > NarrowphaseQuery::kRememberedSets) return;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    first().note(pairs[i], poses[pairs[i].a], poses[pairs[i].b], out[i]);
}

void FrameLanes::pause_notes(bool pause) { first().pause_notes(pause); }

}  // namespace touchstone
