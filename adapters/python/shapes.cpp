#include <pybind11/stl.h>

#include "touchstone/adapters/python/bindings.hpp"
#include "touchstone/adapters/python/poses.hpp"
#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::python {
namespace {

WarpPolicy warp_policy(const std::string& name) {
  if (name == "refuse") return WarpPolicy::refuse;
  if (name == "within_tolerance") return WarpPolicy::within_tolerance;
  if (name == "accept") return WarpPolicy::accept;
  reject("warp", "'" + name + "' is none of refuse, within_tolerance, accept");
}

Hexahedron from_corners(const py::object& vertices, const std::string& warp, const std::string& name) {
  const Doubles corners = doubles(vertices, "vertices", {-1, 3}, "(8, 3)");
  std::vector<Vector3> points;
  for (py::ssize_t i = 0; i < corners.shape(0); ++i)
    points.emplace_back(corners.at(i, 0), corners.at(i, 1), corners.at(i, 2));
  return Hexahedron::from_vertices(points, warp_policy(warp), name);
}

Doubles face_planes(const Hexahedron& solid) {
  Doubles made({6, 4});
  for (int face = 0; face < 6; ++face) {
    const Plane& plane = solid.face_plane(face);
    for (int i = 0; i < 3; ++i) made.mutable_at(face, i) = plane.normal(i);
    made.mutable_at(face, 3) = plane.offset;
  }
  return made;
}

template <std::size_t kRows, std::size_t kColumns>
py::array index_table(const std::array<std::array<std::uint8_t, kColumns>, kRows>& table) {
  return frozen(py::array_t<std::uint8_t>({kRows, kColumns}, table.front().data()));
}

void bind_constructors(py::class_<Hexahedron>& hexahedron) {
  hexahedron
      // Hexahedra.
      .def(py::init(&from_corners), py::arg("vertices"), py::arg("warp") = "within_tolerance",
           py::arg("name") = "hexahedron",
           "vertices: (8, 3) [m]. Vertex i has bits (x y z) = (i>>2 & 1, i>>1 & 1, i & 1); other orders of a "
           "convex hexahedron are understood. warp: which bent faces are taken, 'refuse', 'within_tolerance' "
           "or 'accept'. Raises InputError naming `name`, the face or vertex and the figure.")
      .def_static(
          "box",
          [](const py::object& size, const std::string& name) {
            return Hexahedron::from_size(vector3(size, "size"), name);
          },
          py::arg("size"), py::arg("name") = "box", "A box about its origin; size: (3,) full sides [m].")
      // Rounded solids.
      .def_static("sphere", &Hexahedron::sphere, py::arg("radius"), py::arg("name") = "sphere",
                  "A sphere about its origin: a rounded solid.")
      .def_static("capsule", &Hexahedron::capsule, py::arg("radius"), py::arg("length"),
                  py::arg("name") = "capsule",
                  "All points within radius of a segment of this length along z, about its origin [m].")
      .def_static(
          "rounded_box",
          [](const py::object& core_size, double radius, const std::string& name) {
            return Hexahedron::rounded_box(vector3(core_size, "core_size"), radius, name);
          },
          py::arg("core_size"), py::arg("radius"), py::arg("name") = "rounded box",
          "All points within radius of a box about its origin; core_size: (3,) full sides, 0 allowed [m].")
      .def("padded", &Hexahedron::padded, py::arg("radius"), py::arg("name") = "hexahedron",
           "This solid grown by a radius all round.");
}

void bind_figures(py::class_<Hexahedron>& hexahedron) {
  hexahedron
      .def_property_readonly("radius", &Hexahedron::radius,
                             "How far a rounded solid reaches beyond its vertices' hull [m]; else 0.")
      .def_property_readonly(
          "vertices", [](const Hexahedron& self) { return frozen(array_of(std::span(self.vertices()))); },
          "(8, 3) [m]. Not writeable.")
      .def_property_readonly("is_box", &Hexahedron::is_box,
                             "Whether it is a box along its axes, about its origin.")
      .def_property_readonly(
          "half_extents", [](const Hexahedron& self) { return frozen(array_of(self.half_extents())); },
          "(3,) [m] of a box; else 0. Not writeable.")
      .def_property_readonly("is_warped", &Hexahedron::is_warped,
                             "Whether a face is out of plane by more than 32 eps times the size.")
      .def_property_readonly("out_of_plane", &Hexahedron::out_of_plane, "How far faces are bent [m].")
      .def_property_readonly("size", &Hexahedron::size, "Largest distance of two vertices [m].")
      .def_property_readonly(
          "face_planes", [](const Hexahedron& self) { return frozen(face_planes(self)); },
          "(6, 4): outward unit normal and offset d [m] of n . p + d = 0. Not writeable.")
      .def("__repr__", [](const Hexahedron& self) {
        return "<touchstone.Hexahedron: " + std::string(self.is_box() ? "box" : "convex") + ", size " +
               figure(self.size()) + " m>";
      });
}

void bind_pickling(py::class_<Hexahedron>& hexahedron) {
  hexahedron.def(py::pickle(
      [](const Hexahedron& self) {
        return py::make_tuple(self.is_box(), array_of(self.half_extents()),
                              array_of(std::span(self.vertices())), self.radius());
      },
      [](const py::tuple& state) {
        const double radius = state[3].cast<double>();
        const bool is_box = state[0].cast<bool>();
        const Vector3 size = is_box ? Vector3(2.0 * vector3(state[1], "half_extents")) : Vector3::Zero();
        if (is_box && radius > 0.0) return Hexahedron::rounded_box(size, radius, "pickled box");
        if (is_box) return Hexahedron::from_size(size, "pickled box");
        const Hexahedron core = from_corners(state[2], "accept", "pickled hexahedron");
        return radius > 0.0 ? core.padded(radius, "pickled hexahedron") : core;
      }));
}

void bind_hexahedron(py::module_& module) {
  py::class_<Hexahedron> hexahedron(module, "Hexahedron",
                                    "A convex hexahedron in its own frame: the hull of eight vertices [m].");
  bind_constructors(hexahedron);
  bind_figures(hexahedron);
  bind_pickling(hexahedron);
  hexahedron.attr("FACE_VERTICES") = index_table(Hexahedron::kFaceVertices);
  hexahedron.attr("EDGE_VERTICES") = index_table(Hexahedron::kEdgeVertices);
}

PlacedHexahedron placed(const py::handle& from, std::size_t i) {
  const std::string nth = "h" + std::to_string(i);
  if (py::isinstance<Hexahedron>(from)) return {nth, from.cast<const Hexahedron&>(), {}};
  const auto parts = py::reinterpret_borrow<py::sequence>(from);
  if (!py::isinstance<py::sequence>(from) || py::len(parts) != 3 || !py::isinstance<Hexahedron>(parts[1]))
    throw py::type_error("solids: an entry is neither a Hexahedron nor (name, Hexahedron, pose)");
  const auto name = parts[0].cast<std::string>();
  return {name, parts[1].cast<const Hexahedron&>(), pose(parts[2], name.c_str())};
}

std::shared_ptr<HexahedronTree> make_tree_of(const py::iterable& solids, const std::string& name) {
  std::vector<PlacedHexahedron> list;
  for (const py::handle& solid : solids) list.push_back(placed(solid, list.size()));
  return std::make_shared<HexahedronTree>(std::move(list), name);
}

py::array nodes_of(const py::object& self) {
  using Node = HexahedronTree::Node;
  const auto& nodes = self.cast<const HexahedronTree&>().nodes();
  const py::dtype dtype = record_dtype({{"centre_O", "(3,)f8", offsetof(Node, sphere_O.centre)},
                                        {"radius", "f8", offsetof(Node, sphere_O.radius)},
                                        {"left", "i4", offsetof(Node, left)},
                                        {"right", "i4", offsetof(Node, right)},
                                        {"solid", "i4", offsetof(Node, solid)}},
                                       sizeof(Node));
  return view(dtype, {static_cast<py::ssize_t>(nodes.size())}, nodes.data(), self, false);
}

void bind_tree(py::module_& module) {
  py::class_<HexahedronTree, std::shared_ptr<HexahedronTree>>(
      module, "HexahedronTree", "One rigid object's hexahedra under a tree of bounding spheres.")
      // Making.
      .def(py::init(&make_tree_of), py::arg("solids"), py::arg("name") = "object",
           "solids: Hexahedron (at the object's origin, named h0, h1 ...) or (name, Hexahedron, pose X_OS), "
           "pose: None, (4, 4), or (position, quaternion wxyz).")
      // The hexahedra and the tree over them.
      .def_property_readonly("name", &HexahedronTree::name, "The object's.")
      .def_property_readonly(
          "solids",
          [](const HexahedronTree& self) {
            py::list made;
            for (const PlacedHexahedron& of : self.solids())
              made.append(py::make_tuple(of.name, of.solid, array_of(of.X_OS)));
            return made;
          },
          "List of (name, Hexahedron, X_OS (4, 4)).")
      .def_property_readonly(
          "nodes", &nodes_of,
          "(k,) records: centre_O (3,) and radius [m], left, right, solid; -1: none. Node 0 "
          "is the root. Not writeable.")
      .def(
          "world_poses",
          [](const HexahedronTree& self, const py::object& X_WO) {
            std::vector<Pose> made(self.solids().size());
            find_global_positions(self, pose(X_WO, "X_WO"), made);
            return std::make_unique<Poses>(std::move(made));
          },
          py::arg("X_WO"), "Poses X_WS = X_WO X_OS of its hexahedra.")
      .def("__len__", [](const HexahedronTree& self) { return self.solids().size(); });
}

}  // namespace

void bind_shapes(py::module_& module) {
  bind_hexahedron(module);
  bind_tree(module);
}

}  // namespace touchstone::python
