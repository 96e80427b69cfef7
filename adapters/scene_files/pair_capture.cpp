#include "touchstone/adapters/scene_files/pair_capture.hpp"

#include <algorithm>

namespace touchstone {
namespace {

CapturedAnswer answer_of(const ObservedPair& pair) {
  CapturedAnswer answer;
  answer.by = pair.by;
  answer.contact = pair.status == PairStatus::overlapping;
  if (!answer.contact) return answer;
  answer.separation = pair.geometry.separation;
  answer.n_AB_W = pair.geometry.n_AB_W;
  answer.points.assign(pair.points.begin(), pair.points.end());
  std::stable_sort(answer.points.begin(), answer.points.end(),
                   [](const ContactPoint& p, const ContactPoint& q) { return p.separation < q.separation; });
  return answer;
}

PairCase case_of(const ObservedPair& pair, std::size_t number) {
  PairCase out;
  out.id = "pair-" + std::to_string(number);
  out.pair = PosedPair{{*pair.solids[0], *pair.solids[1]}, pair.X_WS};
  out.captured = answer_of(pair);
  return out;
}

}  // namespace

void PairCapture::observe(const ObservedPair& pair) noexcept {
  const std::scoped_lock lock(mutex_);
  const std::size_t number = ++observed_;
  if (kept_.size() < most_) {
    kept_.push_back({number, case_of(pair, number)});
    return;
  }
  // Not std::uniform_int_distribution, whose draws differ between libraries; the bias is below 1e-9 here.
  const std::size_t place = random_() % number;
  if (place < most_) kept_[place] = {number, case_of(pair, number)};
}

std::size_t PairCapture::observed() const {
  const std::scoped_lock lock(mutex_);
  return observed_;
}

std::vector<PairCase> PairCapture::cases() const {
  const std::scoped_lock lock(mutex_);
  std::vector<const Kept*> order;
  for (const Kept& each : kept_) order.push_back(&each);
  std::sort(order.begin(), order.end(), [](const Kept* a, const Kept* b) { return a->number < b->number; });
  std::vector<PairCase> out;
  for (const Kept* each : order) out.push_back(each->pair);
  return out;
}

}  // namespace touchstone
