#pragma once

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/run/scenes/scene_frames.hpp"
#include "touchstone/examples/measures/runs/backend_run.hpp"
#include "touchstone/examples/measures/truth/oracle.hpp"

/// @file
/// The least that serves: a scene modelled with more and fewer hexahedra, asked about all pairs and only
/// those that its motion needs, by every backend and query: what a frame costs, and how far its answers are
/// off.

namespace touchstone::comparison {

/// One model of a scene, choice of pairs, backend and query.
struct TradeRow {
  std::string backend;
  std::string model;  ///< "as written", "16 facets", "cover, level 0"
  std::size_t hexahedra = 0;
  bool selected = false;                 ///< only the pairs that the motion needs, see pairs_that_decide()
  std::size_t pairs = 0, all_pairs = 0;  ///< asked a frame; of the model
  QueryKind query = QueryKind::overlap;
  double frame_ns = 0;  ///< the median frame of the quietest repetition
  /// Worst over the frames [m]: the exact answer for this row's hexahedra and pairs against the true one.
  double geometry_error = 0;
  /// The same of the backend's answer against the exact one for this row's hexahedra and pairs; +inf where a
  /// figure is missing.
  double backend_error = 0;
  std::size_t wrong_frames = 0;  ///< in which the backend takes this row's hexahedra for what they are not

  double error() const { return geometry_error + backend_error; }
  bool serves(double allowed) const { return error() <= allowed; }
};

struct SceneTrade {
  double allowed = 0;       ///< --max-error or the scene's gap [m]
  std::size_t frames = 0;   ///< judged
  bool all_frames = false;  ///< the scene has no other
  /// Frames among these that follow each other around the first contact, or around the least clearance.
  std::size_t frames_near = 0;
  std::size_t models = 0;            ///< of the scene, each with hexahedra of its own
  std::size_t class_frames = 0;      ///< of `frames`, those in which two models differ in exact class
  bool round = false;                ///< the true round parts are the reference, not the hexahedra as written
  double reference_width = 0;        ///< the reference is known to half of this [m]; 0: exactly
  std::size_t selection_frames = 0;  ///< over which the needed pairs were looked for
  std::vector<TradeRow> rows;
};

/// "native, 16 facets, 5 of its 48 pairs"; "native, as written, 4 pairs".
std::string words(const TradeRow& row);

/// The cheapest row of this query whose error is allowed; null when none is. Of two that cost the same the
/// first.
const TradeRow* cheapest_row(const SceneTrade& trade, QueryKind query, double allowed);

/// From `allowed` on, up to the next step, `row` is the cheapest that serves.
struct TradeStep {
  double allowed = 0;  ///< [m]
  const TradeRow* row = nullptr;
};
/// The cheapest rows for allowed errors of 1 nm, 10 nm, ... 1 m; steps with the same row are one.
std::vector<TradeStep> trade_steps(const SceneTrade& trade, QueryKind query);

/// Fewer frames than this leave more than 5 % of the frames unknown (95 % bound of none).
inline constexpr std::size_t kLeastTradeFrames = 59;
/// The reason why the frames support no recommendation for this query, one line; empty: they do.
std::string thin_evidence(const SceneTrade& trade, QueryKind query);

/// The reference of the frames: the true clearance, of the round parts where there are any.
struct TradeReference {
  std::vector<ClearanceBracket> clearance;  ///< one a frame
  /// The exact least separation of the hexahedra as written; what depths are compared with.
  std::vector<double> written;
  bool round = false;
  double written_offset = 0;  ///< of the facets as written [m]; 0 where nothing is round
};

/// The model's part of the error: its exact least separations against the reference, the worst over the
/// frames [m]. A frame whose class differs costs its true separation. Apart, distances are compared. In
/// contact so are depths; but a round part has no depth that does not depend on how it is cut, so a faceted
/// model counts by its `offset` there, how far its surface is from the round one at most, and so does a
/// contact that it misses, less what it is apart.
/// @param offset of a model made of facets [m]; empty: none, or a cover.
double geometry_error(const TradeReference& reference, std::span<const double> model,
                      std::optional<double> offset, QueryKind query);

/// The backend's part: its answers against the exact least separations of the same hexahedra and pairs, the
/// worst over the frames [m]. A wrong or missing class costs |the exact separation|.
double backend_error(const QueryAnswers& answers, QueryKind query, std::size_t pairs,
                     std::span<const double> exact);

/// Every chosen backend's answers to a set, in this process or a worker.
using AnswerSet = std::function<std::vector<BackendAnswers>(const PairSet&, const MeasureOptions&)>;

struct TradeOptions {
  std::map<std::string, double> parameters;
  MeasureOptions measure;
  std::optional<double> max_error;  ///< [m]
  std::vector<int> facets;          ///< tried beside the scene's own count, where there is a parameter for it
  std::size_t frames = 100;         ///< half of them around the first contact, the others evenly spread
};

/// @param stepped the scene's frames as written. @param exact the exact least separation in each of them.
SceneTrade run_trade(const std::string& file, const SceneFrames& stepped, std::span<const double> exact,
                     const TradeOptions& options, const Oracle& oracle, const AnswerSet& answer,
                     const Progress& progress);

/// Exact least separation of each frame [m]. Pairs whose bounding spheres are further apart than another
/// pair's exact separation are not computed.
std::vector<double> exact_clearance(const PairSet& set, const Oracle& oracle, int threads);

}  // namespace touchstone::comparison
