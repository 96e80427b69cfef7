#include "touchstone/contact_core/world/frame/selection_log.hpp"

namespace touchstone {

void SelectionLog::begin_record(std::size_t room) {
  std::vector<SelectionRecord> record;
  record.reserve(room);
  record_.swap(record);
  room_ = room;
  left_out_ = 0;
}

void SelectionLog::take(WorldModel& model, std::uint64_t frame) {
  queue_.take(applied_);
  refused_.clear();
  std::size_t kept = 0;
  for (const SelectionChange& change : applied_) {
    if (!model.selection.apply(change, model.objects, model.mechanisms)) {
      refused_.push_back(change);
      continue;
    }
    if (record_.size() < room_)
      record_.push_back({frame, change});
    else
      ++left_out_;
    applied_[kept++] = change;
  }
  applied_.resize(kept);
}

}  // namespace touchstone
