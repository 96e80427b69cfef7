#include "touchstone/tests/world/progress/motion_progress.hpp"

#include <algorithm>
#include <iomanip>
#include <iostream>
#include <stdexcept>
#include <string>

#include "touchstone/contact_core/threads/processor_time.hpp"
#include "touchstone/tests/world/progress/progress_trial.hpp"

namespace touchstone {
namespace {

constexpr int kSteps = 12, kPathSamples = 5;
constexpr double kWorthATry = 1e-3, kTaken = 0.1, kMotionless = 1e-6, kStuck = 1e-2;

class Flight {
 public:
  Flight(const ProgressRun& run, std::uint64_t seed, ProgressFigures& figures)
      : trial_(make_trial(run.scene, run.rate, run.gap, seed)),
        finder_(*trial_.model, trial_.world->gap()),
        figures_(figures),
        seed_(seed) {
    // Blocked frames are looked at so that their number does not grow with the rate.
    every_ = std::max(1, trial_.frames / (2 * run.looks));
    // Trials that overlap from the start are not judged.
    if (!finder_.is_apart(trial_.at()))
      throw std::logic_error("'" + run.scene + "' starts in contact, seed " + std::to_string(seed));
  }

  void fly() {
    Configuration goal;
    const Configuration start = trial_.at();
    trial_.model->weigh_at(start);
    for (int frame = 0; frame < trial_.frames; ++frame) goal = step(frame);
    if (!trial_.has_end) return;
    const double left = trial_.model->distance(trial_.at(), goal);
    const double nearer = left - finder_.reached(trial_.at(), goal, kSteps);
    figures_.stuck += nearer > kStuck * trial_.model->distance(start, goal);
  }

 private:
  Configuration step(int frame) {
    const Configuration before = trial_.at();
    frame_ = frame;
    if (trial_.path) {
      follow(before, trial_.path(before.X_WO, frame), trial_.open_path(before.X_WO, frame));
      return before;
    }
    const Configuration goal = trial_.command(before, frame);
    const bool blocked = advance(goal);
    if (blocked) trial_.model->weigh_at(trial_.executed(0, 1.0));  // where its slide began
    const double left = trial_.model->distance(before, goal);
    const double nearer = left - trial_.model->distance(trial_.at(), goal);
    if (blocked && left > 0.0) {
      figures_.motionless += nearer <= kMotionless * left;
      if (is_looked_at()) judge(left, nearer, left - finder_.reached(before, goal, kSteps));
    }
    return goal;
  }

  void follow(const Configuration& before, const RigidPath& path, const RigidPath& open) {
    MotionCommand command{trial_.body, path};
    const bool blocked = run({&command, 1}, {});
    if (!blocked) return;
    const double left = trial_.model->distance(before, {{}, path.to()});
    const double nearer = left - trial_.model->distance(trial_.at(), {{}, path.to()});
    figures_.motionless += nearer <= kMotionless * left;
    if (is_looked_at()) judge(left, nearer, left * finder_.clear_until(open, 64));
  }

  bool advance(const Configuration& goal) {
    if (trial_.is_arm) {
      const JointCommand command{trial_.arm, goal.q};
      return run({}, {&command, 1});
    }
    const MotionCommand command = trial_.world->go_to(trial_.body, goal.X_WO);
    return run({&command, 1}, {});
  }

  bool run(std::span<const MotionCommand> commands, std::span<const JointCommand> joints) {
    const double start = processor_us();
    const FrameReport report = trial_.world->frame(commands, joints);
    const double took = processor_us() - start;
    figures_.worst_us = std::max(figures_.worst_us, took);
    figures_.sum_us += took;
    ++figures_.frames;
    figures_.blocked += report.blocked_movers > 0;
    if (report.blocked_movers > 0) ++blocked_;
    if (report.blocked_movers > 0 && is_looked_at()) figures_.merged += !executed_is_apart();
    return report.blocked_movers > 0;
  }

  /// At samples of every part, its end among them.
  bool executed_is_apart() {
    for (std::size_t part = 0; part < trial_.world->executed_parts(); ++part)
      for (int i = 1; i <= kPathSamples; ++i)
        if (!finder_.is_apart(trial_.executed(part, static_cast<double>(i) / kPathSamples))) return false;
    return true;
  }

  bool is_looked_at() const { return blocked_ % every_ == 0; }

  void judge(double left, double nearer, double found) {
    ++figures_.looked_at;
    if (!(found > kWorthATry * left)) return;
    ++figures_.open;
    if (!(nearer < kTaken * found)) return;
    ++figures_.frozen;
    figures_.frozen_frames.push_back({seed_, frame_, left, nearer, found});
  }

  ProgressTrial trial_;
  PathFinder finder_;
  ProgressFigures& figures_;
  std::uint64_t seed_;
  int every_ = 1, blocked_ = 0, frame_ = 0;
};

}  // namespace

ProgressFigures measure_progress(const ProgressRun& run) {
  ProgressFigures figures;
  figures.run = run;
  for (int trial = 0; trial < run.trials; ++trial) Flight(run, run.seed + trial, figures).fly();
  return figures;
}

void print_progress_heading(std::ostream& out) {
  out << std::left << std::setw(14) << "scene" << std::right << std::setw(6) << "Hz" << std::setw(8) << "gap"
      << std::setw(8) << "trials" << std::setw(9) << "frames" << std::setw(9) << "blocked" << std::setw(12)
      << "motionless" << std::setw(7) << "open" << std::setw(8) << "frozen" << std::setw(8) << "%"
      << std::setw(7) << "stuck" << std::setw(8) << "merged" << std::setw(9) << "mean us" << std::setw(10)
      << "worst us" << '\n';
}

void print_progress(std::ostream& out, const ProgressFigures& f) {
  out << std::left << std::setw(14) << f.run.scene << std::right << std::setw(6) << f.run.rate << std::setw(8)
      << f.run.gap << std::setw(8) << f.run.trials << std::setw(9) << f.frames << std::setw(9) << f.blocked
      << std::setw(12) << f.motionless << std::setw(7) << f.open << std::setw(8) << f.frozen << std::setw(8)
      << std::setprecision(3) << 100.0 * f.frozen_share() << std::setw(7) << f.stuck << std::setw(8)
      << f.merged << std::setw(9) << f.sum_us / static_cast<double>(std::max<std::uint64_t>(f.frames, 1))
      << std::setw(10) << f.worst_us << std::endl;
}

void print_frozen(std::ostream& out, const ProgressFigures& f) {
  for (const FrozenFrame& frame : f.frozen_frames)
    out << "  frozen: seed " << frame.seed << ", frame " << frame.frame << ": " << frame.left << " left, "
        << frame.taken << " taken, " << frame.found << " found\n";
}

}  // namespace touchstone
