#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "touchstone/contact_core/threads/task_runner.hpp"

namespace touchstone {

/// Threads that wait for tasks, the caller of run() being one of them. They sleep while there is no task.
/// run() does not allocate; one call at a time.
class ThreadTeam final : public TaskRunner {
 public:
  /// @param threads the caller's among them: one fewer is started; 0 counts as 1.
  /// @throws std::system_error: the system has no more of them; those that were started have ended then.
  explicit ThreadTeam(std::size_t threads);
  ~ThreadTeam() override;
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  std::size_t threads() const noexcept override { return others_.size() + 1; }
  void run(std::size_t count, Task task) noexcept override;

 private:
  void end() noexcept;
  void take_tasks(Task task, std::size_t count) noexcept;
  void serve();

  std::mutex mutex_;
  std::condition_variable starts_, all_done_;
  std::vector<std::thread> others_;
  Task task_{};
  std::size_t count_ = 0, round_ = 0, working_ = 0;
  std::atomic<std::size_t> next_{0};
  bool ends_ = false;
};

}  // namespace touchstone
