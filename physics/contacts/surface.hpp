#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

/// @file
/// Friction and restitution of two surfaces, by the figures of each or by those of the pair.

namespace touchstone::physics {

/// The friction and restitution of a surface.
struct Surface {
  double friction = 0.5;     ///< Coulomb's coefficient, >= 0
  double restitution = 0.0;  ///< Newton's, 0 to 1
};

/// The rule by which the figures of two surfaces become their pair's. It is symmetric; of equal figures it
/// gives that figure, except for the product.
enum class Combination : std::uint8_t {
  geometric_mean,   ///< sqrt(a b)
  arithmetic_mean,  ///< (a + b) / 2
  minimum,          ///< the smaller
  maximum,          ///< the larger
  product,          ///< a b
};
/// How many there are.
inline constexpr std::size_t kCombinations = 5;
/// The enumerator's name.
std::string_view to_string(Combination combination);
/// @pre a, b >= 0
double combine(Combination combination, double a, double b);

/// Friction and restitution of pairs of surfaces: a rule for all, and figures of their own for some. Set-up
/// may allocate; between() does not. Const use from several threads is safe.
class SurfacePairs {
 public:
  /// The rules for all pairs without figures of their own.
  Combination friction_rule = Combination::geometric_mean, restitution_rule = Combination::maximum;

  /// A pair's own figures; those left out follow the rule.
  struct Figures {
    std::optional<double> friction, restitution;
  };
  /// Sets a pair's figures, by the numbers of its surfaces in either order; the last ones set count.
  void set(std::uint32_t a, std::uint32_t b, const Figures& figures);
  /// The figures that hold between surfaces number a and b.
  Surface between(std::uint32_t a, const Surface& of_a, std::uint32_t b, const Surface& of_b) const;
  /// Whether all pairs follow the usual rules, and none has figures of its own.
  bool is_usual() const;

 private:
  struct Entry {
    std::uint32_t a, b;  // a <= b
    Figures figures;
  };
  std::vector<Entry> pairs_;  // ascending
};

}  // namespace touchstone::physics
