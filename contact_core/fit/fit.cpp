#include "touchstone/contact_core/fit/fit.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "touchstone/contact_core/fit/cover_search.hpp"
#include "touchstone/contact_core/fit/excess.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using fit::AllowedSpace;
using fit::Cells;
using fit::CoverSearch;
using fit::LimitBox;
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
std::vector<LimitBox> limit_boxes(const FitOptions& options, double share) {
  std::vector<LimitBox> boxes;
  for (const FitRegion& region : options.regions) {
    const Vector3 wider = Vector3::Constant(0.25 * region.over);
    boxes.push_back({{region.box.low - wider, region.box.high + wider}, share * region.over});
  }
  return boxes;
}

Fit measured(const MeshDistance& mesh, const std::vector<SixPlanes>& solids, const FitOptions& options) {
  Fit fit;
  fit.region_excess.assign(options.regions.size(), 0.0);
  for (std::size_t i = 0; i < solids.size(); ++i) {
    const std::array<Vector3, 8> vertices = solids[i].corners();
    ExcessBound bound = bound_excess(mesh, vertices, options.over / 32.0);
    if (bound.most > options.over && bound.least < options.over)  // closer, to tell
      bound = bound_excess(mesh, vertices, options.over / 512.0, options.over);
    fit.hexahedra.push_back({vertices, bound.most, bound.where});
    fit.excess = std::max(fit.excess, bound.most);
    for (std::size_t r = 0; r < options.regions.size(); ++r) {
      const FitRegion& region = options.regions[r];
      const ExcessBound in_region = bound_excess(mesh, vertices, region.over / 32.0, 0.0, &region.box);
      fit.region_excess[r] = std::max(fit.region_excess[r], in_region.most);
    }
    if (options.progress)
      options.progress("measure", static_cast<double>(i + 1) / static_cast<double>(solids.size()));
  }
  return fit;
}

bool keeps_to(const Fit& fit, const FitOptions& options) {
  for (std::size_t r = 0; r < options.regions.size(); ++r)
    if (fit.region_excess[r] > options.regions[r].over) return false;
  return fit.excess <= options.over;
}

Fit fit_within(const MeshDistance& mesh, const FitOptions& options, double share) {
  const std::vector<LimitBox> boxes = limit_boxes(options, share);
  AllowedSpace space(mesh, share * options.over, boxes);
  if (options.progress) options.progress("cut", 0.0);
  const Cells cells(mesh, space, share * options.over);
  fit::SearchEffort effort;
  effort.repairs = options.repairs;
  const std::function<void(double)> progress = [&](double done) {
    if (options.progress) options.progress("search", done);
  };
  CoverSearch search(mesh, cells, space, share * options.over, effort, progress);
  const double margin = 0x1p-45 * mesh.largest_coordinate();
  Fit fit = measured(mesh, search.run(options.over / 64.0, margin), options);
  fit.pieces = cells.size();
  return fit;
}

Fit fit_prepared(const MeshDistance& mesh, const FitOptions& options) {
  validate(mesh, options);
  // The search filters; where that let something through, it looks again with less to spend.
  for (const double share : {0.96, 0.9, 0.8, 0.65}) {
    Fit fit = fit_within(mesh, options, share);
    if (keeps_to(fit, options)) return fit;
  }
  reject("fit", "no cover within " + figure(options.over) + " m was found");
}

}  // namespace

Fit fit_hexahedra(const TriangleMesh& mesh, const FitOptions& options) {
  validate(mesh);
  return fit_prepared(MeshDistance(weld(mesh)), options);
}

Fit fit_count(const TriangleMesh& mesh, std::size_t count, FitOptions options, double* over) {
  validate(mesh);
  const MeshDistance distance(weld(mesh));
  const double largest = distance.bounds().diagonal();
  std::optional<Fit> best;
  double low = 0.0, high = std::min(options.over, largest);
  const auto try_at = [&](double at) {
    options.over = at;
    for (FitRegion& region : options.regions) region.over = std::min(region.over, at);
    Fit fit = fit_prepared(distance, options);
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
