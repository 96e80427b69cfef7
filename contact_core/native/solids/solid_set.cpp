#include "touchstone/contact_core/native/solids/solid_set.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <unordered_set>
#include <utility>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"
#include "touchstone/contact_core/native/common/hull_pair.hpp"

namespace touchstone::native {
namespace {

static_assert(sizeof(VertexRecord) == sizeof(WorldVertices) &&
              alignof(VertexRecord) == alignof(WorldVertices));

bool is_ordinary(const Hexahedron& solid) {
  // The core of a sphere has no size that could underflow.
  return (solid.size() >= kOrdinaryLow || solid.size() == 0.0) &&
         norm_inf(solid.bounding_sphere().centre) <= kOrdinaryHigh && solid.size() <= kOrdinaryHigh;
}

BoxRecord box_record(const Hexahedron& solid, bool ordinary) {
  const Vector3& half = solid.half_extents();
  return {{half.x(), half.y(), half.z()}, ordinary ? (half.x() + half.y()) + half.z() : kInfinity};
}

WorldVertices not_a_number() {
  WorldVertices out;
  for (auto* const column : {&out.x, &out.y, &out.z}) column->fill(kNaN);
  return out;
}

ParallelepipedEdges edges_record(const WorldVertices& vertices_S, const Parallelepiped& shape,
                                 bool ordinary) {
  ParallelepipedEdges out{};
  double reach = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double length = ordinary ? norm(vector_of(shape.half_edges[i])) : 0.0;
    for (int k = 0; k < 3; ++k)
      out.directions[i][k] = length > 0.0 ? shape.half_edges[i][k] / length : shape.half_edges[i][k];
    out.half_lengths[i] = ordinary ? length : kInfinity;
    out.centre[i] = shape.centre[i];
    reach += length;
  }
  // Length and division round by 4 u.
  out.deviation = shape.deviation + 4 * kRoundoff * reach;
  std::copy_n(vertices_S.x.begin(), 8, out.x);
  std::copy_n(vertices_S.y.begin(), 8, out.y);
  std::copy_n(vertices_S.z.begin(), 8, out.z);
  return out;
}

/// Cores without volume: rounded boxes with a zero side.
bool is_flat(const Hexahedron& solid) {
  const Vector3& half = solid.half_extents();
  return solid.is_box() && !(half.x() > 0.0 && half.y() > 0.0 && half.z() > 0.0);
}

std::shared_ptr<const SolidHull> make_hull(const Hexahedron& solid) {
  const auto out = std::make_shared<SolidHull>();
  // Flat boxes have the faces and edges of a box: where those are bounded does not count in directions.
  out->features = find_features(is_flat(solid) ? Hexahedron::from_size({1, 1, 1}) : solid, &out->record);
  out->plain = plain_hull(out->features, out->record);
  out->vertices_S = in_columns(solid);
  return out;
}

const std::shared_ptr<const SolidHull>& hull_of_boxes() {
  static const std::shared_ptr<const SolidHull> hull = make_hull(Hexahedron::from_size({1, 1, 1}));
  return hull;
}

/// Hulls of the solids built so far: equal ones, as blocks of a wall and parts of like robots are, share one.
class SharedHulls {
 public:
  explicit SharedHulls(const SolidSet& set) : set_(set), known_(0, Hash{set}, SameBits{set}) {}

  /// The hull of `solid`, which stands last in the set's vertices. @pre ordinary and no box.
  std::shared_ptr<const SolidHull> find(const Hexahedron& solid) {
    const auto last = static_cast<std::uint32_t>(set_.vertices.size() - 1);
    const auto [place, is_new] = known_.insert(last);
    return is_new ? make_hull(solid) : set_.hulls[*place];
  }

 private:
  using Bits = std::array<std::uint64_t, 24>;
  static Bits bits_of(const SolidSet& set, std::uint32_t solid) {
    return std::bit_cast<Bits>(set.vertices[solid]);
  }
  struct Hash {
    const SolidSet& set;
    std::size_t operator()(std::uint32_t solid) const {
      std::uint64_t hash = 0;
      for (const std::uint64_t bits : bits_of(set, solid)) {  // round numbers differ in their highest bits
        hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 32;
      }
      return hash;
    }
  };
  struct SameBits {
    const SolidSet& set;
    bool operator()(std::uint32_t a, std::uint32_t b) const { return bits_of(set, a) == bits_of(set, b); }
  };

  const SolidSet& set_;
  std::unordered_set<std::uint32_t, Hash, SameBits> known_;
};

void add_parallelepiped(SolidSet& set, std::size_t solid, const std::optional<Parallelepiped>& fit) {
  const bool ordinary = set.ordinary[solid] != 0;
  Parallelepiped& shape = set.parallelepipeds.emplace_back(fit.value_or(Parallelepiped{}));
  set.parallelepiped_edges.push_back(edges_record(local_vertices(set, solid), shape, ordinary && fit));
  if (!ordinary) std::fill_n(shape.centre, 3, kInfinity);
}

/// Fills what boxes among themselves do without.
void add_parallelepipeds(SolidSet& set) {
  set.parallelepiped_edges.reserve(set.kinds.size()), set.parallelepipeds.reserve(set.kinds.size());
  for (std::size_t i = set.parallelepipeds.size(); i < set.kinds.size(); ++i)
    add_parallelepiped(set, i, as_parallelepiped(local_vertices(set, i), set.solids[i].size));
}

void reserve(SolidSet& set, std::size_t count, bool only_boxes) {
  set.kinds.reserve(count);
  set.ordinary.reserve(count);
  set.boxes.reserve(count);
  set.vertices.reserve(count);
  set.solids.reserve(count);
  if (only_boxes) return;
  set.parallelepipeds.reserve(count);
  set.parallelepiped_edges.reserve(count);
}

/// Places for hulls, up to this many. A set may have more of them than solids.
void add_places_for_hulls(SolidSet& set, std::size_t count) {
  while (set.hulls.size() < count) set.hulls.emplace_back();
}

/// But for its hull, which has a place. @param i of a solid that is there, or the next one.
void put(SolidSet& set, std::size_t i, const Hexahedron& solid, SolidKind kind) {
  if (i >= set.kinds.size()) {
    set.kinds.emplace_back(), set.ordinary.emplace_back(), set.boxes.emplace_back();
    set.vertices.emplace_back(), set.solids.emplace_back();
  }
  const bool ordinary = is_ordinary(solid);
  set.kinds[i] = kind, set.ordinary[i] = ordinary;
  set.boxes[i] = box_record(solid, ordinary);
  set.vertices[i] = ordinary ? in_columns(solid) : not_a_number();
  set.solids[i] = {solid.size(), norm_inf(solid.bounding_sphere().centre), nullptr, nullptr};
}

void set_hull(SolidSet& set, std::size_t i, std::shared_ptr<const SolidHull> hull) {
  set.solids[i].hull = hull.get();
  set.solids[i].plain = hull->plain.is_plain ? &hull->plain : nullptr;
  set.hulls[i] = std::move(hull);
}

void take_room(SolidSet& set, std::size_t solids, bool with_parallelepipeds, bool with_radii) {
  reserve_more(set.kinds, solids), reserve_more(set.ordinary, solids), reserve_more(set.boxes, solids);
  reserve_more(set.vertices, solids), reserve_more(set.solids, solids);
  if (with_radii) reserve_more(set.radii, solids);
  if (!with_parallelepipeds) return;
  reserve_more(set.parallelepipeds, solids), reserve_more(set.parallelepiped_edges, solids);
}

/// All memory that solids as those of `fresh` take from `first` on. Where it ends, only the list of hulls is
/// longer than the others.
void take_places(SolidSet& set, std::size_t first, const SolidSet& fresh, std::size_t count) {
  const std::size_t solids = std::max<std::size_t>(set.kinds.size(), first + count);
  take_room(set, solids, !fresh.parallelepipeds.empty(), !fresh.radii.empty());
  add_places_for_hulls(set, solids);
}

/// The hull of the solid that stood where number `i` is put, if it is the same one: what comes back, as a
/// tool that was changed or an arm that went, finds its hull. Else null.
std::shared_ptr<const SolidHull> hull_there(const SolidSet& before, std::size_t i,
                                            const WorldVertices& vertices) {
  using Bits = std::array<std::uint64_t, 24>;
  if (i >= before.kinds.size() || before.ordinary[i] == 0 || before.kinds[i] == SolidKind::box)
    return nullptr;
  const bool is_same = std::bit_cast<Bits>(before.vertices[i]) == std::bit_cast<Bits>(vertices);
  return is_same ? before.hulls[i] : nullptr;
}

/// Of solids that are to be put into `before` from `first` on.
SolidSet make_set(std::span<const Hexahedron> solids, const SolidSet& before, std::size_t first) {
  const auto is_box = [](const Hexahedron& solid) { return solid.is_box(); };
  const auto is_rounded = [](const Hexahedron& solid) { return solid.is_rounded(); };
  // Room for what these kinds have.
  const bool only_boxes = std::all_of(solids.begin(), solids.end(), is_box);
  SolidSet out;
  reserve(out, solids.size(), only_boxes);
  add_places_for_hulls(out, solids.size());
  SharedHulls shared(out);
  if (std::any_of(solids.begin(), solids.end(), is_rounded))
    for (const Hexahedron& solid : solids) out.radii.push_back(solid.radius());
  // Each with a hull that is there where there is one.
  for (std::size_t i = 0; i < solids.size(); ++i) {
    const Hexahedron& solid = solids[i];
    const auto fit = only_boxes ? std::nullopt : as_parallelepiped(in_columns(solid), solid.size());
    put(out, i, solid,
        solid.is_box() ? SolidKind::box
        : fit          ? SolidKind::parallelepiped
                       : SolidKind::general);
    if (out.ordinary[i] == 0)
      set_hull(out, i, make_hull(solid));
    else if (solid.is_box())
      set_hull(out, i, hull_of_boxes());
    else if (std::shared_ptr<const SolidHull> there = hull_there(before, first + i, out.vertices[i]))
      set_hull(out, i, std::move(there));
    else
      set_hull(out, i, shared.find(solid));
    if (!only_boxes) add_parallelepiped(out, i, fit);
  }
  return out;
}

bool is_plain_box(const Hexahedron& solid) { return solid.is_box() && !solid.is_rounded(); }

/// Writes all lists of `solids`, from `first` on, but for the hulls. What stands within the set is written
/// over, and nothing else of the set then.
void put_lists(SolidSet& set, std::size_t first, const SolidSet& solids) {
  const auto put = [first](auto& to, const auto& from) {
    const std::size_t replaced = std::min(from.size(), to.size() - first);
    const auto split = from.begin() + static_cast<std::ptrdiff_t>(replaced);
    std::copy(from.begin(), split, to.begin() + static_cast<std::ptrdiff_t>(first));
    if (split != from.end()) to.insert(to.end(), split, from.end());
  };
  if (!solids.parallelepipeds.empty()) {
    put(set.parallelepipeds, solids.parallelepipeds);
    put(set.parallelepiped_edges, solids.parallelepiped_edges);
  }
  put(set.kinds, solids.kinds), put(set.ordinary, solids.ordinary);
  put(set.boxes, solids.boxes), put(set.vertices, solids.vertices);
  put(set.solids, solids.solids);
  if (!solids.radii.empty()) put(set.radii, solids.radii);
}

}  // namespace

const VertexRecord* vertex_records(const SolidSet& set) {
  return reinterpret_cast<const VertexRecord*>(set.vertices.data());
}

SolidSet make_solid_set(std::span<const Hexahedron> solids) { return make_set(solids, {}, 0); }

void take_room(SolidSet& set, std::size_t solids) {
  take_room(set, solids, !set.parallelepipeds.empty(), !set.radii.empty());
}

void set_solids(SolidSet& set, std::size_t first, std::span<const Hexahedron> solids) {
  const bool holds_boxes_alone = set.parallelepipeds.empty() && set.radii.empty();
  if (!holds_boxes_alone || !std::all_of(solids.begin(), solids.end(), is_plain_box))
    return set_solids(set, first, make_set(solids, set, first));
  take_places(set, first, set, solids.size());
  // Boxes among boxes are put in their places without a set of their own.
  for (std::size_t i = 0; i < solids.size(); ++i) {
    std::shared_ptr<const SolidHull> hull = is_ordinary(solids[i]) ? hull_of_boxes() : make_hull(solids[i]);
    put(set, first + i, solids[i], SolidKind::box);
    set_hull(set, first + i, std::move(hull));
  }
}

void set_solids(SolidSet& set, std::size_t first, SolidSet solids) {
  if (set.parallelepipeds.empty() != solids.parallelepipeds.empty())
    add_parallelepipeds(set), add_parallelepipeds(solids);
  if (set.radii.empty() != solids.radii.empty()) {
    set.radii.resize(set.kinds.size(), 0.0);
    solids.radii.resize(solids.kinds.size(), 0.0);
  }
  take_places(set, first, solids, solids.kinds.size());
  put_lists(set, first, solids);
  for (std::size_t i = 0; i < solids.kinds.size(); ++i) set.hulls[first + i] = std::move(solids.hulls[i]);
}

SolidSet make_places(std::size_t count) {
  // No box: a set of boxes alone goes without some lists.
  static const Hexahedron wedge = Hexahedron::from_vertices(
      {{{0, 0, 0}, {0, 0, 1}, {0, 1, 0}, {0, 1, 1}, {1, 0, 0}, {1, 0, 1}, {2, 1, 0}, {2, 1, 1}}});
  return make_solid_set(std::vector<Hexahedron>(count, wedge));
}

void make_placeable(SolidSet& solids) {
  if (solids.parallelepipeds.empty()) add_parallelepipeds(solids);
}

void put_in_places(SolidSet& set, std::size_t first, const SolidSet& solids) {
  put_lists(set, first, solids);
  for (std::size_t i = 0; i < solids.kinds.size(); ++i) set.hulls[first + i] = solids.hulls[i];
}

}  // namespace touchstone::native
