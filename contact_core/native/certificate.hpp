#pragma once

#include <array>
#include <cstdint>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"

namespace touchstone {

/// A proof that two posed solids meet or not, independent of how it was found: a checker needs the 16
/// world vertices (world_vertices(): the solids are their hulls) and exact arithmetic, nothing else. Vertices
/// are numbered 0 to 7 for A's, 8 to 15 for B's.
struct OverlapCertificate {
  /// The kind of proof. It uses the members that its line names; the others mean nothing.
  enum class Kind : std::uint8_t {
    /// Every n . b is greater than every n . a, taken exactly: n = axis_W.
    separating_axis,
    /// The same with n = u x v, where u = lines[0][1] - lines[0][0] and v = lines[1][1] - lines[1][0] are
    /// exact differences of vertices: for solids so close that no axis of doubles was sure to separate them.
    separating_lines,
    /// Solids that meet or touch: the Radon point of `vertices`, of which some are A's and some B's. Five
    /// points that are not in one plane have one dependency sum c_k = 0, sum c_k p_k = 0, up to scale; c_k is
    /// (-1)^k times the orientation det[p - o, q - o, r - o] of the other four o, p, q, r in their order.
    /// Here no c of A's is negative, no c of B's positive (or the other way round), and A's do not add up to
    /// zero. So the point (sum c_k p_k) / (sum c_k), over A's or over B's alike, is in both solids. Some c
    /// may be zero: of solids that touch the rest are the features that touch.
    common_point,
    /// No certificate of these kinds exists: all 16 vertices are in one plane, or {b - a} has no volume. That
    /// takes two solids thinner than the rounding of their own coordinates. Also of rounded solids.
    none,
  };
  Kind kind = Kind::none;
  Vector3 axis_W = Vector3::Zero();
  std::array<std::array<std::uint8_t, 2>, 2> lines{};
  std::array<std::uint8_t, 5> vertices{};
};

/// Certifies a pair's class; native's overlap query agrees with it. Searches all features: for an answer in
/// doubt, not for a frame loop. Does not allocate.
/// @pre valid poses.
OverlapCertificate certify_overlap(const Hexahedron& a, const Pose& X_WA, const Hexahedron& b,
                                   const Pose& X_WB);

}  // namespace touchstone
