#include "touchstone/examples/measures/common/random.hpp"

#include <bit>
#include <cmath>

namespace touchstone::measures {
namespace {

std::uint64_t splitmix(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15ULL);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

Random::Random(std::uint64_t seed) {
  for (std::uint64_t& word : state_) word = splitmix(seed);
}

std::uint64_t Random::next() {
  auto& s = state_;
  const std::uint64_t result = std::rotl(s[1] * 5, 7) * 9;
  const std::uint64_t t = s[1] << 17;
  s[2] ^= s[0];
  s[3] ^= s[1];
  s[1] ^= s[2];
  s[0] ^= s[3];
  s[2] ^= t;
  s[3] = std::rotl(s[3], 45);
  return result;
}

double Random::binary_scale(int low, int high) {
  const int exponent = low + static_cast<int>(below(static_cast<std::uint32_t>(high - low + 1)));
  return std::ldexp(1.0 + uniform(), exponent);
}

double Random::dyadic(double low, double high, int bits) {
  return std::ldexp(std::floor(std::ldexp(uniform(low, high), bits)), -bits);
}

std::uint64_t mix_seed(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
  std::uint64_t state = seed;
  state = splitmix(state) ^ stream;
  state = splitmix(state) ^ index;
  return splitmix(state);
}

// From z to x: the order in which the cases of older reports were drawn.
Vector3 uniform_vector(Random& random, double low, double high) {
  const double z = random.uniform(low, high), y = random.uniform(low, high), x = random.uniform(low, high);
  return {x, y, z};
}

Vector3 random_direction(Random& random) {
  for (;;) {
    const Vector3 v = uniform_vector(random, -1, 1);
    const double square = dot(v, v);
    if (square <= 1.0 && square > 0.01) return v / std::sqrt(square);
  }
}

Matrix3 random_rotation(Random& random) {
  for (;;) {
    const double w = random.uniform(-1, 1), x = random.uniform(-1, 1), y = random.uniform(-1, 1),
                 z = random.uniform(-1, 1);
    const double square = ((w * w + x * x) + y * y) + z * z;
    if (square <= 1.0 && square > 0.01) return rotation_from_quaternion(w, x, y, z);
  }
}

}  // namespace touchstone::measures
