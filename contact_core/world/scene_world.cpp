#include "touchstone/contact_core/world/scene_world.hpp"

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/scene/scene_instance.hpp"

namespace touchstone {
namespace {

/// The one segment that the stretch of time lies in, if there is one.
const MotionSegment* segment_over(const Motion& motion, double from_time, double to_time) {
  for (const MotionSegment& segment : motion.segments)
    if (segment.start <= from_time && to_time <= segment.start + segment.duration) return &segment;
  return nullptr;
}

}  // namespace

void set_rules(const Scene& scene, std::span<const ObjectHandle> objects, ContactWorld& world) {
  world.set_default_rule({scene.policy, {}, {}, scene.passive});
  for (const SceneRule& given : scene.rules) {
    const PairRule rule{given.policy, given.warn_distance, given.translation_only, given.passive};
    const bool has_object =
        find_object(scene, given.first) != kNoObject || find_object(scene, given.second) != kNoObject;
    if (!has_object) {
      world.set_group_rule(given.first, given.second, rule);
      continue;
    }
    for (const std::size_t a : find_objects(scene, given.first))
      for (const std::size_t b : find_objects(scene, given.second))
        if (a != b) world.set_pair_rule(objects[a], objects[b], rule);
  }
}

SceneWorld::SceneWorld(const Scene& scene, std::unique_ptr<Narrowphase> narrowphase,
                       std::unique_ptr<Broadphase> broadphase)
    : scene_(&scene), world_(std::move(narrowphase), std::move(broadphase), scene.contact_gap) {
  const SceneInstance instance(scene);  // validates
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const SceneObject& object = scene.objects[i];
    const bool is_static =
        object.motion.at_rest() && carrier_of(scene, i) == kNoObject && !may_be_taken_along(scene, i);
    // The scene outlives this, so the world's share of the tree owns nothing.
    const std::shared_ptr<const HexahedronTree> tree(std::shared_ptr<void>(), &object.tree);
    objects_.push_back(world_.add({tree, object.X_WO, is_static, object.groups, object.levels}));
  }
  set_rules(scene, objects_, world_);
  for (const SceneLatch& latch : scene.latches)
    world_.latch(objects_[find_object(scene, latch.carrier)], objects_[find_object(scene, latch.carried)],
                 exemptions(instance, latch.allowed));
  for (const Exemption& pair : exemptions(instance, scene.exempt_pairs)) world_.exempt(pair);
  commands_.reserve(scene.objects.size());
  world_.prepare();
}

std::vector<Exemption> SceneWorld::exemptions(const SceneInstance& instance,
                                              std::span<const ExemptPair> pairs) const {
  const auto name = [&](SolidIndex solid, std::uint32_t object) {
    return scene_->objects[object].tree.solids()[solid - instance.first_solid(object)].name;
  };
  std::vector<Exemption> out;
  for (const ExemptPair& pair : pairs)
    for (const SolidPair& solids : instance.solids_of(pair)) {
      const std::uint32_t a = instance.object_of(solids.a), b = instance.object_of(solids.b);
      out.push_back({objects_[a], objects_[b], name(solids.a, a), name(solids.b, b)});
    }
  return out;
}

double SceneWorld::time_of(double s) const {
  const double end = time();
  const double start = frame_ == 0 ? end : scene_->frame_time(frame_ - 1);
  return start + s * (end - start);
}

double SceneWorld::time_of(const ContactEvent& event) const {
  return event.part == 0 ? time_of(event.s) : time();
}

RigidPath SceneWorld::path_of(std::size_t index, double from_time, double to_time) const {
  const SceneObject& object = scene_->objects[index];
  const Pose& actual = world_.actual_pose(objects_[index]);
  const Pose wanted_before = pose_at(object.motion, object.X_WO, from_time);
  const Pose target = pose_at(object.motion, object.X_WO, to_time);
  const MotionSegment* segment = segment_over(object.motion, from_time, to_time);
  if (segment == nullptr || !is_same(actual, wanted_before)) return RigidPath::between(actual, target);
  const double elapsed = to_time - from_time;
  const Vector3 pivot_W = segment->pivot_W + (from_time - segment->start) * segment->velocity_W;
  const Vector3 pivot_O = segment->rate == 0.0 ? Vector3::Zero() : transform(inverse(actual), pivot_W);
  return RigidPath::by(actual, elapsed * segment->velocity_W, (elapsed * segment->rate) * segment->axis_W,
                       pivot_O)
      .ending_at(target);
}

FrameReport SceneWorld::step() {
  const double from_time = scene_->frame_time(frame_), to_time = scene_->frame_time(frame_ + 1);
  commands_.clear();
  for (std::size_t i = 0; i < objects_.size(); ++i)
    if (!scene_->objects[i].motion.at_rest() && world_.is_alive(objects_[i]))
      commands_.push_back({objects_[i], path_of(i, from_time, to_time)});
  ++frame_;
  return world_.frame(commands_);
}

}  // namespace touchstone
