#include <BulletCollision/BroadphaseCollision/btDbvt.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "touchstone/adapters/bullet/backends.hpp"
#include "touchstone/contact_core/broadphase/swept_sphere.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE {
namespace {

constexpr btScalar kEngineInfinity = std::numeric_limits<btScalar>::infinity();

btScalar round_down(double value) {
  const btScalar rounded = to_engine(value);
  return static_cast<double>(rounded) > value ? std::nextafter(rounded, -kEngineInfinity) : rounded;
}
btScalar round_up(double value) { return -round_down(-value); }

// value - margin and value + margin, rounded outwards.
double grown_down(double value, double margin) {
  return margin == 0.0 ? value : std::nextafter(value - margin, -kInfinity);
}
double grown_up(double value, double margin) { return -grown_down(-value, margin); }

/// The bounding box of a solid with these vertices and this radius, grown by margin.
btDbvtVolume bounding_volume(const WorldVertices& v, double radius, double margin) {
  const auto down = [&](double value) { return round_down(grown_down(grown_down(value, radius), margin)); };
  const auto up = [&](double value) { return round_up(grown_up(grown_up(value, radius), margin)); };
  const auto [low_x, high_x] = std::minmax_element(v.x.begin(), v.x.end());
  const auto [low_y, high_y] = std::minmax_element(v.y.begin(), v.y.end());
  const auto [low_z, high_z] = std::minmax_element(v.z.begin(), v.z.end());
  return btDbvtVolume::FromMM(btVector3(down(*low_x), down(*low_y), down(*low_z)),
                              btVector3(up(*high_x), up(*high_y), up(*high_z)));
}

btDbvtVolume engine_volume(const Box& box) {
  return btDbvtVolume::FromMM(
      btVector3(round_down(box.low[0]), round_down(box.low[1]), round_down(box.low[2])),
      btVector3(round_up(box.high[0]), round_up(box.high[1]), round_up(box.high[2])));
}

/// Solids above `a`, of other objects.
struct RowCollector final : btDbvt::ICollide {
  RowCollector(SolidIndex owner, const std::vector<std::uint32_t>& objects, std::vector<SolidIndex>& out)
      : a(owner), object_of(objects), row(out) {}

  using ICollide::Process;
  void Process(const btDbvtNode* leaf) override {
    const auto b = static_cast<SolidIndex>(leaf->dataAsInt);
    if (b > a && object_of[b] != object_of[a]) row.push_back(b);
  }

  SolidIndex a;
  const std::vector<std::uint32_t>& object_of;
  std::vector<SolidIndex>& row;
};

/// The leaves hold the solids' bounding boxes, or those of their whole paths. The pairs of solid a are a's
/// box, grown by the margin, against the tree: one row at a time, so that no list of all pairs is kept and a
/// sweep may stop anywhere.
class BulletBroadphase final : public Broadphase {
 public:
  explicit BulletBroadphase(std::string name) : name_(std::move(name)) {}

  std::string_view name() const noexcept override { return name_; }

  void build(const BroadphaseInput& input) override {
    if (!std::isfinite(input.margin) || input.margin < 0.0)
      throw InputError("broadphase margin is " + std::to_string(input.margin) + ", must be finite and >= 0");
    std::vector<Hexahedron> solids;
    std::vector<std::uint32_t> object_of;
    std::vector<std::uint32_t> first_solid{0};
    for (std::size_t t = 0; t < input.trees.size(); ++t) {
      if (input.trees[t] == nullptr) throw InputError("broadphase tree " + std::to_string(t) + " is null");
      for (const PlacedHexahedron& placed : input.trees[t]->solids()) {
        solids.push_back(placed.solid);
        object_of.push_back(static_cast<std::uint32_t>(t));
      }
      first_solid.push_back(static_cast<std::uint32_t>(solids.size()));
    }
    std::vector<btDbvtNode*> leaves(solids.size(), nullptr);
    std::vector<btDbvtVolume> grown(solids.size());
    std::vector<SolidIndex> row;
    row.reserve(solids.size());
    // A depth-first walk over n leaves never holds more than n nodes.
    stack_.reserve(static_cast<int>(std::max<std::size_t>(solids.size() + 1, btDbvt::SIMPLE_STACKSIZE)));

    tree_.clear();
    solids_.swap(solids);
    object_of_.swap(object_of);
    first_solid_.swap(first_solid);
    leaves_.swap(leaves);
    grown_.swap(grown);
    row_.swap(row);
    margin_ = input.margin;
    state_ = State::built;
    row_owner_ = kNoRow;
  }

  void update(std::span<const Pose> poses, std::span<const std::uint32_t> moved) noexcept override {
    take(State::posed, moved, [&](SolidIndex i) {
      WorldVertices vertices;
      world_vertices(solids_[i], poses[i], vertices);
      const double radius = solids_[i].radius();
      place(i, bounding_volume(vertices, radius, 0.0), bounding_volume(vertices, radius, margin_));
    });
  }

  bool update_paths(const SolidPaths& paths, std::span<const std::uint32_t> moved) noexcept override {
    take(State::swept, moved, [&](SolidIndex i) {
      const double bulge = paths.bulge.empty() ? 0.0 : paths.bulge[i];
      const SweptSphere swept = swept_sphere(solids_[i].bounding_sphere(), paths.from[i], paths.to[i], bulge);
      place(i, engine_volume(bounding_box(swept, 0.0)), engine_volume(bounding_box(swept, margin_)));
    });
    return true;
  }

  std::size_t find_pairs(PairCursor& cursor, std::span<SolidPair> block) noexcept override {
    std::size_t written = 0;
    if (state_ == State::built) cursor.done = true;
    while (!cursor.done) {
      if (cursor.next.a >= solids_.size()) {
        cursor.done = true;
        break;
      }
      collect_row(cursor.next.a);
      auto next = std::lower_bound(row_.begin(), row_.end(), cursor.next.b);
      for (; next != row_.end() && written < block.size(); ++next) block[written++] = {cursor.next.a, *next};
      if (next != row_.end()) {
        cursor.next.b = *next;
        break;
      }
      cursor.next = {cursor.next.a + 1, 0};
    }
    return written;
  }

 private:
  static constexpr SolidIndex kNoRow = kNoIndex;

  enum class State { built, posed, swept };

  /// Shared by update() and update_paths(): the first of its kind places every solid.
  template <class Place>
  void take(State kind, std::span<const std::uint32_t> moved, Place place_solid) noexcept {
    row_owner_ = kNoRow;
    if (state_ == kind) {
      for (const std::uint32_t object : moved)
        for (SolidIndex i = first_solid_[object]; i < first_solid_[object + 1]; ++i) place_solid(i);
      return;
    }
    for (SolidIndex i = 0; i < solids_.size(); ++i) place_solid(i);
    if (state_ == State::built) tree_.optimizeTopDown();
    state_ = kind;
  }

  void place(SolidIndex i, btDbvtVolume volume, const btDbvtVolume& grown) {
    grown_[i] = grown;
    if (leaves_[i] == nullptr) {
      leaves_[i] = tree_.insert(volume, nullptr);
      leaves_[i]->dataAsInt = static_cast<int>(i);
    } else {
      tree_.update(leaves_[i], volume);
    }
  }

  /// Solids above `a`, of other objects, whose boxes meet a's grown box; ascending.
  void collect_row(SolidIndex a) {
    if (row_owner_ == a) return;
    row_.clear();
    RowCollector collector(a, object_of_, row_);
    tree_.collideTVNoStackAlloc(tree_.m_root, grown_[a], stack_, collector);
    std::sort(row_.begin(), row_.end());
    row_owner_ = a;
  }

  std::string name_;
  std::vector<Hexahedron> solids_;
  std::vector<std::uint32_t> object_of_;    ///< of every solid
  std::vector<std::uint32_t> first_solid_;  ///< of every object, and the end
  std::vector<btDbvtNode*> leaves_;
  std::vector<btDbvtVolume> grown_;
  btDbvt tree_;
  btNodeStack stack_;
  std::vector<SolidIndex> row_;  ///< of row_owner_
  SolidIndex row_owner_ = kNoRow;
  double margin_ = 0.0;
  State state_ = State::built;
};

}  // namespace

std::unique_ptr<Broadphase> make_broadphase(std::string name) {
  return std::make_unique<BulletBroadphase>(std::move(name));
}

}  // namespace touchstone::TOUCHSTONE_BULLET_NAMESPACE
