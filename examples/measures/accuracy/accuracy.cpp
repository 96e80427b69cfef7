#include "touchstone/examples/measures/accuracy/accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/measures/accuracy/surface_measure.hpp"
#include "touchstone/examples/measures/common/parallel.hpp"

namespace touchstone::measures {
namespace {

// ---- classes

const char* class_fault(PairStatus status, bool contact) {
  if (status == PairStatus::separated) return contact ? "missed contact" : nullptr;
  if (status == PairStatus::overlapping) return contact ? nullptr : "phantom contact";
  return to_string(status).data();
}

void count(Wrongness& wrongness, PairStatus status, bool contact, bool missing) {
  ++wrongness.cases;
  if (status == PairStatus::separated && contact)
    ++wrongness.missed;
  else if (status == PairStatus::overlapping && !contact)
    ++wrongness.phantom;
  else if (status == PairStatus::undecided)
    ++wrongness.undecided;
  else if (status == PairStatus::failed)
    ++wrongness.failed;
  else if (status == PairStatus::unsupported)
    ++wrongness.unsupported;
  else if (missing)
    ++wrongness.missing;
}

bool carries_geometry(PairStatus status, const PairGeometry& geometry) {
  return status != PairStatus::failed && status != PairStatus::unsupported &&
         std::isfinite(geometry.separation);
}

// ---- measures

// The two surfaces of a case, made when the first point is measured. Flat ones (rounding far out) go to the
// oracle.
class Surfaces {
 public:
  Surfaces(const PosedPair& posed, const Oracle& oracle) : posed_(posed), oracle_(oracle) {}
  double distance_to_a(const Vector3& p) { return distance(a_, posed_.a, p); }
  double distance_to_b(const Vector3& p) { return distance(b_, posed_.b, p); }

 private:
  double distance(std::optional<SurfaceMeasure>& surface, const WorldVertices& solid, const Vector3& p) {
    if (!surface) surface.emplace(solid);
    return surface->is_flat() ? oracle_.surface_distance(solid, p) : surface->distance(p);
  }

  const PosedPair& posed_;
  const Oracle& oracle_;
  std::optional<SurfaceMeasure> a_, b_;
};

double witness_error(Surfaces& surfaces, const Vector3& p_A_W, const Vector3& p_B_W, double separation,
                     const Vector3& n) {
  if (!is_finite(p_A_W) || !is_finite(p_B_W) || !is_finite(n) || !std::isfinite(separation)) return kNaN;
  const double on_a = surfaces.distance_to_a(p_A_W);
  const double on_b = surfaces.distance_to_b(p_B_W);
  return larger(larger(on_a, on_b), norm((p_B_W - p_A_W) - n * separation));
}

struct Point2 {
  double x, y;
};

double turn(const Point2& o, const Point2& a, const Point2& b) {
  return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

// Andrew's monotone chain, then the shoelace formula.
double hull_area(std::vector<Point2> points) {
  if (points.size() < 3) return 0.0;
  std::sort(points.begin(), points.end(),
            [](const Point2& a, const Point2& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  std::vector<Point2> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t base = hull.size();
    for (const Point2& p : points) {
      while (hull.size() >= base + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  double twice = 0.0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Point2 &p = hull[i], &q = hull[(i + 1) % hull.size()];
    twice += (p.x - hull[0].x) * (q.y - hull[0].y) - (q.x - hull[0].x) * (p.y - hull[0].y);
  }
  return std::abs(twice) / 2.0;
}

// The area of the points' hull, projected along n.
double manifold_area(std::span<const ContactPoint> points, const Vector3& n) {
  if (points.empty()) return 0.0;
  Vector3 hint = Vector3::Zero();
  int least = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (std::abs(n[axis]) < std::abs(n[least])) least = axis;
  }
  hint[least] = 1.0;
  Vector3 u = cross(n, hint);
  u /= norm(u);
  const Vector3 v = cross(n, u);
  std::vector<Point2> flat;
  for (const ContactPoint& point : points) {
    const Vector3 r = point.p_A_W - points[0].p_A_W;
    flat.push_back({dot(r, u), dot(r, v)});
  }
  return hull_area(std::move(flat));
}

// Twice the vector area of a face: outward, along its mean normal.
Vector3 area_vector(const WorldVertices& solid, int face) {
  const auto& loop = Hexahedron::kFaceVertices[static_cast<std::size_t>(face)];
  return cross(solid.vertex(loop[2]) - solid.vertex(loop[0]), solid.vertex(loop[3]) - solid.vertex(loop[1]));
}

bool has_face_along(const WorldVertices& solid, const Vector3& n) {
  for (int face = 0; face < 6; ++face) {
    const Vector3 area = area_vector(solid, face);
    if (dot(area, n) > 0.0 && norm(cross(area, n)) <= kFaceOnFaceAngle * norm(area)) return true;
  }
  return false;
}

std::span<const ContactPoint> manifold_points(const QueryAnswers& answers, std::size_t index) {
  const int count = std::clamp(answers.geometry[index].point_count, 0, kMaxManifoldPoints);
  return std::span(answers.points).subspan(index * kMaxManifoldPoints, static_cast<std::size_t>(count));
}

// Patches of less area [S2] are lines and points to rounding.
constexpr double kLeastPatch = 0x1p-40;
// Corners of the clip this close to the limit [S] may count or not.
constexpr double kSameLimit = 0x1p-36;

// The area of the true patch, along n: where corners lie at the limit itself, between two.
struct PatchArea {
  double least, most;

  PatchArea(const PosedPair& posed, const Oracle& oracle, const Vector3& n) {
    const double limit = query_for(QueryKind::manifold).max_point_separation;
    const double slack = kSameLimit * posed.scale;
    least = oracle.patch_area(posed.a, posed.b, n, limit - slack);
    most = oracle.patch_area(posed.a, posed.b, n, limit + slack);
  }
  /// Of what a hull of this area is off by. @pre most > 0
  double error(double area) const {
    return area < least ? 1.0 - area / least : std::max(area / most - 1.0, 0.0);
  }
};

double& at(CaseErrors& errors, Measure measure) { return errors.values[static_cast<std::size_t>(measure)]; }

void measure_distance(const PosedPair& posed, const PairTruth& truth, Surfaces& surfaces,
                      const QueryAnswers& answers, std::size_t index, CaseErrors& errors) {
  const PairGeometry& geometry = answers.geometry[index];
  if (!carries_geometry(answers.status[index], geometry)) return;
  at(errors, truth.contact() ? Measure::depth : Measure::distance) =
      std::abs(geometry.separation - truth.separation);
  if (is_finite(geometry.n_AB_W)) {
    at(errors, Measure::normal) =
        std::abs(separation_along(posed.a, posed.b, geometry.n_AB_W) - truth.separation);
  }
  at(errors, Measure::witness) =
      witness_error(surfaces, geometry.p_A_W, geometry.p_B_W, geometry.separation, geometry.n_AB_W);
}

void measure_manifold(const PosedPair& posed, const PairTruth& truth, const Oracle& oracle,
                      Surfaces& surfaces, const BackendAnswers& answers, std::size_t index,
                      CaseErrors& errors) {
  const QueryAnswers& manifold = answers.queries[index_of(QueryKind::manifold)];
  const PairGeometry& geometry = manifold.geometry[index];
  if (!carries_geometry(manifold.status[index], geometry)) return;
  const auto points = manifold_points(manifold, index);
  if (points.empty()) return;
  // The deepest of its points, and the worst witness error of all.
  double deepest = kInfinity, witness = 0.0;
  for (const ContactPoint& point : points) {
    deepest = std::isnan(point.separation) ? kNaN : std::min(deepest, point.separation);
    witness =
        larger(witness, witness_error(surfaces, point.p_A_W, point.p_B_W, point.separation, geometry.n_AB_W));
  }
  at(errors, Measure::deepest) = std::abs(deepest - truth.separation);
  at(errors, Measure::point_witness) = witness;
  if (!truth.contact() || !is_finite(geometry.n_AB_W)) return;
  // The area that they cover.
  const PatchArea patch(posed, oracle, geometry.n_AB_W);
  if (!(patch.most > kLeastPatch * posed.scale * posed.scale)) return;
  const double area = manifold_area(points, geometry.n_AB_W);
  errors.coverage = area < patch.least ? area / patch.least : 1.0;
  const bool face_on_face =
      has_face_along(posed.a, geometry.n_AB_W) && has_face_along(posed.b, -geometry.n_AB_W);
  at(errors, face_on_face ? Measure::patch_coverage : Measure::tilted_coverage) = patch.error(area);
  if (!face_on_face) return;
  // How much of that a push of 1e-9 S changes.
  const QueryAnswers& moved = answers.perturbed;
  if (moved.status.empty() || !carries_geometry(moved.status[index], moved.geometry[index])) return;
  const double moved_area = manifold_area(manifold_points(moved, index), moved.geometry[index].n_AB_W);
  at(errors, Measure::stability) = std::abs(moved_area - area) / patch.most;
}

// ---- costs

// The least cost of a wrong class: where solids touch exactly, it is wrong by nothing and still not right.
constexpr double kLeastWrong = std::numeric_limits<double>::denorm_min();

// A figure that an answer carries or should carry.
struct Figure {
  double error;  // not finite: missing
  const char* name;
  std::size_t asked;  // bits of AskedFigures; 0: always
};

struct Answer {
  const char* fault;   // of the class, null: right
  double exact;        // |exact signed distance| [m]
  double missing;      // what a missing normal or point costs [m]
  double held;         // errors up to this cost nothing [m]
  bool needs_figures;  // one that is not there is missing
};

void raise(CaseCost& cost, double to, const char* reason) {
  if (to > cost.cost) cost.cost = to, cost.reason = reason;
}

CaseCost charge(const Answer& answer, std::span<const Figure> figures, std::size_t asked) {
  CaseCost cost;
  if (answer.fault != nullptr) raise(cost, std::max(answer.exact, kLeastWrong), answer.fault);
  for (const Figure& figure : figures) {
    if ((figure.asked & ~asked) != 0) continue;
    if (std::isfinite(figure.error)) {
      if (figure.error > answer.held) raise(cost, figure.error, answer.fault ? answer.fault : figure.name);
    } else if (answer.needs_figures) {
      const double unknown = figure.asked == 0 ? answer.exact : answer.missing;
      raise(cost, std::max(unknown, kLeastWrong), answer.fault ? answer.fault : kNoValue);
      if (answer.fault == nullptr) cost.missing = true, cost.reason = kNoValue;
    }
  }
  return cost;
}

double error_of(double answered, double exact) {
  return std::isfinite(answered) ? std::abs(answered - exact) : kNaN;
}

std::vector<Figure> figures_of(const PairTruth& truth, const QueryAnswers& answers, std::size_t index,
                               QueryKind kind, const CaseErrors& errors, double manifold_normal) {
  const auto value = [&](Measure measure) { return errors.values[static_cast<std::size_t>(measure)]; };
  if (kind == QueryKind::overlap) return {};
  const PairStatus status = answers.status[index];
  const bool carries = carries_geometry(status, answers.geometry[index]);
  const double separation = carries ? error_of(answers.geometry[index].separation, truth.separation) : kNaN;
  if (kind == QueryKind::distance)
    return {{separation, truth.contact() ? "depth" : "distance", 0},
            {value(Measure::normal), "normal", kAskedNormals},
            {value(Measure::witness), "witness points", kAskedPoints}};
  if (!truth.contact() && status != PairStatus::overlapping) return {};  // the class alone is asked
  return {{separation, "depth", 0},
          {manifold_normal, "normal", kAskedNormals},
          {value(Measure::deepest), "deepest point", kAskedPoints},
          {value(Measure::point_witness), "contact points", kAskedPoints}};
}

// A contact that was not reported has no figures to be missing: it costs its depth.
bool needs_figures(PairStatus status, const PairTruth& truth, QueryKind kind) {
  if (kind == QueryKind::distance) return true;
  return kind == QueryKind::manifold && truth.contact() && status != PairStatus::separated;
}

double manifold_normal_error(const PosedPair& posed, const PairTruth& truth, const QueryAnswers& manifold,
                             std::size_t index) {
  const PairGeometry& geometry = manifold.geometry[index];
  if (!carries_geometry(manifold.status[index], geometry) || !is_finite(geometry.n_AB_W)) return kNaN;
  return std::abs(separation_along(posed.a, posed.b, geometry.n_AB_W) - truth.separation);
}

void charge_query(const PosedPair& posed, const PairTruth& truth, const BackendAnswers& answers,
                  std::size_t index, QueryKind kind, CaseErrors& errors) {
  const std::size_t q = index_of(kind);
  const QueryAnswers& of_kind = answers.queries[q];
  const PairStatus status = of_kind.status[index];
  errors.unsupported[q] = status == PairStatus::unsupported;
  errors.charges[q].fill({});
  if (errors.unsupported[q]) {
    errors.charges[q].fill({kNaN, "unsupported", false});
    return;
  }
  Answer answer;
  answer.fault = class_fault(status, truth.contact());
  answer.exact = std::abs(truth.separation);
  answer.missing = answer.exact + 2 * posed.size;
  answer.held = held_by_doubles(posed.scale);
  answer.needs_figures = needs_figures(status, truth, kind);
  const double normal =
      kind == QueryKind::manifold ? manifold_normal_error(posed, truth, of_kind, index) : kNaN;
  const std::vector<Figure> figures = figures_of(truth, of_kind, index, kind, errors, normal);
  for (std::size_t asked = 0; asked < kAskedKinds; ++asked)
    errors.charges[q][asked] = charge(answer, figures, asked);
}

bool has_manifold(const QueryAnswers& manifold, std::size_t index) {
  return carries_geometry(manifold.status[index], manifold.geometry[index]) &&
         is_finite(manifold.geometry[index].n_AB_W) && !manifold_points(manifold, index).empty();
}

// A contact without points covers nothing of a patch that has an area.
double coverage_without_points(const PosedPair& posed, const PairTruth& truth, const Oracle& oracle) {
  if (!is_finite(truth.n_AB_W) || !(norm(truth.n_AB_W) > 0.0)) return 1.0;
  const PatchArea patch(posed, oracle, truth.n_AB_W);
  return patch.most > kLeastPatch * posed.scale * posed.scale ? 0.0 : 1.0;
}

}  // namespace

Wrongness& Wrongness::operator+=(const Wrongness& more) {
  cases += more.cases;
  missed += more.missed;
  phantom += more.phantom;
  undecided += more.undecided;
  failed += more.failed;
  unsupported += more.unsupported;
  missing += more.missing;
  return *this;
}

std::string_view to_string(Measure measure) {
  constexpr std::array<std::string_view, kMeasures> kNames = {
      "distance",      "depth",          "normal",          "witness",  "deepest",
      "point_witness", "patch_coverage", "tilted_coverage", "stability"};
  return kNames[static_cast<std::size_t>(measure)];
}

std::string_view definition(Measure measure) {
  constexpr std::array<std::string_view, kMeasures> kDefinitions = {
      "|separation - d| of pairs that are apart, d the exact signed distance",
      "|separation - d| of pairs in contact",
      "|h(n) - d|: h the separation along the returned unit normal n, computed with 64-bit mantissas (long "
      "double)",
      "largest of p_A's distance to A's surface, p_B's to B's, and |p_B - p_A - s n|; distances to surfaces "
      "with 64-bit mantissas (long double, slivers in 113), good to 2^-60 of the largest coordinate",
      "manifold: |deepest point's separation - d|",
      "manifold: the worst witness error of its points, computed as for witness",
      "manifold: |area of the points' hull / area of the true patch - 1|, along n, of contacts face on face: "
      "both faces within 2^-6 rad of n. The patch: the hull of those corners of the exact clip of the two "
      "faces most (anti)parallel to n that are within the asked 1e-3 m. 1: the points hold no area, a block "
      "on them falls over",
      "manifold: the same of all other contacts (an edge, a corner or a tilted face in contact) that have "
      "three corners and an area within 1e-3 m",
      "manifold: change of that area ratio when B moves by 1e-9 S, of contacts face on face"};
  return kDefinitions[static_cast<std::size_t>(measure)];
}

std::string_view cost_definition(QueryKind query) {
  switch (query) {
    case QueryKind::overlap:
      return "overlap: 0 where the class is right";
    case QueryKind::distance:
      return "distance: the largest of the distance or depth error and, where they are asked for, the normal "
             "and the witness error";
    case QueryKind::manifold:
      return "manifold: in contact, the largest of the errors of its depth and, where they are asked for, of "
             "its normal, its deepest point and its points' witness error; apart 0";
  }
  return "";
}

std::array<std::string_view, 5> cost_rules() {
  return {
      "a wrong class or an undecided answer: |exact signed distance|, and the errors of the figures that "
      "come with it where these are larger",
      "a failed answer or a missing separation: what it leaves unknown, |exact signed distance|; a missing "
      "normal or point, where asked for: that and twice the size of the larger solid, as it may lie "
      "anywhere on the two",
      "a contact that is not reported has no points to be missing: it costs its depth, and covers nothing "
      "of its patch",
      "unsupported: no cost and no wrong answer; it takes a backend out where it was asked for",
      "what doubles hold: an error of a figure of at most two ulps of S costs nothing (2e-10 m at 1e6 m); a "
      "wrong class is never excused"};
}

double held_by_doubles(double scale) {
  return scale > 0.0 && std::isfinite(scale) ? std::ldexp(2.0, std::ilogb(scale) - 52) : 0.0;
}

namespace {

// The errors of these queries; those of others are not set.
CaseErrors query_errors(const PosedPair& posed, const PairTruth& truth, const Oracle& oracle,
                        Surfaces& surfaces, const BackendAnswers& answers, std::size_t index,
                        std::span<const QueryKind> kinds) {
  CaseErrors errors;
  errors.values.fill(kNaN);
  for (const QueryKind kind : kinds) {
    const QueryAnswers& of_kind = answers.queries[index_of(kind)];
    if (kind == QueryKind::distance) measure_distance(posed, truth, surfaces, of_kind, index, errors);
    if (kind == QueryKind::manifold) {
      measure_manifold(posed, truth, oracle, surfaces, answers, index, errors);
      if (truth.contact() && !has_manifold(of_kind, index))
        errors.coverage = coverage_without_points(posed, truth, oracle);
    }
    charge_query(posed, truth, answers, index, kind, errors);
  }
  return errors;
}

// How bad an answer is, the worse the larger: its class, what it costs, what its points leave uncovered.
std::array<double, 3> badness(PairStatus status, bool contact, const CaseErrors& errors, QueryKind kind) {
  const CaseCost& cost = errors.cost(kind);
  if (status == PairStatus::unsupported) return {1, 0, 0};
  double rank = cost.missing ? 2 : 0;
  if (status == PairStatus::undecided)
    rank = 3;
  else if (status == PairStatus::failed)
    rank = 4;
  else if (class_fault(status, contact) != nullptr)
    rank = 5;
  return {rank, cost.cost, kind == QueryKind::manifold ? 1.0 - errors.coverage : 0.0};
}

void exchange(QueryAnswers& answers, LaterAnswer& later) {
  std::swap(answers.status[later.index], later.status);
  if (!answers.geometry.empty()) std::swap(answers.geometry[later.index], later.geometry);
  std::swap_ranges(later.points.begin(), later.points.end(),
                   answers.points.begin() + static_cast<std::ptrdiff_t>(later.index * kMaxManifoldPoints));
}

}  // namespace

CaseErrors case_errors(const PosedPair& posed, const PairTruth& truth, const Oracle& oracle,
                       const BackendAnswers& answers, std::size_t index) {
  Surfaces surfaces(posed, oracle);
  return query_errors(posed, truth, oracle, surfaces, answers, index, kQueryKinds);
}

void take_worse_answers(const PairSet& set, std::span<const PairTruth> truth, const Oracle& oracle,
                        BackendAnswers& answers, int threads) {
  for (const QueryKind kind : kQueryKinds) {
    QueryAnswers& of_kind = answers.queries[index_of(kind)];
    // No two of the list are of one case: threads write to cases of their own.
    parallel_chunks(of_kind.later.size(), 64, threads, [&](std::size_t begin, std::size_t end) {
      for (LaterAnswer& later : std::span(of_kind.later).subspan(begin, end - begin)) {
        const std::size_t i = later.index;
        const PosedPair posed = posed_pair(set, i);
        Surfaces surfaces(posed, oracle);
        const auto bad = [&] {
          return badness(of_kind.status[i], truth[i].contact(),
                         query_errors(posed, truth[i], oracle, surfaces, answers, i, {&kind, 1}), kind);
        };
        const std::array<double, 3> before = bad();
        exchange(of_kind, later);
        if (bad() < before) exchange(of_kind, later);
      }
    });
    of_kind.later.clear();
  }
}

namespace {

// Keeps the list short and ordered: dearest first, of equal costs the lower index.
void keep_dearest(std::vector<WorstCase>& kept, const WorstCase& wrong) {
  const auto place =
      std::find_if(kept.begin(), kept.end(), [&](const WorstCase& other) { return wrong.cost > other.cost; });
  kept.insert(place, wrong);
  if (kept.size() > kKeptWrongCases) kept.pop_back();
}

std::vector<SignedError> signed_errors(const BackendAnswers& answers, std::span<const PairTruth> truth,
                                       std::span<const double> scale) {
  const QueryAnswers& distance = answers.queries[index_of(QueryKind::distance)];
  std::vector<SignedError> all;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!carries_geometry(distance.status[i], distance.geometry[i])) continue;
    all.push_back({truth[i].separation / scale[i],
                   (distance.geometry[i].separation - truth[i].separation) / scale[i], i});
  }
  if (all.size() <= kKeptSignedErrors) return all;
  std::vector<SignedError> kept;
  constexpr std::size_t kWorst = 8, kSpread = kKeptSignedErrors - kWorst;
  for (std::size_t i = 0; i < kSpread; ++i) kept.push_back(all[i * all.size() / kSpread]);
  std::stable_sort(all.begin(), all.end(), [](const SignedError& x, const SignedError& y) {
    return std::abs(x.error) > std::abs(y.error);
  });
  kept.insert(kept.end(), all.begin(), all.begin() + kWorst);
  return kept;
}

// One case as the curves take it.
CurveCase curve_case(const PairTruth& truth, const CaseErrors& errors, PairStatus status, QueryKind kind,
                     double scale, double size, std::size_t index) {
  CurveCase each;
  each.stratum = stratum_of(truth.separation, truth.contact(), size, scale);
  each.status = status;
  each.contact = truth.contact();
  each.index = index;
  each.costs = errors.charges[index_of(kind)];
  each.coverage = kind == QueryKind::manifold ? errors.coverage : 1.0;
  return each;
}

void judge_query(std::span<const PairTruth> truth, const BackendAnswers& answers,
                 std::span<const CaseErrors> errors, std::span<const double> scale,
                 std::span<const double> size, QueryKind kind, Judgement& judgement) {
  const std::size_t q = index_of(kind);
  std::vector<CaseValue> sample;
  CurveBuilder curves(kind);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    // Every pair counts in the curves, also where no answer came.
    const PairStatus status = answers.queries[q].status[i];
    const CaseCost& cost = errors[i].cost(kind);
    count(judgement.wrongness[q], status, truth[i].contact(), cost.missing);
    curves.add(curve_case(truth[i], errors[i], status, kind, scale[i], size[i], i));
    if (errors[i].unsupported[q]) continue;
    // Of the worst cases the figures are kept, so that the page can show them.
    WorstCase& worst = judgement.worst[q];
    WorstCase here{cost.cost, i, cost.reason, status};
    if (!answers.queries[q].geometry.empty() && carries_geometry(status, answers.queries[q].geometry[i])) {
      here.separation = answers.queries[q].geometry[i].separation;
      here.n_AB_W = answers.queries[q].geometry[i].n_AB_W;
    }
    if (sample.empty() || here.cost > worst.cost) worst = here;
    if (class_fault(status, truth[i].contact()) != nullptr || cost.missing)
      keep_dearest(judgement.wrong_cases[q], here);
    sample.push_back({cost.cost / scale[i], i});
  }
  // Without a pair to judge there is no worst cost.
  if (sample.empty()) judgement.worst[q].cost = kNaN;
  judgement.cost[q] = quantiles(sample);
  judgement.cost_curve[q] = curve(sample);
  judgement.curves[q] = curves.take();
}

}  // namespace

std::vector<std::vector<CaseErrors>> all_case_errors(const PairSet& set, std::span<const PairTruth> truth,
                                                     const Oracle& oracle,
                                                     std::span<const BackendAnswers> answers, int threads,
                                                     const Progress& progress) {
  std::vector<std::vector<CaseErrors>> errors(answers.size(), std::vector<CaseErrors>(set.cases()));
  parallel_chunks(
      set.cases(), 64, threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          const PosedPair posed = posed_pair(set, i);
          Surfaces surfaces(posed, oracle);
          for (std::size_t b = 0; b < answers.size(); ++b)
            errors[b][i] = query_errors(posed, truth[i], oracle, surfaces, answers[b], i, kQueryKinds);
        }
      },
      progress);
  return errors;
}

Judgement judge(const PairSet& set, std::span<const PairTruth> truth, const Oracle& oracle,
                const BackendAnswers& answers, int threads, const Progress& progress) {
  return judge(set, truth, answers, all_case_errors(set, truth, oracle, {&answers, 1}, threads, progress)[0]);
}

Judgement judge(const PairSet& set, std::span<const PairTruth> truth, const BackendAnswers& answers,
                std::span<const CaseErrors> errors) {
  const std::size_t cases = set.cases();
  std::vector<double> scale(cases), size(cases);
  for (std::size_t i = 0; i < cases; ++i) {
    const PosedPair posed = posed_pair(set, i);
    scale[i] = posed.scale;
    size[i] = posed.size;
  }

  // By query, then by figure over S and over the size.
  Judgement judgement;
  for (const QueryKind kind : kQueryKinds) judge_query(truth, answers, errors, scale, size, kind, judgement);
  std::vector<CaseValue> sample;
  for (std::size_t m = 0; m < kMeasures; ++m) {
    const bool length = is_length(static_cast<Measure>(m));
    const auto over = [&](const std::vector<double>& unit) {
      sample.clear();
      for (std::size_t i = 0; i < cases; ++i) {
        if (!std::isnan(errors[i].values[m]))
          sample.push_back({errors[i].values[m] / (length ? unit[i] : 1.0), i});
      }
      return quantiles(sample);
    };
    judgement.errors[m] = {over(scale), over(size)};
  }
  judgement.signed_errors = signed_errors(answers, truth, scale);
  return judgement;
}

}  // namespace touchstone::measures
