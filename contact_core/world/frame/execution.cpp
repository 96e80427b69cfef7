#include "touchstone/contact_core/world/frame/execution.hpp"

namespace touchstone {
namespace {

Pose link_pose(const MechanismMover& mover, std::uint32_t link, const ExecutedParts& parts,
               const ExecutedParts::At& executed) {
  Pose X = mover.path.X_WB();
  for (const std::uint32_t j : mover.mechanism->chain(link)) {
    const Mechanism::Joint& joint = mover.mechanism->joints()[j];
    const double q =
        joint.value == Mechanism::kNone ? 0.0 : parts.joint_value(executed, joint.value, mover.actual.size());
    X = Mechanism::across(joint, X, q);
  }
  return X;
}

Pose executed_link_pose(const WorldModel& model, const ExecutedParts& parts, std::uint32_t slot,
                        std::size_t part, double s) {
  const ObjectRecord& object = model.objects[slot];
  const ObjectRecord& body = model.objects[object.body];
  const ExecutedParts::At executed = parts.find(model.objects.handle(object.root), part, s);
  if (executed.part == nullptr) return object.X_WO;
  const Pose X = link_pose(*model.mechanisms.at(body.mechanism), body.link, parts, executed);
  return object.body == slot ? X : compose(X, model.objects.poses_in_body()[slot]);
}

/// Of a root that a link took along in the part.
Pose executed_ride_pose(const WorldModel& model, const ExecutedParts& parts, const ExecutedParts::At& ride,
                        const Pose& X_WO) {
  const ExecutedPart& part = *ride.part;
  const ExecutedParts::At executed = parts.find(part.lead, part.part, ride.s);
  if (executed.part == nullptr || !model.objects.is_alive(part.lead)) return X_WO;
  const MechanismMover& mover = *model.mechanism_of(part.lead.slot);
  return compose(link_pose(mover, part.link, parts, executed), part.X_LR);
}

/// Whose link took along what stands on it still.
void note_rides(WorldModel& model, const Movers& movers) {
  for (const std::uint32_t root : movers.roots)
    if (const Rides::Ride* ride = model.rides.find(root))
      model.rides.note_place(root, model.arm_of(root)->X_WL[ride->link], model.objects[root].X_WO);
}

}  // namespace

void execute(WorldModel& model, WatchedPairs& watched, const Movers& movers, FrameLanes& lanes) {
  constexpr std::size_t kObjectsAtOnce = 64;
  ObjectTable& objects = model.objects;
  const Layout& layout = model.layout;
  // Arms take the joint values of their stops.
  for (std::uint32_t i = 0; i < model.mechanisms.size(); ++i)
    if (MechanismMover* mover = model.mechanisms.at(i); mover != nullptr && model.in_motion[mover->lead])
      mover->stand_at(model.stops[mover->lead]);
  // Objects and their solids are placed at their stops, in lanes.
  const std::span<const std::uint32_t> moved = watched.moved();
  lanes.for_each(moved.size(), kObjectsAtOnce, [&](NarrowphaseQuery&, std::size_t i) {
    const std::uint32_t slot = moved[i], root = objects[slot].root;
    if (!model.in_motion[root]) return;
    Pose& X_WO = objects[slot].X_WO;
    const MechanismMover* mover = model.arm_of(slot);
    if (model.stops[root] == 0.0 && mover != nullptr) return;  // of loads that ride, not even by rounding
    if (mover != nullptr) {
      X_WO = model.pose_on_link(slot, mover->X_WL[model.link_of(slot)]);
    } else {
      X_WO = model.paths[root].at(slot, model.stops[root]).X_WO;
    }
    model.for_each_solid_of(slot, [&](SolidIndex solid) {
      model.from[solid] = compose(X_WO, layout.X_OS[solid]), model.travels.has_vertices[solid] = 0;
    });
  });
  // Places are noted in order, and travel beyond a stop is counted out.
  for (const std::uint32_t slot : moved)
    if (model.in_motion[objects[slot].root]) model.note_place(slot);
  for (const std::uint32_t root : movers.roots)
    if (model.in_motion[root] && model.stops[root] < 1.0) watched.take_back(model, root);
  note_rides(model, movers);
}

void place_closed(WorldModel& model, std::span<const ContactState> contacts) {
  const Layout& layout = model.layout;
  for (const ContactState& contact : contacts)
    for (const SolidIndex solid : {contact.solids.a, contact.solids.b}) {
      const std::uint32_t slot = layout.slot_of[solid];
      if (layout.levels[slot] == nullptr || model.open.is_open(solid)) continue;
      model.from[solid] = compose(model.objects[slot].X_WO, layout.X_OS[solid]);
      model.travels.has_vertices[solid] = 0;
    }
}

void record_part(const WorldModel& model, const Movers& movers, std::uint32_t part, ExecutedParts& parts) {
  for (const std::uint32_t slot : movers.roots) {
    if (!model.in_motion[slot]) continue;
    const ObjectHandle object = model.objects.handle(slot);
    const MechanismMover* mover = model.mechanism_of(slot);
    if (const Rides::Ride* ride = model.rides.find(slot))
      parts.add_ride(object, part, model.paths[slot], model.stops[slot], model.objects.handle(ride->lead),
                     ride->link, ride->X_LR);
    else if (mover == nullptr)
      parts.add(object, part, model.paths[slot], model.stops[slot]);
    else
      parts.add(object, part, model.paths[slot], model.stops[slot], mover->path.from(), mover->path.to());
  }
  parts.set_count(part + 1);
}

Pose executed_pose(const WorldModel& model, const ExecutedParts& parts, std::uint32_t slot, std::size_t part,
                   double s) {
  if (model.mechanism_of(slot) != nullptr) return executed_link_pose(model, parts, slot, part, s);
  const ObjectRecord& object = model.objects[slot];
  const ExecutedParts::At executed = parts.find(model.objects.handle(object.root), part, s);
  if (executed.part == nullptr || !executed.part->path.knows(slot)) return object.X_WO;
  if (executed.part->lead != ObjectHandle{}) {
    const Pose X = executed_ride_pose(model, parts, executed, object.X_WO);
    return object.body == slot ? X : compose(X, model.objects.poses_in_body()[slot]);
  }
  return executed.part->path.at(slot, executed.s).X_WO;
}

}  // namespace touchstone
