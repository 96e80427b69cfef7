#include <algorithm>

#include "touchstone/contact_core/edge_face/edge_face.hpp"
#include "touchstone/contact_core/edge_face/edge_face_broadphase.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/training_run/flight/fleet.hpp"
#include "touchstone/examples/training_run/flight/method.hpp"

namespace touchstone::training {
namespace {

/// The paper's coarse check, then its fine one on what is in range.
class PoseCheck {
 public:
  explicit PoseCheck(const Setting& setting)
      : setting_(&setting), broadphase_(make_edge_face_broadphase()), block_(setting.pairs().size() + 1) {
    for (const HexahedronTree* tree : setting.instance().trees())
      refuse_rounded(*tree, "backend 'edge_face'");
    BackendRegistry registry;
    register_edge_face(registry);
    narrowphase_ = registry.make_narrowphase("edge_face");
    narrowphase_->build(setting.instance().solids());
    workspace_ = narrowphase_->make_workspace();
    broadphase_->build({.trees = setting.instance().trees()});
    X_WS_.resize(setting.instance().solids().size());
    in_range_.reserve(setting.pairs().size());
    status_.resize(setting.pairs().size());
    in_contact_.assign(setting.pairs().size(), 0);
  }

  /// Of the setting's pairs, 1 where the check calls it in contact. Allocates the coarse check's list.
  std::span<const char> check(std::span<const Pose> X_WO, const Formation& formation) noexcept {
    place(X_WO);
    broadphase_->update(X_WS_, {});
    in_range_.clear();
    for (PairCursor cursor; !cursor.done;) {
      const std::size_t count = broadphase_->find_pairs(cursor, block_);
      for (const SolidPair& pair : std::span(block_).first(count))
        if (is_checked(pair, formation)) in_range_.push_back(pair);
    }
    const std::span<PairStatus> status = std::span(status_).first(in_range_.size());
    Query query;
    query.kind = QueryKind::overlap;
    narrowphase_->evaluate({in_range_, X_WS_, query}, {status, {}, {}}, *workspace_);
    std::fill(in_contact_.begin(), in_contact_.end(), 0);
    for (std::size_t i = 0; i < in_range_.size(); ++i)
      in_contact_[index_of(in_range_[i])] = status[i] != PairStatus::separated;
    return in_contact_;
  }

 private:
  void place(std::span<const Pose> X_WO) noexcept {
    const SceneInstance& instance = setting_->instance();
    for (std::uint32_t object = 0; object < X_WO.size(); ++object) {
      const HexahedronTree& tree = *instance.trees()[object];
      find_global_positions(tree, X_WO[object],
                            std::span(X_WS_).subspan(instance.first_solid(object), tree.solids().size()));
    }
  }

  std::size_t index_of(const SolidPair& pair) const noexcept {
    const std::span<const SolidPair> pairs = setting_->pairs();
    return static_cast<std::size_t>(std::lower_bound(pairs.begin(), pairs.end(), pair) - pairs.begin());
  }

  bool is_checked(const SolidPair& pair, const Formation& formation) const noexcept {
    const std::size_t index = index_of(pair);
    return index < setting_->pairs().size() && setting_->pairs()[index] == pair &&
           formation.is_checked(pair, setting_->instance());
  }

  const Setting* setting_;
  std::unique_ptr<Broadphase> broadphase_;
  std::unique_ptr<Narrowphase> narrowphase_;
  std::unique_ptr<Narrowphase::Workspace> workspace_;
  std::vector<Pose> X_WS_;
  std::vector<SolidPair> block_, in_range_;
  std::vector<PairStatus> status_;
  std::vector<char> in_contact_;  // by pair of the setting
};

class FirstBuildMethod final : public FleetMethod {
 public:
  explicit FirstBuildMethod(const Setting& setting)
      : FleetMethod(setting),
        check_(setting),
        X_WO_before_(fleet_.X_WO),
        joints_before_(fleet_.joints),
        is_reported_(setting.pairs().size(), 0) {}

  std::string_view name() const noexcept override { return "figure 2"; }
  std::string_view backend() const noexcept override { return "edge_face"; }

  void frame(std::span<const Command> commands, std::span<const ArmCommand> arm_commands,
             FlightLog& log) noexcept override {
    X_WO_before_ = fleet_.X_WO;
    joints_before_ = fleet_.joints;
    for (const Command& command : commands) fleet_.execute(command);
    for (const ArmCommand& command : arm_commands) fleet_.execute(command);
    const std::span<const char> in_contact = check_.check(fleet_.X_WO, fleet_.formation);
    const bool is_commanded = !commands.empty() || !arm_commands.empty();
    const bool is_refused = is_commanded && setting_->scene().policy != ContactPolicy::cue &&
                            std::find(in_contact.begin(), in_contact.end(), 1) != in_contact.end();
    if (is_refused) {
      fleet_.X_WO = X_WO_before_;
      fleet_.joints = joints_before_;
      log_refusal(in_contact, log);
    } else {
      log_changes(in_contact, log);
    }
    ++frame_;
  }

 private:
  void log_event(EventKind kind, std::size_t pair, double s, FlightLog& log) const noexcept {
    log.add({frame_, kind, setting_->pairs()[pair], s, kNaN});
  }

  /// Nothing moved: contacts that were shown still are.
  void log_refusal(std::span<const char> in_contact, FlightLog& log) const noexcept {
    for (std::size_t i = 0; i < in_contact.size(); ++i) {
      if (is_reported_[i]) log_event(EventKind::persists, i, 0.0, log);
      if (in_contact[i]) log_event(EventKind::blocked, i, 0.0, log);
    }
  }

  /// Known of the pose at the frame's end.
  void log_changes(std::span<const char> in_contact, FlightLog& log) noexcept {
    for (std::size_t i = 0; i < in_contact.size(); ++i) {
      if (in_contact[i]) log_event(is_reported_[i] ? EventKind::persists : EventKind::began, i, 1.0, log);
      if (!in_contact[i] && is_reported_[i]) log_event(EventKind::ended, i, 1.0, log);
      is_reported_[i] = in_contact[i];
    }
  }

  PoseCheck check_;
  std::vector<Pose> X_WO_before_;
  std::vector<double> joints_before_;
  std::vector<char> is_reported_;  // by pair of the setting
  std::uint32_t frame_ = 0;
};

}  // namespace

std::unique_ptr<Method> make_first_build_method(const Setting& setting) {
  return std::make_unique<FirstBuildMethod>(setting);
}

}  // namespace touchstone::training
