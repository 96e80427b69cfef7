#include <algorithm>
#include <array>
#include <utility>

#include "touchstone/contact_core/broadphase/native/object_pairs.hpp"
#include "touchstone/contact_core/broadphase/native/pair_sort.hpp"
#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"

namespace touchstone {
namespace {

// build() makes: bounds of the objects, trees over them, pairs of objects out of the trees, pairs of
// solids out of those.
class Scene {
 public:
  explicit Scene(const BroadphaseInput& input)
      : bounds_(input),
        forest_(bounds_, input.threads),
        object_pairs_(bounds_, forest_, input.threads),
        threads_(input.threads) {
    take_room();
  }
  Scene(const Scene&) = delete;  // its parts point at each other
  Scene& operator=(const Scene&) = delete;

  void set_object(std::uint32_t object, const HexahedronTree* tree, bool is_static) {
    const bool was_there = object < bounds_.objects() && !bounds_.is_gone(object);
    const bool was_static = was_there && bounds_.is_static(object);
    bounds_.set_object(object, tree, is_static);
    if (was_there) forest_.erase(object, was_static);
    if (tree != nullptr) forest_.insert(object);
    object_pairs_.set_object(object);
    take_room();
    gathered_ = others_of_ = kNoIndex;
  }

  void find_partners(SolidIndex solid, std::vector<SolidIndex>& out) noexcept {
    const std::uint32_t object = bounds_.object_of(solid);
    gather_others(object);
    const Box box = bounds_.solid_box(solid);
    for (const std::uint32_t other : others_) {
      if (bounds_.is_single(object) && bounds_.is_single(other))
        out.push_back(bounds_.first_solid(other));
      else
        bounds_.append_partners(solid, box, other, out);
    }
  }

  void find_moved_pairs(std::vector<SolidPair>& out) noexcept {
    const auto first = static_cast<std::ptrdiff_t>(out.size());
    // In even scenes listing all pairs takes as long as the partners of so many.
    constexpr std::size_t kMany = 3;
    if (all_moved_ || moved_.size() > bounds_.objects() / kMany) {
      append_pairs_where(out, [this](const SolidPair& pair) { return all_moved_ || !stands_still(pair); });
      return;
    }
    forest_.for_each_pair_of(moved_, [&](std::uint32_t object, std::uint32_t other) {
      // Of two that moved, the lower one is asked.
      if (is_moved_[other] == 0 || object < other)
        append_pairs(std::min(object, other), std::max(object, other), out);
      return true;
    });
    sort_pairs(std::span(out).subspan(static_cast<std::size_t>(first)), pair_scratch_);
  }

  void find_pairs_by_place(std::vector<SolidPair>& out) noexcept {
    if (!object_pairs_.append_by_place(out)) append_pairs_where(out, [](const SolidPair&) { return true; });
  }

  void update(std::span<const Pose> poses, std::span<const std::uint32_t> moved) noexcept {
    const bool all = !is_placed_ || bounds_.on_paths();
    if (all) bounds_.start_poses();
    take(
        all, moved, [&](std::uint32_t object) { bounds_.place(object, poses); },
        [&](std::uint32_t object) { bounds_.prefetch(object, poses); });
  }

  void update_paths(const SolidPaths& paths, std::span<const std::uint32_t> moved) noexcept {
    const bool all = !is_placed_ || !bounds_.on_paths();
    if (all) bounds_.start_paths();
    take(
        all, moved, [&](std::uint32_t object) { bounds_.place_path(object, paths); }, [](std::uint32_t) {});
  }

  std::size_t find_pairs(PairCursor& cursor, std::span<SolidPair> block) noexcept {
    std::size_t count = 0;
    for (SolidIndex a = cursor.next.a; a < bounds_.solids(); ++a) {
      if (object_pairs_.is_listed() && bounds_.solids() == bounds_.objects())
        return copy_pairs({a, a == cursor.next.a ? cursor.next.b : 0}, cursor, block, count);
      gather_partners(a);
      auto b = partners_.begin();
      if (a == cursor.next.a) b = std::lower_bound(b, partners_.end(), cursor.next.b);
      for (; b != partners_.end(); ++b) {
        if (count == block.size()) {
          cursor.next = {a, *b};
          return count;
        }
        block[count++] = {a, *b};
      }
    }
    cursor.next = {bounds_.solids(), 0};
    cursor.done = true;
    return count;
  }

 private:
  void take_room() {
    reserve_more(partners_, bounds_.solids());
    for (std::vector<std::uint32_t>* list : {&others_, &moved_}) reserve_more(*list, bounds_.objects());
    reserve_more(place_keys_, bounds_.objects()), reserve_more(pair_scratch_, bounds_.objects());
    if (is_moved_.size() < bounds_.objects()) resize_more(is_moved_, bounds_.objects());
  }

  template <class Place, class Prefetch>
  void take(bool all, std::span<const std::uint32_t> moved, const Place& place_object,
            const Prefetch& prefetch_object) noexcept {
    gathered_ = others_of_ = kNoIndex;
    note_moved(all, moved);
    if (all) {
      is_placed_ = true;
      place_all(bounds_.objects(), [&](std::size_t i) { place_object(static_cast<std::uint32_t>(i)); });
      forest_.update_all();
      object_pairs_.forget();
      return;
    }
    object_pairs_.forget(moved_);
    if (moved_.empty()) return;
    // Few are taken in the order of their places in the trees, which is none of the objects in memory.
    constexpr std::size_t kAhead = 8;
    const bool few = moved_.size() <= bounds_.objects() / ObjectForest::kFew;
    if (few) forest_.sort_by_place(moved_, place_keys_);
    place_all(moved_.size(), [&](std::size_t i) {
      if (few && i + kAhead < moved_.size()) prefetch_object(moved_[i + kAhead]);
      place_object(moved_[i]);
    });
    forest_.update(moved_);
  }

  /// Calls place_at(0) ... place_at(count - 1).
  template <class PlaceAt>
  void place_all(std::size_t count, const PlaceAt& place_at) noexcept {
    constexpr std::size_t kChunk = 2048;
    auto chunk = [&](std::size_t task) {
      for (std::size_t i = task * kChunk; i < std::min(count, (task + 1) * kChunk); ++i) place_at(i);
    };
    run_tasks(threads_, (count + kChunk - 1) / kChunk, chunk);
  }

  void note_moved(bool all, std::span<const std::uint32_t> moved) noexcept {
    for (const std::uint32_t object : moved_) is_moved_[object] = 0;
    moved_.clear();
    all_moved_ = all;
    if (all) return;
    moved_.resize(std::min<std::size_t>(moved.size(), bounds_.objects()));
    std::size_t count = 0;
    for (const std::uint32_t object : moved)
      if (std::exchange(is_moved_[object], 1) == 0) moved_[count++] = object;
    moved_.resize(count);
  }

  bool stands_still(const SolidPair& pair) const noexcept {
    return (is_moved_[bounds_.object_of(pair.a)] | is_moved_[bounds_.object_of(pair.b)]) == 0;
  }

  /// `out` grows by what is wanted alone.
  template <class IsWanted>
  void append_pairs_where(std::vector<SolidPair>& out, const IsWanted& is_wanted) noexcept {
    std::array<SolidPair, 256> block;
    for (PairCursor cursor; !cursor.done;) {
      const std::size_t count = find_pairs(cursor, block);
      const auto end = std::remove_if(block.begin(), block.begin() + static_cast<std::ptrdiff_t>(count),
                                      [&](const SolidPair& pair) { return !is_wanted(pair); });
      out.insert(out.end(), block.begin(), end);
    }
  }

  /// Of the solids of two objects, as find_pairs() pairs them.
  void append_pairs(std::uint32_t object, std::uint32_t higher, std::vector<SolidPair>& out) noexcept {
    if (bounds_.is_single(object) && bounds_.is_single(higher)) {  // tested already
      out.push_back({bounds_.first_solid(object), bounds_.first_solid(higher)});
      return;
    }
    gathered_ = kNoIndex;
    const SolidIndex end = bounds_.first_solid(object) + bounds_.solids_of(object);
    for (SolidIndex a = bounds_.first_solid(object); a < end; ++a) {
      partners_.clear();
      bounds_.append_partners(a, bounds_.solid_box(a), higher, partners_);
      for (const SolidIndex b : partners_) out.push_back({a, b});
    }
  }

  // Where every object has one solid, the list is the answer.
  std::size_t copy_pairs(SolidPair from, PairCursor& cursor, std::span<SolidPair> block,
                         std::size_t count) const noexcept {
    const std::span<const SolidPair> pairs = object_pairs_.listed();
    const auto first = std::lower_bound(pairs.begin(), pairs.end(), from);
    const auto left = static_cast<std::size_t>(pairs.end() - first);
    const std::size_t copied = std::min(left, block.size() - count);
    std::copy_n(first, copied, block.begin() + static_cast<std::ptrdiff_t>(count));
    cursor.done = copied == left;
    cursor.next = cursor.done ? SolidPair{bounds_.solids(), 0} : first[static_cast<std::ptrdiff_t>(copied)];
    return count + copied;
  }

  /// Once for all solids of an object that are asked about one after the other.
  void gather_others(std::uint32_t object) noexcept {
    if (others_of_ == object) return;
    others_of_ = object;
    others_.clear();
    forest_.for_each_partner(object, 0, [&](std::uint32_t other) {
      others_.push_back(other);
      return true;
    });
  }

  void gather_partners(SolidIndex a) noexcept {
    if (gathered_ == a) return;
    gathered_ = a;
    partners_.clear();
    const std::uint32_t object = bounds_.object_of(a);
    const std::span<const std::uint32_t> row = object_pairs_.row(object);
    if (bounds_.solids() == bounds_.objects()) {  // each solid is an object
      partners_.assign(row.begin(), row.end());
      return;
    }
    const Box box = bounds_.solid_box(a);
    for (std::uint32_t other : row) {
      if (bounds_.is_single(object) && bounds_.is_single(other))  // tested already
        partners_.push_back(bounds_.first_solid(other));
      else
        bounds_.append_partners(a, box, other, partners_);
    }
  }

  SolidBounds bounds_;
  ObjectForest forest_;
  ObjectPairs object_pairs_;
  TaskRunner* threads_;
  bool is_placed_ = false;
  SolidIndex gathered_ = kNoIndex;  // whose partners find_pairs holds, kept for the next block
  std::vector<SolidIndex> partners_;
  std::uint32_t others_of_ = kNoIndex;  // whose others_ are, kept for the object's next solid
  std::vector<std::uint32_t> others_;
  // By the last update: all objects, or these, each once.
  bool all_moved_ = true;
  std::vector<std::uint32_t> moved_;
  std::vector<std::uint64_t> place_keys_;
  std::vector<SolidPair> pair_scratch_;
  GrowingList<std::uint8_t> is_moved_;  // by object
};

class Native final : public Broadphase {
 public:
  std::string_view name() const noexcept override { return "native"; }

  void build(const BroadphaseInput& input) override { scene_ = std::make_unique<Scene>(input); }

  void update(std::span<const Pose> poses, std::span<const std::uint32_t> moved) noexcept override {
    scene_->update(poses, moved);
  }

  bool set_object(std::uint32_t object, const HexahedronTree* tree, bool is_static) override {
    scene_->set_object(object, tree, is_static);
    return true;
  }

  bool find_partners(SolidIndex solid, std::vector<SolidIndex>& out) noexcept override {
    scene_->find_partners(solid, out);
    return true;
  }

  bool find_moved_pairs(std::vector<SolidPair>& out) noexcept override {
    scene_->find_moved_pairs(out);
    return true;
  }

  bool find_pairs_by_place(std::vector<SolidPair>& out) noexcept override {
    scene_->find_pairs_by_place(out);
    return true;
  }

  bool update_paths(const SolidPaths& paths, std::span<const std::uint32_t> moved) noexcept override {
    scene_->update_paths(paths, moved);
    return true;
  }

  std::size_t find_pairs(PairCursor& cursor, std::span<SolidPair> block) noexcept override {
    return scene_->find_pairs(cursor, block);
  }

 private:
  std::unique_ptr<Scene> scene_ = std::make_unique<Scene>(BroadphaseInput{});
};

}  // namespace

std::unique_ptr<Broadphase> make_native_broadphase() { return std::make_unique<Native>(); }

}  // namespace touchstone
