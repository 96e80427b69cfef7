#pragma once

#include <optional>
#include <string>
#include <vector>

#include "examples/compare_backends/verdict.hpp"

namespace touchstone::comparison {

/// A backend along a scene's frames.
struct SceneBackend {
  std::string name;
  std::optional<double> first_contact;  ///< time of the first frame in contact [s]
  std::size_t missed_frames = 0;        ///< frames in contact reported clear
  std::size_t phantom_frames = 0;       ///< clear frames reported in contact
  std::size_t undecided_frames = 0;  ///< neither: some pair undecided, failed or unsupported, none in contact
  double worst_clearance_error = 0;  ///< largest |least separation - exact least separation| of a frame [m]
};

/// A facet count and a query kind: what it costs and how far its least separation is from the finest one's.
struct FacetRow {
  int facets = 0;
  QueryKind query = QueryKind::overlap;
  std::size_t pairs = 0;
  double frame_ns = 0;  ///< the reference backend, median per frame
  double error = 0;     ///< [m]
  bool serves = false;
};

struct SceneResult {
  std::string name;
  std::string file;
  double rate = 0, duration = 0, gap = 0;
  std::size_t frames = 0;
  std::optional<double> exact_first_contact;
  SetResult set;  ///< every pair of every frame
  std::vector<SceneBackend> backends;
  std::string facet_backend;   ///< whose cost the facet rows give
  double facet_reference = 0;  ///< the finest count
  double facet_budget = 0;     ///< --max-error or the scene's gap [m]
  std::vector<FacetRow> facet_rows;
};

}  // namespace touchstone::comparison
