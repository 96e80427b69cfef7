#pragma once

#include <ctime>

namespace touchstone {

/// The time that this thread has had of a processor [us]: other programs on the machine do not count.
inline double processor_us() noexcept {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

}  // namespace touchstone
