#pragma once

#include <vector>

#include "touchstone/contact_core/output/frame_output.hpp"

namespace touchstone {

/// Brings the actual poses of chosen objects of one world to outputs. Used by the thread that owns the world.
class OutputFeed {
 public:
  /// Keeps a pointer to `world`, which must outlive it.
  explicit OutputFeed(const ContactWorld& world) : world_(&world) {}

  /// Keeps a pointer to `output`; objects shown so far are announced to it. @throws as its add_object.
  void add_output(FrameOutput& output);
  /// @throws InputError: an unknown handle, one that is shown already, or as an output's add_object.
  void show(ObjectHandle object);
  /// Brings a frame to the outputs, after the world's frame. Objects that were removed from the world are
  /// left out from then on. Allocates nothing.
  /// @param time of the poses that the frame ended with [s].
  void send(const FrameReport& report, double time) noexcept;

 private:
  const ContactWorld* world_;
  std::vector<FrameOutput*> outputs_;
  std::vector<OutputObject> objects_;
  std::vector<ShownPose> poses_;
};

}  // namespace touchstone
