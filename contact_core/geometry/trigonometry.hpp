#pragma once

/// @file
/// Sine, cosine and arc tangent with the same bits on every compiler, processor and C library: additions,
/// products and divisions of doubles in a stated order, no table, no FMA. (The C library's own choose a
/// variant by the processor: glibc's differ with and without FMA.) Everything that poses depend on uses
/// these.
///
/// Errors, in units in the last place of the result, as tests/numerics/trigonometry_test.cpp measures them
/// against 64 or more bits: sine and cosine below 0.8 for every finite angle, however large; arc tangent
/// below 1.5 where the result is no subnormal number.

namespace touchstone {

/// The sine and the cosine of one angle.
struct SineCosine {
  double sine;
  double cosine;
};

/// Costs little more than one of the two. Not a number for angles that are not finite.
/// @param angle [rad]
SineCosine sine_cosine(double angle) noexcept;
/// The same bits as sine_cosine(angle).sine.
double sine(double angle) noexcept;
/// The same bits as sine_cosine(angle).cosine.
double cosine(double angle) noexcept;

/// The angle of the point (x, y), in [-pi, pi] [rad]; zeros and infinities as std::atan2 has them.
double arc_tangent(double y, double x) noexcept;

}  // namespace touchstone
