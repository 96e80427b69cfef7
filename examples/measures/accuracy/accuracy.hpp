#pragma once

#include <array>
#include <string_view>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/measures/accuracy/cost_curves.hpp"
#include "touchstone/examples/measures/common/quantiles.hpp"
#include "touchstone/examples/measures/runs/backend_run.hpp"
#include "touchstone/examples/measures/truth/oracle.hpp"

namespace touchstone::measures {

/// Wrong and missing answers to one kind of query. What a backend does not support is counted apart: it is no
/// wrong answer, and matters where it was asked for.
struct Wrongness {
  std::size_t cases = 0;
  std::size_t missed = 0;   ///< `separated`, yet the solids touch or overlap
  std::size_t phantom = 0;  ///< `overlapping`, yet they are apart
  std::size_t undecided = 0;
  std::size_t failed = 0;
  std::size_t unsupported = 0;
  /// The class is right but a figure that was asked for is not finite, or there are no points.
  std::size_t missing = 0;

  Wrongness& operator+=(const Wrongness& more);
  std::size_t total() const { return missed + phantom + undecided + failed + missing; }
  std::size_t supported() const { return cases - unsupported; }
  /// Every case has a right answer.
  bool is_complete() const { return total() == 0 && unsupported == 0; }

  struct Kind {
    std::size_t count;
    const char* name;
  };
  /// Each kind of total() with its name, in the order of the reports.
  std::array<Kind, 5> kinds() const {
    return {{{missed, "missed"},
             {phantom, "phantom"},
             {undecided, "undecided"},
             {failed, "failed"},
             {missing, "no value"}}};
  }
};

/// The figures that are measured; all but the last three in metres.
enum class Measure : std::uint8_t {
  distance,         ///< |separation - d| of pairs that are apart
  depth,            ///< |separation - d| of pairs in contact
  normal,           ///< |h(n) - d|: h the exact separation along the returned n
  witness,          ///< largest of p_A to A's surface, p_B to B's, |p_B - p_A - s n|
  deepest,          ///< manifold: |deepest point's separation - d|
  point_witness,    ///< manifold: worst witness error of its points
  patch_coverage,   ///< manifold: |area of its hull / area of the true patch - 1|, of contacts face on face
  tilted_coverage,  ///< manifold: the same of all other contacts whose patch has an area
  stability,        ///< manifold: change of the ratio of contacts face on face when B moves by 1e-9 S
};
inline constexpr std::size_t kMeasures = 9;
/// A contact is face on face when n is within this of a face normal of A and of one of -B [rad]: what three
/// decimals of a metre turn the normal of a face of 0.1 m by.
inline constexpr double kFaceOnFaceAngle = 0x1p-6;
std::string_view to_string(Measure measure);
std::string_view definition(Measure measure);
/// Says in one sentence what an answer to the query costs [m]; the rules for all queries are cost_rules().
std::string_view cost_definition(QueryKind query);
/// Says what wrong, missing and unsupported answers cost, and what doubles can hold.
std::array<std::string_view, 5> cost_rules();
constexpr bool is_length(Measure measure) { return measure < Measure::patch_coverage; }

/// The same errors divided by S and by the pair's size; ratios are not divided.
struct ErrorStats {
  Quantiles over_scale, over_size;
};

/// The case that costs most: what --max-error is held against.
struct WorstCase {
  double cost = 0;  ///< [m], CaseErrors::cost
  std::size_t index = 0;
  const char* reason = "";                      ///< of kCostReasons
  PairStatus status = PairStatus::unsupported;  ///< the answer
  double separation = kNaN;                     ///< NaN: it carries none [m]
  Vector3 n_AB_W = Vector3::Constant(kNaN);
};

/// One case of the figure "error against true separation", both over S and signed.
struct SignedError {
  double separation = 0;
  double error = 0;  ///< separation answered - d
  std::size_t index = 0;
};
/// As many worst wrong cases a query, and signed errors, as a judgement keeps.
inline constexpr std::size_t kKeptWrongCases = 3, kKeptSignedErrors = 48;

struct Judgement {
  std::array<Wrongness, 3> wrongness;    ///< by QueryKind, everything asked
  std::array<WorstCase, 3> worst;        ///< by QueryKind, of the supported cases
  std::array<Quantiles, 3> cost;         ///< CaseErrors::cost over S, by QueryKind, of the supported cases
  std::array<Curve, 3> cost_curve = {};  ///< the distributions of the same
  std::array<CostCurves, 3> curves;      ///< by QueryKind: what verdicts are made of
  std::array<std::vector<WorstCase>, 3>
      wrong_cases;                           ///< by QueryKind: the wrong or missing answers that cost most
  std::vector<SignedError> signed_errors;    ///< distance: cases evenly spread over the set, and the worst
  std::array<ErrorStats, kMeasures> errors;  ///< over all cases that carry the figure, wrong class or not
};

/// One case's errors, NaN where the answer carries no such figure, and what it costs a user.
struct CaseErrors {
  std::array<double, kMeasures> values;
  /// By QueryKind and by what is asked, see cost_definition().
  std::array<std::array<CaseCost, kAskedKinds>, 3> charges;
  std::array<bool, 3> unsupported;
  /// Manifold, in contact: share of the true patch that the points' hull covers, 0 to 1; 0 without points. 1
  /// where the patch has no area, and apart.
  double coverage = 1;

  /// With everything asked.
  const CaseCost& cost(QueryKind kind) const { return charges[index_of(kind)][kAskedKinds - 1]; }
};
CaseErrors case_errors(const PosedPair& posed, const PairTruth& truth, const Oracle& oracle,
                       const BackendAnswers& answers, std::size_t index);

/// Of a case that was answered in two ways the worse answer stays: a wrong class before a failed answer, then
/// undecided, without a value, unsupported, right; of two of these the one that costs more, of equal costs
/// the one whose points cover less of the patch. The lists of later answers are empty afterwards.
/// @param threads for the exact measures.
void take_worse_answers(const PairSet& set, std::span<const PairTruth> truth, const Oracle& oracle,
                        BackendAnswers& answers, int threads);

/// The errors of every case of the set, of each backend, on `threads` threads. What a case's points are
/// measured by is made once for all backends.
std::vector<std::vector<CaseErrors>> all_case_errors(const PairSet& set, std::span<const PairTruth> truth,
                                                     const Oracle& oracle,
                                                     std::span<const BackendAnswers> answers, int threads,
                                                     const Progress& progress = {});

/// Sums up errors of every case.
Judgement judge(const PairSet& set, std::span<const PairTruth> truth, const BackendAnswers& answers,
                std::span<const CaseErrors> errors);
/// The two of them. @param threads for the exact measures.
Judgement judge(const PairSet& set, std::span<const PairTruth> truth, const Oracle& oracle,
                const BackendAnswers& answers, int threads, const Progress& progress = {});

/// Errors of figures up to this cost nothing: two ulps of S [m]. A point's coordinates are multiples of an
/// ulp; rounding both points of a witness moves p_B - p_A by up to sqrt(3) ulps, whoever computes them.
double held_by_doubles(double scale);

}  // namespace touchstone::measures
