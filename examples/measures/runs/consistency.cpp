#include "touchstone/examples/measures/runs/consistency.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/measures/common/parallel.hpp"
#include "touchstone/examples/measures/common/random.hpp"

namespace touchstone::measures {
namespace {

struct Answers {
  std::vector<PairStatus> status;
  std::vector<PairGeometry> geometry;

  explicit Answers(std::size_t cases)
      : status(cases, PairStatus::unsupported),
        geometry(cases, PairGeometry{kNaN, {kNaN, kNaN, kNaN}, {kNaN, kNaN, kNaN}, {kNaN, kNaN, kNaN}, 0}) {}
  NarrowphaseOutput slots(std::size_t first, std::size_t count) {
    return {std::span(status).subspan(first, count), std::span(geometry).subspan(first, count), {}};
  }
};

// A backend without separations is asked for overlaps.
NarrowphaseInput question(const Narrowphase& narrowphase, std::span<const SolidPair> pairs,
                          std::span<const Pose> poses) {
  const Capabilities& can = narrowphase.capabilities();
  return {pairs, poses, {.kind = can.distance || can.penetration ? QueryKind::distance : QueryKind::overlap}};
}

Answers ask(const Narrowphase& narrowphase, std::span<const SolidPair> pairs, std::span<const Pose> poses) {
  Answers answers(pairs.size());
  const auto workspace = narrowphase.make_workspace();
  narrowphase.evaluate(question(narrowphase, pairs, poses), answers.slots(0, pairs.size()), *workspace);
  return answers;
}

// Every NaN is alike.
bool same_bits(double x, double y) {
  return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y) ||
         (std::isnan(x) && std::isnan(y));
}

bool same_number(double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); }

// fmax: NaN, where neither answer has a separation, is no change.
void note_separations(const PairGeometry& before, const PairGeometry& after, double scale, Change& change) {
  if (std::isnan(before.separation) && std::isnan(after.separation)) return;
  double moved = 0.0;
  if (!same_number(before.separation, after.separation)) {
    moved = std::abs(after.separation - before.separation);
    if (std::isnan(moved)) moved = kInfinity;
  }
  change.worst = std::fmax(change.worst, moved / scale);
}

// @param sign -1 where the normal should have turned round
Change compare(const Answers& before, const Answers& after, std::span<const double> scale, double sign) {
  Change change;
  change.cases = before.status.size();
  for (std::size_t i = 0; i < change.cases; ++i) {
    const PairGeometry &x = before.geometry[i], &y = after.geometry[i];
    const bool other_class = before.status[i] != after.status[i];
    bool other_bits = other_class || !same_bits(x.separation, y.separation);
    for (int axis = 0; axis < 3; ++axis) {
      // A zero has no sign worth turning: -0 for 0 is the same direction.
      other_bits |= !same_number(x.n_AB_W[axis], sign * y.n_AB_W[axis]);
    }
    change.classes += other_class;
    change.bits += other_bits;
    if (!other_class) note_separations(x, y, scale[i], change);
  }
  return change;
}

// One rotation and translation of the whole set, as large as its coordinates.
std::vector<Pose> moved_poses(std::span<const Pose> poses) {
  double largest = 1.0;
  for (const Pose& pose : poses) largest = std::max(largest, norm(pose.p));
  Random random(0x6d6f766564);
  const Pose X_VW{random_rotation(random), random_direction(random) * largest};
  std::vector<Pose> moved;
  for (const Pose& pose : poses) moved.push_back(compose(X_VW, pose));
  return moved;
}

// S where the pair lies, or where it was moved to if that is larger.
std::vector<double> scales(const PairSet& set, std::span<const Pose> poses, std::size_t cases) {
  PairSet there = set;
  there.poses.assign(poses.begin(), poses.end());
  std::vector<double> scale;
  for (std::size_t i = 0; i < cases; ++i)
    scale.push_back(std::max(posed_pair(set, i).scale, posed_pair(there, i).scale));
  return scale;
}

// Cases that rounding alone may change class are left out.
Change compare_moved(const Answers& before, const Answers& after, std::span<const double> scale,
                     std::span<const double> exact) {
  Change change;
  for (std::size_t i = 0; i < before.status.size(); ++i) {
    const bool near = !exact.empty() && std::abs(exact[i]) <= kMovedResolution * scale[i];
    ++change.cases;
    change.left_out += near;
    if (before.status[i] != after.status[i]) {
      change.classes += !near;
      continue;
    }
    note_separations(before.geometry[i], after.geometry[i], scale[i], change);
  }
  return change;
}

Answers ask_again(const Narrowphase& narrowphase, std::span<const SolidPair> pairs,
                  std::span<const Pose> poses) {
  Answers answers(pairs.size());
  const auto workspace = narrowphase.make_workspace();
  for (std::size_t i = pairs.size(); i-- > 0;)
    narrowphase.evaluate(question(narrowphase, pairs.subspan(i, 1), poses), answers.slots(i, 1), *workspace);
  return answers;
}

Answers ask_on_threads(const Narrowphase& narrowphase, std::span<const SolidPair> pairs,
                       std::span<const Pose> poses, int threads) {
  Answers answers(pairs.size());
  parallel_chunks(pairs.size(), 64, threads, [&](std::size_t begin, std::size_t end) {
    const auto workspace = narrowphase.make_workspace();
    narrowphase.evaluate(question(narrowphase, pairs.subspan(begin, end - begin), poses),
                         answers.slots(begin, end - begin), *workspace);
  });
  return answers;
}

}  // namespace

Change& Change::operator+=(const Change& more) {
  cases += more.cases;
  classes += more.classes;
  bits += more.bits;
  left_out += more.left_out;
  worst = std::fmax(worst, more.worst);
  return *this;
}

Consistency check_consistency(const Narrowphase& narrowphase, const PairSet& set, int threads,
                              std::size_t most) {
  const std::size_t cases = std::min(set.pairs.size(), most);
  const auto pairs = std::span<const SolidPair>(set.pairs).first(cases);
  std::vector<SolidPair> swapped;
  for (const SolidPair& pair : pairs) swapped.push_back({pair.b, pair.a});
  const std::vector<Pose> moved = moved_poses(set.poses);
  const std::vector<double> scale = scales(set, set.poses, cases), scale_moved = scales(set, moved, cases);

  const Answers before = ask(narrowphase, pairs, set.poses);
  Consistency result;
  result.swapped = compare(before, ask(narrowphase, swapped, set.poses), scale, -1.0);
  result.moved = compare_moved(before, ask(narrowphase, pairs, moved), scale_moved, set.exact_separations);
  result.repeated = compare(before, ask_again(narrowphase, pairs, set.poses), scale, 1.0);
  if (narrowphase.capabilities().thread_safe) {
    result.threads =
        compare(before, ask_on_threads(narrowphase, pairs, set.poses, std::max(threads, 2)), scale, 1.0);
  }
  return result;
}

}  // namespace touchstone::measures
