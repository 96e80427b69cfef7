#include "touchstone/examples/fit/serves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/fit/least_cover.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::fitting {
namespace {

constexpr double kFirst = 64.0;                              // times the tolerance, everywhere
constexpr std::array<double, 2> kBetween = {16.0, 4.0};      // in the zones, on the way to it
constexpr std::array<double, 2> kCoarser = {256.0, 1024.0};  // tried beside kFirst, while there are fewer
constexpr std::array<double, 2> kFiner = {16.0, 4.0};  // tried where none of these is, while there are fewer
constexpr double kCoarsest = 0.25;                     // of the diagonal, of any cover
constexpr int kMostZones = 4;                          // each from a flight that left those before
constexpr int kMostFiner = 2;                          // by 4 each, than the tolerance, for stops' sake
constexpr int kMostTighter = 2;        // zones, each from a flight that needs less than before
constexpr double kWorthTighter = 0.9;  // of the zones' volume before
constexpr double kMostPairs = 1.1;     // times those of the cover whose flight has the fewest

using Clock = std::chrono::steady_clock;

struct TimeIsUp {};

bool stops_as_meshes(const ServesRow& row, double tolerance) {
  return !row.from_meshes || (row.from_meshes->are_alike && row.from_meshes->stops <= tolerance);
}

/// Of two that are held, and both serve or none; see ServesResult::best.
bool is_better(const ServesRow& row, const ServesRow& than) {
  if (row.is_right != than.is_right) return row.is_right;
  if (row.is_uniform != than.is_uniform) return than.is_uniform;  // stands beside what is found
  if (row.serves) return row.hexahedra < than.hexahedra;
  if (!row.is_right) return row.in_zones < than.in_zones;
  // Both are right, and stop things elsewhere than the meshes.
  if (row.from_meshes->are_alike != than.from_meshes->are_alike) return row.from_meshes->are_alike;
  return row.from_meshes->stops < than.from_meshes->stops;
}

class Search {
 public:
  Search(const FitRequest& fit, const ServesRequest& request, program::ProgressLine& progress,
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
      solids_.emplace_back(weld(read.mesh));
    }
    aim_ = tolerance_ = may_meet_each_other(request) ? 0.5 * request.tolerance : request.tolerance;
  }

  ServesResult run() {
    progress_.step("the flight of the meshes themselves");
    own_ = fly_meshes(request_, solids_);
    result_.has_meshes = own_.has_value();
    try {
      approach();
      stop_as_meshes();
      tighten(kFirst);
      look_elsewhere();
      if (request_.with_uniform) add_if_fitted(tolerance_, tolerance_, true);
    } catch (const TimeIsUp&) {
      result_.is_cut = true;
    }
    choose();
    return std::move(result_);
  }

 private:
  // Down to the tolerance; the flight of each cover shows where the next one has to be right.
  void approach() {
    add(kFirst * tolerance_, kFirst * tolerance_, false);
    for (const double times : kBetween) add_if_fitted(times * tolerance_, kFirst * tolerance_, false);
    add_until_held(tolerance_);
  }

  // What meets a mesh at a slant is stopped earlier by more than the error, which is then made smaller.
  void stop_as_meshes() {
    for (int i = 0; i < kMostFiner && result_.rows.back().is_right && !result_.rows.back().serves; ++i) {
      if (!add_until_held(0.25 * aim_)) break;
      aim_ *= 0.25;
    }
    if (!has_one_that_serves()) aim_ = tolerance_;
  }

  // Each flight that leaves its zones has larger ones for the next. False where a row is refused.
  bool add_until_held(double in_zones) {
    for (int i = 0; i < kMostZones; ++i) {
      if (!add_if_fitted(in_zones, kFirst * tolerance_, false)) return false;
      if (result_.rows.back().is_held) break;
    }
    return true;
  }

  // Zones come from a flight with larger errors: that of the cover itself may need less.
  void tighten(double times) {
    const auto volume = [](const std::vector<Bounds>& zones) {
      double sum = 0.0;
      for (const Bounds& zone : zones) sum += (zone.high - zone.low).prod();
      return sum;
    };
    for (int i = 0; i < kMostTighter; ++i) {
      const ServesRow& last = result_.rows.back();
      if (!last.is_held || last.zones.empty()) return;
      double before = 0.0, after = 0.0;
      for (std::size_t m = 0; m < solids_.size(); ++m)
        before += volume(last.zones[m]), after += volume(zones_of(m, times * tolerance_));
      if (after > kWorthTighter * before || !add_if_fitted(aim_, times * tolerance_, false)) return;
    }
  }

  // Coarser elsewhere may take fewer hexahedra, or more where it is hard to keep to the zones: then finer
  // may.
  void look_elsewhere() {
    const auto gains = [&](double times) {
      const std::size_t fewest = fewest_that_serve();
      const std::optional<std::size_t> best = best_row();
      if (add_if_fitted(aim_, times * tolerance_, false)) tighten(times);
      return fewest_that_serve() < fewest || best_row() != best;
    };
    bool has_better = false;
    double before = kFirst;
    for (const double times : kCoarser) {
      if (!is_new(std::exchange(before, times) * tolerance_) || !gains(times)) break;
      has_better = true;
    }
    if (has_better) return;
    for (const double times : kFiner)
      if (is_new(times * tolerance_) && !gains(times)) break;
  }

  // A row that is refused leaves those that stand.
  bool add_if_fitted(double in_zones, double elsewhere, bool is_uniform) {
    try {
      add(in_zones, elsewhere, is_uniform);
      return true;
    } catch (const InputError& error) {
      const std::string where =
          is_uniform ? "everywhere" : fmt::format("in the zones, {:.4g} mm elsewhere", 1e3 * elsewhere);
      result_.left_out.push_back(fmt::format("{:.4g} mm {}: {}", 1e3 * in_zones, where, error.what()));
      return false;
    }
  }

  // Whether covers that keep to an error elsewhere are others than those of any larger one.
  bool is_new(double elsewhere) const {
    return std::any_of(solids_.begin(), solids_.end(), [&](const MeshDistance& solid) {
      return elsewhere < kCoarsest * solid.bounds().diagonal();
    });
  }

  bool has_one_that_serves() const {
    return std::any_of(result_.rows.begin(), result_.rows.end(),
                       [](const ServesRow& row) { return row.serves; });
  }

  std::size_t fewest_that_serve() const {
    std::size_t fewest = std::numeric_limits<std::size_t>::max();
    for (const ServesRow& row : result_.rows)
      if (row.serves) fewest = std::min(fewest, row.hexahedra);
    return fewest;
  }

  double error_elsewhere(std::size_t m, double asked) const {
    return std::min(asked, kCoarsest * solids_[m].bounds().diagonal());
  }

  // Where, of the flight before, the mesh's next cover may come near others: what moves goes on by the error
  // before. Where two covers stand out elsewhere and so come near each other is seen in their flight.
  std::vector<Bounds> zones_of(std::size_t m, double elsewhere) {
    const ServesRow& last = result_.rows.back();
    const double beyond = error_elsewhere(m, elsewhere);
    NearCells near = near_.try_emplace({m, beyond}, solids_[m], beyond).first->second;
    for (const SeenObject& other : last.flight.seen[m]) near.add(other, request_.margin + last.in_zones);
    // Into an opening each flight goes further than the one before; at last as far as among the meshes.
    if (own_ && !last.is_held)
      for (const SeenObject& other : own_->seen[m])
        if (!other.mesh) near.add(other, request_.margin + request_.tolerance);
    return near.boxes();
  }

  struct Covered {
    FitRun run;
    double in_zones;  ///< its largest error in the mesh's zones; in all of it where none was asked for [m]
  };

  struct Known {
    std::size_t m;
    FitRequest asked, kept;  ///< the second: of the error elsewhere that a cover was found with
    FitRun run;
  };

  // A mesh keeps its cover from row to row where nothing else is asked of it.
  Covered fitted(std::size_t m, const ServesRow& row) {
    const FitRequest request = asked(m, row, error_elsewhere(m, row.elsewhere));
    const auto is_same = [&](const Known& known) {
      return known.m == m && known.asked.over.value == request.over.value &&
             known.asked.tries == request.tries &&
             std::equal(known.asked.regions.begin(), known.asked.regions.end(), request.regions.begin(),
                        request.regions.end(), [](const RegionRequest& a, const RegionRequest& b) {
                          return a.over.value == b.over.value && a.low == b.low && a.high == b.high;
                        });
    };
    auto known = std::find_if(known_.begin(), known_.end(), is_same);
    if (known == known_.end()) known = known_.insert(known_.end(), fitted_anew(m, row, request));
    return {known->run, error_in_zones(m, known->run.fit, known->kept, row)};
  }

  // Where no cover keeps to both, one that is finer elsewhere may.
  Known fitted_anew(std::size_t m, const ServesRow& row, const FitRequest& first) const {
    for (double over = error_elsewhere(m, row.elsewhere);; over *= 0.25) {
      const FitRequest request = asked(m, row, over);
      try {
        return {m, first, request, run_fit(request_.meshes[m].file, request, progress_)};
      } catch (const InputError&) {
        if (over <= row.asked_in_zones || row.is_uniform) throw;
      }
    }
  }

  // The regions are the user's, then the zones, then the bores that stay open.
  double error_in_zones(std::size_t m, const Fit& fit, const FitRequest& asked, const ServesRow& row) const {
    // Without a zone of its own a mesh is nowhere met.
    if (!row.zones.empty() && row.zones[m].empty()) return 0.0;
    const std::size_t begin = fit_.regions.size(), end = asked.regions.size();
    if (begin == end) return fit.excess;
    return *std::max_element(fit.region_excess.begin() + static_cast<std::ptrdiff_t>(begin),
                             fit.region_excess.begin() + static_cast<std::ptrdiff_t>(end));
  }

  FitRequest asked(std::size_t m, const ServesRow& row, double over) const {
    FitRequest asked = fit_;
    asked.input = request_.meshes[m].input;
    asked.over = {over, false};
    if (row.asked_in_zones > tolerance_) asked.tries = 1;
    // Corners in the units of the file, as a region of the command line has them.
    if (!row.zones.empty() && row.asked_in_zones < over)
      for (const Bounds& zone : row.zones[m])
        asked.regions.push_back({fmt::format("zone {}", asked.regions.size()),
                                 {row.asked_in_zones, false},
                                 zone.low / scales_[m],
                                 zone.high / scales_[m]});
    return asked;
  }

  void add(double in_zones, double elsewhere, bool is_uniform) {
    ServesRow row;
    row.asked_in_zones = in_zones;
    row.elsewhere = elsewhere;
    row.is_uniform = is_uniform;
    // The first row has no flight before it, and a uniform one needs none.
    if (!is_uniform && !result_.rows.empty())
      for (std::size_t m = 0; m < solids_.size(); ++m) row.zones.push_back(zones_of(m, elsewhere));
    row.is_held = true;
    std::vector<double> errors;
    for (std::size_t m = 0; m < solids_.size(); ++m) {
      progress_.step(fmt::format("'{}', {:.4g} mm in the zones, {:.4g} mm elsewhere",
                                 request_.meshes[m].object, 1e3 * in_zones, 1e3 * elsewhere));
      Covered covered = fitted(m, row);
      errors.push_back(covered.in_zones);
      row.runs.push_back(std::move(covered.run));
      row.hexahedra += row.runs.back().fit.hexahedra.size();
      row.is_held = row.is_held && row.runs.back().verdict.is_proven;
    }
    // It is flown with these covers, and looked at for whether others stayed within the zones.
    std::vector<const Fit*> covers;
    for (const FitRun& run : row.runs) covers.push_back(&run.fit);
    row.flight = fly_scene(request_, covers);
    for (std::size_t m = 0; m < solids_.size(); ++m) {
      const std::vector<Bounds> boxes = part_boxes(make_tree(row.runs[m].fit, "cover"));
      for (const SeenObject& other : row.flight.seen[m]) {
        const double theirs = other.mesh ? errors[*other.mesh] : 0.0;
        row.in_zones = std::max(row.in_zones, errors[m] + theirs);
        if (!row.zones.empty())
          row.is_held = row.is_held && are_held(boxes, other, request_.margin, row.zones[m]);
      }
    }
    row.is_right = row.is_held && row.in_zones <= request_.tolerance;
    if (own_) row.from_meshes = difference(*own_, row.flight);
    row.serves = row.is_right && stops_as_meshes(row, request_.tolerance);
    result_.rows.push_back(std::move(row));
    if (on_row_) on_row_(result_.rows.back());
  }

  std::optional<std::size_t> best_row() const {
    // As many pairs as a row that serves may look at.
    double most_pairs = std::numeric_limits<double>::infinity();
    const bool one_serves = has_one_that_serves();
    for (const ServesRow& row : result_.rows)
      if (row.serves && !row.is_uniform)
        most_pairs = std::min(most_pairs, kMostPairs * static_cast<double>(row.flight.pairs));
    std::optional<std::size_t> best;
    for (std::size_t i = 0; i < result_.rows.size(); ++i) {
      const ServesRow& row = result_.rows[i];
      if (!row.is_held || row.serves != one_serves) continue;
      if (row.serves && !row.is_uniform && static_cast<double>(row.flight.pairs) > most_pairs) continue;
      if (!best || is_better(row, result_.rows[*best])) best = i;
    }
    return best;
  }

  void choose() {
    result_.best = best_row();
    if (!result_.best || !result_.rows[*result_.best].is_right) return;
    // Without a zone a mesh needs one hexahedron, as any does. Where errors add up, one of two meshes may
    // have all of the tolerance.
    const ServesRow& best = result_.rows[*result_.best];
    for (std::size_t m = 0; m < solids_.size(); ++m)
      result_.least +=
          best.zones.empty() ? 1 : least_hexahedra(solids_[m], best.zones[m], request_.tolerance);
  }

  FitRequest fit_;
  std::vector<Known> known_;
  std::map<std::pair<std::size_t, double>, NearCells> near_;  ///< by mesh and how far, nothing marked
  const ServesRequest& request_;
  program::ProgressLine& progress_;
  const std::function<void(const ServesRow&)>& on_row_;
  Clock::time_point start_;
  std::vector<double> scales_;
  std::vector<MeshDistance> solids_;
  double tolerance_;                 ///< of a mesh [m]
  double aim_;                       ///< in the zones; smaller than it where stops ask for that [m]
  std::optional<ServedFlight> own_;  ///< with the meshes themselves
  ServesResult result_;
};

std::string clearance_text(const ServesRow& row) {
  return std::isfinite(row.flight.least_clearance) ? fmt::format("{:.4g}", 1e3 * row.flight.least_clearance)
                                                   : "> margin";
}

/// From where the meshes themselves stop things.
std::string off_text(const ServesRow& row) {
  if (!row.from_meshes) return "?";
  return row.from_meshes->are_alike ? fmt::format("{:.3g}", 1e3 * row.from_meshes->stops) : "other contacts";
}

double pairs_a_frame(const ServesRow& row, const ServesRequest& request) {
  return static_cast<double>(row.flight.pairs) / static_cast<double>(request.scene.frame_count() - 1);
}

std::string zones_text(const ServesRow& row, const ServesRequest& request) {
  const auto corner = [](const Vector3& p) {
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", p.x(), p.y(), p.z());
  };
  std::string text;
  for (std::size_t m = 0; m < row.zones.size(); ++m) {
    const std::string& object = request.meshes[m].object;
    if (row.zones[m].empty()) text += fmt::format("zones in '{}': none, nothing comes near it\n", object);
    for (const Bounds& zone : row.zones[m])
      text += fmt::format("zone in '{}': {} to {} m\n", object, corner(zone.low), corner(zone.high));
  }
  return text +
         fmt::format(
             "zones are where others come near in scene '{}', and {:.4g} mm about that; clearances up to "
             "it are the meshes' to the error in the zones, also where something is stopped\n",
             request.scene.name, 1e3 * request.margin);
}

/// Whether covers that serve, which are right to the tolerance in other places, stop things where the best
/// one does; said where it is not known where the meshes do.
std::string agreement_text(const ServesResult& result, const ServesRequest& request) {
  const ServesRow& best = result.rows[*result.best];
  std::size_t others = 0, unlike = 0;
  double stops = 0.0;
  for (const ServesRow& row : result.rows) {
    if (&row == &best || !row.serves) continue;
    const FlightDifference apart = difference(best.flight, row.flight);
    ++others;
    if (apart.are_alike)
      stops = std::max(stops, apart.stops);
    else
      ++unlike;
  }
  if (others == 0) return "";
  if (unlike == 0 && stops <= request.tolerance)
    return fmt::format("of {} more that serve, contacts are the same, and stops at most {:.3g} mm apart\n",
                       others, 1e3 * stops);
  return fmt::format(
      "STOPS ARE NOT SURE: of {} more that serve, {} have other contacts, and stops of the rest are up to "
      "{:.3g} mm apart: something meets the mesh at a slant, or barely; clearances hold\n",
      others, unlike, 1e3 * stops);
}

/// Where the best one stops things beside where the meshes themselves do, and which others are refused for
/// that.
std::string stops_text(const ServesResult& result, const ServesRequest& request) {
  if (!result.has_meshes)
    return "the meshes' triangles could not be flown: where they stop things is not known\n" +
           agreement_text(result, request);
  const ServesRow& best = result.rows[*result.best];
  const auto refused = std::count_if(result.rows.begin(), result.rows.end(),
                                     [](const ServesRow& row) { return row.is_right && !row.serves; });
  std::string text;
  if (best.serves)
    text = fmt::format(
        "its contacts are those of the meshes' own triangles, and what it stops is at most {:.3g} mm off\n",
        1e3 * best.from_meshes->stops);
  else
    text = fmt::format(
        "STOPS ARE NOT SURE: no cover was found that stops things within the tolerance of where the meshes' "
        "own triangles do; the best {}: something meets the mesh at a slant, or barely; clearances hold\n",
        best.from_meshes->are_alike ? fmt::format("is {:.3g} mm off", 1e3 * best.from_meshes->stops)
                                    : "has other contacts");
  if (best.serves && refused > 0)
    text += fmt::format("{} more are right to the tolerance, but stop things elsewhere: they do not serve\n",
                        refused);
  return text;
}

}  // namespace

FlightDifference difference(const ServedFlight& some, const ServedFlight& other) {
  FlightDifference apart;
  for (std::size_t i = 0; i < std::min(some.places.size(), other.places.size()); ++i)
    apart.frames = std::max(apart.frames, norm(some.places[i] - other.places[i]));
  const auto are_of_same = [](const std::vector<ToldContact>& a, const std::vector<ToldContact>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const ToldContact& p, const ToldContact& q) {
      return p.a == q.a && p.b == q.b && p.began == q.began;
    });
  };
  const auto off = [](const ToldContact& a, const ToldContact& b) {
    return std::max(norm(a.p_WA - b.p_WA), norm(a.p_WB - b.p_WB));
  };
  apart.are_alike = are_of_same(some.contacts, other.contacts) && are_of_same(some.stops, other.stops);
  if (!apart.are_alike) return apart;
  for (std::size_t i = 0; i < some.contacts.size(); ++i) {
    const ToldContact &a = some.contacts[i], &b = other.contacts[i];
    double& times = a.began ? apart.begins : apart.ends;
    times = std::max(times, std::abs(a.time - b.time));
    if (a.began) apart.stops = std::max(apart.stops, off(a, b));
  }
  for (std::size_t i = 0; i < some.stops.size(); ++i)
    apart.stops = std::max(apart.stops, off(some.stops[i], other.stops[i]));
  return apart;
}

ServesResult find_coarsest(const FitRequest& fit, const ServesRequest& request,
                           program::ProgressLine& progress,
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
  program::TextTable table({"in zones, elsewhere [mm]", "hexahedra", "error in zones [mm]", "proof",
                            "in zones", "first contact [s]", "stops off [mm]", "least clearance [mm]",
                            "pairs a frame", "frame [us]", "worst", "serves"});
  // Covers that do not serve are shown, too.
  for (const ServesRow& row : result.rows) {
    const bool is_proven = std::all_of(row.runs.begin(), row.runs.end(),
                                       [](const FitRun& run) { return run.verdict.is_proven; });
    table.add({row.is_uniform ? fmt::format("{:.4g} everywhere", 1e3 * row.asked_in_zones)
                              : fmt::format("{:.4g}, {:.4g}", 1e3 * row.asked_in_zones, 1e3 * row.elsewhere),
               std::to_string(row.hexahedra), fmt::format("{:.4g}", 1e3 * row.in_zones),
               is_proven ? "proven" : "REFUSED", row.is_held ? "stays" : "leaves",
               row.flight.first_contact ? fmt::format("{:.6f}", *row.flight.first_contact) : "-",
               off_text(row), clearance_text(row), fmt::format("{:.2f}", pairs_a_frame(row, request)),
               fmt::format("{:.1f}", row.flight.frame_us), fmt::format("{:.0f}", row.flight.slowest_us),
               row.serves ? "yes" : "no"});
  }
  std::string text = table.str() + "\n";
  if (result.best) text += zones_text(result.rows[*result.best], request);
  for (const std::string& row : result.left_out) text += fmt::format("left out: {}\n", row);
  if (result.is_cut) text += fmt::format("the time was up after {:.4g} s\n", *request.seconds);
  // The search may end without a cover within the tolerance.
  if (!result.best) return text + "no cover is right to any error\n";
  const ServesRow& best = result.rows[*result.best];
  if (!best.is_right)
    return text + fmt::format(
                      "no cover within the tolerance was found; the best so far is right to {:.4g} mm, "
                      "with {} hexahedra\n",
                      1e3 * best.in_zones, best.hexahedra);
  text +=
      fmt::format("coarsest that {}: {} hexahedra, {:.4g} mm elsewhere\n",
                  best.serves ? "serves" : "is right to the tolerance", best.hexahedra, 1e3 * best.elsewhere);
  if (result.least > 0)
    text += fmt::format(
        "any cover that is right to the tolerance in these zones needs at least {}: the meshes have as many "
        "points, no two of which one convex part of such a cover can hold\n",
        result.least);
  return text + stops_text(result, request);
}

std::string comparison_text(const ServesResult& result, const ServesRequest& request) {
  const auto uniform = std::find_if(result.rows.begin(), result.rows.end(),
                                    [](const ServesRow& row) { return row.is_uniform; });
  if (!result.best || uniform == result.rows.end()) return "";
  const ServesRow& best = result.rows[*result.best];
  const auto times_fewer = [&](std::size_t count) {
    return static_cast<double>(uniform->hexahedra) / static_cast<double>(count);
  };
  // Differences are against the uniform cover's flight.
  program::TextTable table({"scene", "cover", "hexahedra", "certified error [mm]", "contacts",
                            "begins differ [ms]", "ends differ [ms]", "stops differ [mm]",
                            "in any frame [mm]", "clearances differ [mm]", "pairs a frame", "frame [us]",
                            "99.9 % [us]"});
  for (const ServesRow* row : {&*uniform, &best}) {
    const ServedFlight &flight = row->flight, &other = uniform->flight;
    const FlightDifference apart = difference(flight, other);
    const auto of_alike = [&](double what) {
      return apart.are_alike ? fmt::format("{:.3g}", 1e3 * what) : "-";
    };
    const double clearance = flight.least_clearance == other.least_clearance
                                 ? 0.0
                                 : std::abs(flight.least_clearance - other.least_clearance);
    table.add({request.scene.name, row == &best ? "fitted to the task" : "uniform error",
               std::to_string(row->hexahedra), fmt::format("{:.3g}", 1e3 * row->in_zones),
               fmt::format("{}{}", flight.contacts.size(), apart.are_alike ? "" : ", others"),
               of_alike(apart.begins), of_alike(apart.ends), of_alike(apart.stops),
               fmt::format("{:.3g}", 1e3 * apart.frames), fmt::format("{:.3g}", 1e3 * clearance),
               fmt::format("{:.2f}", pairs_a_frame(*row, request)), fmt::format("{:.1f}", flight.frame_us),
               fmt::format("{:.1f}", flight.frame_999_us)});
  }
  return table.str() +
         "stops: where objects are as contacts begin; any frame: also where one flight is released a frame "
         "before the other, and goes on to where it is commanded to be\n" +
         fmt::format("{:.3g} times fewer hexahedra{}, {:.3g} times as short a frame\n",
                     times_fewer(best.hexahedra),
                     result.least == 0
                         ? ""
                         : fmt::format(" (at most {:.3g} times with any cover that is right in these zones)",
                                       times_fewer(result.least)),
                     uniform->flight.frame_us / best.flight.frame_us) +
         (best.flight.pairs > uniform->flight.pairs
              ? "its frames look at more pairs than those of the uniform error: more of its hexahedra are "
                "near what is held there, and none that was found and serves has fewer\n"
              : "");
}

}  // namespace touchstone::fitting
