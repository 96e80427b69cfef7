#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/world/model/world_model.hpp"
#include "touchstone/contact_core/world/pairs/selection_state.hpp"

namespace touchstone {

/// Takes selection changes from the thread that queues them to the record.
class SelectionLog {
 public:
  /// May be called from any thread; all other functions belong to the frame loop.
  void push(const SelectionChange& change) { queue_.push(change); }
  void forget_queued() { queue_.clear(); }

  void take_room() { queue_.reserve(1024), applied_.reserve(1024), refused_.reserve(1024); }
  /// Clears the record and makes room for that many changes.
  void begin_record(std::size_t room);

  /// A frame begins: applies what is queued, in order.
  void take(WorldModel& model, std::uint64_t frame);

  std::span<const SelectionChange> applied() const { return applied_; }  ///< by the last take()
  std::span<const SelectionChange> refused() const { return refused_; }  ///< the same
  std::span<const SelectionRecord> record() const { return record_; }
  std::uint64_t left_out() const { return left_out_; }  ///< of the record, for want of room

 private:
  SelectionQueue queue_;
  std::vector<SelectionChange> applied_, refused_;
  std::vector<SelectionRecord> record_;
  std::size_t room_ = 0;
  std::uint64_t left_out_ = 0;
};

}  // namespace touchstone
