#include "touchstone/contact_core/threads/thread_team.hpp"

namespace touchstone {

ThreadTeam::ThreadTeam(std::size_t threads) {
  try {
    for (std::size_t i = 1; i < threads; ++i) others_.emplace_back([this] { serve(); });
  } catch (...) {
    end();
    throw;
  }
}

ThreadTeam::~ThreadTeam() { end(); }

void ThreadTeam::end() noexcept {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  starts_.notify_all();
  for (std::thread& thread : others_) thread.join();
}

void ThreadTeam::run(std::size_t count, Task task) noexcept {
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

void ThreadTeam::take_tasks(Task task, std::size_t count) noexcept {
  for (std::size_t i; (i = next_.fetch_add(1)) < count;) task(i);
}

void ThreadTeam::serve() {
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

}  // namespace touchstone
