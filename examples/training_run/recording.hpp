#pragma once

#include <span>
#include <string>
#include <vector>

#include "examples/training_run/setting.hpp"

namespace touchstone::training {

/// Receives what is shown, once a frame: actual poses only.
class FrameOutput {
 public:
  virtual ~FrameOutput() = default;
  /// @param time of the poses [s]; frame 0 is the start. @param X_WO of all objects, valid during the call.
  /// No allocation.
  virtual void on_frame(std::size_t frame, double time, std::span<const Pose> X_WO) noexcept = 0;
};

/// Keeps every frame in memory taken beforehand.
class Recording final : public FrameOutput {
 public:
  explicit Recording(const Setting& setting);
  void on_frame(std::size_t frame, double time, std::span<const Pose> X_WO) noexcept override;
  /// One row a frame and object that may move, with digits that read back as the same bits:
  /// frame,time,object,x,y,z,r00,r01,r02,r10,r11,r12,r20,r21,r22 [s, m].
  std::string csv() const;

 private:
  const Setting* setting_;
  std::vector<std::uint32_t> movers_;
  std::vector<double> times_;
  std::vector<Pose> X_WO_;  // by frame and mover
};

}  // namespace touchstone::training
