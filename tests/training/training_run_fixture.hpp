#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "touchstone/tests/support/program_test.hpp"

// training_run as a user runs it, and its results.

namespace touchstone::test {

using nlohmann::json;

class TrainingRun : public touchstone::ProgramTest {
 protected:
  TrainingRun() : ProgramTest(TRAINING_RUN) {}

  /// Flies one script; its part of results.json.
  json fly(const std::string& script, const std::string& more = "") const {
    const Outcome outcome = run("--scene " + script + " --out " + (folder_ / "run").string() + " " + more);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    if (outcome.code != 0) return {};
    const json results = json::parse(read(folder_ / "run/results.json"));
    EXPECT_EQ(results["scripts"].size(), 1u);
    return results["scripts"][0];
  }
};

inline json method(const json& script, const std::string& name) {
  for (const json& each : script["methods"])
    if (each["method"] == name) return each;
  ADD_FAILURE() << "no method " << name;
  return {};
}
inline json ours(const json& script) { return method(script, "contact world"); }

}  // namespace touchstone::test
