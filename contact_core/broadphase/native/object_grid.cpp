#include "touchstone/contact_core/broadphase/native/object_grid.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"

namespace touchstone {
namespace {

// Cells are shorter along a row, which the runs of positions follow more closely then.
constexpr float kCellsPerSide = 4.0F;

// Radii are grown by this share of themselves, and by this one of their coordinates. A float is off by 2^-24
// of a coordinate, a squared distance or reach by 5 2^-24 of itself, may_touch() by 2^-49 of the reach; where
// squares are not the least of floats: see kLeastGrowth.
constexpr double kGrowth = 0x1p-20, kCoordinateGrowth = 0x1p-21;

// Coordinates beyond, in sides, are coarse: an object's growth stays below 1/64 of a side.
constexpr double kFarthest = 0x1p15;

// In sides, at least this much of each radius's growth: squares of floats below 2^-63 are too few multiples
// of the least float for the shares above.
constexpr double kLeastGrowth = 0x1p-60;

// However few objects there are.
constexpr std::uint32_t kFewCells = 64;

// Loose objects are tested with each one that is asked for its pairs. There may be these few and one in 64,
// up to the most.
constexpr std::uint32_t kFewLoose = 8, kLooseShare = 64, kMostLoose = 64;

constexpr std::uint32_t kLeastObjects = 512, kLeastSamples = 64;
constexpr std::uint32_t kObjectsPerPart = 4096;
// A run of positions costs as much as so many tests.
constexpr double kTestsPerRun = 7.0;
// A tree takes as long for an object as this many tests, and for a pair.
constexpr double kTestsPerObject = 96.0, kTestsPerPair = 12.0;
constexpr std::uint32_t kFramesToWait = 31;

// One object in so many may be late, and these few.
constexpr std::uint32_t kLateShare = 4, kFewLate = 64;
constexpr float kInfiniteFloat = std::numeric_limits<float>::infinity();
// Where an object was that has left: no square of a distance to it is finite.
constexpr float kGone = 1e30F;

/// Evenly over the objects, but in no step that an order of theirs could follow.
std::uint32_t sampled(std::uint32_t sample, std::uint32_t samples, std::uint32_t objects) {
  const std::uint64_t jitter = sample * 0x9E3779B1U >> 16;
  return static_cast<std::uint32_t>((((std::uint64_t{sample} << 16) + jitter) * objects / samples) >> 16);
}

double quantile(std::vector<double>& values, double share) {
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

}  // namespace

/// What some of the objects tell of all [m].
struct ObjectGrid::Sample {
  std::array<double, 3> low, extent;
  double mean_radius, most_radius, margin;
  double objects;  // in the scene
};

// And for more, which come one by one. As they take memory where they are used alone, lists are sized by
// build().
void ObjectGrid::reserve(std::size_t objects) {
  const std::size_t cells = 2 * objects + kFewCells;
  for (std::vector<double>& list : samples_) list.reserve(kSamples);
  reserve_more(spots_, objects), reserve_more(order_, objects);
  for (GrowingList<float>* list : {&x_, &y_, &z_, &radius_})
    reserve_more(*list, objects + SphereColumns::kPadding);
  for (GrowingList<std::uint32_t>* list : {&cell_start_, &row_at_, &row_place_})
    reserve_more(*list, cells + 1);
  reserve_more(place_, objects), reserve_more(late_, objects / kLateShare + kFewLate);
  reserve_more(late_head_, cells / kCellsPerList + 1);
}

bool ObjectGrid::build(const SolidBounds& bounds, TaskRunner* threads) noexcept {
  if (frames_to_wait_ > 0) {
    --frames_to_wait_;
    return false;
  }
  objects_ = bounds.objects();
  is_plain_ = !bounds.has_static();
  has_places_ = false, late_loose_ = kNoIndex;
  late_.clear();
  // Trees know tighter boxes than spheres about objects of several solids.
  if (objects_ >= kLeastObjects && bounds.are_single() && choose_cells(bounds) && fill(bounds, threads) &&
      is_quick())
    return true;
  frames_to_wait_ = kFramesToWait;
  return false;
}

bool ObjectGrid::choose_cells(const SolidBounds& bounds) noexcept {
  // Some objects are looked at.
  for (std::vector<double>& list : samples_) list.clear();
  const std::uint32_t samples = std::min(kSamples, kLeastSamples + objects_ / 16);
  for (std::uint32_t i = 0; i < samples; ++i) {
    const std::uint32_t object = sampled(i, samples, objects_);
    const Sphere& sphere = bounds.object_spheres_W()[object];
    if (bounds.is_gone(object) || !is_finite(sphere.centre) || !std::isfinite(sphere.radius)) continue;
    for (int k = 0; k < 3; ++k) samples_[k].push_back(sphere.centre(k));
    samples_[3].push_back(sphere.radius);
  }
  std::vector<double>& radii = samples_[3];
  if (radii.size() < samples / 2) return false;
  // Strays do not count, nor do giants.
  Sample sample{};
  for (int k = 0; k < 3; ++k) {
    const double low = quantile(samples_[k], 1.0 / 64), high = quantile(samples_[k], 63.0 / 64);
    const double pad = (high - low) / 32;
    sample.low[k] = low - pad, sample.extent[k] = (high - low) + 2.0 * pad;
  }
  const double most = 2.0 * quantile(radii, 31.0 / 32);
  sample.margin = bounds.margin();
  sample.objects = static_cast<double>(objects_);
  for (const double radius : radii) {
    if (radius > most) continue;
    sample.mean_radius += radius / static_cast<double>(radii.size());
    sample.most_radius = std::max(sample.most_radius, radius);
  }
  half_margin_ = 0.5 * sample.margin;
  largest_ = most;
  // Rows run along the longest side.
  const auto longest = std::max_element(sample.extent.begin(), sample.extent.end()) - sample.extent.begin();
  for (int k = 0; k < 3; ++k) axis_[k] = static_cast<int>((longest + k) % 3);
  for (int k = 0; k < 3; ++k) origin_[k] = sample.low[axis_[k]];
  return choose_side(sample) && count_parts();
}

// The side of a cell that makes tests and runs fewest, if objects were spread evenly.
bool ObjectGrid::choose_side(const Sample& sample) noexcept {
  const double reach = sample.mean_radius + sample.most_radius + sample.margin;
  if (!(reach > 0x1p-506) || !(sample.extent[axis_[0]] < 0x1p500) || !(largest_ < 0x1p500)) return false;
  const double most_cells = 2.0 * sample.objects;
  double least_cost = kInfinity, best = 0.0;
  for (double side = reach;; side *= 1.4142) {
    double cells = 1.0, share = 1.0, runs = 0.5;
    for (int k = 0; k < 3; ++k) {
      const double per_side = k == 0 ? kCellsPerSide : 1.0;
      const double sides = std::max(1.0, sample.extent[axis_[k]] / side);
      const double met = std::min(sides, 2.0 * reach / side + 1.0 / per_side);
      cells *= std::ceil(sides * per_side), share *= met / sides;
      if (k > 0) runs *= met;
    }
    const double cost = 0.5 * sample.objects * share + kTestsPerRun * runs;
    if (cells <= most_cells && cost < least_cost) least_cost = cost, best = side;
    if (sample.extent[axis_[0]] <= side) break;
  }
  // The frame follows from the side.
  if (best == 0.0) return false;
  per_metre_ = 1.0 / best;
  double sides = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double length = std::max(1.0, sample.extent[axis_[k]] * per_metre_);
    sides += length;
    count_[k] = static_cast<std::uint32_t>(std::ceil(length * (k == 0 ? kCellsPerSide : 1.0)));
  }
  farthest_ = 2.0 * sides;
  // may_touch() lets distances up to 2^-511 m pass.
  tiny_ = 0x1p-510 * per_metre_ + kLeastGrowth;
  largest_ = (largest_ + half_margin_) * per_metre_ * (1.0 + kGrowth) + farthest_ * kCoordinateGrowth + tiny_;
  return farthest_ <= kFarthest;
}

/// Numbers rows by square tiles and cuts them into parts.
bool ObjectGrid::count_parts() noexcept {
  constexpr std::uint32_t kTile = 4;
  const std::uint32_t rows = count_[1] * count_[2];
  row_at_.resize(rows), row_place_.resize(rows), cell_start_.resize(count_[0] * rows + 1);
  std::uint32_t next = 0;
  for (std::uint32_t tile_z = 0; tile_z < count_[2]; tile_z += kTile)
    for (std::uint32_t tile_y = 0; tile_y < count_[1]; tile_y += kTile)
      for (std::uint32_t z = tile_z; z < std::min(tile_z + kTile, count_[2]); ++z)
        for (std::uint32_t y = tile_y; y < std::min(tile_y + kTile, count_[1]); ++y) {
          row_at_[z * count_[1] + y] = next;
          row_place_[next++] = z * count_[1] + y;
        }
  const std::uint32_t wanted = std::clamp<std::uint32_t>(objects_ / kObjectsPerPart, 1, kMostParts - 1);
  part_shift_ = 0;
  while ((rows >> part_shift_) >= wanted && part_shift_ < 31) ++part_shift_;
  cell_parts_ = ((rows - 1) >> part_shift_) + 1;
  chunk_ = std::max<std::uint32_t>(4096, objects_ / static_cast<std::uint32_t>(kMostChunks) + 1);
  return cell_parts_ < kMostParts;
}

std::uint32_t ObjectGrid::place(const Sphere& sphere, Spot& spot) const noexcept {
  const double x = (sphere.centre(axis_[0]) - origin_[0]) * per_metre_;
  const double y = (sphere.centre(axis_[1]) - origin_[1]) * per_metre_;
  const double z = (sphere.centre(axis_[2]) - origin_[2]) * per_metre_;
  const double far = (std::abs(x) + std::abs(y)) + std::abs(z);
  const double radius =
      (sphere.radius + half_margin_) * per_metre_ * (1.0 + kGrowth) + (far * kCoordinateGrowth + tiny_);
  if (!(far <= farthest_ && radius <= largest_)) return kNowhere;
  spot.x = static_cast<float>(x), spot.y = static_cast<float>(y), spot.z = static_cast<float>(z);
  spot.radius = static_cast<float>(radius);
  const std::uint32_t row = row_at_[cell_at(spot.z, 1.0F, 2) * count_[1] + cell_at(spot.y, 1.0F, 1)];
  spot.cell = row * count_[0] + cell_at(spot.x, kCellsPerSide, 0);
  return row;
}

/// Notes each object's spot and part, in the order of the objects, and counts what a chunk of them throws on
/// each part.
void ObjectGrid::place_chunk(std::size_t chunk, const SolidBounds& bounds) noexcept {
  const auto first = static_cast<std::uint32_t>(chunk) * chunk_, end = std::min(objects_, first + chunk_);
  std::array<std::uint32_t, kMostParts + 1> counts{};
  float most = 0.0F;
  for (std::uint32_t object = first; object < end; ++object) {
    if (bounds.is_gone(object)) {
      place_[object] = kNowhere;
      continue;
    }
    Spot spot{0.0F, 0.0F, 0.0F, 0.0F, object, 0};
    const std::uint32_t row = place(bounds.object_spheres_W()[object], spot);
    const std::uint32_t part = row != kNowhere ? row >> part_shift_ : kLoosePart;
    x_[object] = spot.x, y_[object] = spot.y, z_[object] = spot.z, radius_[object] = spot.radius;
    order_[object] = spot.cell, place_[object] = part;
    ++counts[part];
    most = std::max(most, spot.radius);
  }
  for (std::size_t part = 0; part <= kMostParts; ++part) start_[part][chunk] = counts[part];
  chunk_radius_[chunk] = most;
}

/// Throws a chunk's objects on their parts.
void ObjectGrid::scatter_chunk(std::size_t chunk) noexcept {
  const auto first = static_cast<std::uint32_t>(chunk) * chunk_, end = std::min(objects_, first + chunk_);
  std::array<std::uint32_t, kMostParts + 1> at;
  for (std::size_t part = 0; part <= kMostParts; ++part) at[part] = start_[part][chunk];
  for (std::uint32_t object = first; object < end; ++object) {
    if (place_[object] == kNowhere) continue;
    spots_[at[place_[object]]++] = {x_[object],      y_[object], z_[object],
                                    radius_[object], object,     order_[object]};
  }
}

// Each part of the cells is sorted by itself, in the caches. Chunks of the objects count what they throw on
// each part first, so that any thread knows where to put it.
bool ObjectGrid::fill(const SolidBounds& bounds, TaskRunner* threads) noexcept {
  // The lists by position hold what is known of each object until it has one.
  const std::size_t chunks = (objects_ + chunk_ - 1) / chunk_;
  spots_.resize(objects_), order_.resize(objects_), place_.resize(objects_);
  for (GrowingList<float>* list : {&x_, &y_, &z_, &radius_}) list->resize(objects_ + SphereColumns::kPadding);
  auto count = [&](std::size_t chunk) { place_chunk(chunk, bounds); };
  run_tasks(threads, chunks, count);
  // Sums say where each chunk's share of a part begins.
  std::uint32_t next = 0;
  for (std::size_t part = 0; part <= kMostParts; ++part) {
    part_start_[part] = next;
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
      const std::uint32_t here = start_[part][chunk];
      start_[part][chunk] = next;
      next += here;
    }
  }
  in_cells_ = part_start_[kLoosePart], loose_ = next - in_cells_;
  loose_now_ = loose_;
  if (loose_ > most_loose()) return false;
  note_radius(
      *std::max_element(chunk_radius_.begin(), chunk_radius_.begin() + static_cast<std::ptrdiff_t>(chunks)));
  // Objects are thrown on their parts, and these sorted.
  auto scatter = [&](std::size_t chunk) { scatter_chunk(chunk); };
  run_tasks(threads, chunks, scatter);
  auto sort = [&](std::size_t part) { sort_part(part); };
  run_tasks(threads, cell_parts_, sort);
  cell_start_[count_[0] * count_[1] * count_[2]] = in_cells_;
  for (std::uint32_t at = in_cells_; at < next; ++at) order_[at] = spots_[at].object;
  return true;
}

/// Growth of both radii, in both squares, as SphereTests says.
void ObjectGrid::note_radius(float most) noexcept {
  most_radius_ = most;
  const double reach = 2.0 * most_radius_;
  doubt_ =
      static_cast<float>(reach * reach * 0x1p-15 + 8.0 * reach * (farthest_ * kCoordinateGrowth + tiny_));
}

std::uint32_t ObjectGrid::most_loose() const noexcept {
  return std::min(kFewLoose + objects_ / kLooseShare, kMostLoose);
}

bool ObjectGrid::move(const SolidBounds& bounds, std::span<const std::uint32_t> moved) noexcept {
  if (late_.size() + moved.size() > objects_ / kLateShare + kFewLate) return false;
  if (!has_places_) find_places();
  if (place_.size() < bounds.objects()) place_.resize(bounds.objects(), kNoIndex);
  for (const std::uint32_t object : moved) {
    leave(object);
    if (!bounds.is_gone(object)) enter(object, bounds);
  }
  return loose_now_ <= most_loose();
}

void ObjectGrid::find_places() noexcept {
  has_places_ = true;
  place_.clear(), late_head_.clear();
  place_.resize(objects_, kNoIndex);
  late_head_.resize(count_[0] * count_[1] * count_[2] / kCellsPerList + 1, kNoIndex);
  for (std::uint32_t at = 0; at < in_cells_ + loose_; ++at) place_[order_[at]] = at;
}

/// A late object keeps its entry, in no list.
void ObjectGrid::leave(std::uint32_t object) noexcept {
  const std::uint32_t at = place_[object];
  if (at == kNoIndex) return;
  if ((at & kIsLate) == 0) {
    order_[at] = kNoIndex;
    if (at < in_cells_)
      x_[at] = kGone;
    else
      --loose_now_;
    place_[object] = kNoIndex;
    return;
  }
  const std::uint32_t index = at & ~kIsLate;
  Late& late = late_[index];
  if (late.spot.cell == kNowhere) return;
  if (late.spot.cell == kIsLoose) --loose_now_;
  std::uint32_t* link = &list_of(late.spot.cell);
  while (*link != index) link = &late_[*link].next;
  *link = late.next;
  late.spot.cell = kNowhere;
}

void ObjectGrid::enter(std::uint32_t object, const SolidBounds& bounds) noexcept {
  if (place_[object] == kNoIndex) {
    place_[object] = static_cast<std::uint32_t>(late_.size()) | kIsLate;
    late_.push_back({});
  }
  const std::uint32_t index = place_[object] & ~kIsLate;
  Late& late = late_[index];
  late.spot = {0.0F, 0.0F, 0.0F, 0.0F, object, 0};
  if (place(bounds.object_spheres_W()[object], late.spot) != kNowhere)
    note_radius(std::max(most_radius_, late.spot.radius));
  else
    late.spot.cell = kIsLoose, ++loose_now_;
  std::uint32_t& list = list_of(late.spot.cell);
  late.next = std::exchange(list, index);
  is_plain_ = is_plain_ && !bounds.is_static(object);
}

/// By counting into cells; objects of a cell keep their order.
void ObjectGrid::sort_part(std::size_t part) noexcept {
  const std::uint32_t rows = count_[1] * count_[2];
  const auto first_row = static_cast<std::uint32_t>(part) << part_shift_;
  const std::uint32_t first = first_row * count_[0];
  const std::uint32_t last = std::min(rows, first_row + (1U << part_shift_)) * count_[0];
  std::fill(cell_start_.begin() + first, cell_start_.begin() + last, 0U);
  const std::uint32_t begin = part_start_[part], end = part_start_[part + 1];
  for (std::uint32_t i = begin; i < end; ++i) ++cell_start_[spots_[i].cell];
  // Sums say where cells end, and filling them from behind moves that to where they begin.
  std::uint32_t sum = begin;
  for (std::uint32_t cell = first; cell < last; ++cell) cell_start_[cell] = sum += cell_start_[cell];
  for (std::uint32_t i = end; i-- > begin;) {
    const Spot& spot = spots_[i];
    const std::uint32_t at = --cell_start_[spot.cell];
    x_[at] = spot.x, y_[at] = spot.y, z_[at] = spot.z, radius_[at] = spot.radius;
    order_[at] = spot.object;
  }
}

ObjectGrid::Rows ObjectGrid::rows_about(std::uint32_t row) const noexcept {
  Rows out{row_place_[row] % count_[1], row_place_[row] / count_[1], row * count_[0], {}};
  const std::uint32_t y_below = out.y - (out.y > 0 ? 1 : 0), y_above = std::min(out.y + 1, count_[1] - 1),
                      z_above = std::min(out.z + 1, count_[2] - 1);
  const std::array<std::uint32_t, 4> places = {out.z * count_[1] + y_above, z_above * count_[1] + y_below,
                                               z_above * count_[1] + out.y, z_above * count_[1] + y_above};
  for (int k = 0; k < 4; ++k) out.next[k] = row_at_[places[k]] * count_[0];
  return out;
}

// Runs to one side alone: further along its own row, in rows of the same z beyond it and in those of greater
// z. Where these are the next rows alone, as is most common, runs that are out of reach are empty: no machine
// predicts which.
template <class Visit>
void ObjectGrid::for_each_run(std::uint32_t at, const Rows& rows, Visit visit) const noexcept {
  const float reach = radius_[at] + most_radius_;
  const std::uint32_t low = cell_at(x_[at] - reach, kCellsPerSide, 0);
  const std::uint32_t high = cell_at(x_[at] + reach, kCellsPerSide, 0) + 1;
  const std::uint32_t y_low = cell_at(y_[at] - reach, 1.0F, 1), y_high = cell_at(y_[at] + reach, 1.0F, 1);
  const std::uint32_t z_high = cell_at(z_[at] + reach, 1.0F, 2);
  visit(at + 1, cell_start_[rows.own + high]);
  if (y_low + 1 >= rows.y && y_high <= rows.y + 1 && z_high <= rows.z + 1) {
    const bool is_below = y_low < rows.y;
    const bool is_above = y_high > rows.y, is_beyond = z_high > rows.z;
    const std::array<bool, 4> is_met = {is_above, is_beyond && is_below, is_beyond, is_beyond && is_above};
    for (int k = 0; k < 4; ++k) {
      const std::uint32_t first = cell_start_[rows.next[k] + low], end = cell_start_[rows.next[k] + high];
      visit(first, is_met[k] ? end : first);
    }
    return;
  }
  for (std::uint32_t z = rows.z; z <= z_high; ++z)
    for (std::uint32_t y = z == rows.z ? rows.y + 1 : y_low; y <= y_high; ++y) {
      const std::uint32_t first = row_at_[z * count_[1] + y] * count_[0];
      visit(cell_start_[first + low], cell_start_[first + high]);
    }
}

// Some objects, evenly over the cells, tell how many tests and pairs there will be.
bool ObjectGrid::is_quick() const noexcept {
  constexpr std::uint32_t kMostAsked = 512, kTestedOf = 8;
  constexpr double kMostTests = 4096.0;
  if (in_cells_ == 0) return false;
  // Of a sample of the objects, how many others each is tested against; of some, how many it meets.
  const std::uint32_t asked = std::min(kMostAsked, kLeastSamples + in_cells_ / 16),
                      cells = count_[0] * count_[1] * count_[2];
  double tests = 0.0, tested = 0.0, pairs = 0.0;
  SphereTests in_runs(columns());
  auto meet = [&](std::uint32_t, std::uint32_t, bool) { pairs += 1.0; };
  for (std::uint32_t i = 0; i < asked; ++i) {
    const std::uint32_t at = sampled(i, asked, in_cells_);
    const auto cell =
        static_cast<std::uint32_t>(std::upper_bound(cell_start_.begin(), cell_start_.begin() + cells, at) -
                                   cell_start_.begin()) -
        1;
    const bool is_tested = i % kTestedOf == 0 && tests <= kMostTests * (i + 1);
    for_each_run(at, rows_about(cell / count_[0]), [&](std::uint32_t first, std::uint32_t end) {
      tests += end - first;
      if (is_tested) in_runs.add(at, first, end, meet);
    });
    tested += is_tested ? 1.0 : 0.0;
  }
  in_runs.finish(meet);
  // Quick are few tests an object, and no more than its pairs are worth.
  tests /= asked, pairs /= std::max(1.0, tested);
  return tests <= kMostTests && pairs < 0.9 * PairList::kPairsPerObject &&
         tests <= kTestsPerObject + kTestsPerPair * pairs;
}

void ObjectGrid::prefetch_run(std::uint32_t low, std::uint32_t high) const noexcept {
  const std::uint32_t first = cell_start_[low], end = cell_start_[high + 1];
  for (const GrowingList<float>* list : {&x_, &y_, &z_, &radius_})
    __builtin_prefetch(&(*list)[first]), __builtin_prefetch(&(*list)[end]);
  __builtin_prefetch(order_.data() + first);
  if (late_.empty()) return;
  for (std::uint32_t list = low / kCellsPerList; list <= high / kCellsPerList; ++list)
    if (late_head_[list] != kNoIndex) __builtin_prefetch(&late_[late_head_[list]]);
}

std::size_t ObjectGrid::find_near(const Reach& reach, std::span<Near, kMostNear> found) const noexcept {
  std::size_t count = 0;
  bool fits = !reach.takes_all;
  const float *xs = x_.data(), *ys = y_.data(), *zs = z_.data(), *radii = radius_.data();
  const std::uint32_t *starts = cell_start_.data(), *order = order_.data();
  const auto add_late = [&](const Spot& spot) {
    const float by = slack(reach, spot.x, spot.y, spot.z, spot.radius);
    if (count < kMostNear)
      found[count++] = {spot.object, by > reach.doubt && is_plain_ ? 1U : 0U};
    else
      fits = false;
  };
  // Rows one after the other; without static objects and gone ones what touches for certain pairs.
  const Floats x = all_lanes(reach.x), y = all_lanes(reach.y), z = all_lanes(reach.z),
               radius = all_lanes(reach.radius), doubt = all_lanes(is_plain_ ? reach.doubt : kInfiniteFloat);
  for_each_row(reach, [&](std::uint32_t low, std::uint32_t high) {
    const std::uint32_t end = starts[high + 1];
    const std::size_t begin = count;
    // Four at a time: those that are met are kept without a branch, which none could predict.
    for (std::uint32_t at = starts[low]; at < end && fits; at += 4) {
      const Floats dx = load_floats(xs + at) - x, dy = load_floats(ys + at) - y,
                   dz = load_floats(zs + at) - z, sum = load_floats(radii + at) + radius;
      const Floats by = sum * sum - ((dx * dx + dy * dy) + dz * dz);
      const std::uint32_t hit = lane_mask(by >= 0.0F) & 15U >> (4 - std::min(end - at, 4U));
      const std::uint32_t sure = lane_mask(by > doubt);
      fits = count + 4 <= kMostNear;
      for (std::uint32_t lane = 0; lane < 4 && fits; ++lane) {
        found[count] = {at + lane, sure >> lane & 1U};
        count += hit >> lane & 1U;
      }
    }
    for (std::size_t i = begin; i < count; ++i) found[i].object = order[found[i].object];
    if (!late_.empty()) for_each_late(reach, low, high, add_late);
  });
  return fits ? count : kMostNear + 1;
}

void ObjectGrid::list_part(std::size_t part, const SolidBounds& bounds,
                           PairList::Writer& writer) const noexcept {
  // The part after the last one of cells has the loose objects.
  if (part == cell_parts_) {
    list_loose(bounds, writer);
    list_late(bounds, writer);
    return;
  }
  // Rows of cells: each object against those after it, in its cell and in the next ones.
  SphereTests tests(columns());
  auto meet = [&](std::uint32_t at, std::uint32_t other, bool is_sure) {
    if (is_sure && is_plain_)
      writer.add(order_[at], order_[other], true);
    else
      add(order_[at], order_[other], is_sure, bounds, writer);
  };
  const std::uint32_t rows = count_[1] * count_[2];
  const auto first_row = static_cast<std::uint32_t>(part) << part_shift_;
  const std::uint32_t last_row = std::min(rows, first_row + (1U << part_shift_));
  for (std::uint32_t row = first_row; row < last_row && !writer.is_full(); ++row) {
    const std::uint32_t end = cell_start_[(row + 1) * count_[0]];
    const Rows about = rows_about(row);
    for (std::uint32_t at = cell_start_[row * count_[0]]; at < end; ++at) {
      if (order_[at] == kNoIndex) continue;
      for_each_run(at, about,
                   [&](std::uint32_t first, std::uint32_t last) { tests.add(at, first, last, meet); });
    }
  }
  tests.finish(meet);
}

/// Loose objects that are not late with all others, and among themselves.
void ObjectGrid::list_loose(const SolidBounds& bounds, PairList::Writer& writer) const noexcept {
  for (std::uint32_t at = in_cells_; at < in_cells_ + loose_ && !writer.is_full(); ++at) {
    const std::uint32_t object = order_[at];
    if (object == kNoIndex) continue;
    const auto add_pair = [&](std::uint32_t other) { add(object, other, false, bounds, writer); };
    for_each_in_cells(reach_of(bounds.object_spheres_W()[object]), add_pair);
    for (std::uint32_t other = at + 1; other < in_cells_ + loose_; ++other)
      if (order_[other] != kNoIndex) add_pair(order_[other]);
    for (std::uint32_t i = late_loose_; i != kNoIndex; i = late_[i].next) add_pair(late_[i].spot.object);
  }
}

/// Late objects with those in cells that are not, and among themselves: each pair from the higher one.
void ObjectGrid::list_late(const SolidBounds& bounds, PairList::Writer& writer) const noexcept {
  for (const Late& late : late_) {
    if (writer.is_full()) return;
    if (late.spot.cell == kNowhere) continue;
    const std::uint32_t object = late.spot.object;
    const Sphere& sphere = bounds.object_spheres_W()[object];
    const auto add_pair = [&](std::uint32_t other) {
      const bool is_late = (place_[other] & kIsLate) != 0;
      if (!is_late || other < object) add(object, other, false, bounds, writer);
    };
    for_each_in_cells(reach_of(sphere), add_pair);
    for (std::uint32_t i = late_loose_; i != kNoIndex; i = late_[i].next) add_pair(late_[i].spot.object);
  }
}

/// @param is_sure the spheres touch.
void ObjectGrid::add(std::uint32_t object, std::uint32_t other, bool is_sure, const SolidBounds& bounds,
                     PairList::Writer& writer) const noexcept {
  bool keeps = is_sure || bounds.may_pair(object, other);
  if (keeps && !is_plain_)
    keeps = !bounds.is_gone(object) && !bounds.is_gone(other) &&
            !(bounds.is_static(object) && bounds.is_static(other));
  writer.add(object, other, keeps);
}

ObjectGrid::Reach ObjectGrid::reach_of(const Sphere& sphere) const noexcept {
  // Within float's range and far beyond the grid, where it tells nothing any more; and where no square
  // overflows [m].
  constexpr double kCoarse = 0x1p18, kSquared = 0x1p500;
  double at[3], far = 0.0;
  for (int k = 0; k < 3; ++k)
    at[k] = (sphere.centre(axis_[k]) - origin_[k]) * per_metre_, far += std::abs(at[k]);
  const double radius =
      (sphere.radius + half_margin_) * per_metre_ * (1.0 + kGrowth) + (far * kCoordinateGrowth + tiny_);
  Reach reach{};
  // The centres of those in cells are within kFarthest, so more than far / 2 from here.
  if (far > kCoarse && far < kSquared * per_metre_ && radius + most_radius_ < 0.25 * far) {
    reach.low = {1, 1, 1};
    return reach;
  }
  reach.takes_all = !(far <= kCoarse && radius <= kCoarse);
  if (reach.takes_all) {
    reach.low = {0, 0, 0}, reach.high = {count_[0] - 1, count_[1] - 1, count_[2] - 1};
    return reach;
  }
  reach.x = static_cast<float>(at[0]), reach.y = static_cast<float>(at[1]),
  reach.z = static_cast<float>(at[2]);
  reach.radius = static_cast<float>(radius);
  reach.doubt = far <= farthest_ && reach.radius <= most_radius_ ? doubt_ : kInfiniteFloat;
  for (int k = 0; k < 3; ++k) {
    const float middle = static_cast<float>(at[k]), half = reach.radius + most_radius_;
    const float per_side = k == 0 ? kCellsPerSide : 1.0F;
    reach.low[k] = cell_at(middle - half, per_side, k), reach.high[k] = cell_at(middle + half, per_side, k);
  }
  return reach;
}

}  // namespace touchstone
