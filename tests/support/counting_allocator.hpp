#pragma once

#include <cstddef>

namespace touchstone {

/// Calls of operator new, in every form, in this program so far. Counts under the sanitizers too.
std::size_t allocation_count();

/// While it lives, one of this program's allocations fails, or all from one on.
class FailingAllocation {
 public:
  enum class Fails { one, all };
  /// @param after how many others.
  explicit FailingAllocation(std::size_t after, Fails fails = Fails::one);
  ~FailingAllocation();
  FailingAllocation(const FailingAllocation&) = delete;
  FailingAllocation& operator=(const FailingAllocation&) = delete;
};

}  // namespace touchstone
