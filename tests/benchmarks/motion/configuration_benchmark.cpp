// Whether configurations are free: the SSRMS-type arm (47 hexahedra) among 500 that stand still, joint values
// drawn anew each time. ConfigurationCheck beside the plain way: a broadphase gets all poses and is asked for
// all pairs, then the narrowphase about all of them.
//
//     configuration_benchmark [configurations, default 2000] [seed, default 1]
//
// Each way goes through all configurations in turn, five times; a configuration's time is the least of the
// five, of this thread's clock but for the batch, which is timed whole. Both must agree.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <random>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/mechanism/arms/ssrms.hpp"
#include "touchstone/contact_core/mechanism/configuration_check.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"
#include "touchstone/tests/support/random_solid.hpp"

namespace touchstone {
namespace {

constexpr int kObstacles = 500, kRounds = 5;

std::shared_ptr<const HexahedronTree> tree(const std::string& name, const Hexahedron& solid) {
  return std::make_shared<const HexahedronTree>(std::vector<PlacedHexahedron>{{"solid", solid, {}}}, name);
}

/// 20 x 20 tiles of 1 m under the arm and 100 blocks above it.
void add_floor(Random& random, ConfigurationScene& scene) {
  for (int i = 0; i < 400; ++i)
    scene.obstacles.push_back({tree("tile " + std::to_string(i), Hexahedron::from_size({1, 1, 0.3})),
                               {Matrix3::Identity(), {i / 20 - 9.5, i % 20 - 9.5, -6.0}}});
  for (int i = 0; i < 100; ++i)
    scene.obstacles.push_back(
        {tree("block " + std::to_string(i), random_solid(random, 1.0)),
         {rotation_about(Vector3::UnitX(), random.uniform(-3, 3)), random.vector(4) + Vector3(0, 0, 12)}});
}

/// Blocks of 0.4 to 1.4 m anywhere within `extent`.
void add_blocks(double extent, Random& random, ConfigurationScene& scene) {
  for (int i = 0; i < kObstacles; ++i)
    scene.obstacles.push_back(
        {tree("block " + std::to_string(i), random_solid(random, 1.0)),
         {rotation_about(Vector3::UnitZ(), random.uniform(-3, 3)), random.vector(extent)}});
}

/// Broadphase, then narrowphase.
class Plain {
 public:
  explicit Plain(const ConfigurationScene& scene) : mechanism_(*scene.mechanism) {
    std::vector<Hexahedron> solids = mechanism_.solids();
    std::vector<const HexahedronTree*> trees;
    std::vector<std::uint8_t> is_static;
    for (std::uint32_t link = 0; link < mechanism_.links().size(); ++link) {
      if (!mechanism_.links()[link].tree) continue;
      moved_.push_back(static_cast<std::uint32_t>(trees.size()));
      trees.push_back(mechanism_.links()[link].tree.get());
      is_static.push_back(link == mechanism_.base());
    }
    X_WS_.resize(solids.size());
    for (const Obstacle& obstacle : scene.obstacles) {
      solids.push_back(obstacle.tree->solids()[0].solid);
      X_WS_.push_back(compose(obstacle.X_WO, obstacle.tree->solids()[0].X_OS));
      trees.push_back(obstacle.tree.get());
      is_static.push_back(1);
    }
    native_->build(solids);
    broadphase_->build({trees, 0.0, is_static});
    X_WL_.resize(mechanism_.links().size());
    pairs_.resize(100000), status_.resize(pairs_.size());
  }

  bool is_free(std::span<const double> q) {
    mechanism_.link_poses({}, q, X_WL_);
    for (std::uint32_t i = 0; i < mechanism_.solids().size(); ++i)
      X_WS_[i] = compose(X_WL_[mechanism_.link_of(i)], mechanism_.placed(i).X_OS);
    broadphase_->update(X_WS_, moved_);
    PairCursor cursor;
    std::size_t count = broadphase_->find_pairs(cursor, pairs_);
    count = static_cast<std::size_t>(std::remove_if(pairs_.begin(), pairs_.begin() + count,
                                                    [&](SolidPair pair) {
                                                      return pair.b < mechanism_.solids().size() &&
                                                             mechanism_.is_exempt(pair.a, pair.b);
                                                    }) -
                                     pairs_.begin());
    asked_ += count;
    const std::span status(status_.data(), count);
    native_->evaluate({std::span(pairs_).first(count), X_WS_, {.kind = QueryKind::overlap}}, {status, {}, {}},
                      *workspace_);
    return std::all_of(status.begin(), status.end(), [](PairStatus s) { return s == PairStatus::separated; });
  }
  std::uint64_t asked() const { return asked_; }

 private:
  const Mechanism& mechanism_;
  std::unique_ptr<Narrowphase> native_ = make_native();
  std::unique_ptr<Narrowphase::Workspace> workspace_ = native_->make_workspace();
  std::unique_ptr<Broadphase> broadphase_ = [] {
    BackendRegistry registry;
    register_core(registry);
    return registry.make_broadphase("native");
  }();
  std::vector<Pose> X_WL_, X_WS_;
  std::vector<std::uint32_t> moved_;
  std::vector<SolidPair> pairs_;
  std::vector<PairStatus> status_;
  std::uint64_t asked_ = 0;
};

template <class Ask>
std::vector<double> timed(std::size_t count, const Ask& ask) {
  std::vector<double> us(count, kInfinity);
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t i = 0; i < count; ++i) {
      const double start = processor_us();
      ask(i);
      us[i] = std::min(us[i], processor_us() - start);
    }
  return us;
}

void print(const char* scene, const char* way, std::vector<double> us, double asked, double free_share) {
  double sum = 0.0;
  for (const double each : us) sum += each;
  std::sort(us.begin(), us.end());
  const auto at = [&](double share) {
    return us[static_cast<std::size_t>(share * static_cast<double>(us.size() - 1))];
  };
  std::printf("| %s | %s | %.1f | %.2f | %.2f | %.2f | %.2f | %.1f |\n", scene, way, 100.0 * free_share,
              sum / static_cast<double>(us.size()), at(0.5), at(0.999), at(1.0), asked);
}

int run(const char* name, const ConfigurationScene& scene, double share, int count, std::uint64_t seed) {
  // All joint values are drawn beforehand: every way is asked about the same ones.
  const std::size_t values = scene.mechanism->value_count();
  Random random(seed);
  std::vector<double> all(static_cast<std::size_t>(count) * values);
  for (double& value : all) value = random.uniform(-share, share) * std::numbers::pi;
  const auto configuration = [&](std::size_t i) { return std::span(all).subspan(i * values, values); };

  Plain plain(scene);
  std::vector<std::uint8_t> by_plain(count), out(count), batch(count);
  const auto plain_us = timed(count, [&](std::size_t i) { by_plain[i] = plain.is_free(configuration(i)); });

  const ConfigurationCheck check(scene, make_native());
  ConfigurationCheck::Scratch scratch = check.make_scratch();
  const auto own_us = timed(count, [&](std::size_t i) { out[i] = check.is_free(configuration(i), scratch); });
  const double asked = static_cast<double>(scratch.pairs_asked()) / (kRounds * count);
  double best = kInfinity;
  std::size_t free = 0;
  for (int round = 0; round < kRounds; ++round) {
    const double start = processor_us();
    free = check.are_free(all, batch, scratch);
    best = std::min(best, (processor_us() - start) / count);
  }
  const double free_share = static_cast<double>(free) / count;
  print(name, "broadphase, then narrowphase", plain_us,
        static_cast<double>(plain.asked()) / (kRounds * count), free_share);
  print(name, "ConfigurationCheck", own_us, asked, free_share);
  print(name, "ConfigurationCheck, in one batch", {best}, asked, free_share);
  std::fflush(stdout);
  return by_plain == out && out == batch ? 0 : 1;
}

}  // namespace
}  // namespace touchstone

int main(int argc, char** argv) {
  using namespace touchstone;
  // The number of configurations and the seed come from the command line.
  const int count = argc > 1 ? std::atoi(argv[1]) : 2000;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  if (count <= 0) {
    std::fprintf(stderr, "configuration_benchmark: the number of configurations must be > 0\n");
    return 1;
  }
  const auto arm = std::make_shared<const Mechanism>(make_ssrms());
  Random random(seed);
  ConfigurationScene floor{arm}, sparse{arm}, dense{arm};
  add_floor(random, floor);
  add_blocks(18.0, random, sparse);
  add_blocks(10.0, random, dense);
  std::printf(
      "| scene | way | free [%%] | mean [us] | median | 99.9 %% | worst | pairs asked |\n"
      "|---|---|---|---|---|---|---|---|\n");
  int wrong = 0;
  // Scenes: a floor of tiles with blocks above, blocks far apart, blocks close together.
  wrong += run("floor of tiles, blocks above; any joint values", floor, 1.0, count, seed);
  wrong += run("the same; joints within 54 deg", floor, 0.3, count, seed);
  wrong += run("500 blocks in 36 m; any", sparse, 1.0, count, seed);
  wrong += run("the same; within 54 deg", sparse, 0.3, count, seed);
  wrong += run("500 blocks in 20 m; any", dense, 1.0, count, seed);
  if (wrong != 0) std::fprintf(stderr, "configuration_benchmark: the two ways disagree\n");
  return wrong;
}
