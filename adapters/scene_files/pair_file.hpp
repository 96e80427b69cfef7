#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/narrowphase/pair_class.hpp"

/// @file
/// Pairs of solids that users bring as JSON, and our own hard cases in the same format
/// (adapters/scene_files/README.md).

namespace touchstone {

/// Two solids in their poses.
struct PosedPair {
  std::array<Hexahedron, 2> solids;
  std::array<Pose, 2> X_WS;
};

/// The exact answer that a case carries: for the hulls of the world vertices as doubles.
struct ExactAnswer {
  PairClass pair_class;
  std::string signed_distance;    ///< decimal [m], at least 25 significant digits unless exact with fewer
  std::optional<Vector3> normal;  ///< n_AB_W where it is unique
};

/// An engine's answer when the pair was captured in it.
struct CapturedAnswer {
  std::string by;  ///< engine and check
  bool contact;
  double separation = 0;  ///< of a contact: of its deepest point [m]
  Vector3 n_AB_W = Vector3::Zero();
  std::vector<ContactPoint> points;  ///< the deepest first; feature ids are not kept
};

/// One case of a pair file.
struct PairCase {
  std::string id;
  std::optional<PosedPair> pair;  ///< empty: invalid
  std::string invalid_reason;     ///< why `pair` is empty
  std::optional<ExactAnswer> exact;
  std::string why_hard;        ///< may be empty
  std::string expected_error;  ///< bad inputs of our own: a part of invalid_reason; else empty
  std::optional<CapturedAnswer> captured = std::nullopt;
};

/// Reads a list of cases, or an object with `cases`. A case that is no pair of hexahedra in valid poses
/// comes out invalid, with the reason. Warped solids are taken as scene files take them: within the
/// tolerance, or by the shape's `warped` (WarpPolicy), with vertices in any order.
/// @throws InputError naming file, and line and column where known: unreadable file, malformed JSON, no list
/// of cases, an id given twice; naming file and element: a field that is not known, units other than m and
/// mm.
std::vector<PairCase> load_pairs(const std::filesystem::path& path);

/// Returns the text of a file in metres that load_pairs reads back bit for bit: shapes (warped ones marked
/// `accept`), poses (as matrices), exact and captured answers. Bytes of other texts than ids that are no
/// UTF-8 are replaced, as by U+FFFD.
/// @throws InputError when a case is invalid, or its id is no UTF-8.
std::string pairs_text(std::span<const PairCase> cases);

/// Writes that text to a file, which appears whole or not at all.
/// @throws InputError when a case is invalid, or its id is no UTF-8, or the file cannot be written.
void save_pairs(const std::filesystem::path& path, std::span<const PairCase> cases);

}  // namespace touchstone
