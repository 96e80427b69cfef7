#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace touchstone::comparison {

/// A sentence of a verdict with {names} to fill in. results.json and the page carry them, so that
/// whatever decides from the counts uses the same words.
struct VerdictText {
  std::string_view name, text;
};

inline constexpr VerdictText kVerdictTexts[] = {
    {"fastest",
     "fastest within {error} m on {which}{domain}: {backend}, {ns} ns a pair{with}; {beyond}; of {cases} of "
     "{all} cases"},
    {"with", ", with {wrong}"},
    {"none", "no backend stays within {error} m on {which}{domain}; of {cases} of {all} cases"},
    {"empty", "nothing is compared: none of {all} cases is in what was chosen{domain}"},
    {"every", "every {query} case"},
    {"all_but", "all but {share} % of {query} cases"},
    {"beyond_none", "none of these pairs is beyond it, at most {bound} % (95 %)"},
    {"beyond_some", "{share} % of these pairs are beyond it, at most {bound} % (95 %)"},

    {"domain", " ({parts})"},
    {"classes_1", "apart only"},
    {"classes_2", "touching only"},
    {"classes_3", "apart or touching"},
    {"classes_4", "deep only"},
    {"classes_5", "apart or deep"},
    {"classes_6", "contacts only"},
    {"classes_0", "no class"},
    {"apart_up_to", "apart up to {limit} m"},
    {"within", "coordinates up to {limit} m"},
    {"without_normals", "without normals"},
    {"without_points", "without points"},
    {"coverage", "coverage from {coverage}"},
    {"deadline", "a call within {deadline} s at 99.9 %"},
    {"no_allocations", "no allocations"},
    {"sets", "of {names}"},

    {"wrong_none", "0 wrong of {cases}"},
    {"wrong_kind", "{count} {kind}"},
    {"unsupported", "{count} unsupported"},
    {"headline", "{backend}, {ns} ns a pair, {wrong}"},
    {"other", "; {backend}{speed} {wrong}"},
    {"slower", " is {ratio} times slower,"},
    {"faster", " is {ratio} times faster,"},

    {"out_missing", "not measured in {set}"},
    {"out_unsupported", "{count} of {cases} unsupported"},
    {"out_beyond", "{reason} in {case}"},
    {"out_just_over", "{reason}, just over, in {case}"},
    {"out_coverage", "coverage"},
    {"out_untimed", "not timed in every set"},
    {"out_deadline", "a call takes {p999} ns at 99.9 %"},
    {"out_few_calls", "too few calls for 99.9 %"},
    {"out_allocations", "{allocations} allocations a query"},
    {"out_uncounted", "allocations not counted"},
    {"first", "the fastest inside"},
    {"ratio", "{ratio} times slower"},
};

using TextValues = std::initializer_list<std::pair<std::string_view, std::string>>;
/// The text of that name, filled in. @pre the name is one of kVerdictTexts, and every {name} in it has a
/// value.
std::string fill(std::string_view name, TextValues values = {});

}  // namespace touchstone::comparison
