#include "touchstone/examples/compare_backends/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "touchstone/examples/program/text_table.hpp"

namespace touchstone::comparison {
namespace {

Candidate sum_up(std::span<const SetResult> sets, const std::string& backend, QueryKind query) {
  Candidate candidate;
  candidate.backend = backend;
  const std::size_t q = index_of(query);
  for (const SetResult& set : sets) {
    const auto found = std::find_if(set.backends.begin(), set.backends.end(),
                                    [&](const BackendResult& result) { return result.name == backend; });
    const bool judged = found != set.backends.end() && found->judged;
    candidate.nanoseconds += found != set.backends.end() ? verdict_speed(set, *found, query)
                                                         : std::numeric_limits<double>::quiet_NaN();
    const WorstCase worst = judged ? found->judgement.worst[q]
                                   : WorstCase{std::numeric_limits<double>::infinity(), 0, "not measured"};
    if (judged) candidate.wrong += found->judgement.wrongness[q];
    if (candidate.worst_id.empty() || worst.cost > candidate.worst_cost) {
      candidate.worst_cost = worst.cost;
      candidate.worst_id = case_id(set, worst.index);
      candidate.worst_reason = worst.reason;
    }
  }
  candidate.nanoseconds /= static_cast<double>(sets.size());
  return candidate;
}

}  // namespace

std::vector<Candidate> candidates(std::span<const SetResult> sets, QueryKind query) {
  std::vector<Candidate> found;
  for (const SetResult& set : sets) {
    for (const BackendResult& backend : set.backends) {
      const bool known = std::any_of(found.begin(), found.end(), [&](const Candidate& candidate) {
        return candidate.backend == backend.name;
      });
      if (!known) found.push_back(sum_up(sets, backend.name, query));
    }
  }
  return found;
}

Verdict decide(std::span<const SetResult> sets, QueryKind query, double max_error) {
  return decide(candidates(sets, query), query, max_error);
}

Verdict decide(std::vector<Candidate> candidates, QueryKind query, double max_error) {
  Verdict verdict{query, max_error, {}, std::move(candidates)};
  for (Candidate& candidate : verdict.candidates)
    candidate.inside = candidate.worst_cost <= max_error && std::isfinite(candidate.nanoseconds);
  std::stable_sort(verdict.candidates.begin(), verdict.candidates.end(),
                   [](const Candidate& x, const Candidate& y) {
                     if (x.inside != y.inside) return x.inside;
                     return x.inside ? x.nanoseconds < y.nanoseconds : x.worst_cost < y.worst_cost;
                   });
  if (!verdict.candidates.empty() && verdict.candidates.front().inside) {
    verdict.fastest = verdict.candidates.front().backend;
  }
  return verdict;
}

std::string sentence(const Verdict& verdict) {
  const std::string asked =
      fmt::format("within {:.3g} m on every {} case", verdict.max_error, to_string(verdict.query));
  if (verdict.fastest.empty()) return "no backend stays " + asked;
  const Candidate& first = verdict.candidates.front();
  return fmt::format("fastest {}: {}, {:.0f} ns a pair{}", asked, verdict.fastest, first.nanoseconds,
                     first.wrong.total() == 0 ? "" : ", with " + wrong_words(first.wrong));
}

std::string wrong_words(const Wrongness& wrong) {
  if (wrong.total() == 0) return fmt::format("0 wrong of {}", format_count(wrong.cases));
  std::string text;
  for (const auto& [count, name] : wrong.kinds())
    if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", format_count(count), name);
  return text;
}

std::string speed_text(const Candidate& candidate) {
  const std::string text = format_ns(candidate.nanoseconds);
  return candidate.wrong.total() == 0 || std::isnan(candidate.nanoseconds) ? text : "(" + text + ")";
}

std::string reason_out(const Verdict& verdict, const Candidate& candidate) {
  if (candidate.worst_cost > verdict.max_error) {
    const std::string reason = candidate.worst_reason.empty() ? "error" : candidate.worst_reason;
    if (format_error(candidate.worst_cost) == format_error(verdict.max_error))
      return fmt::format("{} costs just over the allowed error in {}", reason, candidate.worst_id);
    return std::isinf(candidate.worst_cost)
               ? fmt::format("{} in {}", reason, candidate.worst_id)
               : fmt::format("{} costs {} m in {}", reason, format_error(candidate.worst_cost),
                             candidate.worst_id);
  }
  if (!candidate.inside) return "not timed in every set";
  if (candidate.backend == verdict.fastest) return "the fastest inside";
  return fmt::format("{:.3g} times slower", candidate.nanoseconds / verdict.candidates.front().nanoseconds);
}

std::string headline(const Verdict& verdict) {
  if (verdict.fastest.empty()) return sentence(verdict);
  const Candidate& first = verdict.candidates.front();
  std::string text = fmt::format("{}, {} ns a pair, {}", first.backend, format_ns(first.nanoseconds),
                                 wrong_words(first.wrong));
  for (const Candidate& other : verdict.candidates) {
    if (other.backend == first.backend) continue;
    text += "; " + other.backend;
    const double ratio = other.nanoseconds / first.nanoseconds;
    if (std::isfinite(ratio) && other.wrong.total() == 0) {
      text += ratio >= 1 ? fmt::format(" is {:.3g} times slower,", ratio)
                         : fmt::format(" is {:.3g} times faster,", 1 / ratio);
    }
    text += " " + wrong_words(other.wrong);
  }
  return text;
}

}  // namespace touchstone::comparison
