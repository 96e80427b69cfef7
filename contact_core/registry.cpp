#include "touchstone/contact_core/registry.hpp"

#include <algorithm>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

template <class Entry>
void add_entry(std::vector<Entry>& entries, Entry entry, const char* what) {
  if (entry.name.empty() || !entry.make)
    throw InputError(std::string(what) + " entry without a name or a factory");
  for (const Entry& known : entries)
    if (known.name == entry.name)
      throw InputError(std::string(what) + " '" + entry.name + "' is registered already");
  entries.push_back(std::move(entry));
}

template <class Entry>
const Entry& find_entry(const std::vector<Entry>& entries, std::string_view name, const char* what) {
  const auto found =
      std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return e.name == name; });
  if (found != entries.end()) return *found;
  std::string message = std::string("unknown ") + what + " '" + std::string(name) + "'; known:";
  for (const Entry& known : entries) message += " " + known.name;
  throw InputError(message);
}

}  // namespace

void BackendRegistry::add(NarrowphaseEntry entry) {
  add_entry(narrowphases_, std::move(entry), "narrowphase");
}
void BackendRegistry::add(BroadphaseEntry entry) { add_entry(broadphases_, std::move(entry), "broadphase"); }

const BackendRegistry::NarrowphaseEntry& BackendRegistry::narrowphase(std::string_view name) const {
  return find_entry(narrowphases_, name, "narrowphase");
}
const BackendRegistry::BroadphaseEntry& BackendRegistry::broadphase(std::string_view name) const {
  return find_entry(broadphases_, name, "broadphase");
}

}  // namespace touchstone
