#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/mechanism/joint_space.hpp"
#include "touchstone/contact_core/mechanism/relative_paths.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"

namespace touchstone {

/// The hand that holds a mechanism: ContactWorld::set_hand().
struct ArmHand {
  std::uint32_t link;  ///< the tool's
  Pose X_LT;
  Vector3 translation, turning;  ///< stiffnesses of the tool frame
  JointMatrix root{};            ///< of the metric of the slide at hand
};

/// A mechanism in the world: one mover, of which every link with hexahedra is an object.
struct MechanismMover final : PathViews {
  explicit MechanismMover(MechanismPlacement placement);

  std::shared_ptr<const Mechanism> mechanism;
  std::vector<double> initial, actual, commanded;
  std::vector<double> own_weights;          ///< MechanismPlacement::weights
  std::vector<double> weights;              ///< of the slide's metric: these, or the hand's of the joints
  std::unique_ptr<ArmHand> hand;            ///< null: none, so that the metric is the weights'
  std::vector<std::uint32_t> slot_of_link;  ///< kNone: no hexahedra
  std::vector<std::uint32_t> rigid_with;    ///< by link: the innermost one that no joint moves it against
  std::vector<Pose> X_WL;                   ///< actual, by link
  std::uint32_t lead = kNoIndex;            ///< slot that stands for all
  MechanismPath path;                       ///< of this frame, or sub-step of a slide
  RelativePaths relative;
  JointFrame frame;  ///< of a slide
  /// Two links a < b of which a joint value moves only one, the outer one: the pair's place is a * links + b.
  struct MovedPair {
    std::uint32_t place, outer;
  };
  std::vector<MovedPair> moved_pairs;           ///< by joint value
  std::vector<std::uint32_t> first_moved_pair;  ///< of each value, and one more
  bool is_resting = false;
  double shift_limit = -1.0;  ///< no prismatic value has been further from 0, or is commanded to go [m]
  std::vector<double> radius_of_link;  ///< of all that the link carries, about its origin [m]
  bool is_laid_out = false;            ///< its solids have their places, its pairs of links, too
  std::uint32_t first_link_pair = 0;   ///< of these in Travels
  std::uint64_t paths = 0;             ///< laid so far: another count, another path
  std::uint64_t planned_path = 0;      ///< the one whose travels were planned last: plan_goes_beyond()
  std::uint64_t planned_after = 0;     ///< Travels::clearings then

  const MotionPath& seen_from(std::uint32_t body) noexcept override { return relative.seen_from(body, path); }
  std::uint32_t standing_body() const noexcept override { return mechanism->base(); }

  std::uint32_t link_pairs() const { return static_cast<std::uint32_t>(X_WL.size() * X_WL.size()); }
  JointMetric metric() const { return {weights, hand == nullptr ? nullptr : &hand->root}; }

  std::span<const MovedPair> moved_by(std::uint32_t value) const {
    return std::span(moved_pairs)
        .subspan(first_moved_pair[value], first_moved_pair[value + 1] - first_moved_pair[value]);
  }

  /// Lays the path from the actual joint values; `to` may be a member.
  void go(std::span<const double> to) noexcept;
  /// At the actual joint values.
  void rest() noexcept;
  /// Back to `initial`, at rest.
  void reset() noexcept;
  /// Joint values and link poses as the path has them at s.
  void stand_at(double s) noexcept;

 private:
  void list_moved_pairs();
};

/// The mechanisms by index.
class MechanismTable {
 public:
  MechanismHandle add(std::unique_ptr<MechanismMover> mover);
  void remove(MechanismHandle handle);

  bool is_alive(MechanismHandle handle) const;
  /// @throws InputError.
  MechanismMover& get(MechanismHandle handle) const;

  std::uint32_t size() const { return static_cast<std::uint32_t>(entries_.size()); }
  /// Null: removed.
  MechanismMover* at(std::uint32_t index) const { return entries_[index].mover.get(); }

 private:
  void check(MechanismHandle handle) const;

  struct Entry {
    std::unique_ptr<MechanismMover> mover;
    std::uint32_t generation = 0;
  };
  std::vector<Entry> entries_;
};

}  // namespace touchstone
