#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <unordered_map>

#include "touchstone/contact_core/native/engine/solid_store.hpp"

namespace touchstone::native {

/// The solids of the shapes that one thread has met, by their contents: for engines whose shapes have no
/// place for a handle. Remembers the kPlaces contents asked for last, and forgets the one asked for longest
/// ago. Contents that are no hexahedron are remembered too. Allocates where a content is not remembered.
class SolidMemory {
 public:
  static constexpr std::size_t kPlaces = 1024;
  using Sides = std::array<double, 3>;    ///< full lengths [m]
  using Corners = std::array<float, 24>;  ///< x, y, z of each vertex [m]

  explicit SolidMemory(std::shared_ptr<SolidStore> store);
  ~SolidMemory();
  SolidMemory(const SolidMemory&) = delete;
  SolidMemory& operator=(const SolidMemory&) = delete;

  /// Held until kPlaces other contents have been asked for. Null for a content that is no hexahedron.
  const SolidHandle* find(const SolidContent& content);
  /// As find() of a box of these sides. Null for one that is no hexahedron.
  /// @param sides of three, read one by one: a copy of what an engine has just written would wait for it.
  const SolidHandle* find_box(const double* sides) {
    Places::value_type* const recent = recent_[recent_place(sides)];
    if (recent == nullptr || !recent->first.is_box || !same_bits(recent->first.points[0].data(), sides))
      return find_other_box({sides[0], sides[1], sides[2]});
    return use(*recent);
  }
  /// As find() of these vertices.
  /// @param corners of as many as Corners has, read where they are
  const SolidHandle* find_hull(const float* corners) {
    const RecentHull& recent = recent_hulls_[recent_place(corners)];
    if (recent.known == nullptr || !same_bits(recent.corners, corners)) return find_other_hull(corners);
    return use(*recent.known);
  }

 private:
  struct Hash {  ///< not noexcept: the places then keep theirs, and compare it first
    std::size_t operator()(const SolidContent& content) const;
  };
  /// As the hash sees them: coordinates that are not numbers are equal to themselves, too.
  struct SameBits {
    bool operator()(const SolidContent& a, const SolidContent& b) const;
  };
  struct Place;
  using Places = std::unordered_map<SolidContent, Place, Hash, SameBits>;
  struct Place {
    std::optional<SolidHandle> solid;
    std::list<const SolidContent*>::iterator in_order;
  };

  static constexpr std::size_t kRecent = 64;  ///< six bits of a hash
  /// From one corner's coordinates: no more than a guess. Round numbers differ in their highest bits only.
  template <class Coordinate>
  static std::size_t recent_place(const Coordinate* corner) {
    const auto bits = [&](int k) { return std::bit_cast<std::uint64_t>(static_cast<double>(corner[k])); };
    return (bits(0) * 0x9e3779b97f4a7c15u + bits(1) * 0xc2b2ae3d27d4eb4fu + bits(2) * 0xff51afd7ed558ccdu) >>
           58;
  }
  static bool same_bits(const double* p, const double* q) {
    const auto differ = [&](int k) {
      return std::bit_cast<std::uint64_t>(p[k]) ^ std::bit_cast<std::uint64_t>(q[k]);
    };
    return (differ(0) | differ(1) | differ(2)) == 0;
  }
  static bool same_bits(const Corners& p, const float* q) {
    std::uint32_t differ = 0;
    for (std::size_t i = 0; i < p.size(); ++i)
      differ |= std::bit_cast<std::uint32_t>(p[i]) ^ std::bit_cast<std::uint32_t>(q[i]);
    return differ == 0;
  }
  const SolidHandle* use(Places::value_type& known) {
    if (order_.front() != &known.first) order_.splice(order_.begin(), order_, known.second.in_order);
    return known.second.solid ? &*known.second.solid : nullptr;
  }
  const SolidHandle* find_other_box(const Sides& sides);
  const SolidHandle* find_other_hull(const float* corners);
  void forget_oldest();

  std::shared_ptr<SolidStore> store_;
  Places places_;
  /// Of each recent_place() the content asked for last, or null: most are found here, without the hash.
  std::array<Places::value_type*, kRecent> recent_{};
  /// Likewise the hull asked for last, with the floats that it came from, compared as they stand.
  struct RecentHull {
    Places::value_type* known = nullptr;
    Corners corners;
  };
  std::array<RecentHull, kRecent> recent_hulls_;
  std::list<const SolidContent*> order_;  ///< the places' keys, the one asked for last in front
};

}  // namespace touchstone::native
