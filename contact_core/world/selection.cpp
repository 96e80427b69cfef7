#include "touchstone/contact_core/world/selection.hpp"

#include <algorithm>
#include <string>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {

GroupName::GroupName(std::string_view name) {
  if (name.size() > kMostBytes)
    throw InputError("group '" + std::string(name) + "': the name is longer than " +
                     std::to_string(kMostBytes) + " bytes");
  std::copy(name.begin(), name.end(), bytes_.begin());
  size_ = static_cast<std::uint8_t>(name.size());
}

SelectionChange SelectionChange::of_everything(bool on) {
  SelectionChange change;
  change.on = on;
  return change;
}

SelectionChange SelectionChange::of(ObjectHandle object, bool on) {
  SelectionChange change;
  change.scope = Scope::object, change.on = on;
  change.first = object;
  return change;
}

SelectionChange SelectionChange::of(ObjectHandle a, ObjectHandle b, bool on) {
  SelectionChange change;
  change.scope = Scope::pair, change.on = on;
  change.first = a, change.second = b;
  return change;
}

SelectionChange SelectionChange::of(MechanismHandle mechanism, bool on) {
  SelectionChange change;
  change.scope = Scope::mechanism, change.on = on;
  change.mechanism = mechanism;
  return change;
}

SelectionChange SelectionChange::of_group(std::string_view name, bool on) {
  SelectionChange change;
  change.scope = Scope::group, change.on = on;
  change.group = GroupName(name);
  return change;
}

}  // namespace touchstone
