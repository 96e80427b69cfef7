#pragma once

#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/program/files/json.hpp"

namespace touchstone::comparison {

/// An answer about a path that a results file names.
struct FiledPath {
  std::string id, reason;
  double s = 0;     ///< where motion stops; 1: nowhere
  double cost = 0;  ///< [m]
  double cost_over_scale = 0;
};

/// One engine's times of impact of one set of paths.
struct PathCell {
  std::string gap;    ///< why it was not asked; empty: it was
  std::string check;  ///< proven, sampled or swept
  std::size_t answered = 0, missed = 0, late = 0, phantom = 0, early = 0, open = 0, failed = 0,
              unsupported = 0;
  std::size_t pose_right = 0, pose_later = 0, pose_earlier = 0, pose_open = 0;
  FiledPath worst;
  std::vector<FiledPath> wrong_cases;  ///< the dearest first

  std::size_t wrong() const { return missed + late + phantom + early + failed; }
};

/// A set of paths itself.
struct FiledPathSet {
  std::string name;
  std::size_t paths = 0, poses = 0, meets = 0, open = 0, unseen = 0;
};

FiledPathSet path_set_of(const Json& json);
/// @param json a backend of a set of paths in results.json. @param paths of the set
/// @throws InputError for figures that are none, as counts.hpp, and counts of more than there is.
PathCell path_cell_of(const Json& json, std::size_t paths);

}  // namespace touchstone::comparison
