#include "touchstone/physics/contacts/surface.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace touchstone::physics {

std::string_view to_string(Combination combination) {
  constexpr std::array<std::string_view, kCombinations> kNames{"geometric_mean", "arithmetic_mean", "minimum",
                                                               "maximum", "product"};
  return kNames[static_cast<std::size_t>(combination)];
}

double combine(Combination combination, double a, double b) {
  switch (combination) {
    case Combination::geometric_mean:
      return std::sqrt(a * b);
    case Combination::arithmetic_mean:
      return 0.5 * (a + b);
    case Combination::minimum:
      return std::min(a, b);
    case Combination::maximum:
      return std::max(a, b);
    case Combination::product:
      return a * b;
  }
  return 0.0;
}

namespace {

using Key = std::pair<std::uint32_t, std::uint32_t>;

constexpr auto is_before = [](const auto& entry, const Key& key) { return Key(entry.a, entry.b) < key; };

}  // namespace

void SurfacePairs::set(std::uint32_t a, std::uint32_t b, const Figures& figures) {
  const Key key = std::minmax(a, b);
  auto at = std::lower_bound(pairs_.begin(), pairs_.end(), key, is_before);
  if (at == pairs_.end() || Key(at->a, at->b) != key) at = pairs_.insert(at, {key.first, key.second, {}});
  if (figures.friction) at->figures.friction = figures.friction;
  if (figures.restitution) at->figures.restitution = figures.restitution;
}

Surface SurfacePairs::between(std::uint32_t a, const Surface& of_a, std::uint32_t b,
                              const Surface& of_b) const {
  Surface out{combine(friction_rule, of_a.friction, of_b.friction),
              combine(restitution_rule, of_a.restitution, of_b.restitution)};
  if (pairs_.empty()) return out;
  const Key key = std::minmax(a, b);
  const auto at = std::lower_bound(pairs_.begin(), pairs_.end(), key, is_before);
  if (at == pairs_.end() || Key(at->a, at->b) != key) return out;
  out.friction = at->figures.friction.value_or(out.friction);
  out.restitution = at->figures.restitution.value_or(out.restitution);
  return out;
}

bool SurfacePairs::is_usual() const {
  return pairs_.empty() && friction_rule == Combination::geometric_mean &&
         restitution_rule == Combination::maximum;
}

}  // namespace touchstone::physics
