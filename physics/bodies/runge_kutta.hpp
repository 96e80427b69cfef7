#pragma once

#include <array>
#include <cstddef>

namespace touchstone::physics {

inline constexpr std::size_t kRungeKuttaStages = 7;  ///< the most of any method here

/// An explicit Runge-Kutta method: weights of the stages before each, and of all.
struct RungeKutta {
  using Weights = std::array<double, kRungeKuttaStages>;
  std::size_t stages;
  std::array<Weights, kRungeKuttaStages> before;
  Weights all;
};

/// The midpoint rule.
inline constexpr RungeKutta kOrder2 = {2, {{{}, {1.0 / 2}}}, {0.0, 1.0}};
/// Kutta's (Hairer, Norsett, Wanner I, II.1).
inline constexpr RungeKutta kOrder3 = {3, {{{}, {1.0 / 2}, {-1.0, 2.0}}}, {1.0 / 6, 2.0 / 3, 1.0 / 6}};
/// Kutta's (the same).
inline constexpr RungeKutta kOrder4 = {
    4, {{{}, {1.0 / 2}, {0.0, 1.0 / 2}, {0.0, 0.0, 1.0}}}, {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6}};
/// Butcher's of order 6 (Hairer, Norsett, Wanner I, II.5; Butcher 1964).
inline constexpr RungeKutta kOrder6 = {
    7,
    {{
        {},
        {1.0 / 3},
        {0.0, 2.0 / 3},
        {1.0 / 12, 1.0 / 3, -1.0 / 12},
        {-1.0 / 16, 9.0 / 8, -3.0 / 16, -3.0 / 8},
        {0.0, 9.0 / 8, -3.0 / 8, -3.0 / 4, 1.0 / 2},
        {9.0 / 44, -9.0 / 11, 63.0 / 44, 18.0 / 11, 0.0, -16.0 / 11},
    }},
    {11.0 / 120, 0.0, 27.0 / 40, 27.0 / 40, -4.0 / 15, -4.0 / 15, 11.0 / 120}};

}  // namespace touchstone::physics
