#pragma once

#include <memory>
#include <span>
#include <vector>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/examples/training_run/setting/setting.hpp"

namespace touchstone::station {

/// The least distance to an object, a being of what was asked about.
struct NearDistance {
  std::uint32_t object = 0;  ///< the other one
  SolidPair solids{0, 0};    ///< indices in the scene; not ordered
  double separation = 0.0;   ///< [m]
  Vector3 p_A_W = Vector3::Zero(), p_B_W = Vector3::Zero();
};

/// Read-outs of distance, by `native`. One thread; asking allocates nothing.
class NearDistances {
 public:
  /// Keeps a reference.
  explicit NearDistances(const training::Setting& setting);

  /// The least distance of each object that does not move with `object` (nor is of the same arm) to `object`
  /// and what moves with it, where it is within kReach: the nearest first.
  void find(std::uint32_t object, std::span<const Pose> X_WO, const training::Formation& formation) noexcept;
  std::span<const NearDistance> found() const { return std::span(found_).first(count_); }
  /// Of two objects, whatever carries them [m]; infinite beyond kReach.
  double between(std::uint32_t a, std::uint32_t b, std::span<const Pose> X_WO) noexcept;

  static constexpr double kReach = 2.0;    ///< [m]
  static constexpr std::size_t kMost = 8;  ///< objects found

 private:
  void place(std::uint32_t object, const Pose& X_WO) noexcept;
  /// The nearest pair of a solid of each; infinite separation: beyond reach.
  NearDistance nearest(std::uint32_t a, std::uint32_t b) noexcept;

  const training::Setting* setting_;
  std::unique_ptr<Narrowphase> narrowphase_;
  std::unique_ptr<Narrowphase::Workspace> workspace_;
  std::vector<Pose> X_WS_;
  std::vector<SolidPair> pairs_;
  std::vector<PairStatus> status_;
  std::vector<PairGeometry> geometry_;
  std::vector<NearDistance> found_;
  std::size_t count_ = 0;
};

}  // namespace touchstone::station
