#include "touchstone/tests/benchmarks/pairs/broadphase_frame.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/contact_core/broadphase/first_contact.hpp"
#include "touchstone/contact_core/registry.hpp"

namespace touchstone {
namespace {

constexpr std::size_t kPairs = 4096;

}  // namespace

MovingBoxes::MovingBoxes(int count, const Mix& mix) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> side(0.5, 1.5);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  std::normal_distribution<double> normal;
  const double extent = mix.spacing * std::cbrt(count);
  for (int i = 0; i < count; ++i) {
    // A box, or a row of boxes, whose size is spread over decades.
    const double scale = std::pow(10.0, -mix.decades * (place(random) + 0.5));
    const double x = scale * side(random), y = scale * side(random), z = scale * side(random);
    std::vector<PlacedHexahedron> placed;
    for (int part = 0; part < mix.solids; ++part)
      placed.push_back({"", Hexahedron::from_size({x, y, z}), {Matrix3::Identity(), {part * x, 0, 0}}});
    trees.emplace_back(std::move(placed));
    // Anywhere, turned anyhow.
    Pose X;
    X.R = rotation_from_quaternion(normal(random), normal(random), normal(random), normal(random));
    X.p = extent * Vector3(place(random), place(random), place(random));
    poses.resize(poses.size() + mix.solids);
    find_global_positions(trees.back(), X, std::span(poses).last(mix.solids));
    // Some stand still.
    const bool moves = place(random) + 0.5 >= mix.stationary;
    if (moves) moved.push_back(static_cast<std::uint32_t>(i));
    if (mix.flagged) is_static.push_back(moves ? 0 : 1);
    velocities.push_back(0.02 * Vector3(place(random), place(random), place(random)));
  }
  solids = mix.solids;
  for (const HexahedronTree& tree : trees) pointers.push_back(&tree);
}

void MovingBoxes::step() {
  const double sign = frame++ / 16 % 2 == 0 ? 1.0 : -1.0;
  for (std::uint32_t object : moved)
    for (int part = 0; part < solids; ++part) poses[object * solids + part].p += sign * velocities[object];
}

std::vector<Hexahedron> MovingBoxes::all_solids() const {
  std::vector<Hexahedron> out;
  for (const HexahedronTree& tree : trees)
    for (const PlacedHexahedron& placed : tree.solids()) out.push_back(placed.solid);
  return out;
}

double frame_seconds(const Mix& mix) {
  timespec t;
  clock_gettime(mix.threads > 1 ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

BroadphaseFrame::BroadphaseFrame(const std::string& name, int count, const Mix& wanted)
    : boxes(count, wanted),
      mix(wanted),
      team(static_cast<std::size_t>(wanted.threads)),
      block(kPairs),
      status(kPairs) {
  BackendRegistry registry;
  register_all_backends(registry);
  broadphase = registry.make_broadphase(name);
  broadphase->build({boxes.pointers, 0.0, boxes.is_static, mix.threads > 1 ? &team : nullptr});
  if (!mix.first_contact && !mix.overlap && !mix.manifold) return;
  narrowphase = registry.make_narrowphase("native");
  narrowphase->build(boxes.all_solids());
  workspace = narrowphase->make_workspace();
  if (mix.manifold) geometry.resize(kPairs), points.resize(kPairs * kMaxManifoldPoints);
}

void BroadphaseFrame::step() {
  if (mix.swept) before = boxes.poses;
  boxes.step();
}

void BroadphaseFrame::update() {
  if (mix.swept)
    broadphase->update_paths({before, boxes.poses}, boxes.moved);
  else
    broadphase->update(boxes.poses, boxes.moved);
}

void BroadphaseFrame::find() {
  pairs = 0;
  if (mix.first_contact)
    pairs = find_first_contact(*broadphase, *narrowphase, boxes.poses, *workspace, block, status) ? 1 : 0;
  else if (mix.moved_pairs || mix.by_place)
    find_listed();
  else
    for (PairCursor cursor; !cursor.done;) {
      const std::size_t count = broadphase->find_pairs(cursor, block);
      check(std::span(block).first(count));
      pairs += count;
    }
}

void BroadphaseFrame::find_listed() {
  listed.clear();
  if (mix.moved_pairs)
    broadphase->find_moved_pairs(listed);
  else
    broadphase->find_pairs_by_place(listed);
  for (std::size_t first = 0; first < listed.size(); first += block.size())
    check(std::span(listed).subspan(first, std::min(block.size(), listed.size() - first)));
  pairs = listed.size();
}

void BroadphaseFrame::check(std::span<const SolidPair> some) {
  if (!mix.overlap && !mix.manifold) return;
  Query query;
  query.kind = mix.manifold ? QueryKind::manifold : QueryKind::overlap;
  if (mix.contacts) query.max_separation = 0.0;
  narrowphase->evaluate({some, boxes.poses, query}, {status, geometry, points}, *workspace);
}

}  // namespace touchstone
