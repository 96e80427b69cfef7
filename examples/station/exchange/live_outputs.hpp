#pragma once

#include <atomic>
#include <optional>
#include <string>

#include "touchstone/examples/station/flight/session.hpp"
#include "touchstone/examples/station/flight/shown_flight.hpp"
#include "touchstone/examples/training_run/results/outputs.hpp"

namespace touchstone::station {

/// The outputs of a live flight besides the page: CIGI, a record, an animation. None of them delays the
/// loop: what one does not take at once it loses, counts and reports at the end.
class LiveOutputs {
 public:
  /// @param name of the files, without extension. Shows where the session stands.
  /// @throws InputError as training::prepare_outputs() and FlightOutputs.
  LiveOutputs(const training::OutputOptions& options, const Session& session, const std::string& name);

  /// The loop's thread, after every frame; no allocation. Frames of another scene than the first are counted
  /// and not shown: outputs know its objects alone.
  void send(const Session& session) noexcept;

  /// Ends the record. Returns one line a receiver; empty where there is no receiver, or on a second call.
  std::string end();
  /// After end(): writes the animation, which may take long. Its line; empty: none was asked for.
  std::string write_animation();
  bool has_animation() const { return has_animation_; }

 private:
  std::string lines(std::span<const training::OutputFigures> figures) const;

  training::FlightOutputs outputs_;
  std::optional<ShownFlight> shown_;  // none: nobody receives
  bool has_animation_ = false;
  std::uint64_t of_other_scenes_ = 0;
};

}  // namespace touchstone::station
