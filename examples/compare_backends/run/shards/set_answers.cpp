#include "touchstone/examples/compare_backends/run/shards/set_answers.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "touchstone/examples/compare_backends/run/workers/job_io.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"

namespace touchstone::comparison {
namespace {

// ---- a part of a set, and back

/// Of a list with `width` entries a case those of the shard's cases.
template <class T>
std::vector<T> picked(const std::vector<T>& all, std::size_t width, Shard shard) {
  std::vector<T> part;
  for (std::size_t at = (shard.k - 1) * width; at < all.size(); at += shard.n * width)
    std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(at), width, std::back_inserter(part));
  return part;
}

/// The other way; `all` has a place for every case.
template <class T>
void place(const std::vector<T>& part, std::size_t width, Shard shard, std::vector<T>& all) {
  for (std::size_t i = 0; i * width < part.size(); ++i)
    std::copy_n(part.begin() + static_cast<std::ptrdiff_t>(i * width), width,
                all.begin() + static_cast<std::ptrdiff_t>((shard.k - 1 + i * shard.n) * width));
}

/// By the solids' origins, as check_consistency() moves a set.
bool lies_nearer(const Pose& x, const Pose& y) { return norm(x.p) < norm(y.p); }

QueryAnswers part_of(const QueryAnswers& answers, Shard shard) {
  QueryAnswers part;
  part.status = picked(answers.status, 1, shard);
  part.geometry = picked(answers.geometry, 1, shard);
  part.points = picked(answers.points, kMaxManifoldPoints, shard);
  return part;
}

void place(const QueryAnswers& part, Shard shard, std::size_t cases, QueryAnswers& all) {
  all.status.resize(cases);
  if (!part.geometry.empty()) all.geometry.resize(cases);
  if (!part.points.empty()) all.points.resize(cases * kMaxManifoldPoints);
  place(part.status, 1, shard, all.status);
  place(part.geometry, 1, shard, all.geometry);
  place(part.points, kMaxManifoldPoints, shard, all.points);
}

// ---- times and counts of several shards

/// Of the shards that have it the one in the middle by its median, the lower of two.
std::optional<Timing> middle_of(std::vector<std::optional<Timing>> timings) {
  std::erase_if(timings, [](const auto& timing) { return !timing; });
  if (timings.empty()) return std::nullopt;
  std::sort(timings.begin(), timings.end(),
            [](const auto& x, const auto& y) { return x->median_ns < y->median_ns; });
  return timings[(timings.size() - 1) / 2];
}

/// The mean of counts a query, by bits where all are alike.
std::optional<double> mean_of(std::vector<std::optional<double>> values) {
  std::erase_if(values, [](const auto& value) { return !value; });
  if (values.empty()) return std::nullopt;
  if (std::all_of(values.begin(), values.end(), [&](const auto& value) { return value == values[0]; }))
    return values[0];
  double sum = 0;
  for (const auto& value : values) sum += *value;
  return sum / static_cast<double>(values.size());
}

std::optional<Consistency> sum_of(std::span<const SetAnswers> parts, std::size_t b) {
  std::optional<Consistency> sum = Consistency{};
  for (const SetAnswers& part : parts) {
    const auto& more = part.answers[b].consistency;
    if (!more) return std::nullopt;
    sum->swapped += more->swapped;
    sum->moved += more->moved;
    sum->repeated += more->repeated;
    sum->threads += more->threads;
  }
  return sum;
}

template <class Member>
auto of_query(std::span<const SetAnswers> parts, std::size_t b, std::size_t q, Member member) {
  std::vector<std::remove_cvref_t<decltype(parts[0].answers[b].queries[q].*member)>> values;
  for (const SetAnswers& part : parts) values.push_back(part.answers[b].queries[q].*member);
  return values;
}

BackendAnswers joined_backend(std::span<const SetAnswers> parts, std::size_t b, std::size_t cases) {
  // A worker that died in one shard has no capabilities there.
  const auto living = std::find_if(parts.begin(), parts.end(),
                                   [&](const SetAnswers& part) { return part.answers[b].failure.empty(); });
  const BackendAnswers& first = (living == parts.end() ? parts.front() : *living).answers[b];
  BackendAnswers all;
  all.name = first.name;
  all.description = first.description;
  all.capabilities = first.capabilities;
  for (const SetAnswers& part : parts)
    if (all.failure.empty()) all.failure = part.answers[b].failure;
  for (std::size_t q = 0; q < all.queries.size(); ++q) {
    QueryAnswers& query = all.queries[q];
    for (std::size_t k = 0; k < parts.size(); ++k)
      place(parts[k].answers[b].queries[q], {k + 1, parts.size()}, cases, query);
    query.single = middle_of(of_query(parts, b, q, &QueryAnswers::single));
    query.batch = middle_of(of_query(parts, b, q, &QueryAnswers::batch));
    query.raw = middle_of(of_query(parts, b, q, &QueryAnswers::raw));
    query.cached = middle_of(of_query(parts, b, q, &QueryAnswers::cached));
    query.allocations = mean_of(of_query(parts, b, q, &QueryAnswers::allocations));
  }
  all.consistency = sum_of(parts, b);
  return all;
}

// ---- as bytes

void put(ByteWriter& out, const Vector3& v) {
  for (int i = 0; i < 3; ++i) out.put(v[i]);
}
void get(ByteReader& in, Vector3& v) {
  for (int i = 0; i < 3; ++i) in.get(v[i]);
}

/// The reason of answers without a cost; its number follows those of kCostReasons.
constexpr const char* kUnsupported = "unsupported";

std::uint8_t number_of(const char* reason) {
  const auto found = std::find(kCostReasons.begin(), kCostReasons.end(), std::string_view(reason));
  return static_cast<std::uint8_t>(found - kCostReasons.begin());
}

const char* reason_of(std::uint8_t number) {
  if (number > kCostReasons.size()) throw std::runtime_error("has a cost without a reason");
  return number == kCostReasons.size() ? kUnsupported : kCostReasons[number];
}

void put(ByteWriter& out, const CaseErrors& errors) {
  out.put(errors.values);
  out.put(errors.unsupported);
  out.put(errors.coverage);
  for (const auto& query : errors.charges) {
    for (const CaseCost& cost : query) {
      out.put(cost.cost);
      out.put(number_of(cost.reason));
      out.put(cost.missing);
    }
  }
}

void get(ByteReader& in, CaseErrors& errors) {
  in.get(errors.values);
  in.get(errors.unsupported);
  in.get(errors.coverage);
  for (auto& query : errors.charges) {
    for (CaseCost& cost : query) {
      std::uint8_t reason = 0;
      in.get(cost.cost);
      in.get(reason);
      in.get(cost.missing);
      cost.reason = reason_of(reason);
    }
  }
}

// ---- what a file may hold

void check(bool holds, const char* what) {
  if (!holds) throw std::runtime_error(std::string("has ") + what);
}

/// Answers of engines are taken as they are, as in one run. @param cases of the part.
void check_query(QueryKind kind, const QueryAnswers& answers, std::size_t cases) {
  constexpr const char* kWhat = "answers to other cases than its own";
  check(answers.status.size() == cases, kWhat);
  check(answers.geometry.size() == cases || (kind == QueryKind::overlap && answers.geometry.empty()), kWhat);
  check(answers.points.empty() || answers.points.size() == cases * kMaxManifoldPoints, kWhat);
  for (const auto* timing : {&answers.single, &answers.batch, &answers.raw, &answers.cached})
    check(!*timing || (*timing)->repetitions <= kKeptRepetitions, "more repetitions than are kept");
}

}  // namespace

PairSet part_of(const PairSet& set, Shard shard) {
  PairSet part = set;
  part.pairs = picked(set.pairs, 1, shard);
  part.ids.clear();
  for (std::size_t i = shard.k - 1; i < set.pairs.size(); i += shard.n) part.ids.push_back(case_id(set, i));
  return part;
}

PairSet part_of_family(const std::string& name, std::uint64_t seed, std::size_t count, Shard shard) {
  PairSet part = make_pair_family(name, seed, 0);
  std::optional<std::pair<Hexahedron, Pose>> furthest;
  for (std::size_t i = 0; i < count; ++i) {
    const PairSet one = make_family_pair(name, seed, i);
    for (std::size_t side = 0; side < 2; ++side)
      if (!furthest || lies_nearer(furthest->second, one.poses[side]))
        furthest.emplace(one.solids[side], one.poses[side]);
    if (i % shard.n != shard.k - 1) continue;
    const auto first = static_cast<SolidIndex>(part.solids.size());
    part.solids.insert(part.solids.end(), one.solids.begin(), one.solids.end());
    part.poses.insert(part.poses.end(), one.poses.begin(), one.poses.end());
    part.pairs.push_back({first, first + 1});
    part.ids.push_back(one.ids.front());
  }
  if (!furthest) return part;
  part.solids.push_back(furthest->first);
  part.poses.push_back(furthest->second);
  return part;
}

BackendAnswers part_of(const BackendAnswers& answers, Shard shard) {
  BackendAnswers part;
  part.name = answers.name;
  part.description = answers.description;
  part.capabilities = answers.capabilities;
  for (std::size_t q = 0; q < part.queries.size(); ++q) part.queries[q] = part_of(answers.queries[q], shard);
  return part;
}

SetAnswers joined_parts(std::span<const SetAnswers> parts, std::size_t cases) {
  const SetAnswers& first = parts.front();
  SetAnswers all;
  all.truth.resize(first.truth.empty() ? 0 : cases);
  all.errors.resize(first.errors.size(), std::vector<CaseErrors>(cases));
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const Shard shard{k + 1, parts.size()};
    place(parts[k].truth, 1, shard, all.truth);
    for (std::size_t b = 0; b < all.errors.size(); ++b) place(parts[k].errors[b], 1, shard, all.errors[b]);
  }
  for (std::size_t b = 0; b < first.answers.size(); ++b)
    all.answers.push_back(joined_backend(parts, b, cases));
  return all;
}

std::string encode_set(const SetAnswers& set) {
  ByteWriter out;
  out.put(set.truth.size());
  for (const PairTruth& each : set.truth) {
    out.put(each.pair_class);
    out.put(each.separation);
    put(out, each.n_AB_W);
    out.put(each.normal_unique);
  }
  out.put(encode_answers(set.answers));
  out.put(set.errors.size());
  for (const std::vector<CaseErrors>& list : set.errors) {
    out.put(list.size());
    for (const CaseErrors& errors : list) put(out, errors);
  }
  return out.bytes();
}

SetAnswers decode_set(std::string bytes) {
  ByteReader in(std::move(bytes));
  SetAnswers set;
  for (std::size_t i = in.get_count(); i > 0; --i) {
    PairTruth& each = set.truth.emplace_back();
    in.get(each.pair_class);
    in.get(each.separation);
    get(in, each.n_AB_W);
    in.get(each.normal_unique);
  }
  std::string answers;
  in.get(answers);
  set.answers = decode_answers(std::move(answers));
  for (std::size_t b = in.get_count(); b > 0; --b) {
    std::vector<CaseErrors>& list = set.errors.emplace_back();
    for (std::size_t i = in.get_count(); i > 0; --i) get(in, list.emplace_back());
  }
  if (!in.is_done()) throw std::runtime_error("has more than its lists say");
  return set;
}

std::string set_layout() {
  std::string layout;
  for (const std::size_t size :
       {sizeof(std::size_t), sizeof(PairClass), sizeof(PairStatus), sizeof(Capabilities), sizeof(Timing),
        sizeof(Consistency), sizeof(ContactPoint::feature_id), kQueryKinds.size(), kMeasures, kAskedKinds,
        kCostReasons.size(), std::size_t{kMaxManifoldPoints}})
    layout += std::to_string(size) + " ";
  return layout + (std::endian::native == std::endian::little ? "little" : "big");
}

void check_part(const SetAnswers& part, std::size_t cases, bool has_truth) {
  constexpr const char* kWhat = "exact truth or errors of other cases than its own";
  check(part.truth.size() == (has_truth ? cases : 0), kWhat);
  check(part.errors.size() == (has_truth ? part.answers.size() : 0), kWhat);
  for (const auto& list : part.errors) check(list.size() == cases, kWhat);
  for (const PairTruth& each : part.truth)
    check(each.pair_class <= PairClass::penetrating, "a class that no pair has");
  for (const BackendAnswers& backend : part.answers) {
    for (const QueryKind kind : kQueryKinds) check_query(kind, backend.queries[index_of(kind)], cases);
  }
}

}  // namespace touchstone::comparison
