#include <algorithm>
#include <array>
#include <atomic>

#include "contact_core/broadphase/object_tree.hpp"
#include "contact_core/broadphase/pair_list.hpp"
#include "contact_core/broadphase/register_broadphases.hpp"
#include "contact_core/broadphase/swept_sphere.hpp"
#include "contact_core/broadphase/tree_join.hpp"

namespace touchstone {
namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFF;
constexpr std::size_t kMostThreads = 16;

// One object's sphere tree (the paper's), its spheres in world. Inner spheres are refitted around their
// children's world spheres, so they hold whatever rounding the poses carry; children follow their parent in
// the array.
struct SphereNode {
  Sphere sphere_W;
  std::int32_t left, right, solid;  // left and right relative to the object's first node; solid is global
};

// Moving and static objects have a tree each, so that static ones are neither refitted nor paired.
struct Group {
  ObjectTree tree;
  std::vector<Sphere> sphere_at;  // of the object in each slot
  std::size_t moves_since_sort = 0;
};

// What build() makes.
class Scene {
 public:
  explicit Scene(const BroadphaseInput& input)
      : table_(make_solid_table(input)), margin_(input.margin), threads_(input.threads) {
    const std::uint32_t objects = table_.objects();
    for (std::uint32_t object = 0; object < objects; ++object)
      add_nodes(*input.trees[object], table_.first_solid[object]);
    solid_sphere_W_.resize(table_.solids()), object_sphere_W_.resize(objects);
    std::vector<std::uint32_t> members[2];
    for (std::uint32_t object = 0; object < objects; ++object)
      members[table_.is_static[object] != 0 ? 1 : 0].push_back(object);
    for (int g = 0; g < 2; ++g) {
      groups_[g].sphere_at.resize(members[g].size());
      groups_[g].tree.resize(std::move(members[g]));
    }
    slot_of_.resize(objects);
    list_.resize(objects, kListedPairsPerObject * std::size_t{objects}, kMostThreads);
    work_.reserve(kMostWork), work_scratch_.reserve(kMostWork);
    is_changed_.resize(objects);
    changed_.reserve(objects / kFew + 1);
    fresh_.reserve(std::max<std::size_t>(objects, 64));
    partner_objects_.reserve(objects), partners_.reserve(table_.solids());
    stack_.resize(nodes_.size() + 1);
  }

  void update(std::span<const Pose> poses, std::span<const std::uint32_t> moved) noexcept {
    take(Kind::poses, moved, [&](std::uint32_t object) { place(object, poses); });
  }

  void update_paths(const SolidPaths& paths, std::span<const std::uint32_t> moved) noexcept {
    swept_.resize(table_.solids()), node_box_.resize(nodes_.size());
    take(Kind::paths, moved, [&](std::uint32_t object) { place_path(object, paths); });
  }

  std::size_t find_pairs(PairCursor& cursor, std::span<SolidPair> block) noexcept {
    std::size_t count = 0;
    for (SolidIndex a = cursor.next.a; a < table_.solids(); ++a) {
      if (list_state_ == ListState::complete && table_.solids() == table_.objects())
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
    cursor.next = {table_.solids(), 0};
    cursor.done = true;
    return count;
  }

 private:
  enum class Kind { none, poses, paths };
  enum class ListState { due, few_changed, complete, full };

  void add_nodes(const HexahedronTree& tree, std::uint32_t first_solid) {
    first_node_.push_back(static_cast<std::uint32_t>(nodes_.size()));
    for (const HexahedronTree::Node& node : tree.nodes())
      nodes_.push_back({{Vector3::Zero(), 0.0},
                        node.left,
                        node.right,
                        node.solid < 0 ? -1 : static_cast<std::int32_t>(first_solid) + node.solid});
    node_count_.push_back(static_cast<std::uint32_t>(tree.nodes().size()));
  }

  Group& group_of(std::uint32_t object) { return groups_[table_.is_static[object] != 0 ? 1 : 0]; }
  bool is_single(std::uint32_t object) const { return node_count_[object] == 1; }

  // --- update: the objects' own bounds, then the trees over them

  template <class Place>
  void take(Kind kind, std::span<const std::uint32_t> moved, const Place& place_object) noexcept {
    gathered_solid_ = gathered_object_ = kNone;
    rows_asked_ = 0;
    if (kind != kind_) {
      kind_ = kind;
      list_state_ = ListState::due;
      place_all(table_.objects(), [](std::size_t i) { return static_cast<std::uint32_t>(i); }, place_object);
      for (Group& group : groups_) sort(group);
      for (Group& group : groups_) refit(group);
      return;
    }
    if (moved.empty()) return;
    note_changes(moved);
    // Each object must be placed by one thread.
    const bool ascending = std::is_sorted(moved.begin(), moved.end(), std::less_equal<>());
    if (ascending)
      place_all(moved.size(), [&](std::size_t i) { return moved[i]; }, place_object);
    else
      for (std::uint32_t object : moved) place_object(object);
    refit_moved(moved);
  }

  template <class ObjectAt, class Place>
  void place_all(std::size_t count, ObjectAt object_at, const Place& place_object) noexcept {
    constexpr std::size_t kChunk = 2048;
    auto chunk = [&](std::size_t task) {
      for (std::size_t i = task * kChunk; i < std::min(count, (task + 1) * kChunk); ++i)
        place_object(object_at(i));
    };
    run_tasks(threads_, (count + kChunk - 1) / kChunk, chunk);
  }

  void place(std::uint32_t object, std::span<const Pose> poses) noexcept {
    SphereNode* const nodes = &nodes_[first_node_[object]];
    for (std::uint32_t i = node_count_[object]; i-- > 0;) {
      SphereNode& node = nodes[i];
      if (node.solid >= 0)
        node.sphere_W = solid_sphere_W_[node.solid] =
            world_sphere(table_.sphere_S[node.solid], poses[node.solid]);
      else
        node.sphere_W = enclosing_sphere(nodes[node.left].sphere_W, nodes[node.right].sphere_W);
    }
    object_sphere_W_[object] = nodes[0].sphere_W;
  }

  // Paths are long and thin: boxes of all swept below, not spheres.
  void place_path(std::uint32_t object, const SolidPaths& paths) noexcept {
    const SphereNode* const nodes = &nodes_[first_node_[object]];
    Box* const boxes = &node_box_[first_node_[object]];
    for (std::uint32_t i = node_count_[object]; i-- > 0;) {
      const std::int32_t s = nodes[i].solid;
      if (s >= 0) {
        const double bulge = paths.bulge.empty() ? 0.0 : paths.bulge[s];
        swept_[s] = swept_sphere(table_.sphere_S[s], paths.from[s], paths.to[s], bulge);
        boxes[i] = bounding_box(swept_[s], 0.5 * margin_);
      } else {
        boxes[i] = union_of(boxes[nodes[i].left], boxes[nodes[i].right]);
      }
    }
    Sphere& sphere = object_sphere_W_[object];  // only its centre counts, to sort by
    for (int i = 0; i < 3; ++i) sphere.centre(i) = 0.5 * boxes[0].low[i] + 0.5 * boxes[0].high[i];
  }

  Box object_box(std::uint32_t object) const noexcept {
    if (kind_ == Kind::paths) return node_box_[first_node_[object]];
    return bounding_box(object_sphere_W_[object], 0.5 * margin_);
  }

  void sort(Group& group) noexcept {
    group.moves_since_sort = 0;
    const FloatFrame frame = group.tree.sort(object_sphere_W_, slot_of_);
    // What moves decides; static objects share its frame and would have to be refitted.
    const bool decides = &group == &groups_[0] || groups_[0].tree.size() == 0;
    if (!decides || !(groups_[1].tree.size() == 0 || has_outgrown(frame))) return;
    frame_ = frame;
    if (kind_ != Kind::none && &group == &groups_[0]) refit(groups_[1]);
  }

  // Floats are about 2^-24 of their distance from the origin: a frame serves until that shows.
  bool has_outgrown(const FloatFrame& fit) const noexcept {
    for (int i = 0; i < 3; ++i) {
      const double growth = fit.scale(i) / frame_.scale(i);
      const double shift = (fit.origin(i) - frame_.origin(i)) * frame_.scale(i);
      if (!(growth > 0.125 && growth < 8.0 && std::abs(shift) < 4096.0)) return true;
    }
    return false;
  }

  void refit(Group& group) noexcept {
    auto box_of = [&](std::uint32_t slot, std::uint32_t object) {
      group.sphere_at[slot] = object_sphere_W_[object];
      return object_box(object);
    };
    group.tree.refit(frame_, box_of, threads_);
  }

  // Sorting costs about as much as refitting; a tree whose objects have all moved once since is due.
  void refit_moved(std::span<const std::uint32_t> moved) noexcept {
    std::size_t static_moves = 0;
    for (std::uint32_t object : moved) static_moves += table_.is_static[object] != 0 ? 1 : 0;
    const std::size_t moves[2] = {moved.size() - static_moves, static_moves};
    bool one_by_one[2];
    for (int g = 0; g < 2; ++g) {
      Group& group = groups_[g];
      group.moves_since_sort += moves[g];
      const bool resort = moves[g] > 0 && group.moves_since_sort >= group.tree.size();
      one_by_one[g] = !resort && moves[g] <= group.tree.size() / kFew;
      if (resort) sort(group);
      if (!one_by_one[g]) refit(group);
    }
    for (std::uint32_t object : moved) {
      if (!one_by_one[table_.is_static[object] != 0 ? 1 : 0]) continue;
      Group& group = group_of(object);
      group.sphere_at[slot_of_[object]] = object_sphere_W_[object];
      group.tree.refit_one(slot_of_[object], object_box(object));
    }
  }

  // --- the list of pairs of objects, made when pairs are first asked for

  void note_changes(std::span<const std::uint32_t> moved) noexcept {
    if (list_state_ == ListState::full) list_state_ = ListState::due;
    if (list_state_ == ListState::due) return;
    list_state_ = ListState::few_changed;
    for (std::uint32_t object : moved) {
      if (is_changed_[object] != 0) continue;
      if (changed_.size() >= table_.objects() / kFew) {
        forget_changes();
        list_state_ = ListState::due;
        return;
      }
      is_changed_[object] = 1;
      changed_.push_back(object);
    }
  }

  void forget_changes() noexcept {
    for (std::uint32_t object : changed_) is_changed_[object] = 0;
    changed_.clear();
  }

  void make_list() noexcept {
    if (list_state_ == ListState::few_changed && list_changed_pairs()) return;
    forget_changes();
    list_state_ = list_all_pairs() ? ListState::complete : ListState::full;
  }

  // Only the pairs of objects that moved: each is asked for its own.
  bool list_changed_pairs() noexcept {
    fresh_.clear();
    for (std::uint32_t object : changed_) {
      const bool fits = for_each_partner(object, 0, [&](std::uint32_t other) {
        if (is_changed_[other] != 0 && other <= object) return true;  // found from the other side
        if (fresh_.size() == fresh_.capacity()) return false;
        fresh_.push_back(object < other ? SolidPair{object, other} : SolidPair{other, object});
        return true;
      });
      if (!fits) return false;
    }
    std::sort(fresh_.begin(), fresh_.end());
    if (!list_.replace(is_changed_, fresh_)) return false;
    forget_changes();
    list_state_ = ListState::complete;
    return true;
  }

  struct Work {
    int group;  // the moving objects with this one
    NodePair nodes;
  };

  TreeJoin join_with(int group) const { return {groups_[0].tree, groups_[group].tree}; }

  // All pairs at once, walking the trees, which is kind to caches. False when the list does not hold them.
  bool list_all_pairs() noexcept {
    const std::size_t tasks = threads_ == nullptr ? 1 : std::min(threads_->threads(), kMostThreads);
    work_.clear();
    for (int group = 0; group < 2; ++group) work_.push_back({group, join_with(group).root()});
    if (tasks > 1) split_work();
    list_.start();
    std::atomic<std::size_t> next_work{0};
    std::atomic<bool> fits{true};
    auto task = [&](std::size_t) {
      PairList::Writer writer(list_);
      for (std::size_t i; (i = next_work.fetch_add(1, std::memory_order_relaxed)) < work_.size();)
        if (!list_pairs_below(work_[i], writer)) fits.store(false, std::memory_order_relaxed);
      writer.close();
    };
    run_tasks(threads_, tasks, task);
    if (!fits.load()) return false;
    list_.sort(threads_);
    return true;
  }

  // Into parts of a size that keeps all threads busy to the end.
  void split_work() noexcept {
    for (bool splits = true; splits && work_.size() * 16 <= kMostWork;) {
      splits = false;
      work_scratch_.clear();
      for (const Work& work : work_) {
        if (TreeJoin::is_leaf(work.nodes)) {
          work_scratch_.push_back(work);
          continue;
        }
        splits = true;
        join_with(work.group).expand(work.nodes, [&](const NodePair& nodes) {
          work_scratch_.push_back({work.group, nodes});
        });
      }
      work_.swap(work_scratch_);
    }
  }

  bool list_pairs_below(const Work& work, PairList::Writer& writer) noexcept {
    const Group& a = groups_[0];
    const Group& b = groups_[work.group];
    const TreeJoin join = join_with(work.group);
    bool fits = true;
    const auto list_leaf = [&](const NodePair& leaf, auto may_pair) {
      if (!writer.room()) return fits = false;
      join.visit_leaf(leaf, [&](std::uint32_t slot, std::uint32_t other) {
        writer.add(a.tree.object_at(slot), b.tree.object_at(other), may_pair(slot, other));
      });
      return true;
    };
    if (kind_ == Kind::paths) {
      join.walk(work.nodes, [&](const NodePair& leaf) {
        return list_leaf(leaf, [&](std::uint32_t slot, std::uint32_t other) {
          return paths_may_touch(a.tree.object_at(slot), b.tree.object_at(other));
        });
      });
    } else {
      join.walk(work.nodes, [&](const NodePair& leaf) {
        return list_leaf(leaf, [&](std::uint32_t slot, std::uint32_t other) {
          return may_touch(a.sphere_at[slot], b.sphere_at[other], margin_);
        });
      });
    }
    return fits;
  }

  bool paths_may_touch(std::uint32_t object, std::uint32_t other) const noexcept {
    if (!overlap(node_box_[first_node_[object]], node_box_[first_node_[other]])) return false;
    if (!is_single(object) || !is_single(other)) return true;
    return may_touch(swept_[table_.first_solid[object]], swept_[table_.first_solid[other]], margin_);
  }

  bool may_pair(std::uint32_t object, std::uint32_t other) const noexcept {
    if (kind_ == Kind::paths) return paths_may_touch(object, other);
    return may_touch(object_sphere_W_[object], object_sphere_W_[other], margin_);
  }

  // --- one object's pairs

  // Calls visit(other) for the objects from `first` on that pair with this one, until it returns false.
  template <class Visit>
  bool for_each_partner(std::uint32_t object, std::uint32_t first, Visit visit) const noexcept {
    const Box box = object_box(object);
    bool goes_on = true;
    for (int g = 0; g < (table_.is_static[object] != 0 ? 1 : 2); ++g)
      groups_[g].tree.for_each_from(first, box, [&](std::uint32_t other) {
        if (goes_on && other != object && may_pair(object, other)) goes_on = visit(other);
      });
    return goes_on;
  }

  std::span<const std::uint32_t> partner_objects(std::uint32_t object) noexcept {
    if (gathered_object_ == object) return partner_objects_;
    if (list_state_ == ListState::due || list_state_ == ListState::few_changed) {
      // The first few rows are cheaper asked for one by one: who stops early needs no more.
      if (rows_asked_ < table_.objects() / kRowsAskedFirst)
        ++rows_asked_;
      else
        make_list();
    }
    gathered_object_ = object;
    partner_objects_.clear();
    if (list_state_ == ListState::complete) {
      copy_row(object);
    } else {
      for_each_partner(object, object + 1, [&](std::uint32_t other) {
        partner_objects_.push_back(other);
        return true;
      });
      std::sort(partner_objects_.begin(), partner_objects_.end());
    }
    return partner_objects_;
  }

  // Rows are read in order: the next one begins where the last one ended.
  void copy_row(std::uint32_t object) noexcept {
    const std::span<const SolidPair> pairs = list_.pairs();
    std::size_t next = row_end_;
    const bool follows = next <= pairs.size() && (next == 0 || pairs[next - 1].a < object) &&
                         (next == pairs.size() || pairs[next].a >= object);
    if (!follows)
      next = static_cast<std::size_t>(
          std::lower_bound(pairs.begin(), pairs.end(), SolidPair{object, 0}) - pairs.begin());
    for (; next < pairs.size() && pairs[next].a == object; ++next) partner_objects_.push_back(pairs[next].b);
    row_end_ = next;
  }

  // Where every object has one solid, the list is the answer.
  std::size_t copy_pairs(SolidPair from, PairCursor& cursor, std::span<SolidPair> block,
                         std::size_t count) const noexcept {
    const std::span<const SolidPair> pairs = list_.pairs();
    const auto first = std::lower_bound(pairs.begin(), pairs.end(), from);
    const auto left = static_cast<std::size_t>(pairs.end() - first);
    const std::size_t copied = std::min(left, block.size() - count);
    std::copy_n(first, copied, block.begin() + static_cast<std::ptrdiff_t>(count));
    cursor.done = copied == left;
    cursor.next =
        cursor.done ? SolidPair{table_.solids(), 0} : first[static_cast<std::ptrdiff_t>(copied)];
    return count + copied;
  }

  // --- and its solids'

  void gather_partners(SolidIndex a) noexcept {
    if (gathered_solid_ == a) return;
    gathered_solid_ = a;
    partners_.clear();
    const std::uint32_t object = table_.object_of[a];
    for (std::uint32_t other : partner_objects(object)) {
      if (is_single(object) && is_single(other)) {  // tested already
        partners_.push_back(table_.first_solid[other]);
        continue;
      }
      const auto first = static_cast<std::ptrdiff_t>(partners_.size());
      if (kind_ == Kind::paths)
        gather_paths_below(first_node_[other], a);
      else
        gather_below(first_node_[other], solid_sphere_W_[a]);
      std::sort(partners_.begin() + first, partners_.end());
    }
  }

  void gather_below(std::uint32_t root, const Sphere& sphere) noexcept {
    descend(root, [&](std::uint32_t node) { return may_touch(nodes_[node].sphere_W, sphere, margin_); });
  }

  void gather_paths_below(std::uint32_t root, SolidIndex a) noexcept {
    const Box box = bounding_box(swept_[a], 0.5 * margin_);
    descend(root, [&](std::uint32_t node) {
      if (!overlap(node_box_[node], box)) return false;
      return nodes_[node].solid < 0 || may_touch(swept_[a], swept_[nodes_[node].solid], margin_);
    });
  }

  template <class MayTouch>
  void descend(std::uint32_t root, MayTouch node_may_touch) noexcept {
    std::size_t top = 0;
    stack_[top++] = 0;
    while (top > 0) {
      const std::uint32_t index = root + stack_[--top];
      if (!node_may_touch(index)) continue;
      const SphereNode& node = nodes_[index];
      if (node.solid >= 0) {
        partners_.push_back(static_cast<SolidIndex>(node.solid));
      } else {
        stack_[top++] = static_cast<std::uint32_t>(node.right);
        stack_[top++] = static_cast<std::uint32_t>(node.left);
      }
    }
  }

  SolidTable table_;
  double margin_;
  TaskRunner* threads_;
  Kind kind_ = Kind::none;
  std::vector<SphereNode> nodes_;
  std::vector<std::uint32_t> first_node_, node_count_;
  std::vector<Sphere> solid_sphere_W_, object_sphere_W_;
  std::vector<SweptSphere> swept_;  // of solids, and the boxes of nodes: of paths only
  std::vector<Box> node_box_;

  Group groups_[2];  // moving, static
  FloatFrame frame_;
  std::vector<std::uint32_t> slot_of_;  // of each object, in its group

  // When at most one object in kFew moves, trees and list are mended, not made anew.
  static constexpr std::uint32_t kFew = 16;
  // One row in so many is asked for by itself before the list is made.
  static constexpr std::uint32_t kRowsAskedFirst = 256;
  // Scenes so dense that the list does not hold their pairs are asked object by object: there the answer is
  // most of the work.
  static constexpr std::size_t kListedPairsPerObject = 16;
  static constexpr std::size_t kMostWork = 4096;
  ListState list_state_ = ListState::due;
  PairList list_;
  std::vector<Work> work_, work_scratch_;
  std::vector<std::uint8_t> is_changed_;  // since the list was made, by object
  std::vector<std::uint32_t> changed_;
  std::vector<SolidPair> fresh_;
  std::uint32_t rows_asked_ = 0;

  // What find_pairs gathered last, kept for the next block.
  std::uint32_t gathered_object_ = kNone, gathered_solid_ = kNone;
  std::vector<std::uint32_t> partner_objects_;
  std::vector<SolidIndex> partners_;
  std::vector<std::uint32_t> stack_;
  std::size_t row_end_ = 0;  // of the row of list_ read last
};

class Native final : public Broadphase {
 public:
  std::string_view name() const noexcept override { return "native"; }

  void build(const BroadphaseInput& input) override { scene_ = std::make_unique<Scene>(input); }

  void update(std::span<const Pose> poses, std::span<const std::uint32_t> moved) noexcept override {
    scene_->update(poses, moved);
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
