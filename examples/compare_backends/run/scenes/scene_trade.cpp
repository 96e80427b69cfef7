#include "touchstone/examples/compare_backends/run/scenes/scene_trade.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/compare_backends/run/scenes/frame_answer.hpp"

namespace touchstone::comparison {
namespace {

// The difference that two separations of one frame, apart or in contact alike, make to a query. Manifolds are
// asked of contacts only.
double difference(double answered, double truth, QueryKind query, bool contact) {
  const bool asked = query == QueryKind::distance || (query == QueryKind::manifold && contact);
  return asked ? std::abs(answered - truth) : 0.0;
}

// A frame in contact with a round part.
double round_contact_error(const TradeReference& reference, std::size_t frame, double model,
                           std::optional<double> offset, QueryKind query) {
  if (!offset) {  // a cover, which misses no contact
    const double depth = difference(model, reference.written[frame], query, true);
    return query == QueryKind::overlap ? 0.0 : depth + reference.written_offset;
  }
  if (model > 0.0) return query == QueryKind::distance ? *offset : std::max(0.0, *offset - model);
  return query == QueryKind::overlap ? 0.0 : *offset;
}

}  // namespace

double geometry_error(const TradeReference& reference, std::span<const double> model,
                      std::optional<double> offset, QueryKind query) {
  double worst = 0.0;
  for (std::size_t f = 0; f < model.size(); ++f) {
    const ClearanceBracket& truth = reference.clearance[f];
    const bool contact = truth.contact();
    double error = 0.0;
    if (contact && reference.round) {
      error = round_contact_error(reference, f, model[f], offset, query);
    } else {
      error = difference(model[f], truth.middle(), query, contact);
      if (contact != (model[f] <= 0.0)) error = std::max(error, std::abs(truth.middle()));
      if (error > 0.0) error += truth.half_width();
    }
    worst = std::max(worst, error);
  }
  return worst;
}

double backend_error(const QueryAnswers& answers, QueryKind query, std::size_t pairs,
                     std::span<const double> exact) {
  double worst = 0.0;
  for (std::size_t f = 0; f < exact.size(); ++f) {
    const FrameAnswer answer = frame_answer(answers, f, pairs);
    const bool contact = exact[f] <= 0.0;
    const bool wrong = (!answer.contact && answer.unsure) || answer.contact != contact;
    double error =
        wrong && query != QueryKind::distance ? 0.0 : difference(answer.least, exact[f], query, contact);
    if (wrong) error = std::max(std::abs(exact[f]), error);
    if (std::isnan(error) || (query == QueryKind::distance && std::isnan(answer.least))) error = kInfinity;
    worst = std::max(worst, error);
  }
  return worst;
}

std::string words(const TradeRow& row) {
  std::string pairs = std::to_string(row.pairs);
  if (row.selected) pairs += " of its " + std::to_string(row.all_pairs);
  return row.backend + ", " + row.model + ", " + pairs + (row.all_pairs == 1 ? " pair" : " pairs");
}

const TradeRow* cheapest_row(const SceneTrade& trade, QueryKind query, double allowed) {
  const TradeRow* cheapest = nullptr;
  for (const TradeRow& row : trade.rows) {
    if (row.query != query || !row.serves(allowed)) continue;
    if (cheapest == nullptr || row.frame_ns < cheapest->frame_ns) cheapest = &row;
  }
  return cheapest;
}

std::vector<TradeStep> trade_steps(const SceneTrade& trade, QueryKind query) {
  constexpr double kAllowed[] = {1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1};
  std::vector<TradeStep> steps;
  for (const double allowed : kAllowed) {
    const TradeRow* row = cheapest_row(trade, query, allowed);
    if (row != nullptr && (steps.empty() || steps.back().row != row)) steps.push_back({allowed, row});
  }
  return steps;
}

std::string thin_evidence(const SceneTrade& trade, QueryKind query) {
  if (trade.all_frames) return "";
  if (trade.frames < kLeastTradeFrames)
    return "too few frames (" + std::to_string(trade.frames) + ", at least " +
           std::to_string(kLeastTradeFrames) + " leave less than 5 % unknown)";
  if (query == QueryKind::overlap && trade.models > 1 && trade.class_frames == 0)
    return "no frame lies where the models differ in class";
  return "";
}

}  // namespace touchstone::comparison
