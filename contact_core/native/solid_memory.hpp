#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "contact_core/native/solid_store.hpp"

namespace touchstone::native {

/// The solids of the shapes that one thread has met, by their contents: for engines whose shapes have no
/// place for a handle. Remembers about a thousand; a content that falls on another's place takes it. Contents
/// that are no hexahedron are remembered too. Allocates where a content is new.
class SolidMemory {
 public:
  explicit SolidMemory(std::shared_ptr<SolidStore> store) : store_(std::move(store)), places_(kPlaces) {}
  ~SolidMemory();
  SolidMemory(const SolidMemory&) = delete;
  SolidMemory& operator=(const SolidMemory&) = delete;

  /// Held until its place is taken. Empty for a content that is no hexahedron.
  std::optional<SolidHandle> find(const SolidContent& content);

 private:
  struct Place {
    std::optional<SolidContent> content;
    std::optional<SolidHandle> solid;
  };
  static constexpr std::size_t kPlaces = 1024;

  std::shared_ptr<SolidStore> store_;
  std::vector<Place> places_;
};

}  // namespace touchstone::native
