#pragma once

#include <memory>
#include <span>
#include <vector>

#include "touchstone/contact_core/scene/scene.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"

namespace touchstone {

class SceneInstance;

/// Sets the scene's policy, `passive` and rules. @param objects of the world, by index in the scene.
/// @throws InputError as ContactWorld::set_default_rule(), set_group_rule() and set_pair_rule().
void set_rules(const Scene& scene, std::span<const ObjectHandle> objects, ContactWorld& world);

/// A scene flown through a contact world: its objects, exemptions, latches with what they allow, rules and
/// gap, commanded frame by frame along their prescribed motions. Frame k goes from frame_time(k) to
/// frame_time(k + 1). An object that was stopped is commanded to go from where it is to where it should be.
class SceneWorld {
 public:
  /// Keeps a pointer to `scene`, which must outlive it. Objects without motion that nothing
  /// carries, and that may not be taken along, are static.
  /// @throws InputError as validate(scene), and as ContactWorld.
  SceneWorld(const Scene& scene, std::unique_ptr<Narrowphase> narrowphase,
             std::unique_ptr<Broadphase> broadphase);
  explicit SceneWorld(Scene&&) = delete;

  ContactWorld& world() { return world_; }
  const Scene& scene() const { return *scene_; }
  /// The handle of the scene's object `index`.
  ObjectHandle object(std::size_t index) const { return objects_[index]; }
  /// @throws InputError when the scene has no such object.
  ObjectHandle object(std::string_view name) const { return world_.find(name); }

  /// Frames flown so far; the time is that of the last pose shown [s].
  std::uint64_t frame() const { return frame_; }
  double time() const { return scene_->frame_time(frame_); }
  /// @param s within the frame that was flown last. [s]
  double time_of(double s) const;
  /// @param event of that frame. Of a slide's sub-step, which has no times of its own, the frame's end. [s]
  double time_of(const ContactEvent& event) const;

  /// Flies the next frame; objects that were removed from the world are left out.
  FrameReport step();

 private:
  std::vector<Exemption> exemptions(const SceneInstance& instance, std::span<const ExemptPair> pairs) const;
  RigidPath path_of(std::size_t index, double from_time, double to_time) const;

  const Scene* scene_;
  ContactWorld world_;
  std::vector<ObjectHandle> objects_;
  std::vector<MotionCommand> commands_;
  std::uint64_t frame_ = 0;
};

}  // namespace touchstone
