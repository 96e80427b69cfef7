#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/contact_core/geometry/vector.hpp"

/// @file
/// NumPy's arrays in and out. What is no array of numbers is a TypeError, another shape an InputError with
/// the argument's name.

namespace touchstone::python {

namespace py = pybind11;

/// Doubles without gaps, row by row.
using Doubles = py::array_t<double, py::array::c_style>;

/// Takes integers and floats of any size, order and stride; aligned doubles without gaps are not copied.
/// @param shape -1: any length. @param letters for the error: "(n, 4, 4)".
Doubles doubles(const py::handle& from, const char* name, std::initializer_list<py::ssize_t> shape,
                const char* letters);
/// A figure of each row's.
std::vector<double> numbers(const py::handle& from, const char* name);
Vector3 vector3(const py::handle& from, const char* name);
Matrix3 matrix3(const py::handle& from, const char* name);

/// The same array, which refuses writes: of a property's copy they would be lost without a word.
py::array frozen(py::array copy);

Doubles array_of(const Vector3& v);
Doubles array_of(const Matrix3& m);
Doubles array_of(std::span<const double> values);
/// (n, 3).
Doubles array_of(std::span<const Vector3> points);
/// (4, 4).
Doubles array_of(const Pose& X);

/// A pose from 16 doubles, row by row. @throws InputError as pose_from_matrix(), naming `name`.
Pose pose_from_rows(const double* rows, const std::string& name);
/// Of a 4 x 4 matrix, or (position, quaternion wxyz), or None for the identity.
Pose pose(const py::handle& from, const char* name);
void write_rows(const Pose& X, double* rows);

/// One field of a record.
struct Field {
  const char* name;
  const char* format;  ///< NumPy's: "f8", "(3,)f8"
  std::size_t offset;
};
/// The dtype of C++ structs in an array.
py::dtype record_dtype(std::initializer_list<Field> fields, std::size_t size);

/// A view of memory that `owner` holds: neither copied nor resizable.
template <class T>
py::array view(const py::dtype& dtype, std::vector<py::ssize_t> shape, const T* data, const py::object& owner,
               bool writeable) {
  py::array made(dtype, std::move(shape), std::vector<py::ssize_t>{}, data, owner);
  if (!writeable) made.attr("setflags")(py::arg("write") = false);
  return made;
}

}  // namespace touchstone::python
