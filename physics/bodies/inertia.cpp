#include "touchstone/physics/bodies/inertia.hpp"

#include <cmath>
#include <string>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/motion/mass_metric.hpp"

namespace touchstone::physics {
namespace {

// The eigenvalues of a 3x3 matrix are found to a few roundings of the largest; 64 leaves room for those made
// on the way to the matrix (a rotation, a parallel-axis shift).
constexpr double kMomentTolerance = 64 * 0x1p-52;

/// m (|r|^2 1 - r r^T): a shift of a mass by r adds this to its inertia.
Matrix3 point_inertia(double mass, const Vector3& r) {
  return mass * (dot(r, r) * Matrix3::Identity() - outer(r, r));
}

MassMoments total_moments(std::span<const PlacedHexahedron> solids, std::string_view name) {
  if (solids.empty()) reject(name, "no hexahedron to compute the inertia from");
  MassMoments sum;
  for (const PlacedHexahedron& placed : solids) {
    try {
      sum += touchstone::transform(placed.X_OS, mass_moments(placed.solid));
    } catch (const InputError& error) {
      reject(name, "hexahedron '" + placed.name + "': " + error.what());
    }
  }
  return sum;
}

// Symmetric to the bit: sums of moments about other points are so to rounding alone.
BodyInertia of_moments(const MassMoments& moments, double mass) {
  const MassMetric metric = mass_metric(moments);
  BodyInertia out{mass, metric.centre, mass * metric.J};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < i; ++j) out.inertia_B(j, i) = out.inertia_B(i, j);
  return out;
}

void require_positive(double value, const char* what, std::string_view name) {
  if (!std::isfinite(value) || value <= 0.0)
    reject(name, std::string("the ") + what + " is " + figure(value) + ", not a positive number");
}

void validate_moments(const Matrix3& inertia, Thinness thinness, std::string_view name) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (!std::isfinite(inertia(i, j)) || inertia(i, j) != inertia(j, i))
        reject(name, "inertia entry (" + std::to_string(i) + ", " + std::to_string(j) + ") is " +
                         figure(inertia(i, j)) + ": the matrix must be finite and symmetric");
  const Vector3 moments = symmetric_eigenvalues(inertia);
  const double tolerance = kMomentTolerance * std::abs(moments[2]);
  if (moments[0] < -tolerance || (thinness == Thinness::solid && moments[0] <= tolerance))
    reject(name, "principal moment " + figure(moments[0]) + " kg m2 is not positive");
  if (moments[2] > (moments[0] + moments[1]) + 2.0 * tolerance)
    reject(name, "principal moments " + figure(moments[0]) + ", " + figure(moments[1]) + ", " +
                     figure(moments[2]) + " kg m2: no solid has one larger than the sum of the others");
}

}  // namespace

void validate(const BodyInertia& inertia, Thinness thinness, std::string_view name) {
  const bool is_massless = thinness == Thinness::thin && inertia.mass == 0.0;
  if (!is_massless) require_positive(inertia.mass, "mass", name);
  if (!touchstone::is_finite(inertia.centre_B)) reject(name, "the centre of mass is not finite");
  if (is_massless && inertia.inertia_B != Matrix3::Zero()) reject(name, "inertia without mass");
  validate_moments(inertia.inertia_B, thinness, name);
}

BodyInertia inertia_of_density(std::span<const PlacedHexahedron> solids, double density,
                               std::string_view name) {
  require_positive(density, "density", name);
  const MassMoments moments = total_moments(solids, name);
  return of_moments(moments, density * moments.volume);
}

BodyInertia inertia_of_mass(std::span<const PlacedHexahedron> solids, double mass, std::string_view name) {
  require_positive(mass, "mass", name);
  return of_moments(total_moments(solids, name), mass);
}

BodyInertia box_inertia(double mass, const Vector3& size) {
  BodyInertia out{mass, Vector3::Zero(), Matrix3::Zero()};
  const Vector3 squares = size.cwiseProduct(size);
  out.inertia_B(0, 0) = mass / 12.0 * (squares.y() + squares.z());
  out.inertia_B(1, 1) = mass / 12.0 * (squares.z() + squares.x());
  out.inertia_B(2, 2) = mass / 12.0 * (squares.x() + squares.y());
  return out;
}

BodyInertia inertia_of(const MassProperties& mass, std::string_view name) {
  const Vector3 r = mass.centre_L - mass.inertia_about_L;
  const BodyInertia out{mass.mass, mass.centre_L, mass.inertia_L - point_inertia(mass.mass, r)};
  validate(out, Thinness::thin, name);
  return out;
}

BodyInertia transform(const Pose& X_AB, const BodyInertia& inertia_B) {
  return {inertia_B.mass, touchstone::transform(X_AB, inertia_B.centre_B),
          turned(X_AB.R, inertia_B.inertia_B)};
}

BodyInertia combined(const BodyInertia& a, const BodyInertia& b) {
  const double mass = a.mass + b.mass;
  if (mass == 0.0) return a;
  const Vector3 centre = (a.mass * a.centre_B + b.mass * b.centre_B) / mass;
  return {mass, centre,
          (a.inertia_B + point_inertia(a.mass, a.centre_B - centre)) +
              (b.inertia_B + point_inertia(b.mass, b.centre_B - centre))};
}

void add_inertia(BodyInertia& sum, const BodyInertia& part) {
  if (part.mass == 0.0) return;
  sum = sum.mass == 0.0 ? part : combined(sum, part);
}

}  // namespace touchstone::physics
