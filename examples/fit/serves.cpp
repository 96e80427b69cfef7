#include "touchstone/examples/fit/serves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::fitting {
namespace {

constexpr double kFirst = 64.0;                              // times the tolerance, everywhere
constexpr std::array<double, 2> kBetween = {16.0, 4.0};      // in the zones, on the way to it
constexpr std::array<double, 2> kElsewhere = {256.0, 16.0};  // tried beside kFirst
constexpr double kCoarsest = 0.25;                           // of the diagonal, of any cover
constexpr int kMostZones = 4;                                // each from a flight that left those before

using Clock = std::chrono::steady_clock;

struct TimeIsUp {};

Bounds grown(const Bounds& box, double by) {
  return {box.low - Vector3::Constant(by), box.high + Vector3::Constant(by)};
}

bool holds(const Bounds& outer, const Bounds& inner) {
  return (inner.low - outer.low).minCoeff() >= 0.0 && (outer.high - inner.high).minCoeff() >= 0.0;
}

Bounds bounds_of(const Fit& fit) {
  Bounds bounds;
  for (const FittedHexahedron& each : fit.hexahedra)
    for (const Vector3& p : each.vertices) bounds.add(p);
  return bounds;
}

/// Whether each box, grown by the margin, is in one zone as far as the cover reaches.
bool are_held(std::span<const Bounds> swept, double margin, const Fit& fit, std::span<const Bounds> zones) {
  const Bounds cover = bounds_of(fit);
  return std::all_of(swept.begin(), swept.end(), [&](const Bounds& each) {
    Bounds wanted = grown(each, margin);
    wanted = {wanted.low.cwiseMax(cover.low), wanted.high.cwiseMin(cover.high)};
    return (wanted.high - wanted.low).minCoeff() < 0.0 ||
           std::any_of(zones.begin(), zones.end(), [&](const Bounds& zone) { return holds(zone, wanted); });
  });
}

class Search {
 public:
  Search(const FitRequest& fit, const ServesRequest& request, comparison::ProgressLine& progress,
         const std::function<void(const ServesRow&)>& on_row)
      : fit_(fit), request_(request), progress_(progress), on_row_(on_row), start_(Clock::now()) {
    fit_.page = fit_.training = false;
    fit_.samples = 0;
    fit_.levels.clear();
    if (request.seconds)
      fit_.on_progress = [this] {
        if (std::chrono::duration<double>(Clock::now() - start_).count() > *request_.seconds)
          throw TimeIsUp();
      };
    for (const ServedMesh& mesh : request.meshes) {
      const ReadMesh read = read_mesh(mesh.file, mesh.input);
      scales_.push_back(read.metres_per_unit);
      bounds_.push_back(MeshDistance(weld(read.mesh)).bounds());
    }
  }

  ServesResult run() {
    try {
      approach();
      look_elsewhere();
      if (request_.with_uniform) add(request_.tolerance, request_.tolerance, true);
    } catch (const TimeIsUp&) {
      result_.is_cut = true;
    }
    choose();
    return std::move(result_);
  }

 private:
  // Down to the tolerance; the flight of each cover says where the next one has to be right.
  void approach() {
    const double tolerance = request_.tolerance;
    add(kFirst * tolerance, kFirst * tolerance, false);
    for (const double times : kBetween) {
      set_zones();
      add(times * tolerance, kFirst * tolerance, false);
    }
    for (int i = 0; i < kMostZones; ++i) {
      set_zones();
      add(tolerance, kFirst * tolerance, false);
      if (result_.rows.back().is_held) return;
    }
  }

  // Coarser elsewhere may take fewer hexahedra, or more where it is hard to keep to the zones.
  void look_elsewhere() {
    for (const double times : kElsewhere) {
      const double elsewhere = times * request_.tolerance;
      const bool is_new = std::any_of(bounds_.begin(), bounds_.end(), [&](const Bounds& bounds) {
        return std::min(elsewhere, kFirst * request_.tolerance) < kCoarsest * bounds.diagonal();
      });
      if (is_new) add(request_.tolerance, elsewhere, false);
    }
  }

  void set_zones() {
    const ServesRow& last = result_.rows.back();
    result_.zones.clear();
    for (std::size_t m = 0; m < bounds_.size(); ++m) {
      const double reach = kCoarsest * bounds_[m].diagonal();
      result_.zones.push_back(
          zones_about(last.flight.swept[m], request_.margin + last.in_zones, grown(bounds_[m], reach)));
    }
  }

  struct Covered {
    FitRun run;
    double in_zones;  ///< its largest error in the mesh's zones; in all of it where none was asked for [m]
  };

  // Where no cover keeps to both, one that is finer elsewhere may.
  Covered fitted(std::size_t m, double in_zones, double elsewhere, bool is_uniform) const {
    for (double over = std::min(elsewhere, kCoarsest * bounds_[m].diagonal());; over *= 0.25) {
      const FitRequest request = asked(m, in_zones, over, is_uniform);
      try {
        FitRun run = run_fit(request_.meshes[m].file, request, progress_);
        const double error = error_in_zones(m, run.fit, request, is_uniform);
        return {std::move(run), error};
      } catch (const InputError&) {
        if (over <= in_zones || is_uniform) throw;
      }
    }
  }

  // The regions are the user's, then the zones, then the bores that stay open.
  double error_in_zones(std::size_t m, const Fit& fit, const FitRequest& asked, bool is_uniform) const {
    // Without a zone of its own a mesh is nowhere met.
    if (!is_uniform && !result_.zones.empty() && result_.zones[m].empty()) return 0.0;
    const std::size_t begin = fit_.regions.size(), end = asked.regions.size();
    if (begin == end) return fit.excess;
    return *std::max_element(fit.region_excess.begin() + static_cast<std::ptrdiff_t>(begin),
                             fit.region_excess.begin() + static_cast<std::ptrdiff_t>(end));
  }

  FitRequest asked(std::size_t m, double in_zones, double over, bool is_uniform) const {
    FitRequest asked = fit_;
    asked.input = request_.meshes[m].input;
    asked.over = {over, false};
    if (in_zones > request_.tolerance) asked.tries = 1;
    // Corners in the units of the file, as a region of the command line has them.
    if (!is_uniform && !result_.zones.empty() && in_zones < over)
      for (const Bounds& zone : result_.zones[m])
        asked.regions.push_back({fmt::format("zone {}", asked.regions.size()),
                                 {in_zones, false},
                                 zone.low / scales_[m],
                                 zone.high / scales_[m]});
    return asked;
  }

  void add(double in_zones, double elsewhere, bool is_uniform) {
    ServesRow row;
    row.asked_in_zones = in_zones;
    row.elsewhere = elsewhere;
    row.is_uniform = is_uniform;
    // Every mesh is covered to these errors.
    bool is_proven = true;
    std::vector<const Fit*> covers;
    for (std::size_t m = 0; m < bounds_.size(); ++m) {
      progress_.step(fmt::format("'{}', {:.4g} mm in the zones, {:.4g} mm elsewhere",
                                 request_.meshes[m].object, 1e3 * in_zones, 1e3 * elsewhere));
      Covered covered = fitted(m, in_zones, elsewhere, is_uniform);
      row.in_zones = std::max(row.in_zones, covered.in_zones);
      row.runs.push_back(std::move(covered.run));
      const FitRun& run = row.runs.back();
      row.hexahedra += run.fit.hexahedra.size();
      is_proven = is_proven && run.verdict.is_proven;
    }
    // The scene is flown on the covers; they serve where the errors hold where it went.
    for (const FitRun& run : row.runs) covers.push_back(&run.fit);
    row.flight = fly_scene(request_, covers);
    row.is_held = is_proven;
    for (std::size_t m = 0; m < bounds_.size() && !is_uniform && !result_.zones.empty(); ++m)
      row.is_held =
          row.is_held && are_held(row.flight.swept[m], request_.margin, row.runs[m].fit, result_.zones[m]);
    row.serves = row.is_held && row.in_zones <= request_.tolerance;
    result_.rows.push_back(std::move(row));
    if (on_row_) on_row_(result_.rows.back());
  }

  void choose() {
    const auto is_better = [](const ServesRow& row, const ServesRow& than) {
      if (row.serves != than.serves) return row.serves;
      return row.serves ? row.hexahedra < than.hexahedra : row.in_zones < than.in_zones;
    };
    for (std::size_t i = 0; i < result_.rows.size(); ++i)
      if (result_.rows[i].is_held &&
          (!result_.best || is_better(result_.rows[i], result_.rows[*result_.best])))
        result_.best = i;
  }

  FitRequest fit_;
  const ServesRequest& request_;
  comparison::ProgressLine& progress_;
  const std::function<void(const ServesRow&)>& on_row_;
  Clock::time_point start_;
  std::vector<double> scales_;
  std::vector<Bounds> bounds_;
  ServesResult result_;
};

std::string clearance_text(const ServesRow& row) {
  return std::isfinite(row.flight.least_clearance) ? fmt::format("{:.4g}", 1e3 * row.flight.least_clearance)
                                                   : "> margin";
}

/// The farthest that what moves is in one flight from where it is in the other at the same time [m].
double apart(const ServedFlight& a, const ServedFlight& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < std::min(a.places.size(), b.places.size()); ++i)
    most = std::max(most, norm(a.places[i] - b.places[i]));
  return most;
}

std::string zones_text(const ServesResult& result, const ServesRequest& request) {
  const auto corner = [](const Vector3& p) {
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", p.x(), p.y(), p.z());
  };
  std::string text;
  for (std::size_t m = 0; m < result.zones.size(); ++m) {
    const std::string& object = request.meshes[m].object;
    if (result.zones[m].empty()) text += fmt::format("zones in '{}': none, nothing comes near it\n", object);
    for (const Bounds& zone : result.zones[m])
      text += fmt::format("zone in '{}': {} to {} m\n", object, corner(zone.low), corner(zone.high));
  }
  return text + fmt::format(
                    "zones are where scene '{}' moves, and {:.4g} mm about it; clearances up to that, stops "
                    "and first contacts are the meshes' to the error in the zones\n",
                    request.scene.name, 1e3 * request.margin);
}

std::string uniform_text(const ServesRow& best, const ServesRow& uniform) {
  return fmt::format(
      "beside {:.4g} mm everywhere: {:.3g} times as few hexahedra, {:.3g} times as short a frame; what moves "
      "is at most {:.4g} mm from where it is there\n",
      1e3 * uniform.asked_in_zones,
      static_cast<double>(uniform.hexahedra) / static_cast<double>(best.hexahedra),
      uniform.flight.frame_us / best.flight.frame_us, 1e3 * apart(best.flight, uniform.flight));
}

}  // namespace

ServesResult find_coarsest(const FitRequest& fit, const ServesRequest& request,
                           comparison::ProgressLine& progress,
                           const std::function<void(const ServesRow&)>& on_row) {
  validate(request);
  return Search(fit, request, progress, on_row).run();
}

std::string row_text(const ServesRow& row) {
  return fmt::format("{:.4g} mm in the zones, {:.4g} mm elsewhere: {} hexahedra, {:.4g} mm in the zones {}\n",
                     1e3 * row.asked_in_zones, 1e3 * row.elsewhere, row.hexahedra, 1e3 * row.in_zones,
                     row.is_held ? "proven" : "where the flight leaves them");
}

std::string serves_text(const ServesResult& result, const ServesRequest& request) {
  comparison::TextTable table({"in zones, elsewhere [mm]", "hexahedra", "error in zones [mm]", "proof",
                               "in zones", "first contact [s]", "least clearance [mm]", "frame [us]", "worst",
                               "serves"});
  // Covers that do not serve are shown, too.
  const ServesRow* uniform = nullptr;
  for (const ServesRow& row : result.rows) {
    const bool is_proven = std::all_of(row.runs.begin(), row.runs.end(),
                                       [](const FitRun& run) { return run.verdict.is_proven; });
    if (row.is_uniform) uniform = &row;
    table.add({row.is_uniform ? fmt::format("{:.4g} everywhere", 1e3 * row.asked_in_zones)
                              : fmt::format("{:.4g}, {:.4g}", 1e3 * row.asked_in_zones, 1e3 * row.elsewhere),
               std::to_string(row.hexahedra), fmt::format("{:.4g}", 1e3 * row.in_zones),
               is_proven ? "proven" : "REFUSED", row.is_held ? "stays" : "leaves",
               row.flight.first_contact ? fmt::format("{:.6f}", *row.flight.first_contact) : "-",
               clearance_text(row), fmt::format("{:.1f}", row.flight.frame_us),
               fmt::format("{:.0f}", row.flight.slowest_us), row.serves ? "yes" : "no"});
  }
  std::string text = table.str() + "\n" + zones_text(result, request);
  if (result.is_cut) text += fmt::format("the time was up after {:.4g} s\n", *request.seconds);
  // The search may end without a cover within the tolerance.
  if (!result.best) return text + "no cover is right to any error\n";
  const ServesRow& best = result.rows[*result.best];
  if (!best.serves)
    return text + fmt::format(
                      "no cover within the tolerance was found; the best so far is right to {:.4g} mm, "
                      "with {} hexahedra\n",
                      1e3 * best.in_zones, best.hexahedra);
  text += fmt::format("coarsest that serves: {} hexahedra, {:.4g} mm elsewhere\n", best.hexahedra,
                      1e3 * best.elsewhere);
  return uniform != nullptr && uniform != &best ? text + uniform_text(best, *uniform) : text;
}

}  // namespace touchstone::fitting
