#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/output/frame_output.hpp"

namespace touchstone {

/// Objects by index into Recording::objects.
struct RecordedPose {
  std::uint32_t object;
  Pose X_WO;
};

/// A ContactEvent as recorded. @see ContactEvent for units and signs.
struct RecordedEvent {
  static constexpr std::uint32_t kNone = kNoIndex;

  EventKind kind;
  std::uint32_t a, b;  ///< b: kNone where the event names no second object
  SolidPair solids;
  double s;
  PairGeometry geometry;
  std::uint32_t part;
  PairGeometry geometry_at_end;
};

/// One frame, whole.
struct RecordedFrame {
  std::uint64_t frame;
  double time;                    ///< [s]
  std::uint64_t lost_before = 0;  ///< frames lost between this and the one before
  std::vector<RecordedPose> poses;
  std::vector<RecordedEvent> events;
};

/// A run as it was shown.
struct Recording {
  std::vector<std::string> objects;
  std::vector<RecordedFrame> frames;
  std::uint64_t lost_after = 0;  ///< frames lost after the last one here
  bool is_complete = false;      ///< its end was recorded: nothing is cut off

  std::uint64_t lost() const;
};

/// Brings every frame to `output` as it was recorded, bit for bit; the object with index i gets the handle
/// {i, 0}. @throws as output.add_object().
void replay(const Recording& recording, FrameOutput& output);

}  // namespace touchstone
