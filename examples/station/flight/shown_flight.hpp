#pragma once

#include <span>
#include <vector>

#include "touchstone/contact_core/output/frame_output.hpp"
#include "touchstone/examples/station/flight/session.hpp"

namespace touchstone::station {

/// Brings what `ours` shows to receivers (contact_core/output/frame_output.hpp): objects by their index in
/// the scene, of generation 0, through resets; events with the same handles.
class ShownFlight {
 public:
  /// Announces the objects of the scene that is flown now. @throws InputError as FrameOutput::add_object.
  ShownFlight(const Session& session, std::span<FrameOutput* const> receivers);

  /// After each step; no allocation. False: another scene is flown, of which nothing is brought.
  bool send(const Session& session) noexcept;

 private:
  std::vector<FrameOutput*> receivers_;
  std::size_t scene_;
  std::vector<ShownPose> poses_;
  std::vector<ContactEvent> events_;
};

}  // namespace touchstone::station
