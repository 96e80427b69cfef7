#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <exception>
#include <memory>

#include "touchstone/adapters/python/frame_threads.hpp"

// Private to this folder: threads that are Python's.

namespace touchstone::python {

/// Borrows threads of a concurrent.futures.Executor, or of any callable that has a function called on some
/// thread. Python's lock is held while it is handed out, not while tasks run. The caller's thread takes part
/// and never waits for a function that has not begun: an executor that is busy, shut down or does nothing
/// costs time alone, and a function that is called too late does nothing.
class PythonExecutor final : public FrameThreads {
 public:
  /// @param executor has `submit`, or is callable. @param threads tasks at once, the caller's among them.
  PythonExecutor(pybind11::object executor, std::size_t threads);
  ~PythonExecutor() override;

  std::size_t threads() const noexcept override { return threads_; }
  /// Allocates in Python. An Exception that the executor raises goes to sys.unraisablehook; what else it
  /// raises (KeyboardInterrupt, SystemExit) is kept, and it is asked no more until pass_on().
  void run(std::size_t count, Task task) noexcept override;
  void pass_on() override;
  int traverse(visitproc visit, void* with) override;

 private:
  struct Work;
  void hand_out(const std::shared_ptr<Work>& work, std::size_t helpers) noexcept;

  pybind11::object submit_;
  std::size_t threads_;
  std::exception_ptr kept_;
};

/// @throws InputError, TypeError: neither an executor of threads nor callable, or a bad number of threads.
std::shared_ptr<PythonExecutor> executor_of(const pybind11::object& executor, std::size_t threads);

}  // namespace touchstone::python
