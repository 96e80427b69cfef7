#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/examples/measures/truth/oracle.hpp"
#include "touchstone/examples/training_run/flight/flight_log.hpp"
#include "touchstone/examples/training_run/setting/setting.hpp"

namespace touchstone::training {

/// A pair that stopped a mover which it had not stopped the frame before.
struct Stop {
  double time;       ///< [s]
  SolidPair solids;  ///< indices in the scene
  double clearance;  ///< exact separation of what was shown then [m]
};

/// A pair that a method began or ceased to report in contact.
struct Cue {
  EventKind kind;  ///< penetrating_at_start, began or ended
  double time;     ///< [s]
  SolidPair solids;
};

/// The verdict on a flight, by `exact`.
struct Verdict {
  std::size_t frames = 0;
  std::vector<Stop> stops;
  std::vector<Cue> cues;
  double deepest_shown = 0.0;      ///< depth of the deepest pair of any shown frame; 0: none overlaps [m]
  double deepest_between = 0.0;    ///< between frames too, sampled every millimetre [m]
  std::size_t merged = 0;          ///< shown frames with a pair in contact
  std::size_t passed_through = 0;  ///< frames that took a pair through each other, apart at both ends
  /// Shown frames with a pair in contact that should not be, or that the method did not report. It may be
  /// where the policy is `cue`, and where the pair overlapped at the start and is no deeper.
  std::size_t missed = 0;
  /// Frames in which the method reported a contact, but no such pair was within twice the gap.
  std::size_t phantom = 0;
  std::size_t blocked = 0;  ///< frames in which a mover was stopped
  /// Of those, the ones in which a mover was stopped by pairs of which none would have come below the gap
  /// rule's threshold on the commanded path, or was held though no pair of its own was named. Where a pair is
  /// in a contact that it was not in at the start, only what would bring it out of there is wrongly stopped.
  std::size_t false_stops = 0;
  std::vector<Pose> last;  ///< of all objects
};

/// A separation over time, for plots.
struct SeparationPoint {
  double time, separation;  ///< of the closest pair, exact [s, m]
};

/// Two solids in contact where objects stand.
struct ShownContact {
  SolidPair solids;   ///< indices in the scene
  double separation;  ///< exact, <= 0 [m]
};

/// Judges flights of one setting with the adapter `exact`. One a thread.
class Judge {
 public:
  explicit Judge(const Setting& setting);
  ~Judge();

  /// @param resolution of the backend's distances, none where it has none: a method may report contact within
  /// twice max(g, 4 resolutions).
  Verdict judge(const FlightLog& log, const Resolution& resolution,
                const measures::Progress& progress = {}) const;
  /// Returns the pairs of the setting that are in contact where all objects stand, ascending.
  std::vector<ShownContact> contacts(std::span<const Pose> X_WO, const Formation& formation) const;
  /// Of shown frames `first` to `last`.
  std::vector<SeparationPoint> separations(const FlightLog& log, std::size_t first, std::size_t last) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace touchstone::training
