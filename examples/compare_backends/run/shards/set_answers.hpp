#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/compare_backends/run/shards/shard.hpp"
#include "touchstone/examples/measures/accuracy/accuracy.hpp"

namespace touchstone::comparison {

/// Truth and answers of the cases of a set, or of a shard's part of it.
struct SetAnswers {
  std::vector<PairTruth> truth;  ///< empty without `exact`
  std::vector<BackendAnswers> answers;
  std::vector<std::vector<CaseErrors>> errors;  ///< one list a backend; empty without `exact`
};

/// The shard's pairs among all solids and poses of the set, under their ids: a solid that a backend refuses
/// is refused in every shard.
PairSet part_of(const PairSet& set, Shard shard);
/// The shard's part of a family's first `count` pairs: their solids, and the one that lies furthest out, by
/// which the set's consistency is asked (check_consistency()). The others are drawn, and not kept: a solid
/// that a backend refuses is refused in its own shard alone, or, the furthest one, in all. @throws as
/// make_pair_family().
PairSet part_of_family(const std::string& name, std::uint64_t seed, std::size_t count, Shard shard);
/// The answers to the shard's pairs.
BackendAnswers part_of(const BackendAnswers& answers, Shard shard);

/// The parts of shards 1 to n of a set of `cases` pairs as one, each case in its place. A time is that of the
/// shard in the middle; what was counted is added up.
SetAnswers joined_parts(std::span<const SetAnswers> parts, std::size_t cases);

std::string encode_set(const SetAnswers& set);
/// @throws std::runtime_error for what encode_set() did not write.
SetAnswers decode_set(std::string bytes);

/// Sizes of what encode_set() writes as it lies in memory: what two builds must share to read each other's.
std::string set_layout();

/// Checks what joined_parts(), and readers of the counts, take for granted of a file.
/// @param cases of the part. @throws std::runtime_error for lists of other lengths, and for numbers that
/// this program does not write: of repetitions, a pair's class.
void check_part(const SetAnswers& part, std::size_t cases, bool has_truth);

}  // namespace touchstone::comparison
