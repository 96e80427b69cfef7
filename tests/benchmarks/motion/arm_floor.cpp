#include "touchstone/tests/benchmarks/motion/arm_floor.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"

namespace touchstone {
namespace {

/// A box in the world, with edges along its axes.
struct Bounds {
  Vector3 low = Vector3::Constant(kInfinity), high = Vector3::Constant(-kInfinity);

  void take_in(const Hexahedron& solid, const Pose& X_WS) {
    for (const Vector3& vertex : solid.vertices()) {
      const Vector3 p = transform(X_WS, vertex);
      low = low.cwiseMin(p), high = high.cwiseMax(p);
    }
  }
  bool meets(const Bounds& other) const {
    return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
  }
};

struct SweptPair {
  const Hexahedron* solid;
  RigidPath path;
  const ArmFlight::Block* block;
};

/// The pairs that could meet on the arm's way from one set of joint values to another.
class PairSearch {
 public:
  explicit PairSearch(const ArmFlight& flight)
      : arm_(flight.arm()),
        blocks_(flight.blocks()),
        X_WL_(arm_.links().size()),
        X_WL_to_(arm_.links().size()) {
    for (const ArmFlight::Block& block : blocks_) bounds_.emplace_back().take_in(block.solid, block.X_WS);
  }

  void find(const std::vector<double>& from, const std::vector<double>& to, std::vector<SweptPair>& pairs) {
    pairs.clear();
    arm_.link_poses({}, from, X_WL_), arm_.link_poses({}, to, X_WL_to_);
    for (std::uint32_t i = 0; i < arm_.solids().size(); ++i) {
      const Hexahedron& solid = arm_.solids()[i];
      const Pose& X_LS = arm_.placed(i).X_OS;
      const Pose X_WS = compose(X_WL_[arm_.link_of(i)], X_LS);
      const Pose X_WS_to = compose(X_WL_to_[arm_.link_of(i)], X_LS);
      Bounds way;
      way.take_in(solid, X_WS), way.take_in(solid, X_WS_to);
      for (std::size_t k = 0; k < blocks_.size(); ++k)
        if (way.meets(bounds_[k])) pairs.push_back({&solid, RigidPath::between(X_WS, X_WS_to), &blocks_[k]});
    }
  }

 private:
  const Mechanism& arm_;
  std::span<const ArmFlight::Block> blocks_;
  std::vector<Pose> X_WL_, X_WL_to_;
  std::vector<Bounds> bounds_;
};

}  // namespace

std::vector<FlownFrame> fly_and_note(const ArmCase& wanted, std::size_t frames) {
  ArmFlight flight(wanted);
  std::vector<FlownFrame> flown;
  const auto values = [](std::span<const double> joints) {
    return std::vector<double>(joints.begin(), joints.end());
  };
  const std::size_t settling = static_cast<std::size_t>(flight.frames_until_settled());
  for (std::size_t i = 0; i < settling + frames; ++i) {
    FlownFrame& frame = flown.emplace_back();
    frame.from = values(flight.actual());
    flight.step();
    frame.commanded = values(flight.commanded()), frame.to = values(flight.actual());
  }
  return flown;
}

ToldFrames fly_as_told(const ArmCase& wanted, const std::vector<FlownFrame>& flown, int flights) {
  ToldFrames out;
  std::vector<double> least;
  for (int i = 0; i < flights; ++i) {
    // The same flight again; its frames count once it has settled.
    ArmFlight flight(wanted);
    const std::size_t settling = static_cast<std::size_t>(flight.frames_until_settled());
    const std::size_t frames = flown.size() - settling;
    least.resize(frames, kInfinity);
    out.queries = out.steps = 0.0;
    for (std::size_t k = 0; k < flown.size(); ++k) {
      const double start = processor_us();
      const FrameReport report = flight.step_to(flown[k].to);
      const double time = processor_us() - start;
      if (k < settling) continue;
      double& of_frame = least[k - settling];
      of_frame = report.slide_steps > 0 ? kNaN : std::min(of_frame, time);
      out.queries += static_cast<double>(report.queries) / static_cast<double>(frames);
      out.steps += report.slide_steps / static_cast<double>(frames);
    }
  }
  // Frames in which it slid are the same in each flight.
  std::copy_if(least.begin(), least.end(), std::back_inserter(out.us),
               [](double us) { return !std::isnan(us); });
  return out;
}

SweptFrames sweep(const ArmCase& wanted, const std::vector<FlownFrame>& flown, const SweepEntry& entry) {
  constexpr int kRounds = 3;
  const ArmFlight flight(wanted);
  PairSearch search(flight);
  const std::size_t settling = static_cast<std::size_t>(flight.frames_until_settled());
  SweptFrames out;
  std::vector<SweptPair> pairs;
  std::vector<std::unique_ptr<Sweep>> sweeps;
  std::vector<RigidPath> stand;
  for (std::size_t k = settling; k < flown.size(); ++k) {
    // The frame's pairs are found and set.
    search.find(flown[k].from, flown[k].commanded, pairs);
    stand.clear();
    for (const SweptPair& pair : pairs) stand.emplace_back(pair.block->X_WS);
    while (sweeps.size() < pairs.size()) sweeps.push_back(entry.make());
    for (std::size_t i = 0; i < pairs.size(); ++i)
      sweeps[i]->set(*pairs[i].solid, pairs[i].path, pairs[i].block->solid, stand[i]);
    // All of them are swept.
    double least = kInfinity;
    bool meets = false;
    for (int round = 0; round < kRounds; ++round) {
      const double start = processor_us();
      for (std::size_t i = 0; i < pairs.size(); ++i)
        if (sweeps[i]->impact().has_value()) meets = true;
      least = std::min(least, processor_us() - start);
    }
    out.us.push_back(least);
    out.sweeps += static_cast<double>(pairs.size()), out.meetings += meets ? 1.0 : 0.0;
  }
  out.sweeps /= static_cast<double>(out.us.size()), out.meetings /= static_cast<double>(out.us.size());
  return out;
}

}  // namespace touchstone
