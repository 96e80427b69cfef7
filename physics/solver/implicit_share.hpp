#pragma once

// How much of a linear force's end counts over a step.

namespace touchstone::physics {

/// e^-z in one order of operations, to some roundings. @pre z >= 0
inline double decay(double z) {
  if (!(z < 700.0)) return 0.0;
  int halvings = 0;
  for (; z > 0.5; z *= 0.5) ++halvings;
  double sum = 1.0;
  for (int k = 16; k > 0; --k) sum = 1.0 - sum * z / k;
  for (; halvings > 0; --halvings) sum *= sum;
  return sum;
}

/// theta of the scheme x' = -(z / h) ((1 - theta) x0 + theta x1) that decays by e^-z over a step, as the
/// motion does: 1/2 (the trapezoidal rule) for slow decay, 1 (the implicit Euler method) for fast.
/// Exponential fitting: Liniger, Willoughby, Efficient Integration Methods for Stiff Systems of Ordinary
/// Differential Equations, 1970, section 3. @pre z >= 0
inline double implicit_share(double z) {
  if (z < 0.01) return 0.5 + z * (1.0 / 12 - z * z * (1.0 / 720));  // what is cut off is below 4e-15
  return 1.0 / (1.0 - decay(z)) - 1.0 / z;
}

}  // namespace touchstone::physics
