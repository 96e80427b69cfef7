#include "contact_core/native/solid_memory.hpp"

#include <bit>

namespace touchstone::native {
namespace {

std::uint64_t hash_of(const SolidContent& content) {
  // Round numbers differ in their highest bits only: each product's are folded down before the next.
  std::uint64_t hash = content.is_box ? 1 : 0;
  const std::size_t count = content.is_box ? 1 : content.points.size();
  for (std::size_t i = 0; i < count; ++i) {
    for (const double coordinate : content.points[i]) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(coordinate)) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 32;
    }
  }
  return hash;
}

}  // namespace

SolidMemory::~SolidMemory() {
  for (const Place& place : places_)
    if (place.solid) store_->release(*place.solid);
}

std::optional<SolidHandle> SolidMemory::find(const SolidContent& content) {
  Place& place = places_[hash_of(content) % kPlaces];
  if (place.content == content) return place.solid;
  const std::optional<SolidHandle> solid = store_->acquire(content);
  if (place.solid) store_->release(*place.solid);
  place = {content, solid};
  return solid;
}

}  // namespace touchstone::native
