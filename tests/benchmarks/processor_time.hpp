#pragma once

#include <ctime>

namespace touchstone {

/// Returns what this thread has had of a processor [us]: what other programs take of the machine is not in
/// it.
inline double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

}  // namespace touchstone
