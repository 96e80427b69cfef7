#include "touchstone/contact_core/fit/fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "touchstone/contact_core/fit/excess.hpp"
#include "touchstone/contact_core/fit/meshes/main_axes.hpp"
#include "touchstone/contact_core/fit/search/accepted_solids.hpp"
#include "touchstone/contact_core/fit/search/cover_search.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using fit::AcceptedSolids;
using fit::AllowedSpace;
using fit::Cells;
using fit::CoverSearch;
using fit::LimitBox;
using fit::Prism;
using fit::Sectors;
using fit::SixPlanes;

constexpr double kLeastOver = 0x1p-20;  // of the largest coordinate: distances are still right to 2^-20 of it

constexpr double kFinestCount = 1e-2;  // of the diagonal: below it more hexahedra are what one asks for

void validate(const MeshDistance& mesh, const FitOptions& options) {
  const double least = kLeastOver * mesh.largest_coordinate();
  const auto check = [&](double over, const std::string& what) {
    if (!std::isfinite(over) || !(over > 0.0) || over < least)
      reject("fit", what + " " + figure(over) + " m is not finite and at least " + figure(least) +
                        " m, 2^-20 of the largest coordinate");
  };
  check(options.over, "error");
  if (options.tries < 1) reject("fit", "tries: " + std::to_string(options.tries) + " is not at least 1");
  for (const FitRegion& region : options.regions) {
    check(region.over, "region '" + region.name + "': error");
    if (region.over > options.over)
      reject("fit", "region '" + region.name + "': error " + figure(region.over) +
                        " m is larger than that of the whole, " + figure(options.over) + " m");
    if (!is_finite(region.box.low) || !is_finite(region.box.high) ||
        (region.box.high - region.box.low).minCoeff() < 0.0)
      reject("fit", "region '" + region.name + "': its box is none");
  }
}

// Regions as the search sees them: a quarter of their error wider, so that what a proof looks at across their
// borders keeps to them too.
std::vector<LimitBox> limit_boxes(const FitOptions& options, double share, const Matrix3& axes) {
  std::vector<LimitBox> boxes;
  for (const FitRegion& region : options.regions) {
    const Vector3 wider = Vector3::Constant(0.25 * region.over);
    boxes.push_back({{region.box.low - wider, region.box.high + wider}, share * region.over, axes});
  }
  return boxes;
}

// The mesh, and as the search has it: turned, where its walls then stand along the axes. The rounding of
// turning there and back is a hundredth of what faces stand outside.
struct View {
  const MeshDistance& mesh;
  const MeshDistance& turned;  // the same one where it is not
  std::optional<Matrix3> axes = {};

  Matrix3 turning() const { return axes ? *axes : Matrix3(Matrix3::Identity()); }
  Vector3 there(const Vector3& p) const { return axes ? rotate(*axes, p) : p; }
  std::array<Vector3, 8> corners(const SixPlanes& solid) const {
    std::array<Vector3, 8> vertices = solid.corners();
    if (axes)
      for (Vector3& p : vertices) p = rotate_back(*axes, p);
    return vertices;
  }
};

// Whether hexahedra keep to what is asked, each looked at once, and their figures.
class Measures {
 public:
  Measures(const View& view, const FitOptions& options, std::span<const Prism> prisms)
      : view_(view),
        mesh_(view.mesh),
        options_(options),
        prisms_(prisms),
        accepted_(view.turned.largest_coordinate()) {}

  /// A point that does not keep to it, or that may not, as the search has it.
  std::optional<Vector3> refused(const SixPlanes& solid) {
    const std::array<Vector3, 8> vertices = view_.corners(solid);
    if (about_prism(solid) <= least_over(vertices)) return std::nullopt;
    if (accepted_.holds(solid)) return std::nullopt;
    const std::optional<Vector3>& point = verdict(vertices);
    if (!point) accepted_.add(solid);
    return point ? std::optional<Vector3>(view_.there(*point)) : std::nullopt;
  }

  /// Whether one of them surely has a point that is farther than all of the cover may be.
  bool is_beyond(const std::vector<SixPlanes>& solids) {
    return std::any_of(solids.begin(), solids.end(), [this](const SixPlanes& solid) {
      if (!refused(solid)) return false;
      const std::optional<Vector3>& point = verdict(view_.corners(solid));
      return point && mesh_.to_solid(*point) > options_.over;
    });
  }

  Fit fit(const std::vector<SixPlanes>& solids) {
    // Whether each is known to keep to what is asked.
    std::vector<Measured> all;
    for (const SixPlanes& solid : solids) {
      Measured& each = all.emplace_back(Measured{view_.corners(solid), about_prism(solid), false, {}});
      each.is_accepted = is_slab(each) || !verdict(each.vertices);
      if (options_.progress) options_.progress("measure", 0.0);
    }
    // Those that each region looks at.
    std::vector<std::vector<Measured>> near;
    std::size_t passes = all.size();
    for (const FitRegion& region : options_.regions) {
      near.emplace_back();
      for (const Measured& each : all)
        if (touches(each.vertices, region.box)) near.back().push_back(each);
      passes += near.back().size();
    }
    // How far they reach out, in all and in the regions.
    Ticks ticks{options_, 2 * passes};
    measure(all, options_.over, nullptr, ticks);
    Fit fit;
    for (const Measured& each : all) {
      fit.hexahedra.push_back({each.vertices, each.bound.most, each.bound.where});
      fit.excess = std::max(fit.excess, each.bound.most);
    }
    for (std::size_t r = 0; r < near.size(); ++r) {
      measure(near[r], options_.regions[r].over, &options_.regions[r].box, ticks);
      double& most = fit.region_excess.emplace_back(0.0);
      for (const Measured& each : near[r]) most = std::max(most, each.bound.most);
    }
    return fit;
  }

  /// Tetrahedra looked at so far: what checks cost, the same on every machine.
  std::uint64_t pieces() const { return pieces_; }

 private:
  using Vertices = std::array<Vector3, 8>;
  struct ByCoordinates {
    bool operator()(const Vertices& a, const Vertices& b) const {
      return std::lexicographical_compare(
          a.begin(), a.end(), b.begin(), b.end(), [](const Vector3& p, const Vector3& q) {
            return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
          });
    }
  };

  // No point of it is farther from the solid, as one prism tells; infinite where none does.
  double about_prism(const SixPlanes& solid) const {
    const std::array<Vector3, 8> corners = solid.corners();
    double least = kInfinity;
    for (const Prism& prism : prisms_)
      if (touches(corners, prism.box)) least = std::min(least, prism.bound(corners));
    return least;
  }

  static bool touches(const std::array<Vector3, 8>& vertices, const Bounds& box) {
    Bounds about;
    for (const Vector3& p : vertices) about.add(p);
    return (about.low - box.high).maxCoeff() <= 0.0 && (box.low - about.high).maxCoeff() <= 0.0;
  }

  // That is asked of it somewhere.
  double least_over(const std::array<Vector3, 8>& vertices) const {
    double least = options_.over;
    for (const FitRegion& region : options_.regions)
      if (touches(vertices, region.box)) least = std::min(least, region.over);
    return least;
  }

  // Looked for once of the same vertices.
  const std::optional<Vector3>& verdict(const Vertices& vertices) {
    const auto known = verdicts_.find(vertices);
    return known != verdicts_.end() ? known->second
                                    : verdicts_.emplace(vertices, beyond(vertices)).first->second;
  }

  std::optional<Vector3> beyond(const Vertices& vertices) {
    const auto find = [&](double over, const Bounds* box) {
      return find_beyond(mesh_, vertices, over, over / kClosest, box, kMostPieces, &pieces_);
    };
    std::optional<Vector3> point = find(options_.over, nullptr);
    if (point) return point;
    for (const FitRegion& region : options_.regions) {
      point = find(region.over, &region.box);
      if (point) return point;
    }
    return std::nullopt;
  }

  struct Measured {
    std::array<Vector3, 8> vertices;
    double about;      // no point of it is farther, as one prism tells
    bool is_accepted;  // it keeps to all that is asked
    ExcessBound bound;
  };

  // Says how much is measured, of the whole and of all regions.
  struct Ticks {
    const FitOptions& options;
    std::size_t all, done = 0;

    void again() const {
      if (options.progress) options.progress("measure", static_cast<double>(done) / static_cast<double>(all));
    }
    void next() {
      ++done;
      again();
    }
  };

  // The largest to a thirty-second of what is asked, the others to an eighth, or to what is sure not to be
  // larger.
  void measure(std::vector<Measured>& all, double over, const Bounds* box, Ticks& ticks) const {
    double least = 0.0;  // of the largest
    for (Measured& each : all) {
      each.bound = is_slab(each) ? ExcessBound{0.0, each.about, each.vertices[0]}
                                 : bound(each, over, over / kCoarse, 0.0, box);
      least = std::max(least, each.bound.least);
      ticks.next();
    }
    for (Measured& each : all) {
      // A point that is farther than all before stops the bound; the next one goes on from there.
      while (!is_slab(each) && each.bound.most > least + over / kFine) {
        each.bound = bound(each, over, over / kFine, least + over / kFine, box);
        ticks.again();
        if (each.bound.least <= least) break;
        least = each.bound.least;
      }
      if (each.bound.most > over && each.bound.least < over)  // closer, to tell
        each.bound = judge_excess(mesh_, each.vertices, over, over / kClosest, box);
      ticks.next();
    }
  }

  ExcessBound bound(const Measured& each, double over, double resolution, double enough,
                    const Bounds* box) const {
    return bound_excess(mesh_, each.vertices, resolution, enough, box, kMostPieces,
                        each.is_accepted ? over : kInfinity);
  }

  bool is_slab(const Measured& each) const { return each.about <= least_over(each.vertices); }

  static constexpr double kCoarse = 8.0, kFine = 32.0;  // of what is asked
  static constexpr double kClosest = 512.0;             // of what is asked: to tell whether it is kept to
  static constexpr std::size_t kMostPieces = 200000;    // that a bound looks at
  const View& view_;
  const MeshDistance& mesh_;
  const FitOptions& options_;
  std::span<const Prism> prisms_;
  std::map<Vertices, std::optional<Vector3>, ByCoordinates> verdicts_;
  AcceptedSolids accepted_;
  std::uint64_t pieces_ = 0;
};

bool keeps_to(const Fit& fit, const FitOptions& options) {
  for (std::size_t r = 0; r < options.regions.size(); ++r)
    if (fit.region_excess[r] > options.regions[r].over) return false;
  return fit.excess <= options.over;
}

// Where a search starts: the share of what is allowed that it plans with, and where the solid is cut.
struct Start {
  double share, shift;
};
constexpr std::array<Start, 6> kStarts = {
    {{0.96, 0.0}, {0.98, 0.25}, {0.96, 0.5}, {0.98, 0.0}, {0.96, 0.75}, {0.98, 0.5}}};
constexpr double kVisitsARepair = 1.25e6;     // that a try may take on average for others to follow it
constexpr std::uint64_t kVisitsAPiece = 100;  // that take as long as a check looks at a tetrahedron
constexpr std::size_t kAny = static_cast<std::size_t>(-1);  // number of hexahedra
constexpr std::array<double, 3> kSmallerShares = {0.9, 0.8, 0.65};

// What searches took, and what they did with parts.
struct Record {
  std::uint64_t visits = 0;          // and what was looked at beside, as visits that take as long
  std::vector<std::uint32_t> rings;  // bores that had one, by index; some twice
  std::vector<std::uint32_t> uncovered_rings, uncovered_prisms;

  bool has_uncovered() const { return !uncovered_rings.empty() || !uncovered_prisms.empty(); }
};

// The parts of a mesh that have a cover of a known form.
struct Parts {
  std::vector<RoundPart> rounds;
  std::vector<Prism> prisms;
  std::vector<std::uint32_t> no_rings = {};  // bores whose shells are cut by boxes

  // Leaves those to boxes of which no cover was found, or all where none is named. @return whether there were
  bool leave_to_boxes(const Record& record) {
    if (prisms.empty() && record.rings.empty()) return false;
    const std::vector<std::uint32_t>& rings = record.has_uncovered() ? record.uncovered_rings : record.rings;
    no_rings.insert(no_rings.end(), rings.begin(), rings.end());
    if (!record.has_uncovered()) {
      prisms.clear();
      return true;
    }
    // Steps of one shell go together.
    std::vector<std::uint32_t> shells;
    for (const std::uint32_t i : record.uncovered_prisms) shells.push_back(prisms[i].triangles.front());
    std::erase_if(prisms, [&](const Prism& prism) {
      return std::find(shells.begin(), shells.end(), prism.triangles.front()) != shells.end();
    });
    return true;
  }
};

// Nothing where more than `most` hexahedra are found, or one that goes too far: these are not measured.
std::optional<Fit> fit_within(const View& view, const Parts& parts, const FitOptions& options,
                              const Start& start, std::size_t most, Record& record) {
  // The solid is cut, its parts by themselves.
  const MeshDistance& mesh = view.turned;
  const double share = start.share;
  const std::vector<LimitBox> boxes = limit_boxes(options, share, view.turning());
  AllowedSpace space(mesh, share * options.over, boxes);
  if (options.progress) options.progress("cut", 0.0);
  const std::vector<Sectors> sectors = fit::sectors_about_bores(mesh, parts.rounds, space, parts.no_rings);
  const Cells cells(mesh, space, share * options.over, sectors, start.shift, parts.prisms);
  // A cover of all pieces is looked for.
  fit::SearchEffort effort;
  effort.repairs = options.repairs;
  const std::function<void(double)> progress = [&](double done) {
    if (options.progress) options.progress("search", done);
  };
  CoverSearch search(mesh, cells, space, share * options.over, sectors, parts.prisms, effort, progress);
  const double margin = 0x1p-45 * mesh.largest_coordinate();
  Measures measures(view, options, parts.prisms);
  const std::vector<SixPlanes> solids = search.run(
      options.over / 64.0, margin, [&](const SixPlanes& solid) { return measures.refused(solid); });
  // It is measured.
  record.visits += space.visits() + kVisitsAPiece * measures.pieces();
  record.uncovered_prisms.insert(record.uncovered_prisms.end(), search.uncovered().prisms.begin(),
                                 search.uncovered().prisms.end());
  for (const std::uint32_t i : search.uncovered().rings) record.uncovered_rings.push_back(sectors[i].part);
  for (const Sectors& each : sectors)
    if (each.has_shell()) record.rings.push_back(each.part);
  if (solids.size() > most || measures.is_beyond(solids)) return std::nullopt;
  Fit fit = measures.fit(solids);
  fit.pieces = cells.size();
  return fit;
}

bool is_better(const Fit& fit, const Fit& than) {
  if (fit.hexahedra.size() != than.hexahedra.size()) return fit.hexahedra.size() < than.hexahedra.size();
  return fit.excess < than.excess;
}

// The best of some tries; of none of these, what keeps to all with less to spend.
std::optional<Fit> best_of_tries(const View& view, const Parts& parts, const FitOptions& options,
                                 Record& record) {
  const double budget = kVisitsARepair * options.repairs * options.tries;
  std::optional<Fit> best;
  for (int i = 0; i < options.tries; ++i) {
    // Another try takes what the tries so far took on average.
    if (best && static_cast<double>(record.visits) * (i + 1) / i > budget) break;
    try {
      std::optional<Fit> fit = fit_within(view, parts, options, kStarts[i % kStarts.size()],
                                          best ? best->hexahedra.size() : kAny, record);
      if (fit && keeps_to(*fit, options) && (!best || is_better(*fit, *best))) best = std::move(fit);
    } catch (const InputError&) {  // more memory than it may take; the cover of those before stands
      if (!best) throw;
      break;
    }
  }
  if (best) return best;
  // The search filters; where that let something through, it looks again with less to spend.
  for (const double share : kSmallerShares) {
    std::optional<Fit> fit = fit_within(view, parts, options, {share, 0.0}, kAny, record);
    if (fit && keeps_to(*fit, options)) return fit;
  }
  return std::nullopt;
}

Fit fit_in(const View& view, const FitOptions& options) {
  const std::vector<LimitBox> boxes = limit_boxes(options, 1.0, view.turning());
  Parts parts = {find_round_parts(view.turned), fit::find_prisms(view.turned, options.over, boxes)};
  // Every mesh has a cover of the boxes that it is cut by: those parts that have none of their own are cut
  // so.
  for (;;) {
    Record record;
    if (std::optional<Fit> fit = best_of_tries(view, parts, options, record)) return *std::move(fit);
    if (!parts.leave_to_boxes(record)) break;
  }
  reject("fit", "no cover within " + figure(options.over) + " m was found");
}

}  // namespace

Fit fit_hexahedra(const MeshDistance& mesh, const FitOptions& options) {
  validate(mesh, options);
  // Space is cut along the axes, so that walls along them are cheap.
  const std::optional<Matrix3> axes = fit::turned_frame(mesh.mesh());
  if (!axes) return fit_in({mesh, mesh}, options);
  TriangleMesh triangles = mesh.mesh();
  for (Vector3& p : triangles.vertices) p = rotate(*axes, p);
  const MeshDistance turned(triangles);
  return fit_in({mesh, turned, axes}, options);
}

Fit fit_hexahedra(const TriangleMesh& mesh, const FitOptions& options) {
  validate(mesh);
  return fit_hexahedra(MeshDistance(weld(mesh)), options);
}

Fit fit_count(const TriangleMesh& mesh, std::size_t count, FitOptions options, double* over) {
  validate(mesh);
  return fit_count(MeshDistance(weld(mesh)), count, std::move(options), over);
}

Fit fit_count(const MeshDistance& mesh, std::size_t count, FitOptions options, double* over) {
  const double largest = mesh.bounds().diagonal();
  std::optional<Fit> best;
  double low = 0.0, high = std::min(options.over, largest);
  const auto try_at = [&](double at) {
    options.over = at;
    for (FitRegion& region : options.regions) region.over = std::min(region.over, at);
    Fit fit = fit_hexahedra(mesh, options);
    if (fit.hexahedra.size() > count) return false;
    best = std::move(fit);
    return true;
  };
  while (!try_at(high)) {
    if (high >= largest) reject("fit", "more than " + std::to_string(count) + " hexahedra at any error");
    low = high;
    high = std::min(2.0 * high, largest);
  }
  while (high - low > 0.05 * high && high > kFinestCount * largest) {
    const double middle = 0.5 * (low + high);
    (try_at(middle) ? high : low) = middle;
  }
  if (over != nullptr) *over = high;
  return *best;
}

HexahedronTree make_tree(const Fit& fit, std::string name) {
  std::vector<PlacedHexahedron> solids;
  for (std::size_t i = 0; i < fit.hexahedra.size(); ++i) {
    std::string solid = "h" + std::to_string(i);
    Hexahedron hexahedron = Hexahedron::from_vertices(fit.hexahedra[i].vertices, WarpPolicy::within_tolerance,
                                                      name + "/" + solid);
    solids.push_back({std::move(solid), std::move(hexahedron), Pose()});
  }
  return HexahedronTree(std::move(solids), std::move(name));
}

}  // namespace touchstone
