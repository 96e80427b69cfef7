#include <tuple>

#include "touchstone/contact_core/world/world_state.hpp"

// What only advances goes on about its contact. A pose that is commanded says where a body is to be, not how
// it comes there: on the path on which its origin goes straight a tool that is turned about an edge it rests
// on dips below that edge, and would stand. On the path on which the touching point goes straight it keeps to
// it.

namespace touchstone {

/// A rigid body that turns, stopped by pairs that advance or slide, of which not all slide.
bool ContactWorld::State::may_pivot(std::uint32_t root) const {
  return stops[root] < 1.0 && slides.may_pivot[root] && !slides.may_slide[root] &&
         mechanism_of(root) == nullptr &&
         paths[root].carrier().at(0, 0.0).angular_velocity_W != Vector3::Zero();
}

/// Where the pair that stopped it touches it; of several the nearest. Null: none did in this part.
const Moment* ContactWorld::State::pivot_of(const Slider& slider, Vector3& p_W) const {
  const Moment* found = nullptr;
  for (const FramePair& pair : pairs) {
    if (pair.stop == kNoMoment) continue;
    const Moment& moment = moments[pair.stop];
    const bool of_a = root_of(pair.solids.a) == slider.root, of_b = root_of(pair.solids.b) == slider.root;
    if (!(of_a || of_b) || moment.part != 0 || moment.s != slider.stop) continue;
    const Vector3& p = of_a ? moment.geometry.p_A_W : moment.geometry.p_B_W;
    // Places alone decide between equals, so that no order of pairs shows.
    const auto key = [](double separation, const Vector3& at) {
      return std::tuple(separation, at.x(), at.y(), at.z());
    };
    if (found != nullptr && !(key(moment.geometry.separation, p) < key(found->geometry.separation, p_W)))
      continue;
    found = &moment;
    p_W = p;
  }
  return found;
}

RigidPath ContactWorld::State::pivot_path(const Slider& slider) const {
  const Pose& X_WO = objects[slider.root].X_WO;
  Vector3 p_W = Vector3::Zero();
  if (pivot_of(slider, p_W) == nullptr) return RigidPath(X_WO);
  const Vector3 p_O = transform(inverse(X_WO), p_W);
  const Vector3 turn = RigidPath::between(X_WO, slider.goal).at(0, 0.0).angular_velocity_W;
  return RigidPath::by(X_WO, transform(slider.goal, p_O) - p_W, turn, p_O).ending_at(slider.goal);
}

}  // namespace touchstone
