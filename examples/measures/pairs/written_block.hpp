#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"

// Blocks as files give them: turned and shifted in their own frame, their corners rounded as they were
// written, so that their faces are bent.

namespace touchstone {

/// How a file writes a coordinate.
enum class Written {
  exactly,
  with_nine_decimals,
  with_six_decimals,
  with_four_decimals,
  with_three_decimals,
  as_float
};
inline constexpr std::array kAllWritten = {Written::exactly, Written::with_nine_decimals,
                                           Written::with_six_decimals, Written::with_four_decimals,
                                           Written::as_float};

inline const char* to_string(Written how) {
  constexpr const char* kNames[] = {"exact", "9 decimals", "6 decimals", "4 decimals", "3 decimals", "float"};
  return kNames[static_cast<int>(how)];
}

inline double as_written(double x, Written how) {
  if (how == Written::exactly) return x;
  if (how == Written::as_float) return static_cast<float>(x);
  char text[64];
  constexpr int kDecimals[] = {0, 9, 6, 4, 3};
  std::snprintf(text, sizeof text, "%.*f", kDecimals[static_cast<int>(how)], x);
  return std::strtod(text, nullptr);
}

inline Vector3 as_written(const Vector3& p, Written how) {
  return {as_written(p.x(), how), as_written(p.y(), how), as_written(p.z(), how)};
}

/// Corners before any rounding, about the middle of the base, whose face -z and +z are level: at z = 0 and
/// above.
using BlockCorners = std::array<Vector3, 8>;

inline BlockCorners box_corners(const Vector3& size) {
  BlockCorners out;
  for (int i = 0; i < 8; ++i)
    out[i] = {(i & 4 ? 0.5 : -0.5) * size.x(), (i & 2 ? 0.5 : -0.5) * size.y(), i & 1 ? size.z() : 0.0};
  return out;
}

/// A solid in a file's frame S, X_SF within it, its written corners, and where it stands in the world: as the
/// block in F does at X_WF but for the rounding of its corners.
struct WrittenBlock {
  std::vector<Vector3> corners_S;
  Pose X_WS;

  Hexahedron solid() const { return Hexahedron::from_vertices(corners_S, WarpPolicy::accept); }
};

inline WrittenBlock written_block(const BlockCorners& corners_F, const Pose& X_SF, const Pose& X_WF,
                                  Written how) {
  WrittenBlock out;
  for (const Vector3& p : corners_F) out.corners_S.push_back(as_written(X_SF.p + rotate(X_SF.R, p), how));
  out.X_WS = compose(X_WF, inverse(X_SF));
  return out;
}

}  // namespace touchstone
