#pragma once

#include <gtest/gtest.h>

#include <cstdio>

#include "touchstone/adapters/all/all_backends.hpp"
#include "touchstone/adapters/all/all_engines.hpp"
#include "touchstone/tests/engines/engine_scenes.hpp"

// Shared by the suites over all engines: every engine with each of its checks.

namespace touchstone::engine_tests {

inline constexpr double kStep = 1e-3;

inline const BackendRegistry& backends() {
  static const BackendRegistry registry = [] {
    BackendRegistry out;
    register_all_backends(out);
    return out;
  }();
  return registry;
}

inline const physics::EngineRegistry& engines() {
  static const physics::EngineRegistry registry = [] {
    physics::EngineRegistry out;
    physics::register_all_engines(out, backends());
    return out;
  }();
  return registry;
}

/// Own over native, and every other engine with its own check and with native inside. (Other checks:
/// engine_checks_test.cpp.)
inline std::vector<physics::EngineChoice> choices() {
  std::vector<physics::EngineChoice> out{{"own", "native"}};
  for (const auto& entry : engines().engines())
    for (const std::string& check : entry.checks)
      if (entry.name != "own" && (check == physics::kOwnCheck || check == "native"))
        out.push_back({entry.name, check});
  return out;
}

inline std::string name_of(const ::testing::TestParamInfo<physics::EngineChoice>& test) {
  return test.param.engine + "_" + test.param.check;
}

/// To its end, or to where the engine ends it.
inline std::unique_ptr<physics::DynamicsEngine> run(const physics::EngineChoice& choice,
                                                    const physics::DynamicScene& scene) {
  std::unique_ptr<physics::DynamicsEngine> engine = engines().make(choice, scene);
  while (!engine->is_over()) {
    engine->begin_step();
    const physics::EngineStep step = engine->step();
    EXPECT_TRUE(step.failure.empty()) << step.failure;
    if (!step.failure.empty()) break;
  }
  return engine;
}

class EngineSuite : public ::testing::TestWithParam<physics::EngineChoice> {
 protected:
  bool is_own() const { return GetParam().engine == "own"; }
  bool can(physics::EngineFeature feature) const {
    return engines().engine(GetParam()).features(GetParam().check).has(feature);
  }
  /// Contacts give way: what rests sinks in, what slides or leans on friction creeps.
  bool is_soft() const { return GetParam().engine == "mujoco"; }

  /// @param own_limit what ours may be off by @param limit what the method of others may
  void expect_error(const char* what, double error, double own_limit, double limit) {
    EXPECT_LE(error, is_own() ? own_limit : limit) << GetParam().text() << ": " << what;
    RecordProperty(what, std::to_string(error));
    std::printf("  %-16s %-20s off by %.2e (may be %.1e)\n", GetParam().text().c_str(), what, error,
                is_own() ? own_limit : limit);
  }
};

}  // namespace touchstone::engine_tests
