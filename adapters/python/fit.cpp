#include "touchstone/contact_core/fit/fit.hpp"

#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include "touchstone/adapters/python/arrays.hpp"
#include "touchstone/adapters/python/bindings.hpp"
#include "touchstone/contact_core/fit/stl_file.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::python {
namespace {

TriangleMesh mesh_from(const py::object& vertices, const py::object& triangles) {
  const Doubles points = doubles(vertices, "vertices", {-1, 3}, "(n, 3)");
  TriangleMesh mesh;
  for (py::ssize_t i = 0; i < points.shape(0); ++i)
    mesh.vertices.emplace_back(points.at(i, 0), points.at(i, 1), points.at(i, 2));
  const auto given = py::array::ensure(triangles);
  if (!given || (given.dtype().kind() != 'i' && given.dtype().kind() != 'u'))
    throw py::type_error("triangles: no array of integers");
  const auto corners = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(given);
  if (corners.ndim() != 2 || corners.shape(1) != 3)
    reject("triangles", "shape is " + std::string(py::str(given.attr("shape"))) + ", must be (m, 3)");
  for (py::ssize_t i = 0; i < corners.shape(0); ++i) {
    auto& triangle = mesh.triangles.emplace_back();
    for (py::ssize_t k = 0; k < 3; ++k) {
      const std::int64_t index = corners.at(i, k);
      if (index < 0 || index >= points.shape(0))
        reject("triangle " + std::to_string(i), "vertex " + std::to_string(index) + " is none");
      triangle[static_cast<std::size_t>(k)] = static_cast<std::uint32_t>(index);
    }
  }
  validate(mesh);
  return mesh;
}

void bind_mesh(py::module_& module) {
  py::class_<TriangleMesh>(module, "Mesh", "Triangles, counter-clockwise seen from outside; metres.")
      .def(py::init(&mesh_from), py::arg("vertices"), py::arg("triangles"),
           "vertices: (n, 3) [m]; triangles: (m, 3) indices.")
      .def_property_readonly(
          "vertices", [](const TriangleMesh& self) { return frozen(array_of(std::span(self.vertices))); },
          "(n, 3) [m]. Not writeable.")
      .def_property_readonly(
          "triangles",
          [](const TriangleMesh& self) {
            const auto* first = self.triangles.empty() ? nullptr : self.triangles[0].data();
            return frozen(py::array_t<std::uint32_t>(
                {static_cast<py::ssize_t>(self.triangles.size()), py::ssize_t{3}}, first));
          },
          "(m, 3) uint32, indices of vertices. Not writeable.")
      .def(
          "welded", [](const TriangleMesh& self) { return weld(self); },
          "One vertex a place; nothing moves.");
  module.def(
      "read_stl", &read_stl, py::arg("path"), py::arg("scale"), py::call_guard<py::gil_scoped_release>(),
      "Reads an STL file, binary or ASCII. scale: metres a unit of the file, 1e-3 for millimetres. Raises "
      "InputError with the file and the triangle or line.");
}

/// Called by a long search now and then: Ctrl-C ends it.
std::function<void(std::string_view, double)> progress_of(const py::object& callback) {
  return [callback](std::string_view stage, double share) {
    const py::gil_scoped_acquire locked;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!callback.is_none()) callback(std::string(stage), share);
  };
}

Fit fit_mesh(const TriangleMesh& mesh, double over, const std::vector<py::tuple>& regions, int repairs,
             std::size_t count, const py::object& progress) {
  FitOptions options;
  options.over = over;
  options.repairs = repairs;
  options.progress = progress_of(progress);
  for (const py::tuple& region : regions)  // (name, least, most, over)
    options.regions.push_back({region[0].cast<std::string>(),
                               {vector3(region[1], "region's least"), vector3(region[2], "region's most")},
                               region[3].cast<double>()});
  const py::gil_scoped_release unlocked;
  return count > 0 ? fit_count(mesh, count, options) : fit_hexahedra(mesh, options);
}

py::array hexahedra_of(const py::object& self) {
  const auto& list = self.cast<const Fit&>().hexahedra;
  const py::dtype dtype = record_dtype({{"vertices", "(8,3)f8", offsetof(FittedHexahedron, vertices)},
                                        {"excess", "f8", offsetof(FittedHexahedron, excess)},
                                        {"farthest", "(3,)f8", offsetof(FittedHexahedron, farthest)}},
                                       sizeof(FittedHexahedron));
  return view(dtype, {static_cast<py::ssize_t>(list.size())}, list.data(), self, false);
}

}  // namespace

void bind_fit(py::module_& module) {
  bind_mesh(module);
  py::class_<Fit>(module, "Fit", "Hexahedra that cover a mesh.")
      .def_property_readonly("hexahedra", &hexahedra_of,
                             "(k,) records: vertices (8, 3), excess and farthest (3,) [m]. Not writeable.")
      .def_readonly("excess", &Fit::excess, "No point of the cover is farther from the solid [m].")
      .def_readonly("region_excess", &Fit::region_excess,
                    "The same of the cover's points in each region [m].")
      .def_readonly("pieces", &Fit::pieces, "Pieces that the solid was cut into while looking.")
      .def(
          "tree",
          [](const Fit& self, const std::string& name) {
            return std::make_shared<HexahedronTree>(make_tree(self, name));
          },
          py::arg("name") = "object", "The cover as an object; hexahedra are named h0, h1 ...")
      .def("__len__", [](const Fit& self) { return self.hexahedra.size(); });
  module.def(
      "fit", &fit_mesh, py::arg("mesh"), py::arg("over"), py::arg("regions") = std::vector<py::tuple>{},
      py::arg("repairs") = 60, py::arg("count") = 0, py::arg("progress") = py::none(),
      "Covers a mesh by few hexahedra, none of whose points is farther than `over` [m] from the solid. "
      "regions: (name, least (3,), most (3,), over) boxes with an error of their own. count: at most so "
      "many, `over` is where the search begins; 0: as `over` takes. progress(stage, share) is called now "
      "and then.");
}

}  // namespace touchstone::python
