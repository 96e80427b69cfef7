#include "touchstone/examples/measures/common/allocations.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace touchstone::measures {
namespace {

TEST(Allocations, AreCounted) {
  const auto before = thread_allocations();
  ASSERT_TRUE(before);
  const auto held = std::make_unique<std::vector<int>>(100);
  EXPECT_EQ(*thread_allocations() - *before, 2u);
  EXPECT_EQ(held->size(), 100u);
}

}  // namespace
}  // namespace touchstone::measures
