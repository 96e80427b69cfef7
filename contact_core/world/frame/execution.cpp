#include "touchstone/contact_core/world/frame/execution.hpp"

namespace touchstone {
namespace {

Pose executed_link_pose(const WorldModel& model, const ExecutedParts& parts, std::uint32_t slot,
                        std::size_t part, double s) {
  const ObjectRecord& object = model.objects[slot];
  const ObjectRecord& body = model.objects[object.body];
  const MechanismMover& mover = *model.mechanisms.at(body.mechanism);
  const Mechanism& mechanism = *mover.mechanism;
  const ExecutedParts::At executed = parts.find(model.objects.handle(object.root), part, s);
  if (executed.part == nullptr) return object.X_WO;
  Pose X = mover.path.X_WB();
  for (const std::uint32_t j : mechanism.chain(body.link)) {
    const Mechanism::Joint& joint = mechanism.joints()[j];
    const double q =
        joint.value == Mechanism::kNone ? 0.0 : parts.joint_value(executed, joint.value, mover.actual.size());
    X = Mechanism::across(joint, X, q);
  }
  return object.body == slot ? X : compose(X, model.objects.poses_in_body()[slot]);
}

}  // namespace

void execute(WorldModel& model, WatchedPairs& watched, const Movers& movers, FrameLanes& lanes) {
  constexpr std::size_t kObjectsAtOnce = 64;
  ObjectTable& objects = model.objects;
  const Layout& layout = model.layout;
  for (std::uint32_t i = 0; i < model.mechanisms.size(); ++i)
    if (MechanismMover* mover = model.mechanisms.at(i); mover != nullptr && model.in_motion[mover->lead])
      mover->stand_at(model.stops[mover->lead]);
  const std::span<const std::uint32_t> moved = watched.moved();
  lanes.for_each(moved.size(), kObjectsAtOnce, [&](NarrowphaseQuery&, std::size_t i) {
    const std::uint32_t slot = moved[i], root = objects[slot].root;
    if (!model.in_motion[root]) return;
    Pose& X_WO = objects[slot].X_WO;
    if (const MechanismMover* mover = model.mechanism_of(slot)) {
      const std::uint32_t body = objects[slot].body;
      const Pose& X_WL = mover->X_WL[objects[body].link];
      X_WO = body == slot ? X_WL : compose(X_WL, objects.poses_in_body()[slot]);
    } else {
      X_WO = model.paths[root].at(slot, model.stops[root]).X_WO;
    }
    for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid)
      model.from[solid] = compose(X_WO, layout.X_OS[solid]), model.travels.has_vertices[solid] = 0;
  });
  for (const std::uint32_t slot : moved)
    if (model.in_motion[objects[slot].root]) model.note_place(slot);
  for (const std::uint32_t root : movers.roots)
    if (model.in_motion[root] && model.stops[root] < 1.0) watched.take_back(model, root);
}

void record_part(const WorldModel& model, const Movers& movers, std::uint32_t part, ExecutedParts& parts) {
  for (const std::uint32_t slot : movers.roots) {
    if (!model.in_motion[slot]) continue;
    const ObjectHandle object = model.objects.handle(slot);
    const MechanismMover* mover = model.mechanism_of(slot);
    if (mover == nullptr)
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
  return executed.part->path.at(slot, executed.s).X_WO;
}

}  // namespace touchstone
