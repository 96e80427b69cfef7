#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "touchstone/contact_core/broadphase/native/float_lanes.hpp"
#include "touchstone/contact_core/broadphase/native/pair_list.hpp"
#include "touchstone/contact_core/broadphase/native/solid_bounds.hpp"
#include "touchstone/contact_core/broadphase/native/sphere_tests.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"

namespace touchstone {

/// The spheres of all objects of a scene in a uniform grid, made anew by counting in each frame in which many
/// objects move: cheaper than a tree where sizes and density are much the same. Whether they are is sampled
/// each time that it is made; after a refusal, the 32nd time. A few objects may be loose: giants, strays and
/// those at no finite place are in no cell. Where few move after it was made, these leave their places and
/// are late: each is in a list of its new cells. The grid is made anew where too many are late or loose for
/// move(), too.
///
/// Cells stand in rows along the longest side of the scene, rows in square tiles, and objects in the order of
/// their cells: so a sphere meets its neighbours in few runs of positions, four at a time.
///
/// Objects' places are floats, in sides of a cell. Radii are grown by more than all rounding, so that no pair
/// is missed; pairs that floats cannot tell are left to SolidBounds::may_pair().
class ObjectGrid {
 public:
  /// Parts of the objects that may be asked for their pairs on different threads, and their heaps.
  static constexpr std::size_t kMostParts = PairList::kMostHeaps;

  /// Cold. Room for this many objects.
  void reserve(std::size_t objects);

  /// Takes all objects of the scene where they are now, at poses. False: other means are quicker, and this
  /// grid has nothing.
  bool build(const SolidBounds& bounds, TaskRunner* threads) noexcept;
  /// Objects were removed or became static since it was built: pairs are tested for that.
  void note_changes() noexcept { is_plain_ = false; }
  /// These objects were placed anew, or came. False: too many are late or loose by now, and the grid must be
  /// built. @pre it was built.
  bool move(const SolidBounds& bounds, std::span<const std::uint32_t> moved) noexcept;
  /// A number that is near for objects that are near.
  std::uint32_t place_of(const Sphere& sphere) const noexcept {
    Spot spot{};
    return place(sphere, spot) != kNowhere ? spot.cell : kNoIndex;
  }

  /// One for each run of rows, and one for loose and late objects.
  std::size_t parts() const { return cell_parts_ + 1; }
  /// Writes the pairs whose first object is in this part: each pair comes up in one part. In the same order
  /// on any number of threads.
  void list_part(std::size_t part, const SolidBounds& bounds, PairList::Writer& writer) const noexcept;

  /// Calls visit(other) for all objects that may pair with one there, itself included if it is one of them.
  template <class Visit>
  void for_each_near(const Sphere& sphere, Visit visit) const noexcept {
    for_each_in_cells(reach_of(sphere), visit);
    for_each_loose(visit);
  }

  /// The same for a few spheres at once, with visit(k, other, is_sure) for sphere_of(k), k < count: is_sure
  /// tells that they touch, both are there and not both static. What one sphere needs is fetched while those
  /// before it are looked at.
  template <class SphereOf, class Visit>
  void for_each_near_of(std::uint32_t count, SphereOf sphere_of, Visit visit) const noexcept {
    std::array<Reach, kTogether> reaches;
    for (std::uint32_t k = 0; k < count; ++k) {
      reaches[k] = reach_of(sphere_of(k));
      for_each_row(reaches[k], [&](std::uint32_t low, std::uint32_t high) { prefetch_cells(low, high); });
    }
    for (std::uint32_t k = 0; k < count + kAhead; ++k) {
      if (k < count)
        for_each_row(reaches[k], [&](std::uint32_t low, std::uint32_t high) { prefetch_run(low, high); });
      if (k < kAhead) continue;
      std::array<Near, kMostNear> found;
      const std::uint32_t asked = k - kAhead;
      const std::size_t near = find_near(reaches[asked], found);
      const auto visit_one = [&](std::uint32_t other) { visit(asked, other, false); };
      if (near > kMostNear)
        for_each_in_cells(reaches[asked], visit_one);
      else
        for (const Near& one : std::span(found).first(near)) visit(asked, one.object, one.is_sure != 0);
      for_each_loose(visit_one);
    }
  }
  /// As many spheres are asked about together at most.
  static constexpr std::uint32_t kTogether = 8;

 private:
  static constexpr std::size_t kMostChunks = 128;
  static constexpr std::uint32_t kLoosePart = kMostParts;  // past all parts of cells
  static constexpr std::uint32_t kSamples = 1024;

  /// Of an object: where its sphere is, in sides of a cell, and the cell.
  struct Spot {
    float x, y, z, radius;
    std::uint32_t object, cell;
  };
  /// The cells and radii that a sphere may meet; none where low is above high.
  struct Reach {
    float x, y, z, radius;
    std::array<std::uint32_t, 3> low, high;
    bool takes_all;  // of these cells: floats are too coarse
    float doubt;     // as doubt_; infinite where that is for others
  };
  /// An object that a sphere met, at first by its position.
  struct Near {
    std::uint32_t object, is_sure;
  };
  /// A row's place and first cell, and those of the rows beside it: beyond it at the same z, and at the next
  /// z before it, at it and beyond it. At the grid's border, others stand for those that are not there.
  struct Rows {
    std::uint32_t y, z, own;
    std::array<std::uint32_t, 4> next;
  };
  /// An object that moved since build(), and the next one of its list.
  struct Late {
    Spot spot;
    std::uint32_t next;
  };
  // Instead of a cell.
  static constexpr std::uint32_t kNowhere = kNoIndex, kIsLoose = kNoIndex - 1;
  static constexpr std::uint32_t kIsLate = 1U << 31;  // in a place
  static constexpr std::uint32_t kCellsPerList = 4;
  struct Sample;

  /// Calls visit(low, high) for the cells of each row, both included.
  template <class Visit>
  void for_each_row(const Reach& reach, Visit visit) const noexcept {
    for (std::uint32_t z = reach.low[2]; z <= reach.high[2]; ++z)
      for (std::uint32_t y = reach.low[1]; y <= reach.high[1]; ++y) {
        const std::uint32_t row = row_at_[z * count_[1] + y] * count_[0];
        visit(row + reach.low[0], row + reach.high[0]);
      }
  }

  template <class Visit>
  void for_each_in_cells(const Reach& reach, Visit visit) const noexcept {
    for_each_row(reach, [&](std::uint32_t low, std::uint32_t high) {
      const std::uint32_t end = cell_start_[high + 1];
      for (std::uint32_t at = cell_start_[low]; at < end; ++at)
        if (reach.takes_all ? order_[at] != kNoIndex
                            : slack(reach, x_[at], y_[at], z_[at], radius_[at]) >= 0.0F)
          visit(order_[at]);
      const auto visit_late = [&](const Spot& spot) { visit(spot.object); };
      if (!late_.empty()) for_each_late(reach, low, high, visit_late);
    });
  }

  template <class Visit>
  void for_each_loose(Visit visit) const noexcept {
    for (std::uint32_t at = in_cells_; at < in_cells_ + loose_; ++at)
      if (order_[at] != kNoIndex) visit(order_[at]);
    for (std::uint32_t i = late_loose_; i != kNoIndex; i = late_[i].next) visit(late_[i].spot.object);
  }

  /// In these cells of a row.
  template <class Visit>
  void for_each_late(const Reach& reach, std::uint32_t low, std::uint32_t high, Visit visit) const noexcept {
    for (std::uint32_t list = low / kCellsPerList; list <= high / kCellsPerList; ++list)
      for (std::uint32_t i = late_head_[list]; i != kNoIndex; i = late_[i].next) {
        const Spot& spot = late_[i].spot;
        if (spot.cell < low || spot.cell > high) continue;
        if (reach.takes_all || slack(reach, spot.x, spot.y, spot.z, spot.radius) >= 0.0F) visit(spot);
      }
  }

  /// Spheres ahead whose runs are fetched, and how many objects near one are kept.
  static constexpr std::uint32_t kAhead = 2;
  static constexpr std::size_t kMostNear = 128;

  void prefetch_cells(std::uint32_t low, std::uint32_t high) const noexcept {
    __builtin_prefetch(&cell_start_[low]), __builtin_prefetch(&cell_start_[high + 1]);
    if (!late_.empty()) __builtin_prefetch(&late_head_[low / kCellsPerList]);
  }
  void prefetch_run(std::uint32_t low, std::uint32_t high) const noexcept;
  /// Those in cells. @returns how many; more than there is room for: not all are found.
  std::size_t find_near(const Reach& reach, std::span<Near, kMostNear> found) const noexcept;
  void note_radius(float most) noexcept;

  bool choose_cells(const SolidBounds& bounds) noexcept;
  bool choose_side(const Sample& sample) noexcept;
  bool fill(const SolidBounds& bounds, TaskRunner* threads) noexcept;
  bool count_parts() noexcept;
  void sort_part(std::size_t part) noexcept;
  bool is_quick() const noexcept;
  /// Finds where a sphere is, but for the object. @returns the row of its cell; kNowhere: it is loose.
  std::uint32_t place(const Sphere& sphere, Spot& spot) const noexcept;
  void place_chunk(std::size_t chunk, const SolidBounds& bounds) noexcept;
  void scatter_chunk(std::size_t chunk) noexcept;
  Reach reach_of(const Sphere& sphere) const noexcept;
  SphereColumns columns() const noexcept { return {x_.data(), y_.data(), z_.data(), radius_.data(), doubt_}; }
  Rows rows_about(std::uint32_t row) const noexcept;
  /// Calls visit(first, end) for the positions that the object at a position is tested with.
  template <class Visit>
  void for_each_run(std::uint32_t at, const Rows& rows, Visit visit) const noexcept;
  void list_loose(const SolidBounds& bounds, PairList::Writer& writer) const noexcept;
  void list_late(const SolidBounds& bounds, PairList::Writer& writer) const noexcept;
  void find_places() noexcept;
  void leave(std::uint32_t object) noexcept;
  void enter(std::uint32_t object, const SolidBounds& bounds) noexcept;
  std::uint32_t& list_of(std::uint32_t cell) noexcept {
    return cell == kIsLoose ? late_loose_ : late_head_[cell / kCellsPerList];
  }
  std::uint32_t most_loose() const noexcept;
  void add(std::uint32_t object, std::uint32_t other, bool is_sure, const SolidBounds& bounds,
           PairList::Writer& writer) const noexcept;

  /// By how much two squares differ, as SphereTests says: negative where spheres do not touch.
  static float slack(const Reach& reach, float x, float y, float z, float radius) noexcept {
    const float dx = x - reach.x, dy = y - reach.y, dz = z - reach.z;
    const float sum = reach.radius + radius;
    return sum * sum - ((dx * dx + dy * dy) + dz * dz);
  }
  /// @param v in sides of a cell. @param per_side cells a side.
  std::uint32_t cell_at(float v, float per_side, int axis) const noexcept {
    // Of integers compilers make no branches. What is in cells or asks for them is below 2^22 of these.
    const auto cell = static_cast<std::int32_t>(v * per_side),
               last = static_cast<std::int32_t>(count_[axis] - 1);
    return static_cast<std::uint32_t>(std::min(std::max(cell, 0), last));
  }

  // The frame: of world coordinates axis_[0] runs along rows.
  std::array<int, 3> axis_{0, 1, 2};
  std::array<double, 3> origin_{};  // [m]
  double per_metre_ = 1.0;          // sides of a cell
  double half_margin_ = 0.0, tiny_ = 0.0;
  double farthest_ = 0.0, largest_ = 0.0;        // coordinate and radius of what is not loose, in sides
  float most_radius_ = 0.0F;                     // that is in a cell, grown as all are
  float doubt_ = 0.0F;                           // squares nearer to each other than this tell nothing
  std::array<std::uint32_t, 3> count_{1, 1, 1};  // of cells along a row, of rows along both others
  std::uint32_t part_shift_ = 0;                 // from a row to its part
  std::uint32_t cell_parts_ = 0, in_cells_ = 0, loose_ = 0, chunk_ = 1, objects_ = 0;
  std::uint32_t frames_to_wait_ = 0;  // before it is tried again
  bool is_plain_ = true;              // there are no static objects, and none went
  // By part, then by chunk of objects: how many there are, then where they begin.
  std::array<std::array<std::uint32_t, kMostChunks>, kMostParts + 1> start_{};
  std::array<std::uint32_t, kMostParts + 2> part_start_{};
  std::array<float, kMostChunks> chunk_radius_{};
  std::array<std::vector<double>, 4> samples_;

  // By position: first as objects come by parts, then in order.
  GrowingList<Spot> spots_;
  GrowingList<float> x_, y_, z_, radius_;          // and as many more as SphereColumns says
  GrowingList<std::uint32_t> order_;               // objects, or none where one has left
  GrowingList<std::uint32_t> cell_start_;          // positions, and the number of objects in cells
  GrowingList<std::uint32_t> row_at_, row_place_;  // rows by place, z first, and back

  // Of objects that moved since: lists begin with the last that came.
  bool has_places_ = false;
  GrowingList<std::uint32_t> place_;  // by object: a position, or one of late_; in build() its part
  GrowingList<Late> late_;
  GrowingList<std::uint32_t> late_head_;  // by a few cells
  std::uint32_t late_loose_ = kNoIndex;   // the list of those in no cell
  std::uint32_t loose_now_ = 0;           // loose ones, late or not
};

}  // namespace touchstone
