#include "touchstone/contact_core/broadphase/native/pair_sort.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

namespace touchstone {
namespace {

constexpr std::uint32_t kDigitBits = 9, kDigitValues = 1U << kDigitBits;

/// Of fewer, counting digits costs more than comparing pairs.
constexpr std::size_t kFew = 256;

/// By one digit of one index, in stable order.
template <SolidIndex SolidPair::*index>
void scatter(std::span<const SolidPair> from, std::span<SolidPair> to, std::uint32_t shift) {
  std::array<std::uint32_t, kDigitValues> next{};
  const auto digit = [shift](const SolidPair& pair) { return pair.*index >> shift & (kDigitValues - 1); };
  for (const SolidPair& pair : from) ++next[digit(pair)];
  std::uint32_t start = 0;
  for (std::uint32_t& value : next) start += std::exchange(value, start);
  for (const SolidPair& pair : from) to[next[digit(pair)]++] = pair;
}

}  // namespace

void sort_pairs(std::span<SolidPair> pairs, std::vector<SolidPair>& scratch) noexcept {
  if (pairs.size() < kFew || pairs.size() > scratch.capacity()) {
    std::sort(pairs.begin(), pairs.end());
    return;
  }
  scratch.resize(pairs.size());
  SolidIndex bits = 0;
  for (const SolidPair& pair : pairs) bits |= pair.a | pair.b;
  const auto end = static_cast<std::uint32_t>(std::bit_width(bits));
  // Two lists take turns: an even number of times in all.
  std::span<SolidPair> from = pairs, to = scratch;
  for (std::uint32_t shift = 0; shift < end; shift += kDigitBits)
    scatter<&SolidPair::b>(from, to, shift), std::swap(from, to);
  for (std::uint32_t shift = 0; shift < end; shift += kDigitBits)
    scatter<&SolidPair::a>(from, to, shift), std::swap(from, to);
}

}  // namespace touchstone
