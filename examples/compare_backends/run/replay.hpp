#pragma once

#include <string>

#include "touchstone/examples/compare_backends/run/comparison.hpp"

namespace touchstone::comparison {

/// The set of the one case that `id` names: "family:index", an id of options.pairs_file or of options.corpus,
/// or "scene:frame:pair" of one of options.scenes.
/// @throws InputError when it names none.
PairSet find_case(const Options& options, const std::string& id);

/// The case's solids and poses, the exact answer, and every chosen backend's answer with its errors in
/// metres. Of a path whose ends options.pairs_file has as the cases "id@start" and "id@end" (as the
/// benchmark's site writes them): where each chosen backend, and each sweep of their engines, stops.
/// @throws InputError as find_case(), and for a path where `oracle` is null.
std::string replay_case(const Options& options, const Backends& backends, const Oracle* oracle);

}  // namespace touchstone::comparison
