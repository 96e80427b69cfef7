#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "touchstone/contact_core/broadphase/task_runner.hpp"

namespace touchstone {

/// Threads that wait for tasks, the caller of run() being one of them.
class ThreadTeam final : public TaskRunner {
 public:
  explicit ThreadTeam(std::size_t threads) {
    for (std::size_t i = 1; i < threads; ++i) others_.emplace_back([this] { serve(); });
  }

  ~ThreadTeam() override {
    {
      const std::lock_guard lock(mutex_);
      ends_ = true;
    }
    starts_.notify_all();
    for (std::thread& thread : others_) thread.join();
  }

  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  std::size_t threads() const noexcept override { return others_.size() + 1; }

  void run(std::size_t count, Task task) noexcept override {
    {
      const std::lock_guard lock(mutex_);
      task_ = task, count_ = count, next_ = 0, working_ = others_.size();
      ++round_;
    }
    starts_.notify_all();
    take_tasks(task, count);
    std::unique_lock lock(mutex_);
    all_done_.wait(lock, [this] { return working_ == 0; });
  }

 private:
  void take_tasks(Task task, std::size_t count) noexcept {
    for (std::size_t i; (i = next_.fetch_add(1)) < count;) task(i);
  }

  void serve() {
    std::size_t seen = 0;
    std::unique_lock lock(mutex_);
    while (true) {
      starts_.wait(lock, [&] { return ends_ || round_ != seen; });
      if (ends_) return;
      seen = round_;
      const Task task = task_;
      const std::size_t count = count_;
      lock.unlock();
      take_tasks(task, count);
      lock.lock();
      if (--working_ == 0) all_done_.notify_one();
    }
  }

  std::mutex mutex_;
  std::condition_variable starts_, all_done_;
  std::vector<std::thread> others_;
  Task task_{};
  std::size_t count_ = 0, round_ = 0, working_ = 0;
  std::atomic<std::size_t> next_{0};
  bool ends_ = false;
};

}  // namespace touchstone
