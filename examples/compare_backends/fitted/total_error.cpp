#include "touchstone/examples/compare_backends/fitted/total_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"
#include "touchstone/examples/compare_backends/fitted/clearances.hpp"

namespace touchstone::comparison {
namespace {

using Values = std::vector<double>;  // a pose [m]

// Exact clearances are right to the last bit; this is the rounding of their sums with errors.
constexpr double kRounding = 0x1p-48;

// The mesh's clearance at each pose.
struct Bracket {
  Values low, high;
};

Values exact_clearances(const FittedCover& cover, const ClearancePoses& poses,
                        const BackendRegistry& registry) {
  ClearanceQuery query(cover, poses, registry.make_narrowphase("exact"));
  Values values;
  for (const Pose& X_MP : poses.poses) values.push_back(query(X_MP).value);
  return values;
}

Bracket bracket_of(std::span<const FittedCover> covers, std::span<const Values> exact, std::size_t poses) {
  Bracket bracket{Values(poses, 0.0), Values(poses, kInfinity)};
  for (std::size_t c = 0; c < covers.size(); ++c) {
    for (std::size_t i = 0; i < poses; ++i) {
      bracket.low[i] = std::max(bracket.low[i], exact[c][i]);
      bracket.high[i] = std::min(bracket.high[i], exact[c][i] + covers[c].error);
    }
  }
  for (std::size_t i = 0; i < poses; ++i)
    if (!(bracket.low[i] <= bracket.high[i] * (1.0 + kRounding)))
      reject("fitted", fmt::format("certificates contradict each other: at pose {} one says that the mesh is "
                                   "{:.6g} m away at least, another {:.6g} m at most",
                                   i, bracket.low[i], bracket.high[i]));
  return bracket;
}

void judge(ClearanceQuery& query, const ClearancePoses& poses, const Values& exact, const Bracket& bracket,
           TotalErrorRow& row) {
  std::size_t pairs = 0;
  for (std::size_t i = 0; i < poses.poses.size(); ++i) {
    const Clearance clearance = query(poses.poses[i]);
    pairs += clearance.pairs;
    row.geometry_seen = std::max(row.geometry_seen, bracket.low[i] - exact[i]);
    row.undecided += clearance.is_decided ? 0 : 1;
    if (!clearance.is_known) {
      ++row.unanswered;
      continue;
    }
    row.backend_error = std::max(row.backend_error, std::abs(clearance.value - exact[i]));
    row.total = std::max(
        {row.total, std::abs(clearance.value - bracket.low[i]), std::abs(clearance.value - bracket.high[i])});
  }
  row.pairs = static_cast<double>(pairs) / static_cast<double>(poses.poses.size());
}

// The least that a reading of the clock takes [ns].
double clock_ns() {
  double least = kInfinity;
  for (int i = 0; i < 1000; ++i) {
    const double before = processor_us();
    least = std::min(least, 1e3 * (processor_us() - before));
  }
  return least;
}

// Both figures are of the run whose frames took least. The processor's time counts, without the clock's.
void time(ClearanceQuery& query, const ClearancePoses& poses, int repetitions, TotalErrorRow& row) {
  const auto count = static_cast<double>(poses.poses.size());
  const double clock = clock_ns();
  row.frame_ns = kInfinity;
  for (int i = 0; i < repetitions; ++i) {
    const double before = query.narrowphase_ns(), start = processor_us();
    for (const Pose& X_MP : poses.poses) query(X_MP);
    const double frame_ns = 1e3 * (processor_us() - start) / count - 2.0 * clock;
    if (frame_ns >= row.frame_ns) continue;
    row.frame_ns = frame_ns;
    row.pair_ns = ((query.narrowphase_ns() - before) / count - clock) / row.pairs;
  }
}

}  // namespace

TotalErrors measure_total_errors(std::span<const FittedCover> covers, const ClearancePoses& poses,
                                 const BackendRegistry& registry, std::span<const std::string> backends,
                                 int repetitions, const Progress& progress) {
  // The exact clearances of the covers bracket the mesh's.
  std::vector<Values> exact;
  for (const FittedCover& cover : covers) exact.push_back(exact_clearances(cover, poses, registry));
  const Bracket bracket = bracket_of(covers, exact, poses.poses.size());
  TotalErrors errors;
  for (std::size_t i = 0; i < poses.poses.size(); ++i)
    errors.bracket = std::max(errors.bracket, bracket.high[i] - bracket.low[i]);
  // Each backend is asked about each cover.
  for (std::size_t c = 0; c < covers.size(); ++c) {
    for (const std::string& backend : backends) {
      TotalErrorRow row;
      row.backend = backend;
      row.hexahedra = covers[c].tree.solids().size();
      row.geometry = covers[c].error;
      try {
        ClearanceQuery query(covers[c], poses, registry.make_narrowphase(backend));
        judge(query, poses, exact[c], bracket, row);
        if (repetitions > 0 && row.unanswered == 0) time(query, poses, repetitions, row);
      } catch (const InputError& error) {
        row.refused = error.what();
      }
      errors.rows.push_back(row);
      if (progress)
        progress(static_cast<double>(errors.rows.size()) /
                 static_cast<double>(covers.size() * backends.size()));
    }
  }
  return errors;
}

std::optional<std::size_t> cheapest_within(const TotalErrors& errors, double allowed) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < errors.rows.size(); ++i) {
    const TotalErrorRow& row = errors.rows[i];
    if (!(row.frame_ns > 0.0) || !(row.total <= allowed)) continue;
    if (!best || row.frame_ns < errors.rows[*best].frame_ns) best = i;
  }
  return best;
}

}  // namespace touchstone::comparison
