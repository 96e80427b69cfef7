#include "touchstone/adapters/python/arrays.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::python {
namespace {

std::string shape_text(const py::array& array) {
  std::string text = "(";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
  return text + (array.ndim() == 1 ? ",)" : ")");
}

bool has_shape(const py::array& array, std::initializer_list<py::ssize_t> shape) {
  if (array.ndim() != static_cast<py::ssize_t>(shape.size())) return false;
  return std::equal(shape.begin(), shape.end(), array.shape(),
                    [](py::ssize_t wanted, py::ssize_t is) { return wanted < 0 || wanted == is; });
}

/// The same doubles where C++ may read them: NumPy's may begin at any byte.
Doubles aligned(Doubles array) {
  if (reinterpret_cast<std::uintptr_t>(array.data()) % alignof(double) == 0) return array;
  return Doubles(array.attr("copy")());
}

}  // namespace

Doubles doubles(const py::handle& from, const char* name, std::initializer_list<py::ssize_t> shape,
                const char* letters) {
  if (py::isinstance<Doubles>(from)) {  // as it is: two looks through NumPy less
    auto as_is = py::reinterpret_borrow<Doubles>(from);
    if (!has_shape(as_is, shape)) reject(name, "shape is " + shape_text(as_is) + ", must be " + letters);
    return aligned(std::move(as_is));
  }
  const auto given = py::array::ensure(from);
  if (!given) throw py::type_error(std::string(name) + ": no array of numbers");
  const char kind = given.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u')
    throw py::type_error(std::string(name) + ": dtype is " + std::string(py::str(given.dtype())) +
                         ", must be floats or integers");
  if (!has_shape(given, shape)) reject(name, "shape is " + shape_text(given) + ", must be " + letters);
  // Forced: NumPy calls it unsafe to narrow long doubles.
  auto made = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(given);
  if (!made)
    reject(name,
           "cannot be converted to doubles, or there is no memory for them");  // beyond their range, where
                                                                               // NumPy raises that
  return aligned(py::reinterpret_steal<Doubles>(made.release()));
}

std::vector<double> numbers(const py::handle& from, const char* name) {
  const Doubles array = doubles(from, name, {-1}, "(n,)");
  return {array.data(), array.data() + array.size()};
}

Vector3 vector3(const py::handle& from, const char* name) {
  const Doubles array = doubles(from, name, {3}, "(3,)");
  return {array.data()[0], array.data()[1], array.data()[2]};
}

Matrix3 matrix3(const py::handle& from, const char* name) {
  const Doubles array = doubles(from, name, {3, 3}, "(3, 3)");
  Matrix3 made;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) made(row, column) = array.data()[3 * row + column];
  return made;
}

py::array frozen(py::array copy) {
  copy.attr("setflags")(py::arg("write") = false);
  return copy;
}

Doubles array_of(const Vector3& v) { return Doubles(3, v.data()); }

Doubles array_of(const Matrix3& m) {
  Doubles made({3, 3});
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) made.mutable_at(row, column) = m(row, column);
  return made;
}

Doubles array_of(std::span<const double> values) {
  return Doubles(static_cast<py::ssize_t>(values.size()), values.data());
}

Doubles array_of(std::span<const Vector3> points) {
  Doubles made({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}});
  double* out = made.mutable_data();
  for (const Vector3& point : points) out = std::copy_n(point.data(), 3, out);
  return made;
}

Doubles array_of(const Pose& X) {
  Doubles made({4, 4});
  write_rows(X, made.mutable_data());
  return made;
}

Pose pose_from_rows(const double* rows, const std::string& name) {
  Matrix4 X;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) X(row, column) = rows[4 * row + column];
  return pose_from_matrix(X, name);
}

Pose pose(const py::handle& from, const char* name) {
  if (from.is_none()) return {};
  if (py::isinstance<py::tuple>(from) && py::len(from) == 2) {
    const auto parts = py::reinterpret_borrow<py::tuple>(from);
    const Vector3 p = vector3(parts[0], name);
    if (!is_finite(p)) reject(name, "position is not finite");
    const Doubles q = doubles(parts[1], name, {4}, "(4,)");
    return {rotation_from_quaternion(q.data()[0], q.data()[1], q.data()[2], q.data()[3], name), p};
  }
  return pose_from_rows(doubles(from, name, {4, 4}, "(4, 4)").data(), name);
}

void write_rows(const Pose& X, double* rows) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) rows[4 * row + column] = X.R(row, column);
    rows[4 * row + 3] = X.p(row);
  }
  std::fill_n(rows + 12, 3, 0.0);
  rows[15] = 1.0;
}

py::dtype record_dtype(std::initializer_list<Field> fields, std::size_t size) {
  py::list names, formats, offsets;
  for (const Field& field : fields) {
    names.append(field.name);
    formats.append(field.format);
    offsets.append(field.offset);
  }
  return {std::move(names), std::move(formats), std::move(offsets), static_cast<py::ssize_t>(size)};
}

}  // namespace touchstone::python
