#pragma once

#include <pybind11/pybind11.h>

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <vector>

#include "touchstone/adapters/python/bindings.hpp"
#include "touchstone/adapters/python/frame_threads.hpp"
#include "touchstone/contact_core/registry.hpp"
#include "touchstone/contact_core/threads/thread_team.hpp"
#include "touchstone/contact_core/world/contact_world.hpp"

// Private to this folder: a world as Python holds it.

namespace touchstone::python {

namespace py = pybind11;

/// An object's number in arrays: int(object).
inline std::uint64_t number_of(ObjectHandle object) {
  return static_cast<std::uint64_t>(object.generation) << 32U | object.slot;
}

/// Rows of the arrays that Python gets: no C++ objects' own layouts.
struct EventRow {
  std::uint64_t a, b;
  std::uint32_t solid_a, solid_b, part;
  EventKind kind;
  std::array<std::uint8_t, 3> unused;  // zero: equal rows have equal bytes
  double s, separation;
  std::array<double, 3> n_AB_W, p_A_W, p_B_W;
  double separation_at_end;
};
struct FeelRow {
  std::uint64_t object;
  std::array<double, 3> p_W, lag_W, turn_lag_W, force_W, moment_W;
};

/// A frame's report, kept: its own arrays.
struct Report {
  std::uint64_t frame, queries, slide_pairs, most_slide_work;
  std::uint32_t blocked_movers, candidate_pairs, iteration_limits, slide_steps;
  std::uint32_t refused_selections;
  bool is_proven;
  std::vector<EventRow> events;
  std::vector<FeelRow> felt;
  std::vector<std::uint64_t> cut_off;  ///< numbers of objects
};
Report kept(const FrameReport& of);
void bind_report(py::module_& module);

/// @throws InputError: not 1 to as many as a world takes.
void check_thread_count(std::size_t threads);

/// Threads that worlds borrow for their frames. Worlds that share them take turns.
class ThreadPool final : public FrameThreads {
 public:
  explicit ThreadPool(std::size_t threads) : team_(threads) {}
  std::size_t threads() const noexcept override { return team_.threads(); }
  void run(std::size_t count, Task task) noexcept override {
    const std::scoped_lock turn(in_use_);
    team_.run(count, task);
  }

 private:
  std::mutex in_use_;
  ThreadTeam team_;
};

/// A world, and whether a thread is in a frame of it without Python's lock.
class GuardedWorld {
 public:
  GuardedWorld(const std::string& narrowphase, const std::string& broadphase, double gap)
      : world_(backends().make_narrowphase(narrowphase), backends().make_broadphase(broadphase), gap) {}

  ContactWorld& get() {
    if (is_busy_) throw std::runtime_error("world: is in use by another thread");
    return world_;
  }
  /// For select() alone, which any thread may call at any time.
  ContactWorld& unguarded() { return world_; }

  void set_threads(std::size_t count) {
    get().set_threads(count);
    pool_.reset();
  }
  /// Kept until another one, or none, is set.
  void set_runner(std::shared_ptr<FrameThreads> runner) {
    get().set_task_runner(runner.get());
    pool_ = std::move(runner);
  }

  /// @throws what the threads pass on, once body is done.
  template <class Body>
  auto without_lock(Body&& body) {
    if constexpr (std::is_void_v<decltype(body(world_))>) {
      call_unlocked(body);
      if (pool_) pool_->pass_on();
    } else {
      auto made = call_unlocked(body);
      if (pool_) pool_->pass_on();
      return made;
    }
  }

  /// As tp_traverse and tp_clear: a world and the executor that it borrows may hold each other.
  int traverse(visitproc visit, void* with) { return pool_ ? pool_->traverse(visit, with) : 0; }
  void clear() {
    if (!is_busy_) set_runner(nullptr);
  }

 private:
  template <class Body>
  auto call_unlocked(Body& body) {
    ContactWorld& world = get();
    is_busy_ = true;
    struct Idle {
      bool& is_busy;
      ~Idle() { is_busy = false; }
    } const idle{is_busy_};  // after the lock is back
    const py::gil_scoped_release unlocked;
    return body(world);
  }

  std::shared_ptr<FrameThreads> pool_;  // before the world, which borrows it to its end
  ContactWorld world_;
  bool is_busy_ = false;
};

using WorldClass = py::class_<GuardedWorld>;
void bind_hands(py::module_& module);
/// Hands, budgets and threads of worlds.
void bind_hands_of(WorldClass& world);

}  // namespace touchstone::python
