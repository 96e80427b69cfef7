#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace touchstone {

/// Spheres by position: centres and radii as floats, grown by more than all rounding, and more of them after
/// the last, of any value, so that registers may be loaded at any position.
struct SphereColumns {
  static constexpr std::uint32_t kPadding = 8;

  const float *x, *y, *z, *radius;
  /// Where the squares of reach and distance differ by more, spheres touch for certain.
  float doubt;
};

/// Spheres against runs of positions. Tests are gathered and done together, and so is what follows from them:
/// how many there are, and which hit, are branches that no machine predicts where each sphere is dealt with
/// by itself.
///
/// Where d2 is a squared distance and s2 that of the grown radii's sum, all as floats: pairs whose d2 is
/// above s2 do not touch, as growth is more than all rounding. Those whose d2 is below s2 by more than
/// `doubt` do.
class SphereTests {
 public:
  static constexpr std::uint32_t kLanes = 8;

  /// The sphere at position `of` against those from `first` to before `end`, kLanes of them at most.
  struct Group {
    std::uint32_t of, first, end;
  };
  /// The same with a bit for each that was met: these touch, or may touch where they are not sure.
  struct Hits {
    std::uint32_t of, first, met, sure;
  };
  /// Writes the groups with hits, in order, and returns their number. @pre room for all groups in `out`.
  using Test = std::size_t (*)(const SphereColumns&, std::span<const Group> groups, Hits* out);
  struct Kind {
    const char* isa;
    Test test;
  };

  /// What this machine has, the slowest first: at least one. All give the same answers.
  static std::span<const Kind> available() noexcept;
  /// The fastest, or the one that TOUCHSTONE_ISA in the environment names. The same in every call.
  static const Kind& chosen() noexcept;

  explicit SphereTests(const SphereColumns& spheres, const Kind& kind = chosen()) noexcept
      : spheres_(spheres), test_(kind.test) {}

  /// The sphere at a position against a run of others. Calls meet(position, other, is_sure) for what was met
  /// among those given before, if there is no more room: in the order in which they were given.
  template <class Meet>
  void add(std::uint32_t of, std::uint32_t first, std::uint32_t end, Meet& meet) noexcept {
    if (count_ + 2 > kMostGroups) finish(meet);
    // Most runs are two groups at most.
    groups_[count_] = {of, first, end};
    count_ += first < end ? 1 : 0;
    groups_[count_] = {of, first + kLanes, end};
    count_ += first + kLanes < end ? 1 : 0;
    for (first += 2 * kLanes; first < end; first += kLanes) {
      if (count_ == kMostGroups) finish(meet);
      groups_[count_++] = {of, first, end};
    }
  }

  /// The same for all that is left.
  template <class Meet>
  void finish(Meet& meet) noexcept {
    const std::size_t found = test_(spheres_, std::span(groups_).first(count_), hits_.data());
    count_ = 0;
    for (const Hits& hits : std::span(hits_).first(found))
      for (std::uint32_t left = hits.met; left != 0; left &= left - 1) {
        const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
        meet(hits.of, hits.first + lane, (hits.sure >> lane & 1) != 0);
      }
  }

 private:
  static constexpr std::size_t kMostGroups = 256;

  SphereColumns spheres_;
  Test test_;
  std::size_t count_ = 0;
  std::array<Group, kMostGroups> groups_;
  std::array<Hits, kMostGroups> hits_;
};

}  // namespace touchstone
