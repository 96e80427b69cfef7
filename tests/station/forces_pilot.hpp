#pragma once

#include <gtest/gtest.h>

#include "touchstone/tests/station/pilot.hpp"

namespace touchstone::station {

/// A pilot with forces: torques get an arm moving, so that it is late, and near a place a hand has to wait.
struct ForcesPilot : Pilot {
  explicit ForcesPilot(const std::string& scene) : Pilot(scene, kOurs, true) {
    there = 1e-3;
    EXPECT_TRUE(flight().state().dynamics);
  }
  const FlightFigures& figures() const { return flight().figures(); }
};

}  // namespace touchstone::station
