#include "touchstone/contact_core/world/frame/movers.hpp"

#include <algorithm>

#include "touchstone/contact_core/geometry/finite.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"

namespace touchstone {
namespace {

constexpr std::uint32_t kNone = Mechanism::kNone;

bool is_finite(const RigidPath& path) { return is_valid_pose(path.from()) && is_valid_pose(path.to()); }

/// Of a command, which concerns one object at most.
ContactEvent command_event(EventKind kind, ObjectHandle object) {
  return {kind, object, {}, {0, 0}, 0.0, no_geometry(), 0, no_geometry()};
}

/// Takes up the commanded values, each within its joint's limits.
void clamp_joints(const WorldModel& model, std::span<const double> values, MechanismMover& mover,
                  std::vector<ContactEvent>& events) {
  std::copy(values.begin(), values.end(), mover.commanded.begin());
  for (const Mechanism::Joint& joint : mover.mechanism->joints()) {
    if (joint.value == kNone) continue;
    double& q = mover.commanded[joint.value];
    const double wanted = q;
    q = std::clamp(wanted, joint.lower, joint.upper);
    if (q == wanted) continue;
    const std::uint32_t slot = mover.slot_of_link[joint.outer];
    const std::uint32_t named = slot == kNone ? mover.lead : slot;
    events.push_back(command_event(EventKind::at_limit, model.objects.handle(named)));
  }
}

}  // namespace

void Movers::take_room(std::size_t slots, bool anew) {
  for (std::vector<std::uint32_t>* list : {&roots, &commanded, &commanded_before}) {
    if (anew) list->clear();
    reserve_more(*list, 2 * slots + 64);
  }
  if (anew) is_short.clear();
  resize_more(is_short, slots);
}

void Movers::add_follower(std::uint32_t root) {
  commanded.push_back(root);
  roots.insert(std::lower_bound(roots.begin(), roots.end(), root), root);
}

void begin_frame(WorldModel& model, Movers& movers) {
  ++model.travels.clearings;
  movers.commanded_before.swap(movers.commanded);
  movers.commanded.clear();
  movers.roots.clear();
  for (const std::uint32_t slot : movers.commanded_before) {
    model.in_motion[slot] = movers.is_short[slot] = 0;
    model.stops[slot] = 1.0;
    model.rides.end(slot);
    if (model.objects[slot].is_root(slot))
      model.paths[slot] = CarriedPath(RigidPath(model.objects[slot].X_WO), model.objects.poses_in_body());
  }
}

void accept(WorldModel& model, std::span<const MotionCommand> commands, Movers& movers,
            std::vector<ContactEvent>& events) {
  ObjectTable& objects = model.objects;
  for (const MotionCommand& command : commands) {
    if (!objects.may_move(command.object) || !is_finite(command.path)) {
      events.push_back(command_event(EventKind::refused, command.object));
      continue;
    }
    const std::uint32_t slot = command.object.slot;
    const Pose& X_WO = objects[slot].X_WO;
    const bool starts_here = command.path.from().R == X_WO.R && command.path.from().p == X_WO.p;
    const RigidPath path = starts_here ? command.path : RigidPath::between(X_WO, command.path.to());
    model.paths[slot] = CarriedPath(path, objects.poses_in_body());
    model.in_motion[slot] = !path.at_rest();
    movers.roots.push_back(slot), movers.commanded.push_back(slot);
    objects[slot].commanded = command.path.to();
  }
}

void accept(WorldModel& model, std::span<const JointCommand> commands, Movers& movers,
            std::vector<ContactEvent>& events) {
  MechanismTable& mechanisms = model.mechanisms;
  for (const JointCommand& command : commands) {
    if (!mechanisms.is_alive(command.mechanism)) {
      events.push_back(command_event(EventKind::refused, {}));
      continue;
    }
    MechanismMover& mover = mechanisms.get(command.mechanism);
    if (command.values.size() != mover.actual.size() || !all_finite(command.values)) {
      events.push_back(command_event(EventKind::refused, model.objects.handle(mover.lead)));
      continue;
    }
    clamp_joints(model, command.values, mover, events);
    model.in_motion[mover.lead] = mover.commanded != mover.actual;
    if (model.in_motion[mover.lead]) mover.go(mover.commanded);
    movers.roots.push_back(mover.lead), movers.commanded.push_back(mover.lead);
  }
  for (std::uint32_t i = 0; i < mechanisms.size(); ++i)
    if (MechanismMover* mover = mechanisms.at(i); mover != nullptr && !model.in_motion[mover->lead])
      mover->rest();
}

void order_movers(const WorldModel& model, Movers& movers) {
  std::vector<std::uint32_t>& roots = movers.roots;
  std::sort(roots.begin(), roots.end());
  roots.erase(std::unique(roots.begin(), roots.end()), roots.end());
  std::erase_if(roots, [&](std::uint32_t slot) { return !model.in_motion[slot]; });
}

std::uint32_t note_short(const WorldModel& model, Movers& movers) {
  std::uint32_t count = 0;
  for (const std::uint32_t slot : movers.roots)
    if (model.stops[slot] < 1.0) movers.is_short[slot] = 1, ++count;
  return count;
}

void rest(WorldModel& model, std::uint32_t root) {
  model.paths[root] = CarriedPath(RigidPath(model.objects[root].X_WO), model.objects.poses_in_body());
  if (MechanismMover* mover = model.mechanism_of(root)) mover->rest();
  model.in_motion[root] = 0;
}

}  // namespace touchstone
