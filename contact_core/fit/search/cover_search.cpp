#include "touchstone/contact_core/fit/search/cover_search.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "touchstone/contact_core/fit/meshes/main_axes.hpp"
#include "touchstone/contact_core/fit/search/set_cover.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"

namespace touchstone::fit {
namespace {

constexpr std::array<std::array<int, 6>, 7> kOrders = {{{0, 1, 2, 3, 4, 5},
                                                        {0, 1, 4, 5, 2, 3},
                                                        {2, 3, 0, 1, 4, 5},
                                                        {2, 3, 4, 5, 0, 1},
                                                        {4, 5, 0, 1, 2, 3},
                                                        {4, 5, 2, 3, 0, 1},
                                                        {0, 2, 4, 1, 3, 5}}};

constexpr std::size_t kOrdersTried = 3;

// Where repairs cost less than this there are more of them, up to this many times as asked.
constexpr double kVisitsARepair = 1e6;
constexpr int kMostTimes = 16;

// Scores that change where fewer are chosen of all candidates, a repair asked for: a fraction of its cost.
constexpr std::uint64_t kScoresARepair = 10'000'000;

constexpr std::size_t kMostOut = 6;  // that a repair takes out

void add_once(std::vector<std::uint32_t>& all, std::uint32_t one) {
  if (std::find(all.begin(), all.end(), one) == all.end()) all.push_back(one);
}

Normals frame_of(const Vector3& z, Vector3 hint) {
  hint -= dot(hint, z) * z;
  if (norm(hint) < 1e-6) hint = cross(z, std::abs(z.x()) < 0.7 ? Vector3::UnitX() : Vector3::UnitY());
  const Vector3 x = hint / norm(hint);
  return box_normals(x, cross(z, x), z);
}

// Between the planes of two opposite faces, at the middle of the corners [m].
double thickness(const SixPlanes& solid, int face) {
  Vector3 middle = Vector3::Zero();
  for (const Vector3& p : solid.corners()) middle += 0.125 * p;
  return -(solid.planes[face].signed_distance(middle) + solid.planes[face + 1].signed_distance(middle));
}

// About the points, `thinnest` thick at least: a sheet becomes a thin plate.
SixPlanes plate(const Normals& normals, const std::vector<Vector3>& points, double thinnest) {
  SixPlanes tight = enclosing(normals, points);
  for (int f = 0; f < 6; f += 2) {
    const double lacks = 0.5 * (thinnest - thickness(tight, f));
    for (const int face : {f, f + 1}) tight.planes[face].offset -= std::max(0.0, lacks);
  }
  return tight;
}

// By pyramids from the first corner on to the faces.
double volume(const SixPlanes& solid) {
  const std::array<Vector3, 8> p = solid.corners();
  double six = 0.0;
  for (const auto& face : Hexahedron::kFaceVertices)
    for (int i = 1; i < 3; ++i)
      six += std::abs(dot(p[face[0]] - p[0], cross(p[face[i]] - p[0], p[face[i + 1]] - p[0])));
  return six / 6.0;
}

Normals normals_of(const SixPlanes& solid) {
  Normals normals;
  for (int f = 0; f < 6; ++f) normals[f] = solid.planes[f].normal;
  return normals;
}

// Points that one hexahedron has to hold, and planes about them.
struct Share {
  std::vector<Vector3> points;
  SixPlanes planes;

  void choose_axes(const Normals& own, std::span<const Normals> frames) {
    planes = enclosing(own, points);
    for (const Normals& frame : frames)
      if (const SixPlanes box = enclosing(frame, points); volume(box) < volume(planes)) planes = box;
  }
  SixPlanes with(std::span<const Vector3> more) const {
    SixPlanes grown = planes;
    for (Plane& plane : grown.planes)
      for (const Vector3& p : more) plane.offset = std::min(plane.offset, -dot(plane.normal, p));
    return grown;
  }
  void hold(std::span<const Vector3> more) { points.insert(points.end(), more.begin(), more.end()); }
  void grow(std::span<const Vector3> more) {
    hold(more);
    planes = with(more);
  }
  double growth(std::span<const Vector3> more) const {
    if (points.empty()) return 1e299;  // better one that is needed anyway
    const bool has_room =
        std::all_of(more.begin(), more.end(), [this](const Vector3& p) { return planes.above(p) <= 0.0; });
    return has_room ? 0.0 : volume(with(more)) - volume(planes);
  }
};

}  // namespace

CoverSearch::CoverSearch(const MeshDistance& mesh, const Cells& cells, AllowedSpace& space, double over,
                         std::span<const Sectors> sectors, std::span<const Prism> prisms,
                         const SearchEffort& effort, const std::function<void(double)>& progress)
    : mesh_(mesh),
      cells_(cells),
      space_(space),
      sectors_(sectors),
      prisms_(prisms),
      over_(over),
      growth_(mesh, space, over / 16.0),
      effort_(effort),
      progress_(progress),
      pool_(cells.size()),
      all_((cells.size() + 63) / 64, 0),
      settled_(all_) {
  // Cells of prisms stand together, before those of rings.
  for (std::size_t i = 0; i < cells.size(); ++i) {
    set(all_, i);
    if (cells.cell(i).prism == first_of_prism_.size()) first_of_prism_.push_back(i);
  }
  std::size_t end = cells.size();  // of prisms: rings are last
  while (end > 0 && cells.cell(end - 1).ring != kNoIndex) --end;
  first_of_prism_.push_back(end);
  // Boxes are laid along the axes, and along the mesh's main directions where these differ.
  main_frames_.push_back(box_normals(Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()));
  const Vector3 z = main_direction(mesh.mesh(), Vector3::Zero());
  if (norm(z) == 0.0) return;
  const Vector3 x = main_direction(mesh.mesh(), z);
  const bool is_aligned = norm_inf(z) > 0.9999 && (norm(x) == 0.0 || norm_inf(x) > 0.9999);
  if (!is_aligned) main_frames_.push_back(frame_of(z, x));
}

std::uint64_t CoverSearch::random() {  // Marsaglia's xorshift
  state_ ^= state_ << 13;
  state_ ^= state_ >> 7;
  state_ ^= state_ << 17;
  return state_;
}

void CoverSearch::tick(double done) {
  done_ = done;
  if (progress_) progress_(done);
}

std::vector<Normals> CoverSearch::frames_at(std::size_t cell) const {
  std::vector<Normals> frames = main_frames_;
  if (!cells_.cell(cell).has_surface) return frames;
  const TriangleMesh& mesh = mesh_.mesh();
  const std::span<const Vector3> points = cells_.points(cell);
  const std::uint32_t t = mesh_.nearest(points[points.size() / 2]).triangle;
  const Vector3 n = area_vector(mesh, t);
  if (norm(n) == 0.0) return frames;
  Vector3 longest = Vector3::Zero();
  for (int i = 0; i < 3; ++i) {
    const Vector3 edge = mesh.vertices[mesh.triangles[t][(i + 1) % 3]] - mesh.vertices[mesh.triangles[t][i]];
    if (norm(edge) > norm(longest)) longest = edge;
  }
  // A facet of a round part has its long edge along the axis; a slanted wall may lie in a main plane.
  const Vector3 z = n / norm(n);
  if (norm_inf(z) < 0.9999) {
    frames.push_back(frame_of(z, longest));
    Eigen::Index across = 0;
    z.cwiseAbs().minCoeff(&across);
    frames.push_back(frame_of(z, Vector3::Unit(across)));
  }
  return frames;
}

Candidate CoverSearch::candidate(const SixPlanes& solid) const {
  std::vector<std::uint32_t> held;
  cells_.held(solid, held);
  return {solid, held};
}

std::vector<Vector3> CoverSearch::points_of(std::uint32_t prism, const Window& strips,
                                            std::size_t first_piece, std::size_t last_piece) const {
  const std::size_t first = first_of_prism_[prism];
  const std::size_t pieces = (first_of_prism_[prism + 1] - first) / prisms_[prism].strips();
  std::vector<Vector3> points;
  for (std::size_t strip = strips.first; strip <= strips.last; ++strip)
    for (std::size_t piece = first_piece; piece <= last_piece; ++piece) {
      const std::span<const Vector3> more = cells_.points(first + strip * pieces + piece);
      points.insert(points.end(), more.begin(), more.end());
    }
  return points;
}

bool CoverSearch::is_about(std::uint32_t prism, const SixPlanes& solid) const {
  return prisms_[prism].is_about(solid, space_.least_limit(solid.corners())) &&
         !space_.holds_forbidden(solid);
}

// The most strips about the cell's that a slab holds, with each lowest one.
std::vector<CoverSearch::Window> CoverSearch::windows(std::size_t cell, double limit) const {
  const std::uint32_t index = cells_.cell(cell).prism, strip = cells_.cell(cell).strip;
  const Prism& prism = prisms_[index];
  const std::size_t first = first_of_prism_[index],
                    pieces = (first_of_prism_[index + 1] - first) / prism.strips(),
                    piece = (cell - first) % pieces;
  const auto fits = [&](std::size_t low, std::size_t high) {
    return prism.is_about(prism.slab(points_of(index, {low, high}, piece, piece), low, high), limit);
  };
  std::vector<Window> result;
  std::size_t high = strip;
  if (!fits(strip, strip)) return result;
  while (high + 1 < prism.strips() && fits(strip, high + 1)) ++high;
  result.push_back({strip, high});
  for (std::size_t low = strip; low-- > 0;) {
    while (high > strip && !fits(low, high)) --high;
    if (high == strip && !fits(low, high)) break;
    if (result.back().last == high) result.pop_back();
    result.push_back({low, high});
  }
  return result;
}

// Slabs of the prism that hold the cell. Each goes along all of it, or as far as what is allowed lets it.
bool CoverSearch::grow_prism(std::size_t cell) {
  const std::uint32_t index = cells_.cell(cell).prism;
  const Prism& prism = prisms_[index];
  const std::size_t first = first_of_prism_[index],
                    pieces = (first_of_prism_[index + 1] - first) / prism.strips(),
                    piece = (cell - first) % pieces;
  const double slack = 1e-9 * mesh_.bounds().diagonal();
  const auto slab = [&](const Window& strips, std::size_t from, std::size_t to) {
    SixPlanes solid = prism.slab(points_of(index, strips, from, to), strips.first, strips.last);
    for (Plane& plane : solid.planes) plane.offset -= slack;
    return solid;
  };
  // Some hold what is near with a smaller error, others what is elsewhere with the large one.
  const double near = limit_of(cell);
  bool has_grown = false;
  for (const double limit : {near, over_}) {
    for (const Window& strips : windows(cell, limit - slack)) {
      SixPlanes solid = slab(strips, 0, pieces - 1);
      if (!is_about(index, solid)) {
        const SixPlanes whole = solid;
        solid = slab(strips, piece, piece);
        if (!is_about(index, solid)) continue;
        for (const int end : {4, 5}) {
          const double from = solid.planes[end].offset, way = whole.planes[end].offset - from;
          const double share = largest_share([&](double s) {
            solid.planes[end].offset = from + s * way;
            return is_about(index, solid);
          });
          solid.planes[end].offset = from + share * way;
        }
      }
      Candidate grown = candidate(solid);
      grown.prism = index;
      pool_.add(std::move(grown));
      has_grown = true;
    }
    if (near == over_) break;
  }
  return has_grown;
}

// The least that is allowed at its points, or at some beside them.
double CoverSearch::limit_of(std::size_t cell) const { return space_.least_limit(cells_.points(cell)); }

// Whether a candidate's place may be taken.
bool CoverSearch::may_be(const Candidate& candidate, const SixPlanes& instead) {
  return candidate.prism == kNoIndex ? growth_.allows(instead) : is_about(candidate.prism, instead);
}

void CoverSearch::grow_from(std::size_t cell) {
  if (has(settled_, cell)) return;
  // What is thick beside what is allowed gains nothing of hexahedra that go beyond it.
  const std::uint32_t prism = cells_.cell(cell).prism, ring = cells_.cell(cell).ring;
  bool has_grown = (prism != kNoIndex && grow_prism(cell)) || (ring != kNoIndex && grow_ring(cell));
  if (has_grown && prism != kNoIndex && prisms_[prism].thickness >= kThick * limit_of(cell)) return;
  if (has_grown && ring != kNoIndex && sectors_[ring].is_ring(limit_of(cell))) return;
  const std::vector<Normals> frames = frames_at(cell);
  for (const Normals& frame : frames) {
    SixPlanes start = enclosing(frame, cells_.points(cell));
    for (Plane& plane : start.planes) plane.offset -= 1e-9 * mesh_.bounds().diagonal();
    if (!growth_.allows(start)) continue;
    has_grown = true;
    // Some of the orders each time: cells in reach of one hexahedron try the others.
    const std::size_t first = random();
    for (std::size_t i = 0; i < kOrdersTried; ++i) {
      SixPlanes solid = start;
      growth_.push(solid, kOrders[(first + i * 3) % kOrders.size()]);
      pool_.add(candidate(solid));
    }
  }
  if (has_grown) return;
  // A cell of the tree is at most as large as the limit: the box about it keeps to what is allowed, whatever
  // a filter says. One of a prism or a ring may be larger: it is held all the same, and its part named.
  if (prism != kNoIndex) add_once(uncovered_.prisms, prism);
  if (ring != kNoIndex) add_once(uncovered_.rings, ring);
  SixPlanes box = enclosing(main_frames_[0], cells_.points(cell));
  for (Plane& plane : box.planes) plane.offset -= 1e-9 * mesh_.bounds().diagonal();
  pool_.add(candidate(box));
}

// The hexahedron about a sector's points, or what grows outwards of that.
bool CoverSearch::grow_sector(const Sectors& sectors, int sector, std::span<const Vector3> points) {
  constexpr std::array<std::array<int, 3>, 2> kOutwards = {{{4, 5, 1}, {1, 4, 5}}};
  const double slack = 1e-9 * mesh_.bounds().diagonal();
  SixPlanes start = sectors.about(sector, points);
  for (Plane& plane : start.planes) plane.offset -= slack;
  if ((sectors.has_shell() || sectors.is_ring(over_)) && space_.allows_samples(start)) {
    Candidate whole = candidate(start);
    if (sectors.is_ring(over_))
      for (const HeldWord& word : whole.held) settled_[word.index] |= word.bits;
    pool_.add(std::move(whole));
    return true;
  }
  if (!growth_.allows(start)) return false;
  for (const auto& order : kOutwards) {
    SixPlanes solid = start;
    growth_.push(solid, order);
    pool_.add(candidate(solid));
  }
  return true;
}

std::vector<Vector3> CoverSearch::points_of_sector(std::uint32_t ring, std::uint32_t sector) const {
  std::vector<Vector3> points;
  for (std::size_t cell = first_of_prism_.back(); cell < cells_.size(); ++cell) {
    if (cells_.cell(cell).ring != ring || cells_.cell(cell).strip != sector) continue;
    points.insert(points.end(), cells_.points(cell).begin(), cells_.points(cell).end());
  }
  return points;
}

bool CoverSearch::grow_ring(std::size_t cell) {
  const std::uint32_t ring = cells_.cell(cell).ring, sector = cells_.cell(cell).strip;
  return grow_sector(sectors_[ring], static_cast<int>(sector), points_of_sector(ring, sector));
}

// A hexahedron a sector, from the cells at the bore's wall outwards.
void CoverSearch::grow_sectors(const Sectors& sectors) {
  if (sectors.has_shell()) {
    for (std::size_t cell = first_of_prism_.back(); cell < cells_.size(); ++cell)
      if (&sectors_[cells_.cell(cell).ring] == &sectors && !has(settled_, cell)) grow_ring(cell);
    return;
  }
  // Each sector collects the points of cells about the bore whose middle is in it.
  std::vector<std::vector<Vector3>> points(static_cast<std::size_t>(sectors.count));
  for (std::size_t cell = 0; cell < first_of_prism_.back(); ++cell) {
    if (!sectors.touches(cells_.cell(cell).low, cells_.cell(cell).high)) continue;
    Vector3 middle = Vector3::Zero();
    for (const Vector3& p : cells_.points(cell))
      middle += p / static_cast<double>(cells_.points(cell).size());
    const Vector3 off = middle - sectors.bore.foot;
    const double along = dot(off, sectors.bore.axis);
    if (along < 0.0 || along > sectors.bore.length ||
        norm(off - along * sectors.bore.axis) > std::max(sectors.outer, 1.02 * sectors.bore.radius))
      continue;
    for (int i = 0; i < sectors.count; ++i)
      if (sectors.border(i).signed_distance(middle) >= 0.0 &&
          sectors.border((i + 1) % sectors.count).signed_distance(middle) <= 0.0)
        points[i].insert(points[i].end(), cells_.points(cell).begin(), cells_.points(cell).end());
  }
  for (int i = 0; i < sectors.count; ++i)
    if (!points[i].empty()) grow_sector(sectors, i, points[i]);
}

std::size_t CoverSearch::some_open(const OpenCells& open) {
  return open.next_from(random() % cells_.size(), cells_.size());
}

// The same hexahedron with its faces turned outwards may hold more.
void CoverSearch::improve_best(std::size_t index, const OpenCells& open) {
  if (pool_[index].prism != kNoIndex) return;  // its sides lean as they hold most
  SixPlanes solid = pool_[index].solid;
  growth_.tilt(solid);
  growth_.push(solid, kOrders[6]);
  Candidate turned = candidate(solid);
  if (open.held_by(turned) > open.held_by(pool_[index])) pool_.add(std::move(turned));
}

void CoverSearch::choose(std::vector<std::size_t>& chosen, OpenCells& open, int seeds,
                         std::size_t most_chosen) {
  while (!open.empty() && chosen.size() < most_chosen) {
    tick(done_);
    for (int i = 0; i < seeds; ++i) grow_from(some_open(open));
    OpenCells::Best best = open.best();
    if (best.gain == 0) {
      if (seeds == 0) return;
      grow_from(some_open(open));
      continue;
    }
    if (seeds > 0 && best.gain < open.count()) {
      improve_best(best.index, open);
      best = open.best();
    }
    chosen.push_back(best.index);
    open.cover(pool_[best.index]);
  }
}

CellBits CoverSearch::left_by(std::span<const std::size_t> chosen) const {
  CellBits open = all_;
  for (const std::size_t i : chosen)
    for (const HeldWord& word : pool_[i].held) open[word.index] &= ~word.bits;
  return open;
}

// Of a cover, those all of whose cells others hold, the first of them first.
void CoverSearch::drop_redundant(std::vector<std::size_t>& chosen) const {
  for (std::size_t next = 0; next < chosen.size();) {
    // Cells that one of them holds at least, and two.
    CellBits once(all_.size(), 0), twice(all_.size(), 0);
    for (const std::size_t i : chosen) {
      for (const HeldWord& word : pool_[i].held) {
        twice[word.index] |= once[word.index] & word.bits;
        once[word.index] |= word.bits;
      }
    }
    const auto is_redundant = [&](std::size_t i) {
      return std::all_of(pool_[i].held.begin(), pool_[i].held.end(),
                         [&](const HeldWord& word) { return (word.bits & ~twice[word.index]) == 0; });
    };
    while (next < chosen.size() && !is_redundant(chosen[next])) ++next;
    if (next < chosen.size()) chosen.erase(chosen.begin() + static_cast<std::ptrdiff_t>(next));
  }
}

// Takes a hexahedron and those that share cells with it, or any, out and covers what is then open anew.
bool CoverSearch::repair(std::vector<std::size_t>& chosen) {
  // The hexahedra nearest to a random place are taken out.
  const std::size_t out = std::min<std::size_t>(chosen.size(), 2 + random() % (kMostOut - 1));
  std::vector<std::size_t> kept = chosen;
  const Vector3 centre =
      0.5 * (cells_.cell(random() % cells_.size()).low + cells_.cell(random() % cells_.size()).high);
  std::stable_sort(kept.begin(), kept.end(), [&](std::size_t a, std::size_t b) {
    return pool_[a].solid.above(centre) > pool_[b].solid.above(centre);
  });
  kept.resize(kept.size() - out);
  // A new candidate grows from a cell that is open now.
  OpenCells open(pool_, left_by(kept));
  if (!open.empty()) grow_from(some_open(open));
  // Chance decides, so that the same hole is not always covered alike.
  if (!open.empty() && random() % 2 == 0) {
    const OpenCells::Best best = open.best_at(some_open(open));
    if (best.gain > 0) {
      kept.push_back(best.index);
      open.cover(pool_[best.index]);
    }
  }
  // The hole is covered anew; the result is kept if it has no more hexahedra than before.
  choose(kept, open, 0, chosen.size());
  if (!open.empty() || kept.size() > chosen.size()) return false;
  drop_redundant(kept);
  const bool is_better = kept.size() < chosen.size();
  chosen = std::move(kept);
  return is_better;
}

// Cells that several hold go where they make the hull least larger.
std::vector<std::vector<Vector3>> CoverSearch::share_out(const std::vector<std::size_t>& chosen) const {
  std::vector<std::vector<std::uint32_t>> held(chosen.size());
  std::vector<std::uint32_t> holders(cells_.size(), 0);
  for (std::size_t c = 0; c < chosen.size(); ++c) {
    cells_.held(pool_[chosen[c]].solid, held[c]);
    for (const std::uint32_t cell : held[c]) ++holders[cell];
  }
  // Each has to hold what no other one does, in those of its axes in which that takes least room.
  std::vector<Share> shares(chosen.size());
  std::vector<std::pair<std::uint32_t, std::size_t>> shared;
  for (std::size_t c = 0; c < chosen.size(); ++c) {
    for (const std::uint32_t cell : held[c]) {
      if (holders[cell] > 1)
        shared.emplace_back(cell, c);
      else
        shares[c].hold(cells_.points(cell));
    }
    shares[c].choose_axes(normals_of(pool_[chosen[c]].solid), main_frames_);
  }
  // Each cell that several hold goes where the hull grows least.
  std::sort(shared.begin(), shared.end());
  for (std::size_t i = 0; i < shared.size();) {
    const std::span<const Vector3> points = cells_.points(shared[i].first);
    std::size_t best = shared[i].second, end = i;
    double least = 1e300;
    for (; end < shared.size() && shared[end].first == shared[i].first; ++end) {
      const double growth = shares[shared[end].second].growth(points);
      if (growth >= least) continue;
      least = growth;
      best = shared[end].second;
    }
    shares[best].grow(points);
    i = end;
  }
  std::vector<std::vector<Vector3>> points;
  for (Share& share : shares) points.push_back(std::move(share.points));
  return points;
}

std::vector<SixPlanes> CoverSearch::shrunk(const std::vector<std::size_t>& chosen, double thinnest) {
  const std::vector<std::vector<Vector3>> needed = share_out(chosen);
  std::vector<SixPlanes> result;
  for (std::size_t c = 0; c < chosen.size(); ++c) {
    if (needed[c].empty()) continue;
    // Its planes keep their normals and move in to these points; a plain box about them may be smaller.
    SixPlanes solid = pool_[chosen[c]].solid;
    const double least = thinnest * space_.least_limit(needed[c]) / over_;
    const SixPlanes tight = plate(normals_of(solid), needed[c], least);
    const bool is_slab = pool_[chosen[c]].prism != kNoIndex;
    if (tight.is_hexahedron(is_slab ? Prism::kLeastDeterminant : SixPlanes::kLeastDeterminant)) solid = tight;
    for (const Normals& frame : main_frames_) {
      const SixPlanes box = plate(frame, needed[c], least);
      if (volume(box) < volume(solid) && may_be(pool_[chosen[c]], box)) solid = box;
    }
    result.push_back(solid);
  }
  return result;
}

// Candidates that hold a refused point go, and no new one will hold it; what they covered is covered anew.
void CoverSearch::replace(std::vector<std::size_t>& chosen, std::span<const Vector3> refused) {
  for (const Vector3& p : refused) space_.forbid(p);
  settled_.assign(settled_.size(), 0);
  const auto is_refused = [&](std::size_t i) {
    return std::any_of(refused.begin(), refused.end(),
                       [&](const Vector3& p) { return pool_[i].solid.above(p) <= 0.0; });
  };
  for (std::size_t i = 0; i < pool_.size(); ++i)
    if (is_refused(i)) pool_.forget(i);
  std::erase_if(chosen, [&](std::size_t i) { return pool_[i].count == 0; });
  OpenCells open(pool_, left_by(chosen));
  choose(chosen, open, effort_.seeds_a_choice, static_cast<std::size_t>(-1));
  drop_redundant(chosen);
}

// A set for each candidate, of what it holds: cells that the same candidates hold are one element.
std::vector<std::vector<std::uint32_t>> CoverSearch::pool_as_sets(std::size_t& elements) {
  const auto each_held = [&](std::size_t i, const auto& use) {
    for (const HeldWord& word : pool_[i].held)
      for (std::uint64_t bits = word.bits; bits != 0; bits &= bits - 1)
        use(word.index * 64 + static_cast<std::size_t>(std::countr_zero(bits)));
  };
  // The candidates that hold a cell are told apart by the sum of a random number each.
  std::vector<std::pair<std::uint64_t, std::size_t>> holders;
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) holders.emplace_back(0, cell);
  for (std::size_t i = 0; i < pool_.size(); ++i) {
    const std::uint64_t mark = random();
    each_held(i, [&](std::size_t cell) { holders[cell].first += mark; });
  }
  std::sort(holders.begin(), holders.end());
  // The first cell of those alike stands for them.
  std::vector<std::uint32_t> element(cells_.size(), kNoIndex);
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < holders.size(); ++i)
    if (i == 0 || holders[i].first != holders[i - 1].first) element[holders[i].second] = count++;
  std::vector<std::vector<std::uint32_t>> sets(pool_.size());
  for (std::size_t i = 0; i < pool_.size(); ++i)
    each_held(i, [&](std::size_t cell) {
      if (element[cell] != kNoIndex) sets[i].push_back(element[cell]);
    });
  elements = count;
  return sets;
}

// Of all that is known, as what is taken out in a place cannot change what is chosen everywhere.
void CoverSearch::choose_again(std::vector<std::size_t>& chosen, std::uint64_t work) {
  if (chosen.size() <= kMostOut) return;  // repairs did change everything
  std::size_t elements = 0;
  const std::vector<std::vector<std::uint32_t>> sets = pool_as_sets(elements);
  std::vector<std::size_t> fewer = fewer_sets(sets, elements, chosen, work);
  // Equal sums of different candidates would show here.
  if (fewer.size() < chosen.size() && OpenCells(pool_, left_by(fewer)).empty()) chosen = std::move(fewer);
}

void CoverSearch::look_for_fewer(std::vector<std::size_t>& chosen, int repairs) {
  const std::uint64_t start = space_.visits();
  const double budget = static_cast<double>(repairs) * kVisitsARepair;
  for (int i = 0; i < kMostTimes * repairs; ++i) {
    const double spent = static_cast<double>(space_.visits() - start) / budget;
    if (chosen.size() == 1 || (i >= repairs && (spent >= 1.0 || chosen.size() == 2))) break;
    repair(chosen);
    tick(std::min(1.0, std::max(spent, static_cast<double>(i + 1) / (kMostTimes * repairs))));
  }
  choose_again(chosen, kScoresARepair * static_cast<std::uint64_t>(repairs));
  tick(1.0);
}

std::vector<SixPlanes> CoverSearch::run(double thinnest, double margin, const Check& check) {
  if (cells_.size() == 0) return {};
  std::vector<std::size_t> chosen;
  // A pool of candidates, and a cover of all cells chosen from it.
  for (const Sectors& sectors : sectors_) grow_sectors(sectors);
  OpenCells open(pool_, all_);
  choose(chosen, open, 0, pool_.size());  // sectors first: the rest is what others have to cover
  for (int i = 0; i < effort_.first_seeds && !open.empty(); ++i) {
    tick(done_);
    grow_from(some_open(open));
  }
  choose(chosen, open, effort_.seeds_a_choice, static_cast<std::size_t>(-1));
  // Fewer of them, until the check accepts each.
  drop_redundant(chosen);
  look_for_fewer(chosen, effort_.repairs);
  for (int round = 0;; ++round) {
    std::vector<SixPlanes> result = shrunk(chosen, thinnest);
    std::vector<Vector3> refused;
    for (SixPlanes& solid : result) {
      tick(done_);
      for (Plane& plane : solid.planes) plane.offset -= margin;
      if (const std::optional<Vector3> point = check(solid)) refused.push_back(*point);
    }
    if (refused.empty() || round == effort_.checks) return result;
    replace(chosen, refused);
    look_for_fewer(chosen, effort_.repairs / 6);
  }
}

}  // namespace touchstone::fit
