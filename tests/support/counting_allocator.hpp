#pragma once

#include <cstddef>

namespace touchstone {

/// Calls of operator new, in every form, in this program so far. Counts under the sanitizers too.
std::size_t allocation_count();

/// While it lives, one of this program's allocations fails.
class FailingAllocation {
 public:
  /// @param after how many others.
  explicit FailingAllocation(std::size_t after);
  ~FailingAllocation();
  FailingAllocation(const FailingAllocation&) = delete;
  FailingAllocation& operator=(const FailingAllocation&) = delete;
};

}  // namespace touchstone
