#include "touchstone/contact_core/native/engine/solid_memory.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>

namespace touchstone::native {
namespace {

int used_points(const SolidContent& content) { return content.is_box ? 1 : Hexahedron::kVertices; }

/// fmix64, the finaliser of MurmurHash3: every bit of the key counts in every bit of the result.
std::uint64_t fmix64(std::uint64_t key) {
  key = (key ^ (key >> 33)) * 0xff51afd7ed558ccdu;
  key = (key ^ (key >> 33)) * 0xc4ceb9fe1a85ec53u;
  return key ^ (key >> 33);
}

}  // namespace

std::size_t SolidMemory::Hash::operator()(const SolidContent& content) const {
  std::uint64_t hash = content.is_box ? 1 : 2;
  for (int i = 0; i < used_points(content); ++i) {
    for (const double coordinate : content.points[i]) {  // round numbers differ in their highest bits only
      hash = (hash ^ std::bit_cast<std::uint64_t>(coordinate)) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 32;
    }
  }
  return fmix64(hash);
}

bool SolidMemory::SameBits::operator()(const SolidContent& a, const SolidContent& b) const {
  if (a.is_box != b.is_box) return false;
  const auto same = [](const std::array<double, 3>& p, const std::array<double, 3>& q) {
    using Bits = std::array<std::uint64_t, 3>;
    return std::bit_cast<Bits>(p) == std::bit_cast<Bits>(q);
  };
  return std::equal(a.points.begin(), a.points.begin() + used_points(a), b.points.begin(), same);
}

SolidMemory::SolidMemory(std::shared_ptr<SolidStore> store) : store_(std::move(store)) {
  places_.reserve(kPlaces + 1);
}

SolidMemory::~SolidMemory() {
  while (!places_.empty()) forget_oldest();
}

/// From one corner's coordinates: no more than a guess.
std::size_t SolidMemory::recent_place(const SolidContent& content) {
  std::uint64_t hash = 0;
  for (const double coordinate : content.points[0])
    hash = (hash ^ std::bit_cast<std::uint64_t>(coordinate)) * 0x9e3779b97f4a7c15u;
  return hash >> 58;  // round numbers differ in their highest bits only
}

std::optional<SolidHandle> SolidMemory::find(const SolidContent& content) {
  Places::value_type*& recent = recent_[recent_place(content)];
  if (recent == nullptr || !SameBits{}(recent->first, content)) {
    const auto known = places_.find(content);
    recent = known == places_.end() ? nullptr : &*known;
  }
  if (recent != nullptr) {
    if (order_.front() != &recent->first) order_.splice(order_.begin(), order_, recent->second.in_order);
    return recent->second.solid;
  }
  // A content that is not remembered.
  const std::optional<SolidHandle> solid = store_->acquire(content);
  const auto place = places_.try_emplace(content).first;
  order_.push_front(&place->first);
  place->second = {solid, order_.begin()};
  recent = &*place;
  if (places_.size() > kPlaces) forget_oldest();
  return solid;
}

void SolidMemory::forget_oldest() {
  const auto oldest = places_.find(*order_.back());
  Places::value_type*& recent = recent_[recent_place(oldest->first)];
  if (recent == &*oldest) recent = nullptr;
  if (oldest->second.solid) store_->release(*oldest->second.solid);
  order_.pop_back();
  places_.erase(oldest);
}

}  // namespace touchstone::native
