#pragma once

#include <gtest/gtest.h>

#include "touchstone/contact_core/motion/impact.hpp"

namespace touchstone {

inline constexpr double kGap = 1e-9;

/// Stopped where the separation is from half the gap to the gap.
inline void expect_stop_in_gap(const Impact& impact) {
  EXPECT_EQ(impact.status, ImpactStatus::blocked);
  EXPECT_GE(impact.geometry.separation, 0.5 * kGap);
  EXPECT_LE(impact.geometry.separation, kGap);
}

}  // namespace touchstone
