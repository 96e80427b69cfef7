#include <algorithm>
#include <cmath>
#include <string>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/examples/training_run/flight/fleet.hpp"
#include "touchstone/examples/training_run/flight/method.hpp"

namespace touchstone::training {
namespace {

/// The image generator: checks what it shows and reports late.
class ImageGenerator {
 public:
  ImageGenerator(const Setting& setting, double delay)
      : setting_(&setting),
        narrowphase_(make_native()),
        // A report is there at the first frame that starts at or after its time, to the rounding of a rate.
        delay_(static_cast<std::size_t>(std::ceil(delay * setting.scene().frame_rate * (1.0 - 0x1p-40)))) {
    narrowphase_->build(setting.instance().solids());
    workspace_ = narrowphase_->make_workspace();
    X_WS_.resize(setting.instance().solids().size());
    reports_.assign((delay_ + 1) * setting.pairs().size(), PairStatus::separated);
  }

  /// The poses shown from the start of frame `frame` on.
  void show(std::size_t frame, const Fleet& fleet) noexcept {
    const SceneInstance& instance = setting_->instance();
    for (SolidIndex i = 0; i < X_WS_.size(); ++i) {
      const std::uint32_t object = instance.object_of(i);
      X_WS_[i] = compose(fleet.X_WO[object],
                         instance.trees()[object]->solids()[i - instance.first_solid(object)].X_OS);
    }
    const std::span<PairStatus> report = slot(frame);
    Query query;
    query.kind = QueryKind::overlap;
    narrowphase_->evaluate({setting_->pairs(), X_WS_, query}, {report, {}, {}}, *workspace_);
    for (std::size_t i = 0; i < report.size(); ++i)
      if (!fleet.formation.is_checked(setting_->pairs()[i], setting_->instance()))
        report[i] = PairStatus::separated;
  }

  /// The newest report that is there at the start of frame `frame`; empty: none yet.
  std::span<const PairStatus> report_at(std::size_t frame) noexcept {
    if (frame < delay_) return {};
    return slot(frame - delay_);
  }

 private:
  std::span<PairStatus> slot(std::size_t frame) noexcept {
    const std::size_t pairs = setting_->pairs().size();
    return std::span(reports_).subspan(frame % (delay_ + 1) * pairs, pairs);
  }

  const Setting* setting_;
  std::unique_ptr<Narrowphase> narrowphase_;
  std::unique_ptr<Narrowphase::Workspace> workspace_;
  std::size_t delay_;  // frames
  std::vector<Pose> X_WS_;
  std::vector<PairStatus> reports_;  // by frame modulo delay_ + 1, and pair
};

class LateReportMethod final : public FleetMethod {
 public:
  LateReportMethod(const Setting& setting, double delay)
      : FleetMethod(setting), image_generator_(setting, delay), was_named_(setting.pairs().size(), 0) {
    image_generator_.show(0, fleet_);
  }

  std::string_view name() const noexcept override { return "figure 1"; }
  std::string_view backend() const noexcept override { return "native, poses"; }

  void frame(std::span<const Command> commands, std::span<const ArmCommand> arm_commands,
             FlightLog& log) noexcept override {
    const std::span<const PairStatus> report = image_generator_.report_at(frame_);
    log_changes(report, log);
    for (const Command& command : commands)
      if (!is_stopped(command.object, report, log)) fleet_.execute(command);
    for (const ArmCommand& command : arm_commands)
      if (!is_stopped(command.arm->first_object, report, log)) fleet_.execute(command);
    ++frame_;
    image_generator_.show(frame_, fleet_);
  }

 private:
  void log_event(EventKind kind, std::size_t pair, FlightLog& log) const noexcept {
    log.add({static_cast<std::uint32_t>(frame_), kind, setting_->pairs()[pair], 0.0, kNaN});
  }

  void log_changes(std::span<const PairStatus> report, FlightLog& log) noexcept {
    for (std::size_t i = 0; i < report.size(); ++i) {
      const bool is_named = report[i] != PairStatus::separated;
      if (is_named) log_event(was_named_[i] ? EventKind::persists : EventKind::began, i, log);
      if (!is_named && was_named_[i]) log_event(EventKind::ended, i, log);
      was_named_[i] = is_named;
    }
  }

  bool is_stopped(std::uint32_t mover, std::span<const PairStatus> report, FlightLog& log) const noexcept {
    if (setting_->scene().policy == ContactPolicy::cue) return false;
    bool stopped = false;
    for (std::size_t i = 0; i < report.size(); ++i) {
      if (report[i] == PairStatus::separated) continue;
      const SolidPair& pair = setting_->pairs()[i];
      for (const SolidIndex solid : {pair.a, pair.b}) {
        const std::uint32_t root = fleet_.formation.root_of(setting_->instance().object_of(solid));
        if (setting_->mover_of(root) != mover) continue;
        stopped = true;
        log_event(EventKind::blocked, i, log);
      }
    }
    return stopped;
  }

  ImageGenerator image_generator_;
  std::vector<char> was_named_;
  std::size_t frame_ = 0;
};

}  // namespace

std::unique_ptr<Method> make_late_report_method(const Setting& setting, double delay) {
  if (!(delay >= 0.0 && delay <= kLongestDelay))
    throw InputError("a report's delay of " + std::to_string(delay) + " s is not within 0 and 10 s");
  return std::make_unique<LateReportMethod>(setting, delay);
}

}  // namespace touchstone::training
