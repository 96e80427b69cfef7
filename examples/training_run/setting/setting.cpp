#include "touchstone/examples/training_run/setting/setting.hpp"

#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::training {
namespace {

constexpr std::uint64_t kMostFrames = 1'000'000;

/// Latches of the scene become actions at its start: a script may release what they carry.
Script with_latches_as_actions(Script script) {
  std::vector<OperatorAction> actions;
  for (const SceneLatch& latch : script.scene.latches) {
    actions.push_back({OperatorAction::Kind::latch, 0.0, latch.carried, latch.carrier, latch.allowed});
  }
  script.scene.latches.clear();
  script.actions.insert(script.actions.begin(), actions.begin(), actions.end());
  return script;
}

Script with_rate(Script script, double frame_rate) {
  if (frame_rate == 0.0) return script;
  if (!(frame_rate >= kLowestFrameRate && frame_rate <= kHighestFrameRate))
    throw InputError("a frame rate of " + std::to_string(frame_rate) + " Hz is not within 10 and 1000 Hz");
  script.scene.frame_rate = frame_rate;
  return script;
}

}  // namespace

Setting::Setting(Script script, double frame_rate)
    : script_(with_latches_as_actions(with_rate(std::move(script), frame_rate))),
      arms_(add_arms(script_)),
      instance_(script_.scene) {
  // The log of a flight has room for this many frames.
  if (!(scene().duration * scene().frame_rate <= static_cast<double>(kMostFrames)))
    throw InputError("script '" + script_.name + "': more than 1 000 000 frames");
  // Links of arms and objects in hands may move.
  may_move_.assign(object_count(), 0);
  arm_of_.assign(object_count(), nullptr);
  for (const Arm& arm : arms_) place(arm);
  auto arm = arms_.begin();
  for (const HandScript& hand : script_.hands) {
    object_of_hand_.push_back(hand.arm ? (arm++)->first_object : find(hand.object));
    if (!hand.arm) may_move_[object_of_hand_.back()] = 1;
  }
  // So may objects that are taken along.
  for (std::uint32_t i = 0; i < object_count(); ++i) {
    may_be_taken_along_.push_back(!may_move_[i] && !arm_of_[i] && touchstone::may_be_taken_along(scene(), i));
    if (may_be_taken_along_[i]) may_move_[i] = 1;
  }
  // A latch may move both of its sides.
  for (const OperatorAction& action : script_.actions) {
    const bool latches = action.kind == OperatorAction::Kind::latch,
               holds = action.kind == OperatorAction::Kind::hold;
    actions_.push_back({action.kind, action.time, find(action.object),
                        latches || holds ? find(action.carrier) : kNone, solids_of(action.allowed)});
    // A held object may be let go, so it may move; a fixture that holds it stands still.
    if (latches || holds) may_move_[actions_.back().object] = 1;
    if (!latches) continue;
    if (!arm_of_[actions_.back().carrier]) may_move_[actions_.back().carrier] = 1;
  }
  // Pairs that never move are not checked.
  for (const SolidPair& pair : instance_.checked_pairs())
    if (may_move(instance_.object_of(pair.a)) || may_move(instance_.object_of(pair.b)))
      pairs_.push_back(pair);
}

void Setting::place(const Arm& arm) {
  value_count_ += arm.joints.size();
  for (std::uint32_t i = 0; i < arm.object_count; ++i) {
    arm_of_[arm.first_object + i] = &arm;
    bool moves = false;
    for (const std::uint32_t joint : arm.mechanism->chain(arm.link_of_object[i]))
      moves = moves || arm.mechanism->joints()[joint].value != Mechanism::kNone;
    may_move_[arm.first_object + i] = moves;
  }
}

std::uint32_t Setting::find(const std::string& name) const {
  for (std::uint32_t i = 0; i < object_count(); ++i)
    if (object_name(i) == name) return i;
  throw InputError("script '" + script_.name + "': the scene has no object '" + name + "'");
}

std::vector<SolidPair> Setting::solids_of(std::span<const ExemptPair> pairs) const {
  std::vector<SolidPair> out;
  for (const ExemptPair& pair : pairs) {
    const std::vector<SolidPair> named = instance_.solids_of(pair);
    out.insert(out.end(), named.begin(), named.end());
  }
  std::sort(out.begin(), out.end());
  return out;
}

HandRates Setting::rates(std::size_t hand, std::size_t frame) const {
  HandRates in_force;
  for (const HandRates& row : script_.hands[hand].rates)
    if (row.time <= time(frame)) in_force = row;
  return in_force;
}

bool Formation::is_checked(const SolidPair& pair, const SceneInstance& instance) const {
  const std::uint32_t a = instance.object_of(pair.a), b = instance.object_of(pair.b);
  if (!is_on[a] || !is_on[b] || root_of(a) == root_of(b)) return false;
  return std::none_of(allowed.begin(), allowed.end(), [&](const std::vector<SolidPair>& pairs) {
    return std::binary_search(pairs.begin(), pairs.end(), pair);
  });
}

void Formation::apply(const Action& action, std::span<const Pose> X_WO) {
  using Kind = OperatorAction::Kind;
  if (action.kind == Kind::latch) carrier[action.object] = action.carrier;
  if (action.kind == Kind::latch) allowed[action.object] = action.allowed;
  if (action.kind == Kind::release) carrier[action.object] = kNone, allowed[action.object].clear();
  if (action.kind == Kind::switch_on || action.kind == Kind::switch_off)
    is_on[action.object] = action.kind == Kind::switch_on;
  for (std::uint32_t i = 0; i < X_RO.size(); ++i)
    X_RO[i] = carrier[i] == kNone ? Pose{} : compose(inverse(X_WO[root_of(i)]), X_WO[i]);
}

}  // namespace touchstone::training
