#include "touchstone/adapters/ode/ode_broadphase.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "touchstone/adapters/ode/ode_library.hpp"
#include "touchstone/contact_core/broadphase/swept_sphere.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::ode {
namespace {

/// dSAPSpace sorts by coordinates rounded to float: one part in 2^24. Twice that and the rounding of centre
/// and sides fit in 2^-22.
constexpr double kSortRounding = 0x1p-22;
/// ODE leaves out boxes thinner than its epsilon (2^-52), so none is made thinner than twice this [m].
constexpr double kLeastHalfSide = 1e-12;
/// Coordinates beyond this are cut to it, which keeps floats finite and every overlap an overlap [m].
constexpr double kLargestCoordinate = 1e30;

struct SpaceDeleter {
  void operator()(dxSpace* space) const { dSpaceDestroy(space); }
};
using SpaceHandle = std::unique_ptr<dxSpace, SpaceDeleter>;

struct Body {
  Hexahedron solid;
  std::uint32_t object;
  dGeomID geom;  ///< owned by the space
};

struct World {
  SpaceHandle space{dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ)};
  std::vector<Body> bodies;
  std::vector<std::uint32_t> first_solid;  ///< of each object, and the number of solids
  std::vector<SolidPair> pairs;            ///< of the last update, sorted
  double margin = 0.0;
  enum class State { built, posed, swept };
  State state = State::built;
};

/// @param radius of the solid that has these vertices. What its sum rounds, place() covers.
Box bounding_box(const WorldVertices& vertices, double radius) {
  Box box;
  const std::array<double, 8>* axes[3] = {&vertices.x, &vertices.y, &vertices.z};
  for (int k = 0; k < 3; ++k) {
    const auto [low, high] = std::minmax_element(axes[k]->begin(), axes[k]->end());
    box.low[k] = *low - radius, box.high[k] = *high + radius;
  }
  return box;
}

void place(const Body& body, const Box& box, double margin) {
  double centre[3];
  double side[3];
  for (int k = 0; k < 3; ++k) {
    const double growth = 0.5 * margin + kLeastHalfSide +
                          kSortRounding * (std::max(std::abs(box.low[k]), std::abs(box.high[k])) + margin);
    const double from = std::clamp(box.low[k] - growth, -kLargestCoordinate, kLargestCoordinate);
    const double to = std::clamp(box.high[k] + growth, -kLargestCoordinate, kLargestCoordinate);
    centre[k] = 0.5 * (from + to);
    side[k] = std::max(to - from, 2.0 * kLeastHalfSide);
  }
  dGeomBoxSetLengths(body.geom, side[0], side[1], side[2]);
  dGeomSetPosition(body.geom, centre[0], centre[1], centre[2]);
}

SolidIndex solid_index(dGeomID geom) {
  return static_cast<SolidIndex>(reinterpret_cast<std::uintptr_t>(dGeomGetData(geom)));
}

void collect_pair(void* data, dGeomID geom1, dGeomID geom2) {
  World& world = *static_cast<World*>(data);
  const auto [a, b] = std::minmax({solid_index(geom1), solid_index(geom2)});
  if (world.bodies[a].object != world.bodies[b].object) world.pairs.push_back({a, b});
}

class OdeBroadphase final : public Broadphase {
 public:
  std::string_view name() const noexcept override { return "ode"; }

  void build(const BroadphaseInput& input) override {
    if (!std::isfinite(input.margin) || input.margin < 0.0) {
      throw InputError("ode broadphase: margin must be finite and >= 0, is " + std::to_string(input.margin));
    }
    for (std::size_t i = 0; i < input.trees.size(); ++i) {
      if (input.trees[i] == nullptr)
        throw InputError("ode broadphase: tree " + std::to_string(i) + " is null");
    }
    dAllocateODEDataForThread(dAllocateMaskAll);
    auto world = std::make_unique<World>();
    world->margin = input.margin;
    for (std::size_t object = 0; object < input.trees.size(); ++object)
      add(*world, *input.trees[object], object);
    world->first_solid.push_back(static_cast<std::uint32_t>(world->bodies.size()));
    world_ = std::move(world);
  }

  void update(std::span<const Pose> poses, std::span<const std::uint32_t> moved) noexcept override {
    take(World::State::posed, moved, [&](const Body& body, SolidIndex i) {
      WorldVertices vertices;
      world_vertices(body.solid, poses[i], vertices);
      return bounding_box(vertices, body.solid.radius());
    });
  }

  bool update_paths(const SolidPaths& paths, std::span<const std::uint32_t> moved) noexcept override {
    take(World::State::swept, moved, [&](const Body& body, SolidIndex i) {
      const double bulge = paths.bulge.empty() ? 0.0 : paths.bulge[i];
      return touchstone::bounding_box(
          swept_sphere(body.solid.bounding_sphere(), paths.from[i], paths.to[i], bulge), 0.0);
    });
    return true;
  }

  std::size_t find_pairs(PairCursor& cursor, std::span<SolidPair> block) noexcept override {
    if (!world_ || cursor.done) {
      cursor.done = true;
      return 0;
    }
    const std::vector<SolidPair>& pairs = world_->pairs;
    const auto from = std::lower_bound(pairs.begin(), pairs.end(), cursor.next);
    const auto left = static_cast<std::size_t>(pairs.end() - from);
    const std::size_t count = std::min(block.size(), left);
    std::copy_n(from, count, block.begin());
    cursor.done = count == left;
    if (!cursor.done) cursor.next = from[static_cast<std::ptrdiff_t>(count)];
    return count;
  }

 private:
  static void add(World& world, const HexahedronTree& tree, std::size_t object) {
    world.first_solid.push_back(static_cast<std::uint32_t>(world.bodies.size()));
    for (const PlacedHexahedron& placed : tree.solids()) {
      const dGeomID geom = dCreateBox(world.space.get(), 1, 1, 1);
      // ODE's user data is a pointer; ours is an index. NOLINTNEXTLINE(performance-no-int-to-ptr)
      dGeomSetData(geom, reinterpret_cast<void*>(static_cast<std::uintptr_t>(world.bodies.size())));
      world.bodies.push_back({placed.solid, static_cast<std::uint32_t>(object), geom});
    }
  }

  /// Shared by update() and update_paths(): the first of its kind places every solid.
  template <class BoxOf>
  void take(World::State kind, std::span<const std::uint32_t> moved, BoxOf box_of) noexcept {
    if (!world_) return;
    World& world = *world_;
    const auto place_solids = [&](std::uint32_t from, std::uint32_t to) {
      for (std::uint32_t i = from; i < to; ++i)
        place(world.bodies[i], box_of(world.bodies[i], i), world.margin);
    };
    if (world.state == kind) {
      for (const std::uint32_t object : moved)
        place_solids(world.first_solid[object], world.first_solid[object + 1]);
    } else {
      place_solids(0, world.first_solid.back());
      world.state = kind;
    }
    world.pairs.clear();
    dSpaceCollide(world.space.get(), &world, &collect_pair);
    std::sort(world.pairs.begin(), world.pairs.end());
  }

  LibraryUse library_;
  std::unique_ptr<World> world_;
};

}  // namespace

std::unique_ptr<Broadphase> make_broadphase() { return std::make_unique<OdeBroadphase>(); }

}  // namespace touchstone::ode
