#include "touchstone/examples/station/flight/session.hpp"

#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::station {

std::size_t find_scene(const StationScenes& scenes, std::string_view name) {
  const auto found =
      std::find_if(scenes.begin(), scenes.end(), [&](const auto& scene) { return scene->name == name; });
  return static_cast<std::size_t>(found - scenes.begin());
}

Session::Session(const StationScenes& scenes, std::size_t scene, std::uint32_t methods, bool dynamics)
    : scenes_(&scenes), scene_(scene) {
  if (scene >= scenes.size()) throw InputError("the station has no scene to fly");
  flight_ = std::make_unique<Flight>(*scenes[scene], methods, dynamics);
}

ControlAnswer Session::set(const Control& control) {
  if (control.kind != Control::Kind::scene) return flight_->set(control);
  if (control.index >= scenes_->size()) return {false, "no such scene"};
  auto next = std::make_unique<Flight>(*(*scenes_)[control.index], flight_->state().methods,
                                       flight_->state().dynamics);
  earlier_hash_ = hash();
  epoch_ += flight_->resets() + 1;
  ++serial_;
  flight_ = std::move(next);
  scene_ = control.index;
  return {true, (*scenes_)[scene_]->name};
}

void Session::step(const HandInput& input) noexcept {
  flight_->step(input);
  ++frame_;
}

std::uint64_t Session::hash() const {
  constexpr std::uint64_t kOdd = 0x9e3779b97f4a7c15;
  return flight_->hash() ^ (earlier_hash_ * kOdd);
}

}  // namespace touchstone::station
