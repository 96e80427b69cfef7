#pragma once

// Private: vectors over doubles or over integers of any length, with the same formulas for both.

namespace touchstone::numerics {

template <class Scalar>
struct Vector {
  Scalar x, y, z;

  friend bool operator==(const Vector&, const Vector&) = default;
};

template <class S>
Vector<S> operator-(const Vector<S>& u, const Vector<S>& v) {
  return {u.x - v.x, u.y - v.y, u.z - v.z};
}

template <class S>
Vector<S> operator+(const Vector<S>& u, const Vector<S>& v) {
  return {u.x + v.x, u.y + v.y, u.z + v.z};
}

template <class S>
Vector<S> operator-(const Vector<S>& u) {
  return {-u.x, -u.y, -u.z};
}

template <class S>
Vector<S> scaled(const Vector<S>& u, const S& s) {
  return {u.x * s, u.y * s, u.z * s};
}

template <class S>
S dot(const Vector<S>& u, const Vector<S>& v) {
  return u.x * v.x + u.y * v.y + u.z * v.z;
}

template <class S>
Vector<S> cross(const Vector<S>& u, const Vector<S>& v) {
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

template <class S>
bool is_zero(const Vector<S>& u) {
  return u.x == 0 && u.y == 0 && u.z == 0;
}

}  // namespace touchstone::numerics
