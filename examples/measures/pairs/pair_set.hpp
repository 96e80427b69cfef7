#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone::measures {

/// The input of every backend: pairs of posed solids, over one or more frames. A pair family and a
/// pair file have one frame; a scene has one per step. Case c is pair c % pairs.size() in frame c /
/// pairs.size().
struct PairSet {
  std::string name;
  std::string description;  ///< one line
  std::vector<Hexahedron> solids;
  std::vector<SolidPair> pairs;
  std::vector<Pose> poses;       ///< X_WS, frame by frame: frames * solids.size()
  std::vector<std::string> ids;  ///< one a case; empty: "name:case"
  /// The exact signed separation of every case [m], where it is known; no backend sees it.
  std::vector<double> exact_separations;

  std::size_t frames() const { return solids.empty() ? 0 : poses.size() / solids.size(); }
  std::size_t cases() const { return frames() * pairs.size(); }
  std::span<const Pose> frame_poses(std::size_t frame) const {
    return std::span(poses).subspan(frame * solids.size(), solids.size());
  }
};

std::string case_id(const PairSet& set, std::size_t index);

/// The two solids of a case as world vertices.
struct PosedPair {
  WorldVertices a, b;
  double size;   ///< the larger of the two solids' sizes [m]
  double scale;  ///< S of the error measures: max(size, largest |world coordinate|) [m]
};
PosedPair posed_pair(const PairSet& set, std::size_t index);

}  // namespace touchstone::measures
