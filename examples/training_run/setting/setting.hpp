#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "touchstone/adapters/scene_files/script_file.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/scene/scene_instance.hpp"
#include "touchstone/examples/training_run/setting/arm.hpp"

namespace touchstone::training {

inline constexpr std::uint32_t kNone = kNoIndex;

/// An action with its names looked up.
struct Action {
  OperatorAction::Kind kind;
  double time;                     ///< [s]
  std::uint32_t object;            ///< index in the scene
  std::uint32_t carrier;           ///< kNone unless it latches; of a hold the fixture
  std::vector<SolidPair> allowed;  ///< latch: not checked as well, while it holds; ascending
};

/// A script made ready: the data that all methods of flying it share. Immutable; holds pointers into itself.
class Setting {
 public:
  /// @param frame_rate replaces the script's, if it is not 0 [Hz].
  /// @throws InputError: a rate out of 10 to 1000 Hz, more than 1 000 000 frames.
  explicit Setting(Script script, double frame_rate = 0.0);
  Setting(const Setting&) = delete;
  Setting& operator=(const Setting&) = delete;

  const Script& script() const { return script_; }
  const Scene& scene() const { return script_.scene; }
  const SceneInstance& instance() const { return instance_; }
  std::size_t object_count() const { return scene().objects.size(); }
  const std::string& object_name(std::uint32_t object) const { return scene().objects[object].tree.name(); }
  /// Flown by a hand, latched to something at some time, or taken along.
  bool may_move(std::uint32_t object) const { return may_move_[object]; }
  /// By rules of the scene, while nothing carries it; no hand flies it.
  bool may_be_taken_along(std::uint32_t object) const { return may_be_taken_along_[object]; }
  /// Of an arm's hand: the arm's first link.
  std::uint32_t object_of_hand(std::size_t hand) const { return object_of_hand_[hand]; }
  /// By hand.
  std::span<const Arm> arms() const { return arms_; }
  /// Null: no link of an arm.
  const Arm* arm_of(std::uint32_t object) const { return arm_of_[object]; }
  /// Joint values of all arms.
  std::size_t value_count() const { return value_count_; }
  /// The solids that move as one with it but for latches: the arm's first link, or the object itself.
  std::uint32_t mover_of(std::uint32_t object) const {
    return arm_of_[object] ? arm_of_[object]->first_object : object;
  }
  /// By time; the scene's own latches first.
  std::span<const Action> actions() const { return actions_; }
  /// Every pair of solids that is checked, but for those of two objects that never move.
  std::span<const SolidPair> pairs() const { return pairs_; }

  /// Frame k goes from time(k) to time(k + 1).
  std::size_t frame_count() const { return static_cast<std::size_t>(scene().frame_count() - 1); }
  double time(std::size_t frame) const { return scene().frame_time(frame); }
  /// The hand's command in a frame: the row in force at its start.
  HandRates rates(std::size_t hand, std::size_t frame) const;

 private:
  void place(const Arm& arm);
  std::uint32_t find(const std::string& name) const;
  std::vector<SolidPair> solids_of(std::span<const ExemptPair> pairs) const;

  Script script_;
  std::vector<Arm> arms_;  // their links are in script_.scene
  SceneInstance instance_;
  std::vector<const Arm*> arm_of_;
  std::size_t value_count_ = 0;
  std::vector<char> may_move_, may_be_taken_along_;
  std::vector<std::uint32_t> object_of_hand_;
  std::vector<Action> actions_;
  std::vector<SolidPair> pairs_;
};

/// The carriers, the pairs that latches allow, and the objects that are switched on.
struct Formation {
  std::vector<std::uint32_t> carrier;  ///< by object; kNone: nobody
  std::vector<Pose> X_RO;  ///< in the one that carries all (R); the identity for those not carried
  std::vector<char> is_on;
  std::vector<std::vector<SolidPair>> allowed;  ///< by carried object

  explicit Formation(std::size_t objects)
      : carrier(objects, kNone), X_RO(objects), is_on(objects, 1), allowed(objects) {}
  std::uint32_t root_of(std::uint32_t object) const {
    while (carrier[object] != kNone) object = carrier[object];
    return object;
  }
  /// Of a pair among Setting::pairs().
  bool is_checked(const SolidPair& pair, const SceneInstance& instance) const;
  /// @param X_WO where all stand.
  void apply(const Action& action, std::span<const Pose> X_WO);
};

}  // namespace touchstone::training
