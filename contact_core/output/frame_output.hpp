#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "touchstone/contact_core/world/contact_world.hpp"

/// @file
/// The contact world's output, once a frame: actual poses only. A commanded or rejected pose has no place
/// in these types, so no output can show one.

namespace touchstone {

/// An object that is shown, as announced before the first frame that holds it.
struct OutputObject {
  ObjectHandle handle;
  std::string name;
};

/// The pose of an object in a frame.
struct ShownPose {
  ObjectHandle object;
  Pose X_WO;  ///< actual
};

/// One frame; the spans are valid during the call that brings them.
struct OutputFrame {
  std::uint64_t frame = 0;
  double time = 0.0;  ///< of the poses [s]
  std::span<const ShownPose> poses;
  std::span<const ContactEvent> events;
};

/// offered = delivered + dropped + those in the queue.
struct OutputStatus {
  std::uint64_t offered = 0;    ///< frames brought
  std::uint64_t delivered = 0;  ///< frames handed to the system, whole
  std::uint64_t dropped = 0;    ///< frames lost, whole
  std::uint64_t errors = 0;     ///< refusals by the system
  int last_error = 0;           ///< errno of the latest of them; 0: none
};

/// A receiver of frames. Threads: one thread brings frames and objects; status() may be called from any.
class FrameOutput {
 public:
  FrameOutput() = default;
  FrameOutput(const FrameOutput&) = delete;
  FrameOutput& operator=(const FrameOutput&) = delete;
  virtual ~FrameOutput() = default;

  /// Set-up; may allocate. @throws InputError when the object cannot be shown; nothing has changed then.
  virtual void add_object(const OutputObject& object) = 0;
  /// Takes a copy of what it needs; never allocates and, unless it was made to, never waits. What cannot be
  /// delivered is dropped and counted. An object that is missing from a frame is no longer shown.
  virtual void write(const OutputFrame& frame) noexcept = 0;
  virtual OutputStatus status() const noexcept = 0;
};

}  // namespace touchstone
