#pragma once

#include <cstddef>

namespace touchstone {

/// Lends broadphases and worlds the caller's threads: wrap a thread pool in it. Or take a ThreadTeam.
class TaskRunner {
 public:
  /// The argument of run(): a function of the task's number that neither throws nor outlives the call.
  struct Task {
    void (*function)(void* context, std::size_t index) noexcept;
    void* context;

    void operator()(std::size_t index) const noexcept { function(context, index); }
  };

  virtual ~TaskRunner() = default;

  /// How many tasks run at once; >= 1, the same for as long as somebody holds the runner.
  virtual std::size_t threads() const noexcept = 0;

  /// Calls task(0) ... task(count - 1), once each, on any threads and in any order; returns when all have
  /// returned, and what they wrote is then visible to the caller. Must not
  /// allocate if the caller must not.
  virtual void run(std::size_t count, Task task) noexcept = 0;
};

/// body(0) ... body(count - 1) on the runner's threads; in turn on the caller's when there is no runner.
template <class Body>
void run_tasks(TaskRunner* runner, std::size_t count, Body& body) noexcept {
  if (runner == nullptr || count <= 1) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  runner->run(
      count,
      {[](void* context, std::size_t index) noexcept { (*static_cast<Body*>(context))(index); }, &body});
}

}  // namespace touchstone
