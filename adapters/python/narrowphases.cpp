#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>

#include "touchstone/adapters/c_interface/corners.hpp"
#include "touchstone/adapters/python/answers.hpp"
#include "touchstone/adapters/python/bindings.hpp"
#include "touchstone/adapters/python/poses.hpp"
#include "touchstone/adapters/python/widest.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/registry.hpp"
#ifdef TOUCHSTONE_HAS_PLUGIN
#include "touchstone/adapters/plugin/plugin.hpp"
#endif
#ifdef TOUCHSTONE_HAS_PROCESS_ENGINE
#include "touchstone/adapters/process_engine/process_engine.hpp"
#include "touchstone/contact_core/threads/processor_time.hpp"
#endif

namespace touchstone::python {

Answers::Answers(QueryKind kind, std::size_t count, int slots)
    : kind_(kind), count_(count), slots_(slots), status_(count) {
  if (kind != QueryKind::overlap) geometry_.emplace(count);
  if (kind == QueryKind::manifold) points_.emplace(count * static_cast<std::size_t>(slots));
}

NarrowphaseOutput Answers::output() {
  NarrowphaseOutput of{{status_.get(), count_}, {}, {}};
  if (geometry_) of.geometry = {geometry_->get(), count_};
  if (points_) of.points = {points_->get(), count_ * static_cast<std::size_t>(slots_)};
  return of;
}

void Answers::clear_unused_points() {
  if (!points_) return;
  const Vector3 nowhere = Vector3::Constant(kNaN);
  const ContactPoint unused{nowhere, nowhere, nowhere.x(), 0};
  for (std::size_t i = 0; i < count_; ++i) {
    ContactPoint* const slots = points_->get() + i * static_cast<std::size_t>(slots_);
    std::fill(slots + geometry_->get()[i].point_count, slots + slots_, unused);
  }
}

const py::dtype& geometry_dtype() {
  static const auto* const dtype =
      new py::dtype(record_dtype({{"separation", "f8", offsetof(PairGeometry, separation)},
                                  {"n_AB_W", "(3,)f8", offsetof(PairGeometry, n_AB_W)},
                                  {"p_A_W", "(3,)f8", offsetof(PairGeometry, p_A_W)},
                                  {"p_B_W", "(3,)f8", offsetof(PairGeometry, p_B_W)},
                                  {"point_count", "i4", offsetof(PairGeometry, point_count)}},
                                 sizeof(PairGeometry)));
  return *dtype;
}

namespace {

const py::dtype& point_dtype() {
  static const auto* const dtype =
      new py::dtype(record_dtype({{"p_A_W", "(3,)f8", offsetof(ContactPoint, p_A_W)},
                                  {"p_B_W", "(3,)f8", offsetof(ContactPoint, p_B_W)},
                                  {"separation", "f8", offsetof(ContactPoint, separation)},
                                  {"feature_id", "u4", offsetof(ContactPoint, feature_id)}},
                                 sizeof(ContactPoint)));
  return *dtype;
}

}  // namespace

py::array Answers::status(const py::object& self) {
  const auto& of = self.cast<const Answers&>();
  return view(py::dtype("u1"), {static_cast<py::ssize_t>(of.count_)}, of.status_.get(), self, true);
}

py::object Answers::geometry(const py::object& self) {
  const auto& of = self.cast<const Answers&>();
  if (!of.geometry_) return py::none();
  return view(geometry_dtype(), {static_cast<py::ssize_t>(of.count_)}, of.geometry_->get(), self, true);
}

py::object Answers::points(const py::object& self) {
  const auto& of = self.cast<const Answers&>();
  if (!of.points_) return py::none();
  return view(point_dtype(), {static_cast<py::ssize_t>(of.count_), py::ssize_t{of.slots_}}, of.points_->get(),
              self, true);
}

namespace {

using PairArray = py::array_t<SolidIndex, py::array::c_style>;

/// Zero-copy for uint32 without gaps; other integers are converted.
class Pairs {
 public:
  explicit Pairs(const py::object& from) {
    if (py::isinstance<PairArray>(from)) {
      array_ = from;
      take(py::reinterpret_borrow<py::array>(from));
      if (reinterpret_cast<std::uintptr_t>(data_) % alignof(SolidPair) == 0) return;
    }
    convert(from);
  }

  std::span<const SolidPair> span() const { return {data_, count_}; }

 private:
  void take(const py::array& array) {
    if (array.ndim() != 2 || array.shape(1) != 2)
      reject("pairs", "shape is " + std::string(py::str(array.attr("shape"))) + ", must be (m, 2)");
    data_ = static_cast<const SolidPair*>(array.data());
    count_ = static_cast<std::size_t>(array.shape(0));
  }

  void convert(const py::object& from) {
    auto given = py::array::ensure(from);
    if (!given) throw py::type_error("pairs: no array of integers");
    if (given.size() == 0 && given.ndim() == 1) given = py::array(given.reshape({0, 2}));  // []
    const char kind = given.dtype().kind();
    if (kind != 'i' && kind != 'u' && given.size() > 0)
      throw py::type_error("pairs: dtype is " + std::string(py::str(given.dtype())) + ", must be integers");
    const auto wide = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(given);
    if (!wide) reject("pairs", "cannot be converted to integers, or there is no memory for them");
    std::vector<py::ssize_t> shape(wide.shape(), wide.shape() + wide.ndim());
    PairArray narrow(shape);
    for (py::ssize_t i = 0; i < wide.size(); ++i) {
      const std::int64_t index = wide.data()[i];
      if (index < 0 || index > std::numeric_limits<SolidIndex>::max())
        reject("pair " + std::to_string(i / 2),
               std::string(py::str(given.attr("flat")[py::int_(i)])) + " is no index");
      narrow.mutable_data()[i] = static_cast<SolidIndex>(index);
    }
    array_ = narrow;
    take(narrow);
  }

  py::object array_;
  const SolidPair* data_ = nullptr;
  std::size_t count_ = 0;
};

/// Most solids of a narrowphase, so that a sign tells what is out of range.
constexpr std::size_t kMostSolids = std::size_t{1} << 31U;

/// A sign bit is left where an index is `solids` or more, or a pair's are one: subtractions, which processors
/// of the base instruction set have vectors of, where they have none of unsigned comparisons. A third of a
/// nanosecond a pair there, a third of that with AVX-512.
/// @pre 0 < solids <= kMostSolids
TOUCHSTONE_WIDEST bool are_pairs_of(std::span<const SolidPair> pairs, std::size_t solids) {
  const auto last = static_cast<SolidIndex>(solids - 1);
  SolidIndex beyond = 0;
  std::uint64_t equal = 0;
  constexpr std::size_t kBlock = 512;  // stays in the first cache between the loops
  for (std::size_t i = 0; i < pairs.size(); i += kBlock) {
    const std::size_t count = std::min(kBlock, pairs.size() - i);
    const auto* const indices = reinterpret_cast<const SolidIndex*>(pairs.data() + i);  // as NumPy has them
    for (std::size_t k = 0; k < 2 * count; ++k) beyond |= (last - indices[k]) | indices[k];
    for (std::size_t k = 0; k < count; ++k) {
      std::uint64_t both = 0;
      std::memcpy(&both, indices + 2 * k, sizeof both);
      equal |= (both ^ (both >> 32U)) - 1U;
    }
  }
  return ((beyond | static_cast<SolidIndex>(equal)) >> 31U) == 0;
}

[[noreturn]] void reject_pair(std::span<const SolidPair> pairs, std::size_t solids) {
  std::size_t i = 0;
  while (are_pairs_of(pairs.subspan(i, 1), solids)) ++i;
  reject("pair " + std::to_string(i), "(" + std::to_string(pairs[i].a) + ", " + std::to_string(pairs[i].b) +
                                          ") is not two of the " + std::to_string(solids) + " solids");
}

void check(const Query& query) {
  if (query.max_points < 1 || query.max_points > kMaxManifoldPoints)
    reject("query", "max_points is " + std::to_string(query.max_points) + ", must be 1 to " +
                        std::to_string(kMaxManifoldPoints));
  if (!(query.max_separation >= 0.0))
    reject("query", "max_separation is " + figure(query.max_separation) + ", must be >= 0");
  if (std::isnan(query.max_point_separation)) reject("query", "max_point_separation is nan");
}

/// A narrowphase and its solids, which stay as they are: any thread may ask at any time.
class BuiltNarrowphase {
 public:
  BuiltNarrowphase(const std::string& backend, std::vector<Hexahedron> solids)
      : narrowphase_(backends().make_narrowphase(backend)),
        solids_(std::move(solids)),
        piece_(is_built_in(backend) ? kPiece : std::numeric_limits<std::size_t>::max()) {
    if (solids_.empty() || solids_.size() > kMostSolids)
      reject("solids", "are " + std::to_string(solids_.size()) + ", must be 1 to 2^31");
    const py::gil_scoped_release unlocked;
    narrowphase_->build(solids_);
  }

  const Narrowphase& get() const { return *narrowphase_; }
  std::size_t solid_count() const { return solids_.size(); }

  /// The cost of calls without Python: processor seconds of this thread for `repeats` evaluations into the
  /// same memory.
  double seconds(const Query& query, Poses& poses, const py::object& pairs, int repeats) {
    check(query);
    const Pairs list(pairs);
    if (!are_pairs_of(list.span(), solids_.size()) || poses.span().size() != solids_.size())
      reject("seconds", "pairs or poses do not fit");
    Answers answers(query.kind, list.span().size(), query.max_points);
    const auto workspace = narrowphase_->make_workspace();
    const Poses::Reading reading(poses);
    const py::gil_scoped_release unlocked;
    const double begin = processor_us();
    for (int i = 0; i < repeats; ++i)
      narrowphase_->evaluate({list.span(), poses.span(), query}, answers.output(), *workspace);
    return 1e-6 * (processor_us() - begin);  // as time.thread_time() has it
  }

  py::object ask(const Query& query, const py::object& poses, const py::object& pairs,
                 const py::object& out) {
    check(query);
    const Pairs list(pairs);
    if (!are_pairs_of(list.span(), solids_.size())) reject_pair(list.span(), solids_.size());
    Working working(*this);
    if (!py::isinstance<Poses>(poses)) {
      Poses::convert(poses, py::none(), working->poses);
      return ask({list.span(), working->poses, query}, *working->workspace, out);
    }
    auto& converted = poses.cast<Poses&>();
    const Poses::Reading reading(converted);
    return ask({list.span(), converted.span(), query}, *working->workspace, out);
  }

 private:
  /// What one call at a time works in.
  struct Scratch {
    std::unique_ptr<Narrowphase::Workspace> workspace;
    std::vector<Pose> poses;  ///< of an array
  };

  /// Takes a free scratch, or a new one, and gives it back. With Python's lock.
  class Working {
   public:
    explicit Working(BuiltNarrowphase& of) : of_(of) {
      if (of_.free_.empty()) {
        scratch_.workspace = of_.narrowphase_->make_workspace();
        of_.free_.reserve(++of_.scratches_);  // so that giving one back does not throw
        return;
      }
      scratch_ = std::move(of_.free_.back());
      of_.free_.pop_back();
    }
    ~Working() { of_.free_.push_back(std::move(scratch_)); }
    Working(const Working&) = delete;
    Working& operator=(const Working&) = delete;
    Scratch* operator->() { return &scratch_; }

   private:
    BuiltNarrowphase& of_;
    Scratch scratch_;
  };

  py::object ask(const NarrowphaseInput& input, Narrowphase::Workspace& workspace, const py::object& out) {
    const Query& query = input.query;
    const std::span<const SolidPair> pairs = input.pairs;
    if (input.poses.size() != solids_.size())
      reject("poses", "are " + std::to_string(input.poses.size()) + ", must be " +
                          std::to_string(solids_.size()) + ", one a solid");
    py::object made = out;
    if (out.is_none()) made = py::cast(std::make_unique<Answers>(query.kind, pairs.size(), query.max_points));
    auto& answers = made.cast<Answers&>();
    if (!answers.fits(query.kind, pairs.size(), query.max_points))
      reject("out", "was made for another query or number of pairs");
    if (answers.is_written) throw std::runtime_error("out: is being written by another thread");
    run(input, answers, workspace);
    return made;
  }

  /// Of one thread, until its batch has ended, however that was.
  class Writing {
   public:
    explicit Writing(Answers& answers) : answers_(answers) { answers_.is_written = true; }
    ~Writing() { answers_.is_written = false; }
    Writing(const Writing&) = delete;
    Writing& operator=(const Writing&) = delete;

   private:
    Answers& answers_;
  };

  void run(const NarrowphaseInput& input, Answers& answers, Narrowphase::Workspace& workspace) {
    const Writing writing(answers);
    const py::gil_scoped_release unlocked;
    std::unique_lock<std::mutex> alone(one_at_a_time_, std::defer_lock);
    if (!narrowphase_->capabilities().thread_safe) alone.lock();
    evaluate(input, answers.output(), workspace);
    answers.clear_unused_points();
  }

  /// Without Python's lock, but to look for Ctrl-C where a batch takes long.
  /// @throws py::error_already_set for what a signal's handler raised; the rest of the batch is not answered.
  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Narrowphase::Workspace& workspace) const {
    using Clock = std::chrono::steady_clock;
    constexpr auto kBetweenLooks = std::chrono::milliseconds(100);
    const std::size_t count = input.pairs.size();
    if (count <= piece_) return narrowphase_->evaluate(input, output, workspace);
    Clock::time_point looked = Clock::now();
    for (std::size_t first = 0; first < count; first += piece_) {
      // A piece's pairs, and their answers.
      const std::size_t size = std::min(piece_, count - first);
      const std::size_t slots = input.query.slots();
      NarrowphaseInput part = input;
      part.pairs = input.pairs.subspan(first, size);
      NarrowphaseOutput to{output.status.subspan(first, size), {}, {}};
      if (!output.geometry.empty()) to.geometry = output.geometry.subspan(first, size);
      if (!output.points.empty()) to.points = output.points.subspan(first * slots, size * slots);
      narrowphase_->evaluate(part, to, workspace);

      // Python's lock may be far: it is asked for rarely.
      if (Clock::now() - looked < kBetweenLooks) continue;
      const py::gil_scoped_acquire locked;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      looked = Clock::now();
    }
  }

  /// Pairs between two looks at the clock. `exact` takes 70 ms for their manifolds; half as many cost
  /// `native` one per cent where a pair takes 14 ns.
  static constexpr std::size_t kPiece = 512;

  std::unique_ptr<Narrowphase> narrowphase_;
  std::vector<Hexahedron> solids_;
  /// Engines from outside get a batch in one: their complaints name pairs by their number in it.
  std::size_t piece_;
  std::size_t scratches_ = 0;
  std::vector<Scratch> free_;  // with Python's lock
  std::mutex one_at_a_time_;
};

std::vector<Hexahedron> solids_from(const py::object& solids) {
  if (!py::isinstance<py::array>(solids)) {
    std::vector<Hexahedron> list;
    for (const py::handle& solid : solids) {
      if (!py::isinstance<Hexahedron>(solid))
        throw py::type_error("solids: neither Hexahedron objects nor an array of corners (n, 8, 3)");
      list.push_back(solid.cast<const Hexahedron&>());
    }
    return list;
  }
  const Doubles corners = doubles(solids, "solids", {-1, 8, 3}, "(n, 8, 3)");
  return c_interface::solids_from_corners({corners.data(), static_cast<std::size_t>(corners.size())});
}

py::dict capabilities_of(const BuiltNarrowphase& self) {
  const Capabilities& of = self.get().capabilities();
  py::dict made;
  made["distance"] = of.distance;
  made["penetration"] = of.penetration;
  made["manifold"] = of.manifold;
  made["overlap_complete"] = of.overlap_complete;
  made["scalar_bits"] = of.scalar_bits;
  made["deterministic"] = of.deterministic;
  made["thread_safe"] = of.thread_safe;
  made["absolute_resolution"] = of.resolution.absolute;
  made["relative_resolution"] = of.resolution.relative;
  made["depth_resolution"] = of.resolution.of_depth;
  return made;
}

py::dict backend_table() {
  py::dict made;
  for (const BackendRegistry::NarrowphaseEntry& entry : backends().narrowphases())
    made[py::str(entry.name)] = entry.description;
  return made;
}

void bind_poses(py::module_& module) {
  py::class_<Poses>(module, "Poses",
                    "Poses X_WS of solids, checked and converted once; see the package's stubs for shapes.")
      // Making, and writing anew.
      .def(py::init([](const py::object& poses, const py::object& quaternions) {
             return std::make_unique<Poses>(poses, quaternions);
           }),
           py::arg("poses"), py::arg("quaternions") = py::none(),
           "Poses(matrices (n, 4, 4)) or Poses(positions (n, 3) [m], quaternions (n, 4), w x y z of any "
           "length but 0). Raises InputError for what is no rigid transform, naming the pose.")
      .def(
          "update",
          [](Poses& self, const py::object& poses, const py::object& quaternions, std::size_t first) {
            self.update(poses, quaternions, first);
          },
          py::arg("poses"), py::arg("quaternions") = py::none(), py::arg("first") = 0,
          "Replaces the poses from `first` on, all or none of them. Raises RuntimeError while another thread "
          "reads them.")
      // Reading.
      .def("matrices", &Poses::matrices, "A copy as (n, 4, 4), every bit as in the poses.")
      .def("__len__", [](const Poses& self) { return self.span().size(); })
      .def("__getitem__", [](const Poses& self, std::ptrdiff_t i) {
        const auto count = static_cast<std::ptrdiff_t>(self.span().size());
        if (i < -count || i >= count)
          throw py::index_error("poses: " + std::to_string(i) + " of " + std::to_string(count));
        return frozen(array_of(self.span()[static_cast<std::size_t>(i < 0 ? i + count : i)]));
      });
}

void bind_answers(py::module_& module) {
  py::class_<Answers>(module, "Answers", "One batch's answers, in the order of its pairs; row i is pair i's.")
      .def_property_readonly("status", &Answers::status, "(m,) uint8, values of touchstone.Status.")
      .def_property_readonly(
          "geometry", &Answers::geometry,
          "(m,) records: separation [m], n_AB_W (3,), p_A_W (3,) and p_B_W (3,) [m], point_count; NaN where "
          "the status carries nothing. None for overlap.")
      .def_property_readonly(
          "points", &Answers::points,
          "(m, max_points) records: p_A_W (3,), p_B_W (3,) and separation [m], feature_id; "
          "NaN from point_count on. None unless manifold.")
      .def("__len__", &Answers::count)
      .def("__repr__", [](const Answers& self) {
        return "<touchstone.Answers: " + std::string(to_string(self.kind())) + " of " +
               std::to_string(self.count()) + " pairs>";
      });
}

void bind_loading(py::module_& module) {
#ifdef TOUCHSTONE_HAS_PLUGIN
  module.def(
      "load_plugin", [](const std::string& library) { return register_plugin(backends(), library); },
      py::arg("library"), "Loads a backend from a shared library (touchstone_plugin.h); returns its name.");
#endif
#ifdef TOUCHSTONE_HAS_PROCESS_ENGINE
  module.def(
      "start_engine",
      [](std::vector<std::string> command) {
        ProcessEngineOptions options;
        options.command = std::move(command);
        return register_process_engine(backends(), options);  // with Python's lock: others read the registry
      },
      py::arg("command"), "Starts a backend that is a program and its arguments; returns its name.");
#endif
  static_cast<void>(module);
}

}  // namespace

void bind_narrowphases(py::module_& module) {
  bind_poses(module);
  bind_answers(module);
  bind_loading(module);
  module.def("backends", backend_table,
             "Names of the narrowphases of this build, each with its description.");
  const py::none none;
  // A narrowphase over solids.
  py::class_<BuiltNarrowphase>(
      module, "Narrowphase",
      "A fine check over solids. It stays as it is: any thread may ask, and Python's lock is free meanwhile. "
      "Arrays that are being read must not be written to.")
      .def(py::init([](const std::string& backend, const py::object& solids) {
             return std::make_unique<BuiltNarrowphase>(backend, solids_from(solids));
           }),
           py::arg("backend"), py::arg("solids"),
           "solids: a sequence of Hexahedron, or their corners (n, 8, 3) [m]. Raises InputError for an "
           "unknown name, or a solid that the backend cannot represent.")
      // Questions, each dearer than the one before.
      .def(
          "overlap",
          [](BuiltNarrowphase& self, const py::object& poses, const py::object& pairs,
             const py::object& out) { return self.ask({}, poses, pairs, out); },
          py::arg("poses"), py::arg("pairs"), py::arg("out") = none,
          "Whether pairs touch. poses: Poses or (n, 4, 4), one a solid. pairs: (m, 2) indices; uint32 is not "
          "copied. out: Answers of an earlier call of as many pairs, written again.")
      .def(
          "distance",
          [](BuiltNarrowphase& self, const py::object& poses, const py::object& pairs, double max_separation,
             const py::object& out) {
            return self.ask({QueryKind::distance, max_separation}, poses, pairs, out);
          },
          py::arg("poses"), py::arg("pairs"), py::arg("max_separation") = kInfinity, py::arg("out") = none,
          "Signed distances [m], normals and witness points. Pairs further apart than max_separation [m] get "
          "+inf.")
      .def(
          "manifold",
          [](BuiltNarrowphase& self, const py::object& poses, const py::object& pairs, int max_points,
             double max_separation, double max_point_separation, const py::object& out) {
            return self.ask({QueryKind::manifold, max_separation, max_points, max_point_separation}, poses,
                            pairs, out);
          },
          py::arg("poses"), py::arg("pairs"), py::arg("max_points") = kMaxManifoldPoints,
          py::arg("max_separation") = kInfinity, py::arg("max_point_separation") = 0.0, py::arg("out") = none,
          "As distance, with up to max_points (1 to 8) contact points a pair, no further apart than "
          "max_point_separation [m] or the pair itself.")
      .def(
          "_seconds",
          [](BuiltNarrowphase& self, int kind, Poses& poses, const py::object& pairs, int repeats) {
            if (kind < 0 || kind > static_cast<int>(QueryKind::manifold)) reject("kind", "is 0, 1 or 2");
            return self.seconds({static_cast<QueryKind>(kind)}, poses, pairs, repeats);
          },
          "For benchmarks: processor seconds of evaluations in C++ alone.")
      // Its name and capabilities.
      .def_property_readonly(
          "name", [](const BuiltNarrowphase& self) { return self.get().name(); }, "The backend's.")
      .def_property_readonly("capabilities", &capabilities_of,
                             "What it answers, and its resolution [m] (absolute + relative * scale).")
      .def("__len__", &BuiltNarrowphase::solid_count);
}

}  // namespace touchstone::python
