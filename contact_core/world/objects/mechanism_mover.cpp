#include "touchstone/contact_core/world/objects/mechanism_mover.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

std::shared_ptr<const Mechanism> checked(std::shared_ptr<const Mechanism> mechanism) {
  if (!mechanism) throw InputError("contact world: no mechanism");
  return mechanism;
}

}  // namespace

MechanismMover::MechanismMover(MechanismPlacement placement)
    : mechanism(checked(std::move(placement.mechanism))),
      initial(std::move(placement.initial)),
      own_weights(std::move(placement.weights)),
      slot_of_link(mechanism->links().size(), Mechanism::kNone),
      rigid_with(mechanism->links().size()),
      X_WL(mechanism->links().size()),
      path(*mechanism),
      relative(*mechanism),
      frame(*mechanism),
      radius_of_link(X_WL.size(), 0.0) {
  const std::string label = "mechanism '" + mechanism->name() + "'";
  validate_pose(placement.X_WB, label + ", base");
  // Initial values default to the reference, and must be within the joints' limits.
  if (initial.empty()) initial.assign(mechanism->reference().begin(), mechanism->reference().end());
  if (initial.size() != mechanism->value_count())
    throw InputError(label + ": " + std::to_string(initial.size()) + " initial values for " +
                     std::to_string(mechanism->value_count()) + " joints that move");
  if (!mechanism->is_within_limits(initial))
    throw InputError(label + ": an initial joint value is not finite or beyond its limits");
  // Weights must be above 0, since the metric of the slide is theirs.
  if (own_weights.empty()) own_weights.assign(mechanism->value_count(), 1.0);
  if (own_weights.size() != mechanism->value_count())
    throw InputError(label + ": " + std::to_string(own_weights.size()) + " joint weights for " +
                     std::to_string(mechanism->value_count()) + " joints that move");
  for (const double weight : own_weights)
    if (!std::isfinite(weight) || !(weight > 0.0))
      throw InputError(label + ": joint weight " + std::to_string(weight) + " is not a number above 0");
  weights = own_weights;
  // Links that fixed joints hold together count as one body.
  for (std::uint32_t link = 0; link < rigid_with.size(); ++link) rigid_with[link] = link;
  for (const Mechanism::Joint& joint : mechanism->joints())
    if (joint.value == Mechanism::kNone) rigid_with[joint.outer] = rigid_with[joint.inner];
  list_moved_pairs();
  // The mechanism stands at its initial values from the start. Here memory may end, below it may not.
  actual = commanded = initial;
  path.set(placement.X_WB, initial, initial);
  reset();
  frame.set(X_WL);
  go(actual);  // sets reaches
}

void MechanismMover::list_moved_pairs() {
  const auto links = static_cast<std::uint32_t>(X_WL.size());
  for (std::uint32_t value = 0; value < mechanism->value_count(); ++value) {
    first_moved_pair.push_back(static_cast<std::uint32_t>(moved_pairs.size()));
    for (std::uint32_t a = 0; a < links; ++a)
      for (std::uint32_t b = a + 1; b < links; ++b)
        if (const int turn = frame.sign(value, b, a); turn != 0)
          moved_pairs.push_back({a * links + b, turn > 0 ? b : a});
  }
  first_moved_pair.push_back(static_cast<std::uint32_t>(moved_pairs.size()));
}

void MechanismMover::go(std::span<const double> to) noexcept {
  // Plans lay the same path more than once.
  if (!std::equal(actual.begin(), actual.end(), path.from().begin()) ||
      !std::equal(to.begin(), to.end(), path.to().begin())) {
    path.lay(path.X_WB(), actual, to, X_WL);
    relative.forget();
    ++paths;
  }
  is_resting = false;
  double largest = 0.0;
  for (const double q : to) largest = std::max(largest, std::abs(q));
  for (const double q : actual) largest = std::max(largest, std::abs(q));
  if (largest <= shift_limit) return;
  shift_limit = 2.0 * largest;
  frame.set_reaches(shift_limit);
}

void MechanismMover::rest() noexcept {
  if (is_resting) return;
  path.rest(path.X_WB(), actual, X_WL);
  relative.forget();
  ++paths;
  is_resting = true;
}

void MechanismMover::reset() noexcept {
  actual = commanded = initial;
  path.set(path.X_WB(), actual, actual);
  relative.forget();
  ++paths;
  is_resting = true;
  stand_at(0.0);
}

void MechanismMover::stand_at(double s) noexcept {
  path.values_at(s, actual);
  if (s >= 1.0) path.finish();
  if (s > 0.0 && s < 1.0) {
    mechanism->link_poses(path.X_WB(), actual, X_WL);
    return;
  }
  for (std::uint32_t link = 0; link < X_WL.size(); ++link) X_WL[link] = path.at(link, s).X_WO;
}

MechanismHandle MechanismTable::add(std::unique_ptr<MechanismMover> mover) {
  std::uint32_t index = 0;
  while (index < size() && entries_[index].mover) ++index;
  if (index == size()) entries_.emplace_back();
  entries_[index].mover = std::move(mover);
  return {index, ++entries_[index].generation};
}

void MechanismTable::remove(MechanismHandle handle) {
  check(handle);
  entries_[handle.index].mover.reset();
}

bool MechanismTable::is_alive(MechanismHandle handle) const {
  return handle.index < size() && entries_[handle.index].mover &&
         entries_[handle.index].generation == handle.generation;
}

void MechanismTable::check(MechanismHandle handle) const {
  if (!is_alive(handle)) throw InputError("contact world: the mechanism of a handle is gone, or never was");
}

MechanismMover& MechanismTable::get(MechanismHandle handle) const {
  check(handle);
  return *entries_[handle.index].mover;
}

}  // namespace touchstone
