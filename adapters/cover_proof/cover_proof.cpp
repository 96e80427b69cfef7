#include "touchstone/adapters/cover_proof/cover_proof.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "touchstone/adapters/cover_proof/exact_cover.hpp"
#include "touchstone/adapters/cover_proof/excess_proof.hpp"
#include "touchstone/adapters/cover_proof/solid_side.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using namespace cover_proof;

Vector3 middle_of(const Polygon& polygon, const Grid& grid) {
  Vector3 sum = Vector3::Zero();
  for (const Point& p : polygon) sum += grid.to_metres(p);
  return sum / static_cast<double>(polygon.size());
}

constexpr double kLargestCoordinate = 1e70;  // as in a mesh: fourth powers stay finite

void validate(const CoverClaim& claim) {
  if (claim.hexahedra.empty()) reject("cover", "no hexahedron");
  if (!(claim.excess > 0.0) || !std::isfinite(claim.excess))
    reject("cover", "the excess claimed, " + figure(claim.excess) + " m, is not positive and finite");
  for (const CoverClaim::Region& region : claim.regions) {
    const std::string name = "region '" + region.name + "'";
    if (!(region.excess >= 0.0) || !std::isfinite(region.excess))  // 0: it is within the solid, or empty
      reject(name, "the excess claimed, " + figure(region.excess) + " m, is negative or not finite");
    for (int axis = 0; axis < 3; ++axis) {
      const double low = region.low(axis), high = region.high(axis);
      if (!(std::abs(low) <= kLargestCoordinate) || !(std::abs(high) <= kLargestCoordinate))
        reject(name, "a coordinate is not finite or beyond 1e70");
      if (low > high) reject(name, "its box is none: " + figure(low) + " is above " + figure(high));
    }
  }
}

class CoverCheck {
 public:
  CoverCheck(const TriangleMesh& mesh, const CoverClaim& claim) : mesh_(mesh), claim_(claim) {
    for (const Vector3& p : mesh.vertices) {
      grid_.include(p);
      largest_ = std::max(largest_, norm_inf(p));
    }
    for (std::size_t h = 0; h < claim.hexahedra.size(); ++h) {
      for (const Vector3& p : claim.hexahedra[h]) {
        if (!(norm_inf(p) <= kLargestCoordinate) || !is_finite(p))
          reject("hexahedron " + std::to_string(h), "a coordinate is not finite or beyond 1e70");
        grid_.include(p);
        largest_ = std::max(largest_, norm_inf(p));
      }
    }
    for (std::size_t h = 0; h < claim.hexahedra.size(); ++h) {
      hulls_.push_back(make_hull(claim.hexahedra[h], grid_));
      if (hulls_.back().planes.empty()) reject("hexahedron " + std::to_string(h), "no volume");
    }
  }

  CoverVerdict run(std::size_t most_tetrahedra) {
    const SolidSide solid(mesh_, grid_);
    covers_triangles() && covers_inside(solid) && keeps_to_claim(solid, most_tetrahedra);
    verdict_.is_proven = verdict_.reason.empty();
    return verdict_;
  }

 private:
  std::vector<const Hull*> hulls_meeting(const Vector3& low, const Vector3& high) const {
    std::vector<const Hull*> result;
    for (const Hull& hull : hulls_)
      if ((hull.high - low).minCoeff() >= 0.0 && (high - hull.low).minCoeff() >= 0.0) result.push_back(&hull);
    return result;
  }

  // Whether a plane of the hull has none of a polygon's inside below it, and not all of it in it: then the
  // hull holds nothing of it that has an area.
  bool is_beside(const Hull& hull, std::span<const Vector3> corners) const {
    return std::any_of(hull.planes.begin(), hull.planes.end(), [&](const FacetPlane& plane) {
      bool is_above = false;
      for (const Vector3& p : corners) {
        const int at = side(plane, p, grid_);
        if (at < 0) return false;
        is_above = is_above || at > 0;
      }
      return is_above;
    });
  }

  bool is_in_one(const std::array<Vector3, 3>& corners, const std::vector<const Hull*>& hulls) const {
    return std::any_of(hulls.begin(), hulls.end(), [&](const Hull* hull) {
      return std::all_of(corners.begin(), corners.end(), [&](const Vector3& p) {
        return std::all_of(hull->planes.begin(), hull->planes.end(),
                           [&](const FacetPlane& plane) { return side(plane, p, grid_) <= 0; });
      });
    });
  }

  bool covers_triangles() {
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const auto& i = mesh_.triangles[t];
      const std::array<Vector3, 3> corners = {mesh_.vertices[i[0]], mesh_.vertices[i[1]],
                                              mesh_.vertices[i[2]]};
      // Hexahedra away from the triangle cannot cover it.
      const Vector3 low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
      const Vector3 high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
      std::vector<const Hull*> hulls = hulls_meeting(low, high);
      // Most triangles lie in one hexahedron, where no cut is needed.
      if (is_in_one(corners, hulls)) {
        ++verdict_.in_one_hexahedron;
        continue;
      }
      // The others are cut by the hexahedra that they meet, until nothing is left.
      ++verdict_.cut;
      std::vector<Polygon> left;
      Polygon polygon;
      for (const Vector3& p : corners) polygon.push_back(grid_.on_grid(p));
      // A triangle without area is a segment: its edges must be covered.
      if (has_no_area(polygon)) {
        if (is_segment_covered(corners, hulls)) continue;
        verdict_.reason = "triangle " + std::to_string(t) + ", which has no area, is not covered";
        return false;
      }
      std::erase_if(hulls, [&](const Hull* hull) { return is_beside(*hull, corners); });
      if (subtract(polygon, hulls, 1, left)) continue;
      verdict_.reason = "triangle " + std::to_string(t) + " is not covered at " +
                        text_of(middle_of(left.front(), grid_)) + " m";
      return false;
    }
    return true;
  }

  static bool has_no_area(const Polygon& p) {
    const mpz_class ux = p[1].x - p[0].x, uy = p[1].y - p[0].y, uz = p[1].z - p[0].z;
    const mpz_class vx = p[2].x - p[0].x, vy = p[2].y - p[0].y, vz = p[2].z - p[0].z;
    return uy * vz == uz * vy && uz * vx == ux * vz && ux * vy == uy * vx;
  }

  // Its three sides, each as the stretches of it that hulls hold.
  bool is_segment_covered(const std::array<Vector3, 3>& corners,
                          const std::vector<const Hull*>& hulls) const {
    for (int i = 0; i < 3; ++i) {
      // Each hexahedron covers one stretch of an edge.
      const Point a = grid_.on_grid(corners[i]), b = grid_.on_grid(corners[(i + 1) % 3]);
      std::vector<std::pair<mpq_class, mpq_class>> stretches;
      for (const Hull* hull : hulls) {
        mpq_class begin = 0, end = 1;
        for (const FacetPlane& plane : hull->planes) {
          const mpz_class ha = plane.x * a.x + plane.y * a.y + plane.z * a.z + plane.d;
          const mpz_class hb = plane.x * b.x + plane.y * b.y + plane.z * b.z + plane.d;
          // A plane with both ends outside leaves no stretch.
          if (ha > 0 && hb > 0) end = -1;
          if (sgn(ha) * sgn(hb) >= 0) {
            if (ha > 0) begin = 1;  // hb is 0
            if (hb > 0) end = std::min<mpq_class>(end, 0);
            continue;
          }
          // The edge crosses the plane at an exact fraction of its length.
          mpq_class at(ha, mpz_class(ha - hb));
          at.canonicalize();
          if (ha > 0)
            begin = std::max(begin, at);
          else
            end = std::min(end, at);
        }
        if (begin <= end) stretches.emplace_back(begin, end);
      }
      // The sorted stretches must join from end to end without a gap.
      std::sort(stretches.begin(), stretches.end());
      mpq_class reached = 0;
      bool is_begun = false;
      for (const auto& [begin, end] : stretches) {
        if (begin > reached) break;
        is_begun = true;
        reached = std::max(reached, end);
      }
      if (!is_begun || reached < 1) return false;
    }
    return true;
  }

  // Those that may take a part of this facet: of two hulls whose facets lie in one plane and face the same
  // way the first keeps it.
  std::vector<const Hull*> others_at(std::size_t h, const FacetPlane& facet) const {
    // They can only be hulls that meet the facet's box.
    Vector3 low = Vector3::Constant(1e300), high = -low;
    std::vector<Vector3> corners;
    for (const int i : facet.corners) {
      corners.push_back(claim_.hexahedra[h][i]);
      low = low.cwiseMin(corners.back());
      high = high.cwiseMax(corners.back());
    }
    std::vector<const Hull*> result;
    for (const Hull* other : hulls_meeting(low, high)) {
      if (other == &hulls_[h] || is_beside(*other, corners)) continue;
      const bool shares =
          other > &hulls_[h] &&
          std::any_of(other->planes.begin(), other->planes.end(), [&](const FacetPlane& plane) {
            return plane.x == facet.x && plane.y == facet.y && plane.z == facet.z && plane.d == facet.d;
          });
      if (!shares) result.push_back(other);
    }
    return result;
  }

  bool covers_inside(const SolidSide& solid) {
    if (!solid.has_closed_shells()) return true;
    for (std::size_t h = 0; h < hulls_.size(); ++h) {
      for (const FacetPlane& facet : hulls_[h].planes) {
        Polygon polygon;
        for (const int i : facet.corners) polygon.push_back(hulls_[h].points[i]);
        // Pieces that no other hexahedron covers are part of the outer surface.
        std::vector<Polygon> left;
        subtract(polygon, others_at(h, facet), static_cast<std::size_t>(-1), left);
        verdict_.outer_pieces += left.size();
        // No inside of a closed shell may lie beyond the outer surface.
        for (const Polygon& piece : left) {
          for (const Polygon& part : solid.uncrossed(piece, facet)) {
            if (is_outside_beyond(part, facet, solid)) continue;
            verdict_.reason = "the inside is not covered beyond hexahedron " + std::to_string(h) + " at " +
                              text_of(middle_of(part, grid_)) + " m";
            return false;
          }
        }
      }
    }
    return true;
  }

  // By one point within a piece that is not crossed, a mean of its corners; another where its ray meets an
  // edge.
  bool is_outside_beyond(const Polygon& piece, const FacetPlane& facet, const SolidSide& solid) const {
    Eigen::Index axis = 0;
    facet.normal.cwiseAbs().maxCoeff(&axis);
    for (unsigned long attempt = 1; attempt < 30; ++attempt) {
      Point mean{0, 0, 0, 1};
      mpz_class total = 0;
      for (std::size_t i = 0; i < piece.size(); ++i) {
        const mpz_class weight = 1 + (i * attempt * 7 + attempt * attempt) % 13;
        mean = {mean.x * piece[i].w + weight * piece[i].x * mean.w,
                mean.y * piece[i].w + weight * piece[i].y * mean.w,
                mean.z * piece[i].w + weight * piece[i].z * mean.w, mean.w * piece[i].w};
        total += weight;
      }
      mean.w *= total;
      const std::optional<int> winding =
          solid.winding_beyond(mean, static_cast<int>(axis), facet.normal(axis) > 0.0);
      if (winding) return *winding == 0;
    }
    return false;
  }

  bool keeps_to_claim(const SolidSide& solid, std::size_t most_tetrahedra) {
    std::vector<std::uint32_t> all(mesh_.triangles.size());
    std::iota(all.begin(), all.end(), 0U);
    const TriangleBoxes surface(mesh_, std::move(all));
    ExcessProof proof(surface, solid, 0x1p-45 * largest_, most_tetrahedra);
    const auto fails = [&](std::size_t h, double limit, const CoverClaim::Region* region) {
      const std::string why = proof.prove(hulls_[h], claim_.hexahedra[h], limit, region);
      verdict_.tetrahedra = proof.pieces();
      if (why.empty()) return false;
      verdict_.reason = "hexahedron " + std::to_string(h) + " " + why;
      if (region != nullptr) verdict_.reason += ", in region '" + region->name + "'";
      return true;
    };
    for (std::size_t h = 0; h < hulls_.size(); ++h) {
      if (fails(h, claim_.excess, nullptr)) return false;
      for (const CoverClaim::Region& region : claim_.regions)
        if (fails(h, region.excess, &region)) return false;
    }
    return true;
  }

  const TriangleMesh& mesh_;
  const CoverClaim& claim_;
  Grid grid_;
  double largest_ = 0.0;
  std::vector<Hull> hulls_;
  CoverVerdict verdict_;
};

}  // namespace

CoverVerdict check_cover(const TriangleMesh& mesh, const CoverClaim& claim, std::size_t most_tetrahedra) {
  validate(mesh);
  validate(claim);
  return CoverCheck(mesh, claim).run(most_tetrahedra);
}

}  // namespace touchstone
