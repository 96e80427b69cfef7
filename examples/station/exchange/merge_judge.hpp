#pragma once

#include <array>
#include <memory>
#include <vector>

#include "touchstone/examples/station/exchange/exchange.hpp"
#include "touchstone/examples/station/flight/session.hpp"
#include "touchstone/examples/training_run/results/judge.hpp"

namespace touchstone::station {

/// The verdict of `exact` on the frames that a method has shown since the last reset.
struct MergeFigures {
  std::uint64_t judged_frame = 0;  ///< the last one
  std::uint32_t judged = 0, merged = 0;
  double depth_now = 0.0, depth_worst = 0.0;  ///< [m]
  std::uint32_t with_off = 0;  ///< judged while something was switched off: its pairs were left out
  bool has_pair = false;       ///< of the last one: the deepest pair
  SolidPair pair{0, 0};
};

struct JudgeFigures {
  std::uint32_t epoch = 0;  ///< Session::epoch() that they are about
  std::array<MergeFigures, kMethods> methods;
};

/// Judges shown frames off the loop's path. offer() and take() are the loop's thread's, work() another's.
class MergeJudge {
 public:
  /// Keeps a reference.
  explicit MergeJudge(const StationScenes& scenes);

  /// Takes the poses that every method shows now. No allocation; those without room are counted, not judged.
  void offer(const Session& session) noexcept;
  /// The newest figures.
  const JudgeFigures& take() noexcept;
  std::uint64_t passed_by() const { return passed_by_; }

  /// Judges what is there. Returns whether there was any.
  bool work();

 private:
  struct Job {
    std::size_t scene = 0;
    std::uint32_t epoch = 0;
    std::uint64_t frame = 0;
    std::size_t method = 0;
    std::shared_ptr<const training::Formation> formation;
    std::vector<Pose> X_WO;
  };
  void judge(const Job& job);

  static constexpr std::size_t kRoom = 256;

  const StationScenes* scenes_;
  Ring<Job> jobs_;
  Latest<JudgeFigures> figures_;
  std::uint64_t passed_by_ = 0;
  // The other thread's.
  std::vector<std::unique_ptr<training::Judge>> judges_;  // by scene; made when first needed
  JudgeFigures so_far_;
  std::array<std::vector<Pose>, kMethods> last_;
  std::array<std::shared_ptr<const training::Formation>, kMethods> last_formation_;
};

}  // namespace touchstone::station
