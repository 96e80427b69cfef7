#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/native/check_inside.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/physics/engine/dynamics_engine.hpp"
#include "touchstone/physics/engine/engine_features.hpp"

namespace touchstone::physics {

/// An engine's word for its own check.
inline constexpr std::string_view kOwnCheck = "own";

/// Engine and check, as they are chosen together: "bullet" is Bullet with its own check, "bullet:native" and
/// "bullet:exact" with ours inside. `own` has no other check than a narrowphase: "own" is "own:native".
struct EngineChoice {
  std::string engine;
  std::string check;  ///< kOwnCheck, or the name of a narrowphase

  std::string text() const { return check == kOwnCheck ? engine : engine + ":" + check; }
};
/// Parses "bullet" or "bullet:native"; the names need not be known.
EngineChoice parse_engine_choice(std::string_view text);

/// Dynamics engines by name. Registration is explicit, as BackendRegistry's. Not synchronised.
class EngineRegistry {
 public:
  /// An engine that this build lacks, or a check that an engine cannot take, with the reason.
  struct Missing {
    std::string name;
    std::string reason;
  };
  /// An engine and how to make one for a scene.
  struct Entry {
    std::string name;
    std::string description;  ///< one line, with library and version
    /// Checks that may stand inside: kOwnCheck first, where it has one of its own; narrowphases by name.
    std::vector<std::string> checks;
    /// Narrowphases that may not, and why.
    std::vector<Missing> refused_checks = {};
    /// Its features with that check.
    std::function<EngineFeatures(std::string_view check)> features;
    /// The result of its DynamicsEngine::after_restore().
    EngineReturn after_restore = EngineReturn::none;
    /// @pre the scene is valid and supported, the check is one of `checks`; the scene outlives the engine.
    std::function<std::unique_ptr<DynamicsEngine>(const DynamicScene&, const std::string& check)> make;
  };

  /// @throws InputError when the name is taken.
  void add(Entry entry);
  void add_missing(Missing missing) { missing_.push_back(std::move(missing)); }

  /// @throws InputError naming the known engines, and why one that is known is missing.
  const Entry& engine(std::string_view name) const;
  /// @throws InputError as engine(), and for a check that cannot stand in it, naming those that can.
  const Entry& engine(const EngineChoice& choice) const;
  const std::vector<Entry>& engines() const { return engines_; }
  const std::vector<Missing>& missing() const { return missing_; }

  /// @throws InputError as engine(choice) and validate(DynamicScene), and where the engine lacks what the
  /// scene asks for: "engine 'mujoco': unsupported: restitution (object 'x')". Nothing is ever approximated
  /// in its place.
  std::unique_ptr<DynamicsEngine> make(const EngineChoice& choice, const DynamicScene& scene) const;

 private:
  std::vector<Entry> engines_;
  std::vector<Missing> missing_;
};

/// Sets the checks of an engine whose plug-in takes any narrowphase of ours: its own check, and all of
/// `backends` that have manifolds; the others are refused by name.
void set_checks(EngineRegistry::Entry& entry, const BackendRegistry& backends);

/// A check of set_checks() as the plug-ins take it. Null where they need none: kOwnCheck, native.
/// @throws InputError: a solid of the scene that it refuses.
std::shared_ptr<CheckInside> make_check(const BackendRegistry& backends, const std::string& check,
                                        const DynamicScene& scene);

/// Adds `own`: DynamicsWorld over the contacts of any narrowphase of `backends` that has manifolds.
/// @param backends must outlive the registry's engines.
void register_own_engine(EngineRegistry& registry, const BackendRegistry& backends);

}  // namespace touchstone::physics
