#include "touchstone/examples/measures/paths/path_truth.hpp"

#include "touchstone/examples/measures/common/parallel.hpp"
#include "touchstone/examples/measures/paths/path_impact.hpp"

#ifdef TOUCHSTONE_HAS_EXACT
#include "touchstone/adapters/exact/exact.hpp"
#endif

namespace touchstone::measures {
namespace {

bool is_contact(const SolidPaths& paths, double s, const Oracle& oracle) {
  const PosedPair posed = posed_at(paths, s);
  return oracle.truth(posed.a, posed.b).contact();
}

/// The first look beyond `lo` that finds a contact; steps double from the resolution of s, so that one which
/// is shorter than its distance from lo may be passed by. None: 2.
double find_contact(const SolidPaths& paths, double lo, const Oracle& oracle) {
  double apart = lo;
  for (double step = 0x1p-50; apart < 1.0; step *= 2) {
    const double s = std::min(1.0, apart + step);
    if (!is_contact(paths, s, oracle)) {
      apart = s;
      continue;
    }
    double contact = s;
    for (double middle; (middle = 0.5 * (apart + contact)) > apart && middle < contact;)
      (is_contact(paths, middle, oracle) ? contact : apart) = middle;
    return contact;
  }
  return 2.0;
}

std::unique_ptr<Narrowphase> make_exact_narrowphase() {
#ifdef TOUCHSTONE_HAS_EXACT
  BackendRegistry registry;
  register_exact(registry);
  return registry.narrowphases().front().make();
#else
  return nullptr;
#endif
}

}  // namespace

std::string_view to_string(PathClass path_class) {
  constexpr std::array<std::string_view, 3> kNames = {"clear", "meets", "open"};
  return kNames[static_cast<std::size_t>(path_class)];
}

PathTruth path_truth(const SolidPaths& paths, const Narrowphase& exact, const Oracle& oracle) {
  if (is_contact(paths, 0.0, oracle)) return {PathClass::open, 0.0, 1.0};
  NarrowphaseQuery query(exact, paths.solids.size());
  const Impact impact = impact_of(paths, {kProofGap * paths.scale}, query);
  if (impact.status == ImpactStatus::clear) return {PathClass::clear, 1.0, 1.0};
  const double hi = find_contact(paths, impact.lo, oracle);
  return hi > 1.0 ? PathTruth{PathClass::open, impact.lo, 1.0} : PathTruth{PathClass::meets, impact.lo, hi};
}

std::vector<PathTruth> compute_path_truth(const PairSet& set, std::size_t poses, const Oracle& oracle,
                                          int threads) {
  std::vector<PathTruth> truth(set.pairs.size() / poses);
  parallel_chunks(truth.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const SolidPaths paths = paths_of(set, poses, i);
      const auto exact = make_exact_narrowphase();
      exact->build(paths.solids);
      truth[i] = path_truth(paths, *exact, oracle);
    }
  });
  return truth;
}

}  // namespace touchstone::measures
