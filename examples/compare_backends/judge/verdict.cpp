#include "touchstone/examples/compare_backends/judge/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/compare_backends/judge/upper_bound.hpp"
#include "touchstone/examples/compare_backends/judge/verdict_texts.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {
namespace {

std::size_t beyond_of(const AskedCosts& asked, const Choice& choice) {
  const std::size_t needed =
      choice.query == QueryKind::manifold ? bin_of(choice.min_coverage, kCoverageBins) : 0;
  std::size_t beyond = 0;
  for (const auto& [bin, codes] : asked.counts) {
    for (const auto& [code, count] : codes)
      if (bin < needed || cost_of_code(code) > choice.max_error) beyond += count;
  }
  return beyond;
}

void add(Candidate& candidate, const StratumCosts& stratum, const ChoiceSet& set, const Choice& choice) {
  const AskedCosts& asked = stratum.asked[choice.asked()];
  Wrongness wrong{stratum.cases,  stratum.missed,      stratum.phantom, stratum.undecided,
                  stratum.failed, stratum.unsupported, asked.missing};
  candidate.wrong += wrong;
  candidate.beyond += beyond_of(asked, choice);
  const double worst = cost_of_code(asked.worst_code);
  if (worst <= candidate.worst_cost) return;
  candidate.worst_cost = worst;
  candidate.worst_id = asked.worst_index < set.ids.size() ? set.ids[asked.worst_index] : "";
  candidate.worst_reason = kCostReasons[asked.worst_reason];
}

Candidate sum_up(std::span<const ChoiceSet* const> sets, const std::string& name, const Choice& choice) {
  Candidate candidate;
  candidate.backend = name;
  const std::size_t q = index_of(choice.query);
  for (const ChoiceSet* set : sets) {
    const auto found = std::find_if(set->backends.begin(), set->backends.end(),
                                    [&](const ChoiceSet::Backend& each) { return each.name == name; });
    if (found == set->backends.end()) {
      if (candidate.missing_set.empty()) candidate.missing_set = set->name;
      continue;
    }
    const ChoiceSet::Answers& answers = found->queries[q];
    candidate.nanoseconds += answers.nanoseconds;
    candidate.p999_ns = larger(candidate.p999_ns, answers.p999_ns);
    candidate.allocations = larger(candidate.allocations, answers.allocations);
    for (const StratumCosts& stratum : answers.curves)
      if (choice.has(stratum.stratum)) add(candidate, stratum, *set, choice);
  }
  candidate.nanoseconds /= static_cast<double>(sets.size());
  if (!candidate.missing_set.empty()) candidate.nanoseconds = kNaN;
  return candidate;
}

bool is_inside(const Candidate& candidate, const Choice& choice) {
  return candidate.missing_set.empty() && candidate.wrong.unsupported == 0 &&
         static_cast<double>(candidate.beyond) <= choice.share * static_cast<double>(candidate.wrong.cases) &&
         std::isfinite(candidate.nanoseconds) &&
         (std::isinf(choice.deadline) || candidate.p999_ns <= choice.deadline * 1e9) &&
         (!choice.no_allocations || candidate.allocations == 0);
}

// Those outside: who answered all before who did not, then by share and cost.
bool stands_before(const Candidate& x, const Candidate& y) {
  if (x.inside != y.inside) return x.inside;
  if (x.inside) return x.nanoseconds < y.nanoseconds;
  const bool answered_x = x.missing_set.empty() && x.wrong.unsupported == 0;
  const bool answered_y = y.missing_set.empty() && y.wrong.unsupported == 0;
  if (answered_x != answered_y) return answered_x;
  if (x.share() != y.share()) return x.share() < y.share();
  return x.worst_cost < y.worst_cost;
}

std::string general(double value) { return fmt::format("{:.3g}", value); }

void add_part(std::string& parts, const std::string& part) { parts += (parts.empty() ? "" : ", ") + part; }

std::string domain_text(const Choice& choice) {
  std::string parts;
  const int classes = (choice.apart ? 1 : 0) + (choice.touching ? 2 : 0) + (choice.deep ? 4 : 0);
  if (classes != 7) add_part(parts, fill("classes_" + std::to_string(classes)));
  const double apart = upper_end(choice.apart_up_to, kApartBins),
               within = upper_end(choice.within, kWithinBins);
  if (choice.apart && std::isfinite(apart)) add_part(parts, fill("apart_up_to", {{"limit", general(apart)}}));
  if (std::isfinite(within)) add_part(parts, fill("within", {{"limit", general(within)}}));
  if (choice.query != QueryKind::overlap) {
    if (!choice.normals) add_part(parts, fill("without_normals"));
    if (!choice.points) add_part(parts, fill("without_points"));
  }
  if (choice.query == QueryKind::manifold && choice.min_coverage > 0)
    add_part(parts, fill("coverage", {{"coverage", general(upper_end(choice.min_coverage, kCoverageBins))}}));
  if (std::isfinite(choice.deadline))
    add_part(parts, fill("deadline", {{"deadline", general(choice.deadline)}}));
  if (choice.no_allocations) add_part(parts, fill("no_allocations"));
  std::string names;
  for (const std::string& name : choice.sets) add_part(names, name);
  if (!names.empty()) add_part(parts, fill("sets", {{"names", names}}));
  return parts.empty() ? "" : fill("domain", {{"parts", parts}});
}

std::string which_text(const Choice& choice) {
  const std::string query(to_string(choice.query));
  return choice.share == 0 ? fill("every", {{"query", query}})
                           : fill("all_but", {{"share", format_percent(choice.share)}, {"query", query}});
}

std::string bound_text(const Candidate& candidate) {
  return format_percent(upper_bound_95(candidate.beyond, candidate.wrong.supported()));
}

std::string beyond_sentence(const Candidate& candidate) {
  return candidate.beyond == 0 ? fill("beyond_none", {{"bound", bound_text(candidate)}})
                               : fill("beyond_some", {{"share", format_percent(candidate.share())},
                                                      {"bound", bound_text(candidate)}});
}

// The cost and the share stand beside it.
std::string reason_beyond(const Verdict& verdict, const Candidate& candidate) {
  const double allowed = verdict.choice.max_error;
  if (candidate.worst_cost <= allowed) return fill("out_coverage");
  const bool just_over = format_error(candidate.worst_cost) == format_error(allowed);
  return fill(just_over ? "out_just_over" : "out_beyond",
              {{"reason", candidate.worst_reason}, {"case", candidate.worst_id}});
}

}  // namespace

double Candidate::share() const {
  const std::size_t supported = wrong.supported();
  return supported == 0 ? 0.0 : static_cast<double>(beyond) / static_cast<double>(supported);
}

Verdict decide(std::span<const ChoiceSet> sets, const Choice& choice) {
  Verdict verdict;
  verdict.choice = choice;
  std::vector<const ChoiceSet*> chosen;
  std::vector<std::string> names;
  for (const ChoiceSet& set : sets) {
    verdict.all += set.cases;
    const std::size_t cases = cases_in(set, choice);
    if (cases == 0) continue;
    verdict.cases += cases;
    chosen.push_back(&set);
    for (const ChoiceSet::Backend& backend : set.backends)
      if (std::find(names.begin(), names.end(), backend.name) == names.end()) names.push_back(backend.name);
  }
  for (const std::string& name : names) {
    verdict.candidates.push_back(sum_up(chosen, name, choice));
    verdict.candidates.back().inside = is_inside(verdict.candidates.back(), choice);
  }
  std::stable_sort(verdict.candidates.begin(), verdict.candidates.end(), stands_before);
  if (!verdict.candidates.empty() && verdict.candidates.front().inside)
    verdict.fastest = verdict.candidates.front().backend;
  return verdict;
}

std::string sentence(const Verdict& verdict) {
  const std::string all = format_count(verdict.all), domain = domain_text(verdict.choice);
  if (verdict.is_empty()) return fill("empty", {{"all", all}, {"domain", domain}});
  const std::string error = general(verdict.choice.max_error), which = which_text(verdict.choice);
  const std::string cases = format_count(verdict.cases);
  if (verdict.fastest.empty())
    return fill("none",
                {{"error", error}, {"which", which}, {"domain", domain}, {"cases", cases}, {"all", all}});
  const Candidate& first = verdict.candidates.front();
  const std::string with =
      first.wrong.total() == 0 ? "" : fill("with", {{"wrong", wrong_words(first.wrong)}});
  return fill("fastest", {{"error", error},
                          {"which", which},
                          {"domain", domain},
                          {"backend", first.backend},
                          {"ns", format_ns(first.nanoseconds)},
                          {"with", with},
                          {"beyond", beyond_sentence(first)},
                          {"cases", cases},
                          {"all", all}});
}

std::string wrong_words(const Wrongness& wrong) {
  std::string text;
  for (const auto& [count, name] : wrong.kinds())
    if (count > 0) add_part(text, fill("wrong_kind", {{"count", format_count(count)}, {"kind", name}}));
  if (text.empty() && wrong.supported() > 0)
    text = fill("wrong_none", {{"cases", format_count(wrong.supported())}});
  if (wrong.unsupported > 0)
    add_part(text, fill("unsupported", {{"count", format_count(wrong.unsupported)}}));
  return text.empty() ? fill("wrong_none", {{"cases", "0"}}) : text;
}

std::string speed_text(const Candidate& candidate) {
  const std::string text = format_ns(candidate.nanoseconds);
  return candidate.wrong.is_complete() || std::isnan(candidate.nanoseconds) ? text : "(" + text + ")";
}

std::string reason_out(const Verdict& verdict, const Candidate& candidate) {
  const Choice& choice = verdict.choice;
  if (candidate.inside) {
    if (candidate.backend == verdict.fastest) return fill("first");
    return fill("ratio",
                {{"ratio", general(candidate.nanoseconds / verdict.candidates.front().nanoseconds)}});
  }
  if (!candidate.missing_set.empty()) return fill("out_missing", {{"set", candidate.missing_set}});
  if (candidate.wrong.unsupported > 0)
    return fill("out_unsupported", {{"count", format_count(candidate.wrong.unsupported)},
                                    {"cases", format_count(candidate.wrong.cases)}});
  if (static_cast<double>(candidate.beyond) > choice.share * static_cast<double>(candidate.wrong.cases))
    return reason_beyond(verdict, candidate);
  if (!std::isfinite(candidate.nanoseconds)) return fill("out_untimed");
  if (std::isfinite(choice.deadline) && std::isnan(candidate.p999_ns)) return fill("out_few_calls");
  if (std::isfinite(choice.deadline) && candidate.p999_ns > choice.deadline * 1e9)
    return fill("out_deadline", {{"p999", format_ns(candidate.p999_ns)}});
  if (std::isnan(candidate.allocations)) return fill("out_uncounted");
  return fill("out_allocations", {{"allocations", format_allocations(candidate.allocations)}});
}

std::string headline(const Verdict& verdict) {
  if (verdict.fastest.empty()) return "";
  const Candidate& first = verdict.candidates.front();
  std::string text = fill("headline", {{"backend", first.backend},
                                       {"ns", format_ns(first.nanoseconds)},
                                       {"wrong", wrong_words(first.wrong)}});
  for (const Candidate& other : verdict.candidates) {
    if (other.backend == first.backend) continue;
    const double ratio = other.nanoseconds / first.nanoseconds;
    std::string speed;
    if (std::isfinite(ratio) && other.wrong.is_complete())
      speed = ratio >= 1 ? fill("slower", {{"ratio", general(ratio)}})
                         : fill("faster", {{"ratio", general(1 / ratio)}});
    text +=
        fill("other", {{"backend", other.backend}, {"speed", speed}, {"wrong", wrong_words(other.wrong)}});
  }
  return text;
}

std::string beyond_text(const Candidate& candidate) {
  return candidate.beyond == 0
             ? "0"
             : format_count(candidate.beyond) + " (" + format_percent(candidate.share()) + " %)";
}

std::string format_allocations(double allocations) {
  return std::isnan(allocations) ? "-" : fmt::format("{:.3g}", allocations);
}

std::string format_percent(double share) {
  const double percent = 100 * share;
  return percent < 99.5 ? fmt::format("{:.2g}", percent) : fmt::format("{:.3g}", percent);
}

}  // namespace touchstone::comparison
