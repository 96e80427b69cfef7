#pragma once

#include <pybind11/pybind11.h>

#include "touchstone/contact_core/threads/task_runner.hpp"

// Private to this folder: threads that a world of Python borrows.

namespace touchstone::python {

/// Threads for a world's frames, which may be Python's. Both calls: with Python's lock.
class FrameThreads : public TaskRunner {
 public:
  /// Throws what Python raised meanwhile and a frame must not swallow; once.
  virtual void pass_on() {}
  /// As tp_traverse: the Python objects that it holds.
  virtual int traverse(visitproc /*visit*/, void* /*with*/) { return 0; }
};

}  // namespace touchstone::python
