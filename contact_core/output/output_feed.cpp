#include "touchstone/contact_core/output/output_feed.hpp"

#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {

void OutputFeed::add_output(FrameOutput& output) {
  outputs_.reserve(outputs_.size() + 1);
  for (const OutputObject& object : objects_) output.add_object(object);
  outputs_.push_back(&output);
}

void OutputFeed::show(ObjectHandle object) {
  OutputObject shown{object, std::string(world_->name_of(object))};
  const auto same = [&](const OutputObject& other) { return other.handle == object; };
  if (std::any_of(objects_.begin(), objects_.end(), same))
    throw InputError("output: object '" + shown.name + "' is shown already");
  objects_.reserve(objects_.size() + 1);
  poses_.reserve(objects_.size() + 1);
  for (FrameOutput* output : outputs_) output->add_object(shown);
  objects_.push_back(std::move(shown));
}

void OutputFeed::send(const FrameReport& report, double time) noexcept {
  std::erase_if(objects_, [&](const OutputObject& object) { return !world_->is_alive(object.handle); });
  poses_.clear();
  for (const OutputObject& object : objects_)
    poses_.push_back({object.handle, world_->actual_pose(object.handle)});
  const OutputFrame frame{report.frame, time, poses_, report.events};
  for (FrameOutput* output : outputs_) output->write(frame);
}

}  // namespace touchstone
