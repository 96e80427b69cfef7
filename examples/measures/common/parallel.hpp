#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <thread>
#include <vector>

namespace touchstone::measures {

/// Calls body(begin, end) for consecutive chunks of [0, count) on `threads` threads, the caller's among them;
/// `progress` is called on the caller's thread only. The body must not throw.
template <typename Body>
void parallel_chunks(std::size_t count, std::size_t chunk, int threads, const Body& body,
                     const std::function<void(double)>& progress = {}) {
  std::atomic<std::size_t> next{0};
  const auto work = [&](bool reports) {
    for (std::size_t begin; (begin = next.fetch_add(chunk)) < count;) {
      const std::size_t end = begin + chunk < count ? begin + chunk : count;
      body(begin, end);
      if (reports && progress) progress(static_cast<double>(end) / static_cast<double>(count));
    }
  };
  std::vector<std::jthread> others;
  for (int i = 1; i < threads; ++i) others.emplace_back(work, false);
  work(true);
}

}  // namespace touchstone::measures
