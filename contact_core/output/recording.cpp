#include "touchstone/contact_core/output/recording.hpp"

namespace touchstone {
namespace {

ObjectHandle handle_of(std::uint32_t index) {
  return index == RecordedEvent::kNone ? ObjectHandle{} : ObjectHandle{index, 0};
}

}  // namespace

std::uint64_t Recording::lost() const {
  std::uint64_t count = lost_after;
  for (const RecordedFrame& frame : frames) count += frame.lost_before;
  return count;
}

void replay(const Recording& recording, FrameOutput& output) {
  for (std::uint32_t i = 0; i < recording.objects.size(); ++i)
    output.add_object({{i, 0}, recording.objects[i]});
  std::vector<ShownPose> poses;
  std::vector<ContactEvent> events;
  for (const RecordedFrame& frame : recording.frames) {
    poses.clear();
    events.clear();
    for (const RecordedPose& pose : frame.poses) poses.push_back({handle_of(pose.object), pose.X_WO});
    for (const RecordedEvent& event : frame.events) {
      events.push_back({event.kind, handle_of(event.a), handle_of(event.b), event.solids, event.s,
                        event.geometry, event.part, event.geometry_at_end});
    }
    output.write({frame.frame, frame.time, poses, events});
  }
}

}  // namespace touchstone
