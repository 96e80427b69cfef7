#include "touchstone/adapters/python/executor.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <string>
#include <utility>

#include "touchstone/adapters/python/world.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::python {

/// Tasks that any number of threads take from, until run() is over: whoever comes then finds it closed.
struct PythonExecutor::Work {
  Work(std::size_t tasks, Task each) : count(tasks), task(each) {}

  void take() noexcept {
    for (std::size_t index; (index = next.fetch_add(1)) < count;) task(index);
  }
  /// Of a borrowed thread.
  void help() noexcept {
    {
      const std::scoped_lock lock(mutex);
      if (is_closed) return;
      ++inside;
    }
    take();
    const std::scoped_lock lock(mutex);
    --inside;
    idle.notify_all();
  }
  /// Of the caller: all tasks are taken, and are waited for.
  void close() noexcept {
    std::unique_lock lock(mutex);
    is_closed = true;
    idle.wait(lock, [this] { return inside == 0; });
  }

  std::size_t count;
  Task task;
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::condition_variable idle;
  int inside = 0;
  bool is_closed = false;
};

PythonExecutor::PythonExecutor(py::object executor, std::size_t threads)
    : submit_(py::hasattr(executor, "submit") ? executor.attr("submit") : executor), threads_(threads) {}

PythonExecutor::~PythonExecutor() {
  const py::gil_scoped_acquire locked;
  submit_ = py::object();
  kept_ = nullptr;
}

void PythonExecutor::pass_on() {
  if (kept_ != nullptr) std::rethrow_exception(std::exchange(kept_, nullptr));
}

int PythonExecutor::traverse(visitproc visit, void* with) { return submit_ ? visit(submit_.ptr(), with) : 0; }

void PythonExecutor::hand_out(const std::shared_ptr<Work>& work, std::size_t helpers) noexcept {
  const py::gil_scoped_acquire locked;
  try {
    const py::cpp_function help([work] {
      const py::gil_scoped_release unlocked;
      work->help();
    });
    for (std::size_t i = 0; i < helpers; ++i) submit_(help);
  } catch (py::error_already_set& error) {
    if (error.matches(PyExc_Exception))
      error.discard_as_unraisable("the executor of a world");
    else
      kept_ = std::current_exception();
  } catch (const std::exception& error) {
    PyErr_SetString(PyExc_RuntimeError, error.what());
    PyErr_WriteUnraisable(submit_.ptr());
  }
}

void PythonExecutor::run(std::size_t count, Task task) noexcept {
  if (count == 0) return;
  // The caller's thread is one of them.
  const auto work = std::make_shared<Work>(count, task);
  const std::size_t helpers = std::min(count, threads_) - 1;
  if (helpers > 0 && kept_ == nullptr) hand_out(work, helpers);
  // Its own share, and the end, without Python's lock: the others need it to begin and to end.
  const auto work_on = [&] {
    work->take();
    work->close();
  };
  if (PyGILState_Check() == 0) return work_on();
  const py::gil_scoped_release unlocked;
  work_on();
}

std::shared_ptr<PythonExecutor> executor_of(const py::object& executor, std::size_t threads) {
  const py::object processes = py::module_::import("concurrent.futures").attr("ProcessPoolExecutor");
  if (py::isinstance(executor, processes))
    throw py::type_error("executor: a ProcessPoolExecutor has no threads of this process");
  if (!py::hasattr(executor, "submit") && PyCallable_Check(executor.ptr()) == 0)
    throw py::type_error("executor: has no submit(), and is not callable");
  check_thread_count(threads);
  return std::make_shared<PythonExecutor>(executor, threads);
}

}  // namespace touchstone::python
