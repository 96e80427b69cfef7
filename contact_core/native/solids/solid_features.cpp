#include "touchstone/contact_core/native/solids/solid_features.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/difference_determinant.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"
#include "touchstone/contact_core/narrowphase/rounded_manifold.hpp"
#include "touchstone/contact_core/native/common/double_double.hpp"
#include "touchstone/contact_core/native/common/hull_pair.hpp"

// Which facets count as one, for the candidate axes. Depth is the least overlap over the facet normals of B -
// A, which are facet normals of A, of B, and across an edge of each. Leaving out a facet whose normal is
// within an angle t of a kept one, and the edges between such facets, leaves out only axes within t of the
// kept normal: an edge's axes lie on the arc between its facets' normals, and a cap is convex. The overlap
// along a unit axis is a support function of B - A, whose points are no further from the origin than both
// sizes, so it changes by no more than t * (size of A + size of B). Here t = 16 u: 32 u S. How far a vertex
// is off a plane says nothing of that where the face is narrow: of a sheet as thick as the rounding of its
// corners, the side faces' diagonals are edges like others, and depth may be across one of them.

namespace touchstone::native {
namespace {

// The kernels number and turn faces as hexahedra do.
static_assert([] {
  for (int f = 0; f < 6; ++f)
    for (int k = 0; k < 4; ++k)
      if (kQuads[f][k] != Hexahedron::kFaceVertices[f][k]) return false;
  return true;
}());

constexpr double kEps = 2.0 * kUnitRoundoff;
constexpr double kFlat = 4 * kEps;  // per metre of size: a vertex this far off a face's plane belongs to it
constexpr double kFlatPerThickness = 1e-3;     // keeps top and bottom of a slab thinner than that apart
constexpr double kParallel = 2 * kEps;         // sine between unit directions that count as one
constexpr double kSameFacet = 16 * kRoundoff;  // angle between the normals of facets that count as one

using Vertices = std::array<Vector3, 8>;

struct Facet {
  unsigned mask = 0;  // bit i: vertex i lies on it
  Vector3 normal = Vector3::Zero();
  double area = 0.0;
  int leader = 0;  // the first facet that this counts as one with; itself
};

struct Edge {
  int from, to;
  int facet, other;  // along the loop of `facet`
};

/// The side of the plane through three vertices on which a fourth one lies. Found once for every four, as
/// each four are asked for in several orders and those in one plane, as most faces' are, take integers.
class Sides {
 public:
  Sides(const Vertices& v, unsigned distinct) {
    numerics::DifferenceDeterminant determinants(v);
    for (int i = 0; i < 8; ++i)
      for (int j = i + 1; j < 8; ++j)
        for (int k = j + 1; k < 8; ++k)
          for (int l = k + 1; l < 8; ++l)
            if (const unsigned four = bits(i, j, k, l); (four & ~distinct) == 0)
              signs_[four] = determinants.sign({i, j}, {i, k}, {i, l});
  }

  /// As orient3d_sign() of these vertices. @pre distinct ones.
  int of(int i, int j, int k, int l) const {
    const int swaps = (i > j) + (i > k) + (i > l) + (j > k) + (j > l) + (k > l);
    const int sign = signs_[bits(i, j, k, l)];
    return swaps % 2 == 0 ? sign : -sign;
  }

 private:
  static unsigned bits(int i, int j, int k, int l) { return 1u << i | 1u << j | 1u << k | 1u << l; }

  std::array<int, 256> signs_{};  // of ascending indices, by their bits; 0 where two are the same
};

/// The exact hull of a solid's vertices.
struct Hull {
  Vertices v;  // each axis scaled by a power of two of its own to at most 2: no sign of a determinant changes
  std::array<int, 3> exponent;  // of those
  unsigned distinct;            // a bit a vertex; repeated ones (collapsed edges) stand for the first of them
  std::vector<Facet> facets;    // the largest first
  std::vector<Edge> edges;      // between facets of different leaders
};

Vector3 scaled_by(const Vector3& v, int x, int y, int z) {
  return {std::scalbn(v.x(), x), std::scalbn(v.y(), y), std::scalbn(v.z(), z)};
}

Vertices scaled_to_unit(const Vertices& vertices) {
  double largest = 0.0;
  for (const Vector3& v : vertices) largest = std::max(largest, norm_inf(v));
  const int exponent = -std::ilogb(largest);
  Vertices out;
  for (int i = 0; i < 8; ++i) out[i] = scaled_by(vertices[i], exponent, exponent, exponent);
  return out;
}

unsigned distinct_vertices(const Vertices& v) {
  unsigned mask = 0;
  for (int i = 0; i < 8; ++i) {
    bool repeated = false;
    for (int j = 0; j < i; ++j) repeated = repeated || v[i] == v[j];
    if (!repeated) mask |= 1u << i;
  }
  return mask;
}

Hull scaled_by_axis(const Hexahedron& solid) {
  Hull out;
  for (int axis = 0; axis < 3; ++axis) {
    double largest = 0.0;
    for (const Vector3& v : solid.vertices()) largest = std::max(largest, std::abs(v(axis)));
    out.exponent[axis] = -std::ilogb(largest);
    for (int i = 0; i < 8; ++i) out.v[i](axis) = std::scalbn(solid.vertices()[i](axis), out.exponent[axis]);
  }
  out.distinct = distinct_vertices(out.v);
  return out;
}

/// Edge's direction in the solid's frame, right to u.
Vector3 direction_of(const Hull& hull, int from, int to) {
  const auto& [x, y, z] = hull.exponent;
  const int least = std::min({x, y, z});
  return safe_unit(scaled_by(hull.v[to] - hull.v[from], least - x, least - y, least - z));
}

/// Sets normal (in the solid's frame) and area. The products are exact, else the normal of a facet with a
/// narrow corner would be off by u over that corner's sine.
void set_normal_and_area(const Hull& hull, int i, int j, int k, bool turned, Facet& facet) {
  const Vector3 across = cross(difference(hull.v[j], hull.v[i]), difference(hull.v[k], hull.v[i])).rounded();
  const auto& [x, y, z] = hull.exponent;
  const int greatest = std::max({x, y, z}), least = std::min({x, y, z}), sum = (x + y) + z;
  const Vector3 normal = safe_unit(scaled_by(across, x - greatest, y - greatest, z - greatest));
  facet.normal = turned ? Vector3(-normal) : normal;
  const int common = 2 * least - sum;
  facet.area = norm(scaled_by(across, common + x, common + y, common + z));
}

// The facet through i, j, k if that plane supports the hull.
bool supporting_facet(const Hull& hull, const Sides& sides, int i, int j, int k, Facet& facet) {
  bool above = false;
  bool below = false;
  facet.mask = 0;
  for (int l = 0; l < 8; ++l) {
    if (!(hull.distinct >> l & 1u)) continue;
    const int side = sides.of(i, j, k, l);
    above = above || side > 0;
    below = below || side < 0;
    if (side == 0) facet.mask |= 1u << l;
  }
  if (above == below) return false;  // both: no support; neither: collinear, as the solid has volume
  set_normal_and_area(hull, i, j, k, above, facet);
  return true;
}

void find_facets(const Sides& sides, Hull& hull) {
  std::vector<Facet>& facets = hull.facets;
  for (int i = 0; i < 8; ++i)
    for (int j = i + 1; j < 8; ++j)
      for (int k = j + 1; k < 8; ++k) {
        if (!(hull.distinct >> i & hull.distinct >> j & hull.distinct >> k & 1u)) continue;
        Facet facet;
        if (!supporting_facet(hull, sides, i, j, k, facet)) continue;
        const auto known =
            std::find_if(facets.begin(), facets.end(), [&](const Facet& f) { return f.mask == facet.mask; });
        if (known == facets.end())
          facets.push_back(facet);
        else if (facet.area > known->area)
          *known = facet;  // the widest triangle gives the best normal
      }
  std::stable_sort(facets.begin(), facets.end(),
                   [](const Facet& f, const Facet& g) { return f.area > g.area; });
}

void find_box_facets(Hull& hull) {
  for (int f = 0; f < 6; ++f) {
    Facet& facet = hull.facets.emplace_back();
    for (const std::uint8_t i : Hexahedron::kFaceVertices[f]) facet.mask |= 1u << i;
    facet.normal = (f % 2 ? 1.0 : -1.0) * Vector3::Unit(f / 2);
    facet.leader = f;
  }
}

bool count_as_one(const Facet& f, const Facet& g) {
  const Vector3 sine = accurate_cross(f.normal, g.normal);
  return dot(f.normal, g.normal) > 0.0 && dot(sine, sine) <= kSameFacet * kSameFacet;
}

void find_leaders(Hull& hull) {
  for (int f = 0; f < static_cast<int>(hull.facets.size()); ++f) {
    int leader = 0;
    while (leader < f &&
           !(hull.facets[leader].leader == leader && count_as_one(hull.facets[leader], hull.facets[f])))
      ++leader;
    hull.facets[f].leader = leader;
  }
}

/// The two vertices of a set on one line that are furthest apart.
Edge ends_of(const Hull& hull, unsigned shared) {
  Edge out{};
  double longest = -1.0;
  for (int i = 0; i < 8; ++i) {
    for (int j = i + 1; j < 8; ++j) {
      if (!(shared >> i & shared >> j & 1u)) continue;
      const Vector3 edge = hull.v[j] - hull.v[i];
      if (const double length = dot(edge, edge); length > longest) longest = length, out.from = i, out.to = j;
    }
  }
  return out;
}

/// Whether the facet's loop, counter-clockwise from outside, goes from `to` to `from`.
bool runs_backwards(const Hull& hull, const Sides& sides, const Facet& facet, const Edge& edge) {
  const int inner = std::countr_zero(hull.distinct & ~facet.mask);
  for (int i = 0; i < 8; ++i) {
    if (!(facet.mask >> i & 1u)) continue;
    if (const int side = sides.of(edge.from, edge.to, i, inner)) return side > 0;
  }
  return false;
}

void find_edges(const Sides& sides, Hull& hull) {
  const int count = static_cast<int>(hull.facets.size());
  for (int f = 0; f < count; ++f) {
    for (int g = f + 1; g < count; ++g) {
      const unsigned shared = hull.facets[f].mask & hull.facets[g].mask;
      if (hull.facets[f].leader == hull.facets[g].leader || std::popcount(shared) < 2) continue;
      Edge edge = ends_of(hull, shared);
      if (runs_backwards(hull, sides, hull.facets[f], edge)) std::swap(edge.from, edge.to);
      edge.facet = f, edge.other = g;
      hull.edges.push_back(edge);
    }
  }
}

Hull exact_hull(const Hexahedron& solid) {
  Hull out = scaled_by_axis(solid);
  const Sides sides(out.v, out.distinct);
  if (solid.is_box()) {
    find_box_facets(out);
  } else {
    find_facets(sides, out);
    find_leaders(out);
  }
  find_edges(sides, out);
  return out;
}

void take_in_flat_neighbours(const Vertices& v, unsigned distinct, double size, Facet& facet) {
  const Vector3 origin = v[std::countr_zero(facet.mask)];
  double thickness = 0.0;
  for (int i = 0; i < 8; ++i) thickness = std::max(thickness, std::abs(dot(facet.normal, v[i] - origin)));
  const double tolerance = std::min(kFlat * size, kFlatPerThickness * thickness);
  for (int i = 0; i < 8; ++i)
    if (distinct >> i & 1u && std::abs(dot(facet.normal, v[i] - origin)) <= tolerance) facet.mask |= 1u << i;
}

// Convex, counter-clockwise about the normal: next comes the vertex that leaves all others to the left.
HullFace ordered_face(const Vertices& v, const Facet& facet) {
  HullFace face;
  face.normal = facet.normal;
  // A face of the hexahedron keeps its order.
  for (const auto& quad : Hexahedron::kFaceVertices) {
    unsigned mask = 0;
    for (std::uint8_t i : quad) mask |= 1u << i;
    if (mask != facet.mask) continue;
    face.count = 4;
    std::copy(quad.begin(), quad.end(), face.vertices.begin());
    return face;
  }
  // Any other is wrapped round.
  const int first = std::countr_zero(facet.mask);
  int current = first;
  do {
    face.vertices[face.count++] = static_cast<std::uint8_t>(current);
    int next = -1;
    for (int i = 0; i < 8; ++i) {
      if (i == current || !(facet.mask >> i & 1u)) continue;
      if (next < 0) {
        next = i;
        continue;
      }
      const Vector3 to_next = v[next] - v[current];
      const Vector3 to_i = v[i] - v[current];
      const double turn = dot(facet.normal, cross(to_next, to_i));
      if (turn < 0.0 || (turn == 0.0 && dot(to_i, to_i) > dot(to_next, to_next))) next = i;
    }
    current = next;
  } while (current != first && face.count < 8);
  return face;
}

template <std::size_t N>
void add_direction(const Vector3& direction, std::array<Vector3, N>& directions, int& count) {
  if (count == static_cast<int>(N) || direction == Vector3::Zero()) return;
  for (int i = 0; i < count; ++i) {
    const Vector3 off = cross(directions[i], direction);
    if (dot(off, off) <= kParallel * kParallel) return;
  }
  directions[count++] = direction;
}

/// The faces, where they are the six that the solid's vertices have in its own order.
QuadFaces quad_faces(const SolidFeatures& features) {
  QuadFaces out{};
  if (features.face_count != 6) return out;
  unsigned found = 0;
  for (int f = 0; f < 6; ++f) {
    // The face's number.
    const HullFace& face = features.faces[f];
    const auto& quads = Hexahedron::kFaceVertices;
    const auto* const quad = std::find_if(quads.begin(), quads.end(), [&face](const auto& loop) {
      return face.count == 4 && std::equal(loop.begin(), loop.end(), face.vertices.begin());
    });
    if (quad == quads.end()) return out;
    const auto number = static_cast<std::size_t>(quad - quads.begin());
    found |= 1u << number;
    // Its planes.
    const bool is_plane = face.bend == HullFace::kPlane;
    const Bend bend = is_plane ? Bend{0, {face.normal, face.normal}} : features.bends[face.bend];
    out.anchor[number] = face.vertices[bend.ridge];
    if (!is_plane) out.bent = static_cast<std::uint8_t>(out.bent | 1u << number);
    for (int k = 0; k < 3; ++k) {
      out.normals[k][number] = face.normal(k);
      for (int i = 0; i < 2; ++i) out.planes[number].normals[i][k] = bend.normals[i](k);
    }
  }
  out.are_quads = found == 0x3fu;
  return out;
}

SolidFeatures box_features() {
  SolidFeatures out;
  out.face_count = 6;
  for (int f = 0; f < 6; ++f) {
    HullFace& face = out.faces[f];
    face.count = 4;
    std::copy(Hexahedron::kFaceVertices[f].begin(), Hexahedron::kFaceVertices[f].end(),
              face.vertices.begin());
    face.normal = (f % 2 ? 1.0 : -1.0) * Vector3::Unit(f / 2);
  }
  out.normal_count = out.edge_count = 3;
  for (int i = 0; i < 3; ++i) out.normals[i] = out.edges[i] = Vector3::Unit(i);
  out.quads = quad_faces(out);
  return out;
}

/// A bit each for the four corners of one of the user's faces, repeated vertices by the first of them; fewer
/// bits where corners coincide.
std::array<unsigned, 4> corner_bits(const Hull& hull, const std::array<std::uint8_t, 4>& loop) {
  std::array<unsigned, 4> out;
  for (int k = 0; k < 4; ++k) {
    int first = 0;
    while (hull.v[first] != hull.v[loop[k]]) ++first;
    out[k] = 1u << first;
  }
  return out;
}

const Facet* facet_of(const Hull& hull, unsigned mask) {
  const auto found =
      std::find_if(hull.facets.begin(), hull.facets.end(), [mask](const Facet& f) { return f.mask == mask; });
  return found == hull.facets.end() ? nullptr : &*found;
}

/// Makes a bent face of two triangles of the hull where they are one of the user's faces and lean little
/// enough. Returns the bits of its vertices, 0 where there is none.
unsigned make_bent_face(const Hull& hull, const Facet& facet, HullFace& face, Bend& bend) {
  for (const auto& loop : Hexahedron::kFaceVertices) {
    const std::array<unsigned, 4> bit = corner_bits(hull, loop);
    const unsigned quad = bit[0] | bit[1] | bit[2] | bit[3];
    const unsigned missing = quad & ~facet.mask;
    if ((facet.mask & ~quad) != 0 || std::popcount(quad) != 4 || std::popcount(missing) != 1) continue;
    const auto k = std::find(bit.begin(), bit.end(), missing) - bit.begin();
    const Facet* const other = facet_of(hull, quad & ~bit[(k + 2) % 4]);
    if (other == nullptr || !(dot(facet.normal, other->normal) >= kManifoldCosine)) return 0;
    face.count = 4;
    std::copy(loop.begin(), loop.end(), face.vertices.begin());
    face.normal = safe_unit(facet.area * facet.normal + other->area * other->normal);
    // The triangle without vertex 3 is (0 1 2), that without vertex 0 is (1 2 3).
    const bool is_right = k == 3 || k == 0;
    bend.ridge = k % 2 == 0 ? 1 : 0;
    bend.normals = {is_right ? facet.normal : other->normal, is_right ? other->normal : facet.normal};
    return quad;
  }
  return 0;
}

/// Returns the bits of the vertices that the face takes in.
unsigned add_face(const Vertices& v, const Hull& hull, const Facet& facet, SolidFeatures& out) {
  HullFace& face = out.faces[out.face_count++];
  if (std::popcount(facet.mask) == 3 && out.bend_count < static_cast<int>(out.bends.size())) {
    if (const unsigned mask = make_bent_face(hull, facet, face, out.bends[out.bend_count])) {
      face.bend = static_cast<std::int8_t>(out.bend_count++);
      return mask;
    }
  }
  face = ordered_face(v, facet);
  return facet.mask;
}

void find_faces(const Hexahedron& solid, const Hull& hull, SolidFeatures& out) {
  const Vertices v = scaled_to_unit(solid.vertices());
  double size = 0.0;
  for (int i = 0; i < 8; ++i)
    for (int j = i + 1; j < 8; ++j) size = std::max(size, norm(v[i] - v[j]));
  std::vector<unsigned> taken;
  for (Facet facet : hull.facets) {
    const bool part_of_another =
        std::any_of(taken.begin(), taken.end(), [&](unsigned mask) { return (facet.mask & ~mask) == 0; });
    if (part_of_another) continue;
    take_in_flat_neighbours(v, hull.distinct, size, facet);
    taken.push_back(add_face(v, hull, facet, out));
  }
}

/// The numbers of the hull's leaders, facets that stand for others too, as faces; -1 of those others. In the
/// order of the hexahedron's faces, if these are they: `is_regular`.
struct FaceNumbers {
  std::vector<int> of;
  int count = 0;
  bool is_regular;

  explicit FaceNumbers(const Hull& hull) : of(hull.facets.size(), -1) {
    for (std::size_t f = 0; f < of.size(); ++f)
      if (hull.facets[f].leader == static_cast<int>(f)) of[f] = count++;
    is_regular = take_quads(hull);
  }

 private:
  bool take_quads(const Hull& hull) {
    if (count != kRegularFaces) return false;
    std::vector<int> numbers(of.size(), -1);
    unsigned found = 0;
    for (std::size_t f = 0; f < of.size(); ++f) {
      if (of[f] < 0) continue;
      unsigned vertices = 0;  // of all that it leads
      for (const Facet& facet : hull.facets)
        if (facet.leader == static_cast<int>(f)) vertices |= facet.mask;
      numbers[f] = quad_of(vertices);
      if (numbers[f] < 0) return false;
      found |= 1u << numbers[f];
    }
    if (found != 0x3fu) return false;
    of = numbers;
    return true;
  }
  static int quad_of(unsigned vertices) {
    for (int q = 0; q < 6; ++q) {
      unsigned mask = 0;
      for (const std::uint8_t v : Hexahedron::kFaceVertices[q]) mask |= 1u << v;
      if (mask == vertices) return q;
    }
    return -1;
  }
};

/// Whether the hull's edges are the hexahedron's, between the same faces. @param faces regular
bool has_regular_edges(const Hull& hull, const FaceNumbers& faces) {
  if (hull.edges.size() != kRegularEdges) return false;
  unsigned found = 0;
  for (Edge edge : hull.edges) {
    int first = faces.of[hull.facets[edge.facet].leader], second = faces.of[hull.facets[edge.other].leader];
    if (first > second) std::swap(first, second), std::swap(edge.from, edge.to);
    const HullTopology& regular = kRegularHull;
    for (int e = 0; e < kRegularEdges; ++e)
      if (regular.edge_faces[0][e] == first && regular.edge_faces[1][e] == second &&
          regular.edge_vertices[0][e] == edge.from && regular.edge_vertices[1][e] == edge.to)
        found |= 1u << e;
  }
  return found == (1u << kRegularEdges) - 1;
}

HullTopology topology_of(const Hull& hull, const FaceNumbers& faces) {
  if (faces.is_regular && has_regular_edges(hull, faces)) return kRegularHull;
  HullTopology out{};
  out.face_count = static_cast<std::uint8_t>(faces.count);
  for (std::size_t f = 0; f < hull.facets.size(); ++f)
    if (faces.of[f] >= 0)
      out.face_vertex[faces.of[f]] = static_cast<std::uint8_t>(std::countr_zero(hull.facets[f].mask));
  for (const Edge& edge : hull.edges) {
    const int e = out.edge_count++;
    out.edge_vertices[0][e] = static_cast<std::uint8_t>(edge.from);
    out.edge_vertices[1][e] = static_cast<std::uint8_t>(edge.to);
    for (int side = 0; side < 2; ++side) {
      const int facet = side == 0 ? edge.facet : edge.other;
      out.edge_faces[side][e] = static_cast<std::uint8_t>(faces.of[hull.facets[facet].leader]);
    }
  }
  return out;
}

HullRecord hull_record(const Hull& hull) {
  const FaceNumbers faces(hull);
  HullRecord out{};
  out.topology = topology_of(hull, faces);
  for (std::size_t f = 0; f < hull.facets.size(); ++f) {
    if (faces.of[f] < 0) continue;
    const Vector3& n = hull.facets[f].normal;
    HullRecord::Normals& normals = out.normals[faces.of[f] / 8];
    const int lane = faces.of[f] % 8;
    normals.x[lane] = n.x(), normals.y[lane] = n.y(), normals.z[lane] = n.z();
  }
  return out;
}

/// Whether the record is that of kRegularHull, with the normals of `plain`.
bool is_regular(const HullRecord& record, const PlainHull& plain) {
  if (!plain.is_plain || std::memcmp(&record.topology, &kRegularHull, sizeof kRegularHull) != 0) return false;
  const HullRecord::Normals& n = record.normals[0];
  for (int f = 0; f < kRegularFaces; ++f)
    if (n.x[f] != plain.normals[0][f] || n.y[f] != plain.normals[1][f] || n.z[f] != plain.normals[2][f])
      return false;
  return true;
}

}  // namespace

SolidFeatures find_features(const Hexahedron& solid, HullRecord* record) {
  if (solid.is_box() && record == nullptr) return box_features();
  const Hull hull = exact_hull(solid);
  if (record != nullptr) *record = hull_record(hull);
  if (solid.is_box()) return box_features();
  SolidFeatures out;
  find_faces(solid, hull, out);
  out.quads = quad_faces(out);
  for (int f = 0; f < static_cast<int>(hull.facets.size()); ++f)
    if (hull.facets[f].leader == f) add_direction(hull.facets[f].normal, out.normals, out.normal_count);
  for (const Edge& edge : hull.edges)
    add_direction(direction_of(hull, edge.from, edge.to), out.edges, out.edge_count);
  return out;
}

PlainHull plain_hull(const SolidFeatures& features, const HullRecord& record) {
  PlainHull out{};
  const QuadFaces& quads = features.quads;
  if (!quads.are_quads || quads.bent != 0) return out;
  for (int k = 0; k < 3; ++k) std::copy_n(quads.normals[k], 6, out.normals[k]);
  out.is_plain = true;
  out.is_regular = is_regular(record, out);
  return out;
}

}  // namespace touchstone::native
