#include "touchstone/examples/compare_backends/run/selection_gain.hpp"

#include <chrono>
#include <cmath>
#include <memory>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/examples/measures/runs/swarm.hpp"

namespace touchstone::comparison {
namespace {

constexpr double kGap = 1e-9;  // [m]

// One world of the swarm's boxes and what its frames took.
class SelectedWorld {
 public:
  SelectedWorld(const Swarm& swarm, double share_off)
      : swarm_(swarm), world_(make_native(), make_native_broadphase(), kGap) {
    world_.set_default_rule({ContactPolicy::cue});
    for (std::size_t i = 0; i < swarm.trees.size(); ++i)
      objects_.push_back(
          world_.add({std::make_shared<const HexahedronTree>(swarm.trees[i]), swarm.frames.front()[i]}));
    const auto count = static_cast<double>(objects_.size());
    off_ = static_cast<std::size_t>(std::lround(share_off * count));
    for (std::size_t k = 0; k < off_; ++k)
      world_.select(SelectionChange::of(objects_[k * objects_.size() / off_], false));
    world_.prepare();
  }

  void fly_there_and_back(bool timed) {
    const std::size_t frames = swarm_.frames.size();
    for (std::size_t f = 1; f < frames; ++f) step(f, timed);
    for (std::size_t f = frames - 1; f-- > 0;) step(f, timed);
  }

  /// Last: reorders the times.
  SelectionRow row(std::size_t repetitions) {
    const double candidates = static_cast<double>(candidates_) / static_cast<double>(times_.size());
    return {objects_.size(), off_, candidates, summarise_blocks(times_, repetitions)};
  }

 private:
  void step(std::size_t frame, bool timed) {
    commands_.clear();
    for (std::size_t i = 0; i < objects_.size(); ++i)
      commands_.push_back(world_.go_to(objects_[i], swarm_.frames[frame][i]));
    const auto begin = std::chrono::steady_clock::now();
    const FrameReport report = world_.frame(commands_);
    const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - begin;
    if (!timed) return;
    times_.push_back(taken.count());
    candidates_ += report.candidate_pairs;
  }

  const Swarm& swarm_;
  ContactWorld world_;
  std::vector<ObjectHandle> objects_;
  std::vector<MotionCommand> commands_;
  std::vector<double> times_;
  std::size_t off_ = 0, candidates_ = 0;
};

}  // namespace

std::vector<SelectionRow> run_selection(const SelectionOptions& options) {
  const Swarm swarm = make_swarm({options.objects, 1}, options.frames, options.seed);
  std::vector<std::unique_ptr<SelectedWorld>> worlds;
  for (const double share : options.shares_off)
    worlds.push_back(std::make_unique<SelectedWorld>(swarm, share));
  for (const auto& world : worlds) world->fly_there_and_back(false);
  for (std::size_t r = 0; r < options.repetitions; ++r)
    for (const auto& world : worlds) world->fly_there_and_back(true);
  std::vector<SelectionRow> rows;
  for (const auto& world : worlds) rows.push_back(world->row(options.repetitions));
  return rows;
}

}  // namespace touchstone::comparison
