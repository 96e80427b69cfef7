#pragma once

#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "touchstone/adapters/mujoco/engine.hpp"
#include "touchstone/adapters/mujoco/geom_pose.hpp"
#include "touchstone/adapters/mujoco/xml_model.hpp"
#include "touchstone/contact_core/geometry/hexahedron.hpp"

namespace touchstone::test {

/// A geom by its content.
struct GeomText {
  bool is_box;
  std::string numbers;  ///< half sizes, or vertices
};

inline std::string joined(std::span<const Vector3> points) {
  std::ostringstream out;
  out.precision(17);
  for (const Vector3& p : points) out << p.x() << ' ' << p.y() << ' ' << p.z() << ' ';
  return out.str();
}
inline GeomText box(double x, double y, double z) {
  const Vector3 half(0.5 * x, 0.5 * y, 0.5 * z);
  return {true, joined({&half, 1})};
}
inline GeomText mesh(std::span<const Vector3> vertices) { return {false, joined(vertices)}; }

/// Free bodies of one geom each, placed without rounding, and asked for contacts through mj_collision.
class CollisionScene {
 public:
  explicit CollisionScene(const std::vector<GeomText>& geoms, double margin = 0.0) {
    std::ostringstream assets, bodies;
    bodies.precision(17);
    for (std::size_t i = 0; i < geoms.size(); ++i) {
      const std::string mesh_name = "mesh" + std::to_string(i);
      if (!geoms[i].is_box)
        assets << "<mesh name=\"" << mesh_name << "\" vertex=\"" << geoms[i].numbers << "\"/>";
      bodies << "<body><freejoint/><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/><geom margin=\""
             << margin << '"'
             << (geoms[i].is_box ? " type=\"box\" size=\"" + geoms[i].numbers
                                 : " type=\"mesh\" mesh=\"" + mesh_name)
             << "\"/></body>";
    }
    model = mujoco::load_model("<mujoco><size nconmax=\"5000\" njmax=\"100\"/><asset>" + assets.str() +
                               "</asset><worldbody>" + bodies.str() + "</worldbody></mujoco>");
    data.reset(mj_makeData(model.get()));
    mj_kinematics(model.get(), data.get());
  }

  void place(int i, const Pose& X_WS) {
    const Pose X_SG = mujoco::pose_in_solid(*model, i).value();
    mujoco::place(*data, i, model->geom_type[i] == mjGEOM_BOX ? X_WS : compose(X_WS, X_SG));
  }

  Pose pose(int i) const {
    Pose X;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) X.R(r, c) = data->geom_xmat[9 * i + 3 * r + c];
    X.p = {data->geom_xpos[3 * i], data->geom_xpos[3 * i + 1], data->geom_xpos[3 * i + 2]};
    return X;
  }

  /// As MuJoCo stores it. A mesh of 8 vertices.
  Hexahedron solid(int i) const {
    if (model->geom_type[i] == mjGEOM_BOX) {
      const mjtNum* half = model->geom_size + 3 * i;
      return Hexahedron::from_size({2 * half[0], 2 * half[1], 2 * half[2]});
    }
    const float* v = model->mesh_vert + 3 * model->mesh_vertadr[model->geom_dataid[i]];
    std::array<Vector3, 8> vertices;
    for (int k = 0; k < 8; ++k) vertices[k] = Vector3(v[3 * k], v[3 * k + 1], v[3 * k + 2]);
    return Hexahedron::from_vertices(vertices, WarpPolicy::accept);
  }

  std::span<const mjContact> collide() {
    mj_collision(model.get(), data.get());
    return {data->contact, static_cast<std::size_t>(data->ncon)};
  }

  mujoco::ModelHandle model;
  mujoco::DataHandle data;
};

/// One pair, through MuJoCo's table: without its bounding volumes, which know less than its checks.
inline std::vector<mujoco::EngineContact> collide_pair(CollisionScene& scene) {
  const int* const type = scene.model->geom_type;
  const bool swapped = type[0] > type[1];
  std::vector<mujoco::EngineContact> contacts(mjMAXCONPAIR);
  const mjfCollision check = mjCOLLISIONFUNC[type[swapped]][type[!swapped]];
  contacts.resize(static_cast<std::size_t>(
      check(scene.model.get(), scene.data.get(), contacts.data(), swapped, !swapped, 0.0)));
  return contacts;
}

template <class Contacts>
std::optional<double> least_distance(const Contacts& contacts) {
  std::optional<double> least;
  for (const auto& contact : contacts)
    if (!least || contact.dist < *least) least = contact.dist;
  return least;
}

}  // namespace touchstone::test
