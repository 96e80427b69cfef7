#pragma once

#include "touchstone/adapters/python/arrays.hpp"

namespace touchstone::python {

/// Poses of solids, converted and checked once. As many for ever: what an evaluation reads without Python's
/// lock stays where it is, and does not change meanwhile.
class Poses {
 public:
  explicit Poses(std::vector<Pose> poses) : poses_(std::move(poses)) {}
  Poses(const py::handle& matrices_or_positions, const py::handle& quaternions) {
    convert(matrices_or_positions, quaternions, poses_);
  }
  /// From (n, 4, 4), or (n, 3) and (n, 4), to `out`, which becomes as long: memory that it has is used again.
  static void convert(const py::handle& matrices_or_positions, const py::handle& quaternions,
                      std::vector<Pose>& out);

  std::span<const Pose> span() const { return poses_; }
  /// Replaces those from `first` on. @throws InputError: as convert(), beyond the end; RuntimeError: in use.
  void update(const py::handle& matrices_or_positions, const py::handle& quaternions, std::size_t first);
  Doubles matrices() const;

  /// Held while read without Python's lock; taken and given back with it.
  class Reading {
   public:
    explicit Reading(Poses& of) : of_(of) { ++of_.readers_; }
    ~Reading() { --of_.readers_; }
    Reading(const Reading&) = delete;
    Reading& operator=(const Reading&) = delete;

   private:
    Poses& of_;
  };

 private:
  std::vector<Pose> poses_;
  std::vector<Pose> spare_;  ///< of the last update, whose memory serves the next
  int readers_ = 0;
};

}  // namespace touchstone::python
