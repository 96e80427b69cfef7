#pragma once

#include <optional>
#include <string>
#include <vector>

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/measures/common/quantiles.hpp"
#include "touchstone/examples/measures/runs/swarm.hpp"
#include "touchstone/examples/measures/truth/oracle.hpp"

namespace touchstone::measures {

/// One broadphase over a swarm, all of which moves and turns every frame.
struct BroadphaseResult {
  std::string name;
  std::string description;
  SwarmSize size;
  std::size_t frames = 0;  ///< timed; 0: not run, see gap
  Timing frame;            ///< update and find_pairs [ns per frame]
  std::optional<Timing>
      with_overlap;       ///< and the overlap of all pairs by the narrowphase of that name [ns per frame]
  double candidates = 0;  ///< pairs per frame, mean
  std::optional<double> allocations;  ///< per frame, after the first
  std::optional<std::size_t> missed;  ///< of `true_pairs`, last frame; empty: not checked
  std::size_t true_pairs = 0;         ///< pairs whose solids are within the margin
  bool from_candidates = false;       ///< true_pairs come from what all broadphases found, not from all pairs
  std::string gap;                    ///< why it was not run
};

struct BroadphaseOptions {
  std::uint64_t seed = 1;
  double margin = 0.01;  ///< [m]
  std::vector<SwarmSize> swarms = {{1000, 1}, {10000, 1}, {100000, 1}, {1000, 4}, {1000, 16}, {1000, 64}};
  std::size_t largest_checked = 10000;    ///< [hexahedra] beyond, true pairs come from all candidates
  std::size_t largest_quadratic = 10000;  ///< [hexahedra; edge_face: objects] these are not run beyond
  int threads = 1;
};

/// Runs every broadphase of the registry on the same frames, frame by frame in turn, and where there is a
/// narrowphase of its name, that one on its pairs. Without an oracle nothing is checked.
std::vector<BroadphaseResult> run_broadphases(const BackendRegistry& registry,
                                              const BroadphaseOptions& options, const Oracle* oracle,
                                              const Progress& progress = {});

}  // namespace touchstone::measures
