#pragma once

#include <string>

namespace touchstone::comparison {

/// Fewer repetitions of a row than this are not tested.
inline constexpr std::size_t kLeastRepetitions = 9;
/// Of the changes of speed that are named, at most this share is expected to be chance.
inline constexpr double kFalseDiscoveryRate = 0.05;

/// Returns the changes between two results.json: first wrong and missing answers (of pair sets, scenes'
/// frames and broadphases), then worst errors, consistency and allocations, then rows that are gone or new
/// and settings, then times: the ratio of the medians of the repetitions and Mann and Whitney's p;
/// "unresolved" where noise wins or the repetitions are too few. What cannot be compared, as one of the two
/// has no exact, is named.
/// @param all also the rows that are unresolved.
/// @throws InputError for text that is no results.json.
std::string diff_reports(const std::string& old_json, const std::string& new_json, bool all);

/// compare_backends diff OLD.json NEW.json [--all]. @return the program's exit code.
/// @throws InputError for a command line or file that cannot be used.
int run_diff(int argc, const char* const* argv);

}  // namespace touchstone::comparison
