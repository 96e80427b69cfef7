#include "contact_core/input_error.hpp"
#include "examples/compare_backends/pair_file_run.hpp"

#ifdef TOUCHSTONE_HAS_SCENE_FILES
#include "adapters/scene_files/pair_file.hpp"
#endif

namespace touchstone::comparison {

#ifdef TOUCHSTONE_HAS_SCENE_FILES

PairFileCases load_pair_file(const std::string& file) {
  PairFileCases result;
  result.file = file;
  result.set.name = "pairs";
  result.set.description = "the cases of " + file;
  for (const PairCase& each : load_pairs(file)) {
    result.cases.push_back({each.id, each.pair ? "" : each.invalid_reason, result.set.pairs.size()});
    if (!each.pair) continue;
    const auto first = static_cast<SolidIndex>(result.set.solids.size());
    for (int i = 0; i < 2; ++i) {
      result.set.solids.push_back(each.pair->solids[i]);
      result.set.poses.push_back(each.pair->X_WS[i]);
    }
    result.set.pairs.push_back({first, first + 1});
    result.set.ids.push_back(each.id);
  }
  return result;
}

#else

PairFileCases load_pair_file(const std::string& file) {
  throw InputError(file + ": this build reads no pair files (adapter scene_files is off)");
}

#endif

}  // namespace touchstone::comparison
