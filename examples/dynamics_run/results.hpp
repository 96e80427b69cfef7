#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/examples/measures/common/quantiles.hpp"
#include "touchstone/physics/scene/dynamic_scene.hpp"

namespace touchstone::dynamics {

inline constexpr double kNone = kNaN;

/// One contact in one step.
struct ContactRow {
  double time;         ///< at the step's end [s]
  std::uint32_t a, b;  ///< solids, as SceneResult::solid_names has them
  PairStatus status;
  Vector3 p_W, n_AB_W;  ///< at the step's start; the point in the middle between the two surfaces'
  double depth;         ///< at the step's start: > 0 overlapping, < 0 apart [m]
  Vector3 force_W;      ///< on B, mean over the step, impacts included [N]
  Vector3 impact_W;     ///< on B, of impacts alone [N s]
};

/// The state at a step's end. The first sample is the start.
struct Sample {
  double time;
  Vector3 linear_W, angular_W;  ///< momenta of all, about the world's origin
  double energy;
};

/// The recorded samples; of every n-th step.
struct Series {
  std::vector<Sample> samples;
  // By sample and object or joint; joints through the mechanisms in order.
  std::vector<Vector3> force_W, moment_W;  ///< of contacts on the object, the moment about the world's origin
  std::vector<Vector3> p_W;                ///< of the object's origin
  std::vector<Quaternion> q_WO;            ///< the object's attitude
  std::vector<double> value, rate, torque;
  std::vector<ContactRow> contacts;
};

/// One answer of the scene against what came out.
struct AnswerResult {
  Vector3 found = Vector3::Constant(kNone);
  double error = kNone;  ///< distance, in the answer's unit; nan: it never came out
  bool holds = false;
  bool is_given = true;  ///< false: the engine does not give this figure, and it is not judged
};

/// One scene in one engine, over the contacts of one backend.
struct BackendRun {
  std::string backend;      ///< see run_name()
  std::string not_run;      ///< why; empty: it was
  std::string stopped;      ///< why before the end; empty: it went through
  std::uint64_t steps = 0;  ///< taken
  std::vector<Pose> last;   ///< by object
  std::vector<AnswerResult> answers;
  double deepest = 0.0;  ///< worst penetration at a step's end, by native [m]
  double unexplained_momentum = kNone, linear_drift = kNone, angular_drift = kNone, energy_drift = kNone,
         energy_made = kNone, energy_lost = kNone, energy_scale = kNone, linear_scale = kNone,
         angular_scale = kNone;
  double pose_error = kNone, angle_error = kNone;  ///< of final poses, from the reference's [m], [rad]
  std::vector<double> total_us, detection_us;  ///< of each step, its fastest repetition; emptied when judged
  measures::StepTimes total, detection;        ///< of a step; finding the contacts alone
  std::optional<std::uint64_t> allocations;    ///< in all of them but the first
  std::uint64_t contact_count = 0, undecided = 0, failed = 0, unconverged = 0;
  double worst_residual = 0.0;  ///< of the contact solver [m/s]
  double rest_speed = kNone;    ///< of the fastest point of any dynamic object at the end [m/s]
  Series series;
  std::vector<std::string> misses;  ///< of the scene's limits: what keeps it from being recommended
  bool late = false;                ///< its steps' 99.9th percentile is beyond the deadline

  bool is_whole() const { return not_run.empty() && stopped.empty(); }  ///< it went through
};

struct SceneResult {
  std::string file;  ///< the scene's name without .yaml
  std::shared_ptr<const physics::DynamicScene> scene;
  std::vector<std::string> solid_names;
  std::string reference;  ///< the backend that final poses are compared with
  std::vector<BackendRun> runs;
  double deadline_us = kNone;  ///< of a step; nan: none
  bool touches = true;         ///< by the reference, or nobody knows; else there is nothing to choose by
  std::string recommended;     ///< empty: none
  std::string reason;
};

/// The verdict over all scenes.
struct OverallVerdict {
  std::string recommended;  ///< empty: none
  std::string reason;
};

/// `mechanism.joint` of all joints that move, in the order of Series.
std::vector<std::string> joint_names(const physics::DynamicScene& scene);
std::vector<physics::JointAddress> moving_joints(const physics::DynamicScene& scene);

/// Whether final poses count: false where the scene accepts any, as where none can be foreseen.
bool compares_poses(const physics::DynamicScene& scene);

/// Compares final poses with the reference's, says what each run misses, and names the backend to build on.
void judge(SceneResult& result);

/// Names the backend to build on for a scene whose runs are judged: fewest misses, then within the deadline,
/// then without allocations, then the fastest (median or 99.9th percentile, whichever is further behind), and
/// of those as fast the most accurate. None where nothing touches.
void choose(SceneResult& result);

/// The same over all scenes: misses and lateness count by scene, times where something touches.
OverallVerdict choose_over_all(const std::vector<SceneResult>& results);

/// The whole run as JSON: figures in SI units; what was not measured is null.
/// @param not_measured scenes, or scene/backend, that a run which ended early did not come to; empty:
/// complete.
std::string results_json(const std::vector<SceneResult>& results,
                         const std::vector<std::string>& not_measured = {});
/// One row a scene and backend; the last column tells a partial run.
std::string results_csv(const std::vector<SceneResult>& results,
                        const std::vector<std::string>& not_measured = {});
/// A run over time: momenta, energy, joints, forces on objects and where they are.
std::string series_csv(const SceneResult& result, const BackendRun& run);
/// One row a contact and step.
std::string contacts_csv(const SceneResult& result, const BackendRun& run);
/// Explains the columns.
std::string legend_text(const std::string& reference);
/// Tables for a terminal of 120 columns.
std::string terminal_text(const SceneResult& result);
/// The verdict over all scenes, a line.
std::string terminal_text(const OverallVerdict& verdict, std::size_t scenes);
/// Contact forces, joint torques, momenta and energy over time, all backends; empty without any.
std::string time_plot(const SceneResult& result);

}  // namespace touchstone::dynamics
