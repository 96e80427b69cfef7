#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/broadphase/native/float_frame.hpp"
#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"

namespace touchstone {

/// Puts objects in Morton order of their spheres' centres, a share of the work at a time. Spheres may move in
/// between: that costs order, nothing else.
class MortonSort {
 public:
  /// Unlimited work: sorts all at once.
  static constexpr std::size_t kAll = static_cast<std::size_t>(-1);

  /// Cold. Makes room to sort this many objects without allocation.
  void reserve(std::size_t objects);
  /// Begins to sort the first `count` objects of an order.
  void begin(std::uint32_t count) noexcept;
  /// Goes on until `work`, about as many objects looked at, is used up. @returns whether all is sorted.
  bool go_on(std::span<const Sphere> spheres, std::span<std::uint32_t> order, std::size_t& work) noexcept;
  /// The frame that suits the objects, once all are sorted.
  const FloatFrame& frame() const { return frame_; }

 private:
  enum class Stage : std::uint8_t { bounds, keys, scatter, runs };
  struct Range {
    std::uint32_t first, last;
  };
  static constexpr int kDigits = 3, kDigitBits = 10;
  static constexpr std::uint32_t kDigitValues = 1U << kDigitBits;

  bool is_few() const noexcept;
  void begin_range() noexcept;
  void fetch_ahead(std::span<const Sphere> spheres, std::span<const std::uint32_t> order) const noexcept;
  void find_bounds(std::span<const Sphere> spheres, std::span<const std::uint32_t> order,
                   std::uint32_t end) noexcept;
  bool begin_keys() noexcept;
  void find_keys(std::span<const Sphere> spheres, std::span<const std::uint32_t> order,
                 std::uint32_t end) noexcept;
  void begin_scatter() noexcept;
  void scatter(std::span<std::uint32_t> order, std::uint32_t end) noexcept;
  void insert_all(std::span<const std::uint32_t> order) noexcept;
  void begin_runs() noexcept;
  void find_runs(std::span<std::uint32_t> order, std::uint32_t end) noexcept;
  void note_run(std::uint32_t end) noexcept;

  FloatFrame frame_;
  std::vector<Range> ranges_;  // that wait
  Stage stage_ = Stage::bounds;
  Range range_{};  // at hand
  std::uint32_t count_ = 0, at_ = 0, run_ = 0;
  int digit_ = 0;
  bool is_whole_ = false;  // the range at hand is all
  Vector3 low_, high_, cells_per_metre_;
  std::array<std::array<std::uint32_t, kDigitValues>, kDigits> start_{};
  GrowingList<std::uint32_t> keys_, keys_scratch_, order_scratch_;
};

}  // namespace touchstone
