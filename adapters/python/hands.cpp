#include <pybind11/stl.h>

#include <limits>

#include "touchstone/adapters/python/arrays.hpp"
#include "touchstone/adapters/python/executor.hpp"
#include "touchstone/adapters/python/world.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"

// Python's hands of a world, the budget of its slides, and the threads of its frames.

namespace touchstone::python {
namespace {

constexpr std::size_t kMostThreads = 64;  // as ContactWorld::set_threads()

Vector3 stiffness(const py::object& values, const char* name, const Vector3& otherwise) {
  return values.is_none() ? otherwise : vector3(values, name);
}

HandStiffness hand_stiffness(const py::object& translation, const py::object& turning,
                             const py::object& X_OT) {
  HandStiffness made;
  made.translation = stiffness(translation, "translation", made.translation);
  made.turning = stiffness(turning, "turning", made.turning);
  if (!X_OT.is_none()) made.X_OT = pose(X_OT, "X_OT");
  return made;
}

ArmHandStiffness arm_hand_stiffness(const std::string& link, const py::object& X_LT,
                                    const py::object& translation, const py::object& turning,
                                    const py::object& joints) {
  ArmHandStiffness made;
  made.link = link;
  made.X_LT = pose(X_LT, "X_LT");
  made.translation = stiffness(translation, "translation", made.translation);
  made.turning = stiffness(turning, "turning", made.turning);
  if (!joints.is_none()) made.joints = numbers(joints, "joints");
  return made;
}

void set_slide_budget(GuardedWorld& self, std::optional<std::uint64_t> pairs, std::optional<double> seconds,
                      std::optional<std::uint64_t> mover_work) {
  SlideBudget budget;
  budget.mover_work = mover_work.value_or(std::numeric_limits<std::uint64_t>::max());
  if (pairs) budget.pairs = *pairs;
  if (seconds) budget.seconds = *seconds;
  self.get().set_slide_budget(budget);
}

py::dict slide_budget(GuardedWorld& self) {
  const SlideBudget& budget = self.get().slide_budget();
  const auto limit = [](std::uint64_t count) {
    return count == std::numeric_limits<std::uint64_t>::max() ? py::object(py::none()) : py::int_(count);
  };
  py::dict made;
  made["pairs"] = limit(budget.pairs);
  made["seconds"] = budget.seconds == kInfinity ? py::object(py::none()) : py::float_(budget.seconds);
  made["mover_work"] = limit(budget.mover_work);
  return made;
}

std::shared_ptr<ThreadPool> thread_pool(std::size_t threads) {
  check_thread_count(threads);
  return std::make_shared<ThreadPool>(threads);
}

constexpr const char* kStiffnessText =
    "translation: (3,) along the tool frame's axes [N/m], turning: (3,) about them [N m/rad]; None: 500 "
    "each. Above 0, no two of a frame further apart than a factor of 1e6. ";

}  // namespace

void check_thread_count(std::size_t threads) {
  if (threads < 1 || threads > kMostThreads)
    reject("threads", "are " + std::to_string(threads) + ", must be 1 to " + std::to_string(kMostThreads));
}

namespace {

void bind_object_stiffness(py::module_& module) {
  py::class_<HandStiffness>(module, "HandStiffness",
                            "How stiffly a hand holds a rigid object: springs from its tool frame T to where "
                            "the command has that. A slide goes where they are slackest.")
      .def(
          py::init(&hand_stiffness), py::arg("translation") = py::none(), py::arg("turning") = py::none(),
          py::arg("X_OT") = py::none(),
          (std::string(kStiffnessText) +
           "X_OT: T in the object, None, (4, 4) or (position, quaternion wxyz); None: at the centre of mass, "
           "along the object's axes.")
              .c_str())
      .def_property_readonly(
          "translation", [](const HandStiffness& self) { return frozen(array_of(self.translation)); },
          "(3,) [N/m].")
      .def_property_readonly(
          "turning", [](const HandStiffness& self) { return frozen(array_of(self.turning)); },
          "(3,) [N m/rad].")
      .def_property_readonly(
          "X_OT",
          [](const HandStiffness& self) -> py::object {
            if (!self.X_OT) return py::none();
            return frozen(array_of(*self.X_OT));
          },
          "(4, 4), or None: at the centre of mass.");
}

void bind_arm_stiffness(py::module_& module) {
  py::class_<ArmHandStiffness>(module, "ArmHandStiffness",
                               "How stiffly a hand holds a mechanism: springs on a tool frame T of one of "
                               "its links, and one on each joint.")
      .def(py::init(&arm_hand_stiffness), py::arg("link"), py::arg("X_LT") = py::none(),
           py::arg("translation") = py::none(), py::arg("turning") = py::none(),
           py::arg("joints") = py::none(),
           ("link: some joint moves it. X_LT: T in the link, None, (4, 4) or (position, quaternion wxyz). " +
            std::string(kStiffnessText) +
            "joints: (n,) of each joint value [N m/rad] or [N/m]; None: all a hundredth of the least "
            "translation.")
               .c_str())
      .def_readonly("link", &ArmHandStiffness::link, "Its name.")
      .def_property_readonly(
          "X_LT", [](const ArmHandStiffness& self) { return frozen(array_of(self.X_LT)); }, "(4, 4).")
      .def_property_readonly(
          "translation", [](const ArmHandStiffness& self) { return frozen(array_of(self.translation)); },
          "(3,) [N/m].")
      .def_property_readonly(
          "turning", [](const ArmHandStiffness& self) { return frozen(array_of(self.turning)); },
          "(3,) [N m/rad].")
      .def_property_readonly(
          "joints", [](const ArmHandStiffness& self) { return frozen(array_of(self.joints)); },
          "(n,) [N m/rad] or [N/m]; (0,): a hundredth of the least translation each.");
}

void bind_thread_pool(py::module_& module) {
  py::class_<ThreadPool, std::shared_ptr<ThreadPool>>(
      module, "ThreadPool",
      "Threads for the frames of worlds: World.set_thread_pool(). They sleep in between. Worlds that share "
      "them take turns.")
      .def(py::init(&thread_pool), py::arg("threads"),
           "threads: 1 to 64, the one that calls frame() among them.")
      .def_property_readonly("threads", &ThreadPool::threads,
                             "How many, the one that calls frame() among them.");
}

void bind_stiffness_of(WorldClass& world) {
  world
      // Of an object, of a mechanism, and of objects that were given none.
      .def(
          "set_hand",
          [](GuardedWorld& self, ObjectHandle object, const std::optional<HandStiffness>& hand) {
            self.get().set_hand(object, hand);
          },
          py::arg("object"), py::arg("hand"),
          "How stiffly the hand of an object holds it where it is commanded; FrameReport.felt says what it "
          "feels. None: as its own mass.")
      .def(
          "set_hand",
          [](GuardedWorld& self, MechanismHandle mechanism, const std::optional<ArmHandStiffness>& hand) {
            self.get().set_hand(mechanism, hand);
          },
          py::arg("mechanism"), py::arg("hand"),
          "The same of a mechanism. None: by the weights of its joints alone, and nothing felt.")
      .def(
          "set_default_hand",
          [](GuardedWorld& self, const std::optional<HandStiffness>& hand) {
            self.get().set_default_hand(hand);
          },
          py::arg("hand"),
          "Of objects that were given none of their own; HandStiffness() unless this is called. No tool "
          "frame.");
}

void bind_slide_budget(WorldClass& world) {
  world
      .def(
          "set_slide_budget", &set_slide_budget, py::arg("pairs") = py::none(),
          py::arg("seconds") = py::none(), py::arg("mover_work") = kMoverWork,
          "What all slides of a frame together may cost from now on: pairs that are planned with or whose "
          "paths are checked, each once a sub-step (the same on every machine); seconds by the clock [s]. "
          "mover_work: what each mover's slide may cost by itself, in rows, steps and pairs of its plans. "
          "None: unlimited. A mover that is cut off stands as safely, only less far on: FrameReport.cut_off.")
      .def_property_readonly(
          "slide_budget", &slide_budget,
          "{'pairs': int or None, 'seconds': float or None, 'mover_work': int or None}: None is unlimited.");
}

void bind_threads_of(WorldClass& world) {
  world
      .def("set_threads", &GuardedWorld::set_threads, py::arg("count"),
           "Frames run on this many threads of the world's own, 1 to 64, the caller's among them; the same "
           "bits with any number.")
      .def(
          "set_executor",
          [](GuardedWorld& self, const py::object& executor, std::size_t threads) {
            self.set_runner(executor_of(executor, threads));
          },
          py::arg("executor"), py::arg("threads"),
          "Frames run on threads of a concurrent.futures.Executor, or of a callable that has the function "
          "that it is given called on some thread: this many tasks at once, 1 to 64, the caller's thread "
          "among them. The same bits with any. The frame never waits for a call that has not begun, and a "
          "late one does nothing. An Exception that the executor raises goes to sys.unraisablehook; "
          "KeyboardInterrupt and SystemExit are raised where the frame ends, which is flown to its end. The "
          "world keeps the executor until another one, or set_threads(1).")
      .def(
          "set_thread_pool",
          [](GuardedWorld& self, std::shared_ptr<ThreadPool> pool) { self.set_runner(std::move(pool)); },
          py::arg("pool"),
          "Frames run on a ThreadPool's threads, which other worlds may share; None: on the caller's alone. "
          "The same bits with any.");
}

}  // namespace

void bind_hands(py::module_& module) {
  bind_object_stiffness(module);
  bind_arm_stiffness(module);
  bind_thread_pool(module);
}

void bind_hands_of(WorldClass& world) {
  bind_stiffness_of(world);
  bind_slide_budget(world);
  bind_threads_of(world);
}

}  // namespace touchstone::python
