#include "contact_core/native/solid_memory.hpp"

#include <bit>

namespace touchstone::native {
namespace {

using Bits = std::array<std::uint64_t, 24>;

Bits bits_of(const SolidContent& content) { return std::bit_cast<Bits>(content.points); }

/// fmix64, the finaliser of MurmurHash3: every bit of the key counts in every bit of the result.
std::uint64_t fmix64(std::uint64_t key) {
  key = (key ^ (key >> 33)) * 0xff51afd7ed558ccdu;
  key = (key ^ (key >> 33)) * 0xc4ceb9fe1a85ec53u;
  return key ^ (key >> 33);
}

}  // namespace

std::size_t SolidMemory::Hash::operator()(const SolidContent& content) const noexcept {
  std::uint64_t hash = content.is_box ? 1 : 2;  // not 0, which fmix64 keeps
  const std::size_t count = content.is_box ? 3 : Bits{}.size();
  const Bits bits = bits_of(content);
  for (std::size_t i = 0; i < count; ++i) hash = fmix64(hash ^ bits[i]);
  return hash;
}

bool SolidMemory::SameBits::operator()(const SolidContent& a, const SolidContent& b) const noexcept {
  return a.is_box == b.is_box && bits_of(a) == bits_of(b);
}

SolidMemory::SolidMemory(std::shared_ptr<SolidStore> store) : store_(std::move(store)) {
  places_.reserve(kPlaces + 1);
}

SolidMemory::~SolidMemory() {
  while (!places_.empty()) forget_oldest();
}

std::optional<SolidHandle> SolidMemory::find(const SolidContent& content) {
  if (const auto known = places_.find(content); known != places_.end()) {
    order_.splice(order_.begin(), order_, known->second.in_order);
    return known->second.solid;
  }
  const std::optional<SolidHandle> solid = store_->acquire(content);
  const auto place = places_.try_emplace(content).first;
  order_.push_front(&place->first);
  place->second = {solid, order_.begin()};
  if (places_.size() > kPlaces) forget_oldest();
  return solid;
}

void SolidMemory::forget_oldest() {
  const auto oldest = places_.find(*order_.back());
  if (oldest->second.solid) store_->release(*oldest->second.solid);
  order_.pop_back();
  places_.erase(oldest);
}

}  // namespace touchstone::native
