#pragma once

#include <array>
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

  /// Held until kPlaces other contents have been asked for. Empty for a content that is no hexahedron.
  std::optional<SolidHandle> find(const SolidContent& content);
  /// As find() of a box of these sides.
  std::optional<SolidHandle> find_box(const Sides& sides);
  /// As find() of these vertices.
  std::optional<SolidHandle> find_hull(const Corners& corners);

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
  static std::size_t recent_place(const std::array<double, 3>& corner);
  std::optional<SolidHandle> use(Places::value_type& known);
  void forget_oldest();

  std::shared_ptr<SolidStore> store_;
  Places places_;
  /// Of each recent_place() the content asked for last, or null: most are found here, without the hash.
  std::array<Places::value_type*, kRecent> recent_{};
  std::list<const SolidContent*> order_;  ///< the places' keys, the one asked for last in front
};

}  // namespace touchstone::native
