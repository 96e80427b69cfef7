#include "touchstone/contact_core/narrowphase/validate.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

std::string pair_name(std::size_t i) { return "pair " + std::to_string(i); }

std::size_t geometry_of(const Query& query) { return query.kind == QueryKind::overlap ? 0 : 1; }

bool is_sound(const Query& query) {
  return query.kind != QueryKind::manifold ||
         (query.max_points >= 1 && query.max_points <= kMaxManifoldPoints);
}

void validate_query(const Query& query) {
  if (query.kind > QueryKind::manifold)
    reject("query", "kind " + std::to_string(static_cast<int>(query.kind)) + " is none");
  if (!is_sound(query))
    reject("query", "max_points is " + std::to_string(query.max_points) + ", must be 1 to " +
                        std::to_string(kMaxManifoldPoints));
  if (!(query.max_separation >= 0.0))
    reject("query", "max_separation is " + figure(query.max_separation) + ", must be >= 0");
  if (std::isnan(query.max_point_separation)) reject("query", "max_point_separation is nan");
}

void validate_size(std::string_view span, std::size_t size, std::size_t least) {
  if (size < least) reject(span, "has " + std::to_string(size) + " entries, needs " + std::to_string(least));
}

void validate_spans(const NarrowphaseInput& input, const NarrowphaseOutput& output, std::size_t solid_count) {
  const std::size_t count = input.pairs.size();
  validate_size("poses", input.poses.size(), solid_count);
  if (!input.cache.empty() && input.cache.size() != count)
    reject("cache", "has " + std::to_string(input.cache.size()) + " entries, must be empty or have " +
                        std::to_string(count) + ", one a pair");
  validate_size("status", output.status.size(), count);
  validate_size("geometry", output.geometry.size(), count * geometry_of(input.query));
  validate_size("points", output.points.size(), count * input.query.slots());
  if (!output.geometry.empty()) validate_size("geometry", output.geometry.size(), count);
}

void validate_pair(const NarrowphaseInput& input, std::size_t i, std::size_t solid_count) {
  const SolidPair& pair = input.pairs[i];
  for (const SolidIndex solid : {pair.a, pair.b})
    if (solid >= solid_count)
      reject(pair_name(i), "solid " + std::to_string(solid) + " is out of range, build() was given " +
                               std::to_string(solid_count));
  if (pair.a >= pair.b)
    reject(pair_name(i), "(" + std::to_string(pair.a) + ", " + std::to_string(pair.b) + ") is not a < b");
  for (const SolidIndex solid : {pair.a, pair.b})
    validate_pose(input.poses[solid], pair_name(i) + ": pose " + std::to_string(solid));
}

}  // namespace

bool fits(const NarrowphaseInput& input, const NarrowphaseOutput& output, std::size_t solid_count) noexcept {
  const std::size_t count = input.pairs.size();
  if (!is_sound(input.query) || output.status.size() < count ||
      output.geometry.size() < count * geometry_of(input.query) ||
      output.points.size() < count * input.query.slots() ||
      (!output.geometry.empty() && output.geometry.size() < count) ||
      (!input.cache.empty() && input.cache.size() < count))
    return false;
  const std::size_t known = std::min(solid_count, input.poses.size());
  return std::all_of(input.pairs.begin(), input.pairs.end(),
                     [known](const SolidPair& pair) { return pair.a < known && pair.b < known; });
}

void validate(const NarrowphaseInput& input, const NarrowphaseOutput& output, std::size_t solid_count) {
  validate_query(input.query);
  validate_spans(input, output, solid_count);
  for (std::size_t i = 0; i < input.pairs.size(); ++i) validate_pair(input, i, solid_count);
}

}  // namespace touchstone
