#include "touchstone/adapters/mjcf/mjcf.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <memory>

#include "touchstone/adapters/mujoco/engine.hpp"
#include "touchstone/adapters/robots/builder.hpp"
#include "touchstone/adapters/robots/mesh_units.hpp"
#include "touchstone/adapters/robots/text_file.hpp"
#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::mjcf {
namespace {

/// Keeps MuJoCo's warnings for as long as it lives: else it writes them to a file in the working folder.
class WarningLog {
 public:
  WarningLog() : before_(mju_user_warning) {
    warnings().clear();
    mju_user_warning = [](const char* text) { warnings().emplace_back(text); };
  }
  WarningLog(const WarningLog&) = delete;
  WarningLog& operator=(const WarningLog&) = delete;
  ~WarningLog() { mju_user_warning = before_; }
  static std::vector<std::string>& warnings() {
    static std::vector<std::string> kept;
    return kept;
  }

 private:
  void (*before_)(const char*);
};

Vector3 vector(const mjtNum* v) { return {v[0], v[1], v[2]}; }

Pose pose(const mjtNum* p, const mjtNum* q) {
  return {rotation_from_quaternion(q[0], q[1], q[2], q[3], "quaternion of a body or geom"), vector(p)};
}

Pose shift(const Vector3& p) { return {Matrix3::Identity(), p}; }

struct Reader {
  const mjModel& model;
  const std::string& source;
  const RobotOptions& options;
  Robot robot = {};
  RobotBuilder builder{robot, options, source};
  std::vector<std::size_t> link_of = {};                 // by body
  std::vector<Vector3> anchor = {};                      // by body: its link's origin in its frame
  std::vector<std::vector<std::string>> solids_of = {};  // by geom: `link/solid`

  std::string name(mjtObj kind, int id, const char* otherwise) const {
    const char* given = mj_id2name(&model, kind, id);
    return given && *given ? given : otherwise + std::to_string(id);
  }
  std::string body_name(int body) const { return name(mjOBJ_BODY, body, "body."); }

  void read() {
    robot.mechanism.name = model.names && *model.names ? model.names : "robot";
    link_of.resize(model.nbody);
    anchor.assign(model.nbody, Vector3::Zero());
    solids_of.resize(model.ngeom);
    for (int body = 0; body < model.nbody; ++body) take_body(body);
    for (int i = 0; i < model.nexclude; ++i) take_exclude(model.exclude_signature[i]);
    take_bits();
    if (model.neq > 0)
      robot.notes.push_back(source + ": " + std::to_string(model.neq) +
                            " equality constraints are not read: their joints move by themselves");
  }

  void take_body(int body) {
    const int joints = model.body_jntnum[body];
    if (body > 0 && joints == 0) add_joint(body, -1, previous_of(body), X_parent(body), body_name(body));
    for (int i = 0; i < joints; ++i) {
      const int joint = model.body_jntadr[body] + i;
      const bool is_last = i + 1 == joints;
      const std::string child =
          is_last ? body_name(body) : body_name(body) + "." + name(mjOBJ_JOINT, joint, "joint.");
      const Vector3 at = vector(model.jnt_pos + 3 * joint);
      const Pose X = i == 0 ? compose(X_parent(body), shift(at)) : shift(at - anchor[body]);
      add_joint(body, joint, i == 0 ? previous_of(body) : robot.mechanism.links.back().name, X, child);
      anchor[body] = at;
    }
    link_of[body] = builder.add_link(body_name(body));
    take_mass(body);
    for (int i = 0; i < model.body_geomnum[body]; ++i) take_geom(body, model.body_geomadr[body] + i);
  }

  std::string previous_of(int body) const {
    return robot.mechanism.links[link_of[model.body_parentid[body]]].name;
  }
  /// The body's frame in its parent's link.
  Pose X_parent(int body) const {
    return compose(shift(-anchor[model.body_parentid[body]]),
                   pose(model.body_pos + 3 * body, model.body_quat + 4 * body));
  }

  void add_joint(int body, int joint, const std::string& parent, const Pose& X_PJ, const std::string& child) {
    JointDescription out;
    out.parent = parent;
    out.child = child;
    out.X_PJ = rigid_frame(X_PJ);
    out.name = joint < 0 ? body_name(body) + ".fixed" : name(mjOBJ_JOINT, joint, "joint.");
    if (joint >= 0) {
      const int type = model.jnt_type[joint];
      if (type != mjJNT_HINGE && type != mjJNT_SLIDE)
        throw InputError(source + ": joint '" + out.name + "' of body '" + body_name(body) +
                         "': " + (type == mjJNT_FREE ? "free" : "ball") + " joints are not supported");
      out.kind = type == mjJNT_HINGE ? JointKind::revolute : JointKind::prismatic;
      out.axis_J = vector(model.jnt_axis + 3 * joint);
      out.axis_J = out.axis_J / norm(out.axis_J);
      const double ref = model.qpos0[model.jnt_qposadr[joint]];
      if (model.jnt_limited[joint]) {
        out.lower = model.jnt_range[2 * joint] - ref;
        out.upper = model.jnt_range[2 * joint + 1] - ref;
      }
      robot.mechanism.reference.push_back(std::clamp(0.0, out.lower, std::max(out.lower, out.upper)));
      // Links between a body's joints are there before the body's own.
      if (child != body_name(body)) {
        robot.mechanism.joints.push_back(out);
        builder.add_link(child);
        return;
      }
    }
    robot.mechanism.joints.push_back(out);
  }

  void take_mass(int body) {
    const Pose X_BI = pose(model.body_ipos + 3 * body, model.body_iquat + 4 * body);
    Matrix3 inertia = Matrix3::Zero();
    for (int i = 0; i < 3; ++i) inertia(i, i) = model.body_inertia[3 * body + i];
    const Vector3 centre = X_BI.p - anchor[body];
    robot.mechanism.links[link_of[body]].mass = {model.body_mass[body], centre, turned(X_BI.R, inertia),
                                                 centre};
  }

  bool can_touch(int geom) const {
    return model.geom_contype[geom] != 0 || model.geom_conaffinity[geom] != 0;
  }

  void take_geom(int body, int geom) {
    if (!can_touch(geom)) return;  // to be looked at
    if (body == 0 && model.geom_type[geom] == mjGEOM_PLANE) {
      robot.notes.push_back(source + ": plane '" + name(mjOBJ_GEOM, geom, "geom.") +
                            "' of the world is left out: a floor is the scene's, as a box");
      return;
    }
    const std::string geom_name = name(mjOBJ_GEOM, geom, "geom.");
    const std::string label = source + ": body '" + body_name(body) + "', geom '" + geom_name + "'";
    const Pose X_LS = rigid_frame(
        compose(shift(-anchor[body]), pose(model.geom_pos + 3 * geom, model.geom_quat + 4 * geom)));
    const std::vector<PlacedHexahedron>& solids = robot.mechanism.links[link_of[body]].solids;
    const std::size_t before = solids.size();
    add_shape({link_of[body], geom_name, label, X_LS}, geom);
    for (std::size_t i = before; i < solids.size(); ++i)
      solids_of[geom].push_back(body_name(body) + "/" + solids[i].name);
  }

  void add_shape(const ShapePlace& place, int geom) {
    const Vector3 size = vector(model.geom_size + 3 * geom);
    switch (model.geom_type[geom]) {
      case mjGEOM_BOX:
        return builder.add_box(place, 2.0 * size);
      case mjGEOM_SPHERE:
        return builder.add_sphere(place, size.x());
      case mjGEOM_CAPSULE:
        return builder.add_capsule(place, size.x(), 2.0 * size.y());
      case mjGEOM_CYLINDER:
        return builder.add_cylinder(place, size.x(), 2.0 * size.y());
      case mjGEOM_ELLIPSOID:
        return builder.add_ellipsoid(place, size);
      case mjGEOM_MESH:
        return builder.add_mesh(place, mesh_of(model.geom_dataid[geom]),
                                "'" + name(mjOBJ_MESH, model.geom_dataid[geom], "mesh.") + "'");
      default:
        throw InputError(place.label + ": a " +
                         (model.geom_type[geom] == mjGEOM_PLANE ? "plane" : "height field") +
                         " is no hexahedra: give a box, or contype and conaffinity 0");
    }
  }

  TriangleMesh mesh_of(int id) const {
    TriangleMesh mesh;
    const float* vertices = model.mesh_vert + 3 * model.mesh_vertadr[id];
    for (int i = 0; i < model.mesh_vertnum[id]; ++i)
      mesh.vertices.emplace_back(vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]);
    const int* faces = model.mesh_face + 3 * model.mesh_faceadr[id];
    for (int i = 0; i < model.mesh_facenum[id]; ++i)
      mesh.triangles.push_back({static_cast<std::uint32_t>(faces[3 * i]),
                                static_cast<std::uint32_t>(faces[3 * i + 1]),
                                static_cast<std::uint32_t>(faces[3 * i + 2])});
    return mesh;
  }

  /// mjmodel.h: (body1 + 1) << 16 + body2 + 1.
  void take_exclude(int signature) {
    const int first = (signature >> 16) - 1, second = (signature & 0xffff) - 1;
    if (first < 0 || second < 0 || first >= model.nbody || second >= model.nbody)
      throw InputError(source + ": an excluded pair names no bodies");
    exempt(body_name(first), body_name(second));
  }

  /// As MuJoCo: two geoms are checked if one's contype meets the other's conaffinity.
  void take_bits() {
    for (int a = 0; a < model.ngeom; ++a)
      for (int b = a + 1; b < model.ngeom; ++b) {
        const bool meet = (model.geom_contype[a] & model.geom_conaffinity[b]) != 0 ||
                          (model.geom_contype[b] & model.geom_conaffinity[a]) != 0;
        if (meet || model.geom_bodyid[a] == model.geom_bodyid[b]) continue;
        for (const std::string& first : solids_of[a])
          for (const std::string& second : solids_of[b]) exempt(first, second);
      }
  }

  void exempt(const std::string& first, const std::string& second) {
    robot.mechanism.exempt_pairs.push_back({first, second});
  }
};

}  // namespace

Robot load_robot(const std::filesystem::path& file, const RobotOptions& options) {
  mujoco::require_version();
  const std::string source = file.string();
  read_robot_text(file);  // the same words for a file that is not there
  const WarningLog log;
  std::array<char, 2000> error{};
  const std::unique_ptr<mjModel, void (*)(mjModel*)> model(
      mj_loadXML(source.c_str(), nullptr, error.data(), static_cast<int>(error.size())), mj_deleteModel);
  if (!model) throw InputError(source + ": " + one_line(error.data()));
  Reader reader{*model, source, options};
  reader.read();
  for (const std::string& warning : WarningLog::warnings())
    reader.robot.notes.push_back(source + ": " + one_line(warning));
  check_mesh_units(source, options, reader.robot);
  return std::move(reader.robot);
}

}  // namespace touchstone::mjcf
