#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/motion/narrowphase_query.hpp"
#include "touchstone/contact_core/output/frame_output.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"
#include "touchstone/examples/training_run/flight/flight_log.hpp"
#include "touchstone/examples/training_run/setting/setting.hpp"

namespace touchstone::training {

/// One object's commanded path over a frame.
struct Command {
  std::uint32_t object;  ///< index in the scene
  RigidPath path;        ///< from its actual pose
};

/// An arm's commanded joint values at a frame's end; they change evenly from the actual ones.
struct ArmCommand {
  const Arm* arm;
  std::span<const double> values;
};

/// Answers commands: decides what is shown at a frame's end.
class Method {
 public:
  virtual ~Method() = default;
  virtual std::string_view name() const noexcept = 0;
  virtual std::string_view backend() const noexcept = 0;
  /// How the poses that it shows were checked.
  virtual MotionCheck check() const noexcept { return MotionCheck::proven; }
  /// Between frames; may allocate.
  virtual void act(const Action& action) = 0;
  /// Between frames; may allocate. From the next frame on commands come with `arm`: one of the setting's,
  /// held by another link where that is (held_by()), which carries what it carried. Who keeps nothing of an
  /// arm has nothing to do. @throws InputError, nothing changed: the method cannot.
  virtual void set_base(const Arm&) {}
  /// Moves what may move and adds events to the log. Allocates only where the method documents it.
  virtual void frame(std::span<const Command> commands, std::span<const ArmCommand> arm_commands,
                     FlightLog& log) noexcept = 0;
  /// Set-up. @throws InputError as FrameOutput::add_object.
  virtual void attach(FrameOutput& output) = 0;
  /// Brings what is shown now to the outputs; 0 frames have been flown at the start. No allocation.
  virtual void send(double time) noexcept = 0;
  /// Actual poses of all objects.
  virtual std::span<const Pose> poses() const noexcept = 0;
  /// Of all arms, actual.
  virtual std::span<const double> joints() const noexcept = 0;
  virtual const Formation& formation() const noexcept = 0;
};

/// (i) No check: every command is carried out.
std::unique_ptr<Method> make_unchecked_method(const Setting& setting);

inline constexpr double kImageGeneratorDelay = 0.1;  ///< round trip [s]
inline constexpr double kLongestDelay = 10.0;        ///< a report's [s]

/// (ii) The paper's Figure 1. The host carries commands out and sends poses to the image generator, which
/// shows them, checks what it shows (poses alone, here by `native`, so never wrongly), and reports which
/// pairs are in contact. The report on a frame is there `delay` [s] later: at the start of the first frame at
/// or after that. While the newest report there names a mover in a pair whose policy is not `cue`, the host
/// does not carry out its commands.
/// @throws InputError: a delay below 0 or above kLongestDelay.
std::unique_ptr<Method> make_late_report_method(const Setting& setting, double delay = kImageGeneratorDelay);

/// (iii) The paper's Figure 2, its first build. The host checks where all that is commanded in a frame would
/// be at the frame's end, poses alone, with the paper's coarse check and its fine check behind it (both
/// `edge_face`). If any pair whose policy is not `cue` is in contact there, no command of that frame is
/// carried out. The paper speaks of a step as a whole; that it means all movers of a frame is a reading.
/// Frames allocate: the coarse check's list.
std::unique_ptr<Method> make_first_build_method(const Setting& setting);

/// (iv) The contact world with the scene's policy and gap.
/// @throws InputError where it cannot work with the narrowphase.
std::unique_ptr<Method> make_contact_world_method(const Setting& setting,
                                                  std::unique_ptr<Narrowphase> narrowphase,
                                                  std::unique_ptr<Broadphase> broadphase);

}  // namespace touchstone::training
