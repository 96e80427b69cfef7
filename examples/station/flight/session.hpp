#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/examples/station/flight/flight.hpp"

namespace touchstone::station {

using StationScenes = std::vector<std::unique_ptr<const StationScene>>;

/// The index of a scene by its name; as many as there are: none has it.
std::size_t find_scene(const StationScenes& scenes, std::string_view name);

/// Flights one after another, of one scene or several: what a recording replays. One thread.
class Session {
 public:
  /// Keeps a reference. @throws InputError: no scenes, or as Flight.
  /// @param dynamics where the scene has them.
  Session(const StationScenes& scenes, std::size_t scene, std::uint32_t methods = kAllMethods,
          bool dynamics = false);

  /// Between frames; may allocate.
  ControlAnswer set(const Control& control);
  void step(const HandInput& input) noexcept;

  const Flight& flight() const { return *flight_; }
  const StationScenes& scenes() const { return *scenes_; }
  std::size_t scene() const { return scene_; }
  std::uint64_t frame() const { return frame_; }
  double time() const { return static_cast<double>(frame_) / flight_->rate(); }
  /// Changes with every scene chosen and every reset: what was judged before counts no more.
  std::uint32_t epoch() const { return epoch_ + flight_->resets(); }
  /// Changes with every scene chosen.
  std::uint32_t serial() const { return serial_; }
  /// Of every pose of every method in every frame so far.
  std::uint64_t hash() const;

 private:
  const StationScenes* scenes_;
  std::size_t scene_;
  std::unique_ptr<Flight> flight_;
  std::uint64_t frame_ = 0, earlier_hash_ = 0;
  std::uint32_t epoch_ = 1, serial_ = 1;
};

}  // namespace touchstone::station
