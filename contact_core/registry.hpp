#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/broadphase/broadphase.hpp"
#include "touchstone/contact_core/narrowphase/raw_check.hpp"

namespace touchstone {

/// Backends by name. Registration is explicit (register_native(registry), register_bullet(registry) ...):
/// nothing depends on static initialisers that a linker may drop. Not synchronised: fill it before threads
/// start.
class BackendRegistry {
 public:
  /// A fine check and how to make one; every call of `make` returns a new instance, not yet built.
  struct NarrowphaseEntry {
    std::string name;
    std::string description;  ///< one line, with library and version
    std::function<std::unique_ptr<Narrowphase>()> make;
    std::function<std::unique_ptr<RawCheck>()> make_raw;  ///< may be empty
  };
  /// The same for a coarse check.
  struct BroadphaseEntry {
    std::string name;
    std::string description;
    std::function<std::unique_ptr<Broadphase>()> make;
  };

  /// @throws InputError when the name is taken.
  void add(NarrowphaseEntry entry);
  void add(BroadphaseEntry entry);

  /// @throws InputError naming the known backends when `name` is not among them.
  const NarrowphaseEntry& narrowphase(std::string_view name) const;
  const BroadphaseEntry& broadphase(std::string_view name) const;
  std::unique_ptr<Narrowphase> make_narrowphase(std::string_view name) const {
    return narrowphase(name).make();
  }
  std::unique_ptr<Broadphase> make_broadphase(std::string_view name) const { return broadphase(name).make(); }

  const std::vector<NarrowphaseEntry>& narrowphases() const { return narrowphases_; }
  const std::vector<BroadphaseEntry>& broadphases() const { return broadphases_; }

 private:
  std::vector<NarrowphaseEntry> narrowphases_;
  std::vector<BroadphaseEntry> broadphases_;
};

/// contact_core's own: narrowphases `native` and `edge_face`, broadphases `brute_force`, `native`,
/// `edge_face`.
void register_core(BackendRegistry& registry);

}  // namespace touchstone
