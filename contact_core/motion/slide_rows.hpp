#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/motion/impact.hpp"
#include "touchstone/contact_core/motion/slide.hpp"

// Makes the rows that hold a slide from the narrowphase's answers about pairs.

namespace touchstone {

/// A solid of the mover and one that it may meet, at their current poses.
struct NearPair {
  const Hexahedron* mover;
  const Hexahedron* obstacle;
  Pose X_WM, X_WB;       ///< the mover's solid, the obstacle
  Vector3 centre_W;      ///< the mover's centre of mass
  double gap;            ///< [m]
  double share = 1.0;    ///< of the slack that is the mover's: a half where the other moves too
  double reach;          ///< no point of the mover's solid goes further [m]
  std::uint32_t source;  ///< copied into the rows
  std::uint32_t link = 0, other_link = 0;  ///< the same
  double separation;                       ///< [m]
  Vector3 n;                               ///< unit, from the obstacle to the mover
  int point_count;
  std::array<ContactPoint, kMaxManifoldPoints> points;  ///< A: the obstacle's, B: the mover's

  /// Which plane holds the mover back: that of the closest points, or a face's. A pair that is in contact on
  /// a face is sure; of all others, seams among them, the plane follows the motion.
  bool is_sure = false;
  int plane = -1;  ///< -1: of the closest points; 0-5 the mover's faces, 6-11 the obstacle's

  // By classify(), as they do not change while the two stand.
  bool turns = false;           ///< the plane of the closest points turns with the mover
  Vector3 e = Vector3::Zero(),  ///< the edges that span that plane, f so long that n = e x f;
      f = Vector3::Zero();      ///< zero: others do
  /// Bit i: plane i keeps half the gap. By choose_plane(), the first time that it needs them.
  unsigned planes_that_part = 0;
  bool are_planes_known = false;
};

/// Sets is_sure and the inputs of rows from the geometry.
void classify(NearPair& pair);

/// Chooses, among the planes that keep half the gap, the one that lets most of `twist` through. Returns
/// whether the choice changed.
bool choose_plane(NearPair& pair, const Twist& twist);

/// @param reach rows with more slack than this are left out [m].
/// @pre rows has a capacity above kMostSlideRows: where that is reached, order_rows() makes room.
void add_rows(const NearPair& pair, double reach, std::vector<SlideRow>& rows);

/// Sorts, and keeps the kMostSlideRows with the least slack: those left out stop a motion when it comes
/// there.
void order_rows(std::vector<SlideRow>& rows);

/// The rows of all these pairs, in their order, instead of what was in `rows`. @param all else only of those
/// that are sure.
void collect_rows(std::span<const NearPair> near, bool all, std::vector<SlideRow>& rows);

/// Calls visit(source) for each pair that holds a plan by one of its active rows. Pairs may share a row to
/// the last bit, where a corner is equally deep in two solids: then all of them hold, whichever came first.
/// @param rows in their order. @param active indices into it.
template <class Visit>
void for_each_holding(std::span<const SlideRow> rows, std::span<const int> active, Visit visit) {
  for (const int row : active) {
    const auto k = static_cast<std::size_t>(row);
    visit(rows[k].source);
    for (std::size_t i = k; i > 0 && !(rows[i - 1] < rows[k]); --i) visit(rows[i - 1].source);
    for (std::size_t i = k + 1; i < rows.size() && !(rows[k] < rows[i]); ++i) visit(rows[i].source);
  }
}

}  // namespace touchstone
