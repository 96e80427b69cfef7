#pragma once

#include <optional>

#include "touchstone/adapters/python/arrays.hpp"
#include "touchstone/adapters/python/recycled_array.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone::python {

/// A batch's answers. It owns the memory; its arrays are views that keep it.
class Answers {
 public:
  Answers(QueryKind kind, std::size_t count, int slots);

  bool fits(QueryKind kind, std::size_t count, int slots) const {
    return kind_ == kind && count_ == count && slots_ == slots;
  }
  NarrowphaseOutput output();
  /// After an evaluation: slots that no point took get NaN and feature 0.
  void clear_unused_points();

  QueryKind kind() const { return kind_; }
  std::size_t count() const { return count_; }
  static py::array status(const py::object& self);
  static py::object geometry(const py::object& self);
  static py::object points(const py::object& self);

  bool is_written = false;  ///< by a thread without Python's lock

 private:
  QueryKind kind_;
  std::size_t count_;
  int slots_;  ///< points a pair
  RecycledArray<PairStatus> status_;
  std::optional<RecycledArray<PairGeometry>> geometry_;
  std::optional<RecycledArray<ContactPoint>> points_;
};

/// Of PairGeometry.
const py::dtype& geometry_dtype();

}  // namespace touchstone::python
