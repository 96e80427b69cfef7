#pragma once

#include <string_view>

#include "touchstone/examples/compare_backends/names.hpp"

namespace touchstone::comparison {

/// Documents a key of results.json. Objects whose keys are names (queries, errors, libraries, definitions,
/// parameters, pareto_front, least_that_serves, consistency of the root) are described by their own key.
struct SchemaEntry {
  std::string_view where;  ///< the object that holds it
  std::string_view keys;   ///< one or more, separated by spaces
  std::string_view meaning;
};

inline constexpr SchemaEntry kJsonSchema[] = {
    {"root", "schema command seed version date", "name and number of this format; how and when it was made"},
    {"root", "partial not_measured",
     "true: the run ended early; the sets, scenes and parts that are missing then"},
    {"root", "engine_messages",
     "lines that engines wrote by themselves, kept in engines.log; a merge counts those of the shards, too, "
     "which the shards printed"},
    {"root", "corpus", "with --corpus: what was asked; sha256 of its manifest"},
    {"corpus", "name sha256", "as its manifest says; of that file"},
    {"root", "machine", "cpu, instruction_set, hardware_threads, system, compiler, build_type, flags"},
    {"machine", "cpu instruction_set hardware_threads system compiler build_type flags",
     "what the figures were measured with"},
    {"root", "shards_elsewhere",
     "of a merge, only where there are such: shards of other machines than `machine`"},
    {"shards_elsewhere", "k n cpu instruction_set compiler",
     "shard k of n, and what its pairs were measured with"},
    {"root", "libraries", "name: version, besides the engines"},
    {"root", "timing", "how times were taken"},
    {"timing", "pairs_a_family pairs_a_block pairs_a_batch repetitions seconds_a_row_and_repetition_at_most",
     "sizes of the measurement"},
    {"root, timing", "definitions", "name: definition, of errors (root) and of rows of times (timing)"},
    {"root", "gaps", "what is not in this build, and why"},
    {"gaps, thread_gaps", "what why", "texts"},
    {"root", "measured_against_exact", "false: no errors were measured"},
    {"root", "curve_shares", "the shares at which every curve is given"},
    {"root", "backends", "every backend: name, description with its version"},
    {"root", "pair_sets", "the families, the corpus's, then the pair file"},
    {"pair_sets, cases", "name description cases contacts touching backends",
     "a set: its pairs, how many are in contact, how many of these exactly touching"},
    {"pair_sets, cases", "pareto_front", "by query: backends that none beats in worst error and median time"},
    {"backends", "backend capabilities failure", "name; what it declares; why it did not take the whole set"},
    {"capabilities",
     "distance penetration manifold overlap_complete scalar_bits deterministic thread_safe resolution "
     "absolute_m relative",
     "as declared; resolution = absolute_m + relative * scale"},
    {"backends", "queries", "overlap, distance, manifold"},
    {"queries", "single cached batch raw frame", "rows of times, see timing.definitions; null: not measured"},
    {"times", "median_ns p99_ns minimum_ns lower_quartile_ns upper_quartile_ns blocks pairs_a_block",
     "of the averages of blocks of pairs, ns a pair (frame: ns a frame); p99_ns null below 100 blocks"},
    {"times", "p999_ns calls",
     "99.9 % of single calls (frame: frames), the clock's own time included; null below 1 000 calls"},
    {"times", "repetition_medians_ns", "the median of each of the first 32 repetitions: the samples of diff"},
    {"queries", "allocations_per_query", "null: not counted"},
    {"queries", "wrong", "counts of wrong and missing answers"},
    {"wrong", "cases missed phantom undecided failed unsupported missing_value",
     "of cases; missed: reported apart, yet in contact; phantom: reported in contact, yet apart"},
    {"wrong", "share_below_95",
     "upper 95 % confidence bound of each share of the supported, and of any but unsupported"},
    {"share_below_95", "any", "of all kinds together"},
    {"queries", "cost_over_S cost_curve_over_S",
     "the query's error, which --max-error is held against (see Errors), over S: quantiles, and values at "
     "curve_shares"},
    {"queries", "worst wrong_cases", "the dearest case; the wrong or missing answers that cost most"},
    {"worst, wrong_cases", "cost_m case reason", "[m], id, what was wrong"},
    {"worst, wrong_cases", "status separation_m normal", "the answer; null: it carries none"},
    {"quantiles", "median p99 worst_case", "nearest rank; the case of the worst"},
    {"backends", "errors", "by measure, see definitions; lengths over S and over size, ratios as they are"},
    {"errors", "over_S over_size ratio", "quantiles"},
    {"backends", "signed_errors_over_S", "[true separation, error, case] of some pairs"},
    {"backends", "consistency", "the same pairs asked in other ways"},
    {"consistency", "swapped moved repeated threads", "(b,a); moved rigidly; again in reverse; on threads"},
    {"consistency", "classes_changed bits_changed left_out worst_over_S",
     "pairs whose class, or any bit, changed; whose class was not compared; largest change of a separation, "
     "null: none was given"},
    {"root", "path_sets", "times of impact of those of the corpus's sets that are paths"},
    {"path_sets", "name paths poses meets open unseen backends",
     "paths, of so many cases each: which meet, are not decided, and meet at none of their poses"},
    {"path_sets.backends", "gap check",
     "why it was not asked; proven: by its separations, sampled: by its verdict at poses, swept: an engine's "
     "own sweep"},
    {"path_sets.backends", "sweep", "of an engine's own sweep, which is no backend: one line, with version"},
    {"path_sets.backends", "first_pose", "the first of a path's poses that it calls contact; not of sweeps"},
    {"first_pose", "right later earlier open", "than the exact one; open: it says neither before"},
    {"path_sets.backends", "impacts", "where motion stops"},
    {"impacts", "answered missed late phantom early open failed unsupported",
     "missed: it goes through; late: it stops in the contact; phantom: it stops on a clear path; early: 1e-3 "
     "S and more before the contact"},
    {"path_sets.backends", "worst wrong_cases", "the dearest answer; the wrong and open ones that cost most"},
    {"worst, wrong_cases", "path stops_at_s", "s from 0 to 1; cost_m: how deep there, or how far apart"},
    {"root", "broadphases", "one entry a broadphase and swarm"},
    {"broadphases",
     "broadphase objects hexahedra_each gap frames frame_ms minimum with_overlap_ms candidates_per_frame "
     "allocations_per_frame missed true_pairs true_pairs_from",
     "gap: why it was not run; missed: of true_pairs, null: not checked"},
    {"root", "scenes", "one entry a scene"},
    {"scenes", "file rate_hz duration_s gap_m parameters frames_of_the_scene pairs exact_first_contact_s",
     "the scene as it was stepped"},
    {"scenes.backends",
     "first_contact_s missed_frames phantom_frames undecided_frames worst_clearance_error_m",
     "over the frames"},
    {"scenes.backends", "frame_outcomes",
     "one character a frame: . free, b blocked rightly, w wrongly, m merged"},
    {"scenes.backends", "clearance_at_stop_m", "exact clearance of the last frame before the first block"},
    {"scenes", "trade", "the least that serves: models of the scene, choices of pairs, backends and queries"},
    {"trade", "allowed_m frames all_frames frames_near_contact", "--max-error or the gap; the frames judged"},
    {"trade", "frames_that_differ_in_class frames_wrong_below_95",
     "where two models differ in exact class; 95 % bound of the share of frames with an error that none of "
     "them has"},
    {"trade", "round reference_width_m selection_frames",
     "judged against the true round parts, known to half of this; frames over which needed pairs were looked "
     "for"},
    {"trade", "rows", "one a model, choice of pairs, backend and query"},
    {"rows", "model hexahedra selected all_pairs query frame_ns wrong_frames serves",
     "selected: only the pairs that the motion needs, of all_pairs; wrong_frames: by the backend"},
    {"rows", "geometry_error_m backend_error_m error_m",
     "exact answers for the row's hexahedra and pairs against the true ones; the backend's against these; "
     "the sum"},
    {"trade", "steps allowed_m row",
     "the cheapest row (index into rows) for this allowed error and up to the next"},
    {"trade", "least_that_serves", "by query, null: none"},
    {"least_that_serves", "row thin", "index into rows; why that is no recommendation; empty: it is one"},
    {"root", "selection", "a contact world of boxes, some of them switched off"},
    {"selection", "switched_off frame_us", "of objects; what a frame costs"},
    {"root", "consistency", "by backend: over all pair_sets"},
    {"root", "fitted_slopes",
     "of the logarithms of time against size, where nothing is wrong; null: fewer than three points"},
    {"fitted_slopes", "along slope", "objects, hexahedra an object, or threads"},
    {"root", "dynamics", "of --dynamics: one entry a scene and backend, as dynamics_run found it"},
    {"dynamics",
     "scene pose_error_m unexplained_momentum_ns energy_made_over_scale deepest_m step_ns step_p99_9_ns "
     "allocations answers answers_met misses build_on",
     "step_ns: median; misses: what its run was out in; build_on: the backend that dynamics_run names for "
     "the scene; gap: why it did not end"},
    {"root", "thread_runs", "distances on several threads"},
    {"root", "thread_gaps", "backends that were not run on several threads, and why"},
    {"thread_runs", "threads pass", "wall-clock times of whole passes, ns a pair"},
    {"root", "gallery", "the worst cases"},
    {"gallery", "set replay shown_for cost_over_S S_m exact answers vertices_A_m vertices_B_m",
     "world vertices in the order of Hexahedron; answers of every backend to that query"},
    {"exact, answers", "class status separation_m normal normal_unique", "normal: unit, from A to B"},
    {"root", "rankings", "over pair_sets, by query"},
    {"rankings", "standings mean_ns worst_cost_over_S", "the right ones by speed, then the others"},
    {"root", "choices",
     "what verdicts are decided from: every set's cases, counted by kind of pair, by what is asked and by "
     "cost"},
    {"choices", "deep_over_size apart_bins_m within_bins_m coverage_bins",
     "a contact is deep beyond this share of the larger solid's size; upper ends of the bins, the last open"},
    {"choices", "codes_a_decade last_code first_exponent reasons texts",
     "code c is (10 + (c-1) mod codes_a_decade) * 10^(first_exponent + (c-1) div codes_a_decade) m, 0 none, "
     "last_code more; reasons by their place; the verdict's sentences"},
    {"choices", "sets", "name, cases, ids (of the dearest cases), backends"},
    {"choices.sets", "ids ns p999_ns allocations",
     "speed of the verdict, 99.9 % of a call, allocations a query"},
    {"choices.sets", "curves",
     "numbers in digits of 5 bits, least first, of A-Z a-z 0-9 + /, 32 added to all but a number's last. A "
     "list of: class (apart, touching, deep), apart bin, within bin, cases, missed, phantom, undecided, "
     "failed, unsupported; then for each thing asked (overlap one; else value, + normals, + points, both): "
     "missing, worst code, its id, its reason, number of coverage bins (0: as the one before), each: bin, "
     "number of codes, each: difference from the last, count"},
    {"root", "verdicts", "with --max-error: one a query, the one asked for first"},
    {"verdicts", "candidates choice of_cases fastest sentence headline",
     "cases: that it rests on, of_cases of the run"},
    {"choice",
     "of_sets classes apart_up_to_m within_m normals points max_error_m share min_coverage deadline_s "
     "no_allocations",
     "see --help; limits as taken; of_sets empty: all"},
    {"verdicts.candidates",
     "inside mean_ns beyond beyond_words beyond_below_95 worst_cost_m worst_reason wrong_words reason_out",
     "those inside by speed; beyond: cases dearer than allowed, with the 95 % bound of their share"},
};

inline constexpr std::string_view kCsvSchema =
    "One row a set, backend and query: set, backend, query; counts of wrong and missing answers (cases, "
    "missed, phantom, undecided, failed, unsupported, missing_value); median and 99th percentile of single, "
    "batch, raw, cached and frame [ns]; allocations_per_query; the dearest case (worst_cost_m, "
    "worst_cost_case, worst_cost_reason); for every measure median, p99, worst and its case, lengths over S "
    "and over size; partial: 1 in every row of a run that ended early. Empty: not measured. unsupported is "
    "no wrong answer.";

inline constexpr std::string_view kKnownLimits[] = {
    "Bounds speak of pairs drawn as these were, not of your pairs: bring them with --pairs.",
    "Times are of one machine, taken in one run; on shared machines read ratios, and compare runs with diff.",
    "The exact answer is of the hulls of the eight world vertices as doubles: posing's rounding is no error.",
    "Single-precision Bullet is timed in a process of its own, set by set, not block by block.",
    "Scenes are judged frame by frame on the commanded motion; what a stop changes later is training_run's.",
    "exact's class, separation and normal are exact to one rounding; its manifold points are computed in "
    "doubles, and off by "
    "rounding times a face's length over its width.",
    "A verdict's times are of all pairs of the sets that hold such pairs, not of these pairs alone.",
    "Signed errors and consistency look at some of a set's pairs, wrongness and errors at all of them.",
};

}  // namespace touchstone::comparison
