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
  return std::equal(a.points.begin(), a.points.begin() + used_points(a), b.points.begin(),
                    [](const auto& p, const auto& q) { return same_bits(p.data(), q.data()); });
}

SolidMemory::SolidMemory(std::shared_ptr<SolidStore> store) : store_(std::move(store)) {
  places_.reserve(kPlaces + 1);
}

SolidMemory::~SolidMemory() {
  while (!places_.empty()) forget_oldest();
}

const SolidHandle* SolidMemory::find_other_box(const Sides& sides) {
  SolidContent content;
  content.is_box = true;
  content.points[0] = sides;
  return find(content);
}

const SolidHandle* SolidMemory::find_other_hull(const float* corners) {
  SolidContent content;
  for (std::size_t i = 0; i < Hexahedron::kVertices; ++i)
    for (std::size_t k = 0; k < 3; ++k) content.points[i][k] = static_cast<double>(corners[3 * i + k]);
  const SolidHandle* const solid = find(content);
  const std::size_t place = recent_place(corners);
  RecentHull& recent = recent_hulls_[place];
  recent.known = recent_[place];  // where find() has just put it
  std::copy_n(corners, recent.corners.size(), recent.corners.data());
  return solid;
}

const SolidHandle* SolidMemory::find(const SolidContent& content) {
  Places::value_type*& recent = recent_[recent_place(content.points[0].data())];
  if (recent == nullptr || !SameBits{}(recent->first, content)) {
    const auto known = places_.find(content);
    recent = known == places_.end() ? nullptr : &*known;
  }
  if (recent != nullptr) return use(*recent);
  // A content that is not remembered.
  const std::optional<SolidHandle> solid = store_->acquire(content);
  const auto place = places_.try_emplace(content).first;
  order_.push_front(&place->first);
  place->second = {solid, order_.begin()};
  recent = &*place;
  if (places_.size() > kPlaces) forget_oldest();
  return use(*place);
}

void SolidMemory::forget_oldest() {
  const auto oldest = places_.find(*order_.back());
  Places::value_type*& recent = recent_[recent_place(oldest->first.points[0].data())];
  if (recent == &*oldest) recent = nullptr;
  RecentHull& hull = recent_hulls_[recent_place(oldest->first.points[0].data())];
  if (hull.known == &*oldest) hull.known = nullptr;
  if (oldest->second.solid) store_->release(*oldest->second.solid);
  order_.pop_back();
  places_.erase(oldest);
}

}  // namespace touchstone::native
