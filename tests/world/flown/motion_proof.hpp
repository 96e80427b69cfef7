#pragma once

#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>

// Random motions of random solids through a contact world, each executed pose judged by `exact`.

namespace touchstone {

struct MotionProof {
  std::string narrowphase = "native";
  std::string broadphase = "native";
  std::uint64_t motions = 2000;  ///< commands: one mover in one frame
  std::uint64_t seed = 1;
  bool rounded = false;  ///< two thirds of the movers, and of what stands in contact, have a radius
};

/// The findings. `overlap` of pairs that were apart at their frame's start: touching counts.
struct MotionFigures {
  MotionProof proof;
  bool is_sampled = false;
  std::uint64_t motions = 0, frames = 0, blocked = 0;
  std::uint64_t slid_frames = 0;
  std::uint64_t iteration_limits = 0;
  std::uint64_t poses_judged = 0;     ///< pairs at poses
  std::uint64_t actual_overlaps = 0;  ///< pairs at the frame's end
  std::uint64_t path_overlaps = 0;    ///< pairs at sampled poses before it
  double deepest = 0.0;               ///< of these [m]
  std::uint64_t overlapping_starts = 0;
  std::uint64_t deepened = 0;  ///< of these, at any judged pose, beyond rounding
  double deepest_growth = 0.0;
  std::uint64_t order_shows = 0;  ///< frames after which a world registered in another order differs

  /// The count that must be 0 for a backend with right separations.
  std::uint64_t violations() const { return actual_overlaps + path_overlaps + deepened + order_shows; }
};

/// Worlds of five movers, drawn anew every 25 frames, each with a twin that registered and commanded its
/// objects the other way round. Half of them are in a trough: policy, pace (0.01 to 0.5 m and rad a frame;
/// now and then a whole turn), thin or bulky solids, some that overlap at the start. The others start in
/// contacts of any direction, edges across each other, corners on faces, tilted, tapered and sheared solids;
/// they are moved and turned any way, by 1e-3 to 1 m and rad a frame.
MotionFigures prove_motions(const MotionProof& proof);

void print_table(std::ostream& out, std::span<const MotionFigures> figures);

}  // namespace touchstone
