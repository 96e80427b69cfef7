#include "touchstone/adapters/mujoco_dynamics/mujoco_model.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "touchstone/adapters/mujoco_dynamics/mujoco_joints.hpp"
#include "touchstone/contact_core/geometry/quaternion.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::physics::mujoco_dynamics {
namespace {

/// MuJoCo takes no body without inertia about an axis.
constexpr double kThinnest = 1e-6;
/// Contacts a body that there is room for; fewer where the tables would not fit. (A thousand boxes
/// in a pile had 3 to 4 a body with any engine's check.)
constexpr std::size_t kContactsABody = 12, kLeastABody = 5, kContactsBesides = 200;
constexpr double kMostBytes = 1.9e9;  // MuJoCo 2.2 counts them in an int
/// Newton's method factors a dense matrix of all degrees of freedom, which takes a minute for 6 000 of them,
/// and its default stack would be 13 GB there: beyond this many, conjugate gradients.
constexpr std::size_t kMostForNewton = 600;
/// From 2.3 on MuJoCo takes contacts and rows as they come from one arena, of this size. A contact of a pile
/// of 400 boxes took 3.6 kB of it with its rows and the solver's share (3.10).
constexpr bool kHasArena = mjVERSION_HEADER >= 230;
constexpr std::size_t kArenaBytes = 64000000, kArenaBytesAContact = 8000;

/// The tables of a model: MuJoCo allocates them whole, rows times columns and rows times rows.
struct Tables {
  std::size_t contacts, rows, columns;

  Tables(const EngineScene& scene, std::size_t a_body) {
    std::size_t moving = 0;
    for (const EngineScene::Body& body : scene.bodies()) moving += body.kind == ContactSide::body ? 1 : 0;
    contacts = a_body * moving + kContactsBesides;
    rows = 3 * contacts + 2 * scene.joints().size() + 9 * scene.body_joints().size();
    columns = 6 * moving + scene.joints().size();
  }
  /// Jacobian and its transpose, A + R, each with column indices.
  double bytes() const {
    const auto r = static_cast<double>(rows), c = static_cast<double>(columns);
    return 24.0 * r * c + 12.0 * r * r;
  }
};

/// @throws InputError: more bodies than fit.
Tables tables_for(const EngineScene& scene) {
  if (kHasArena) return {scene, kContactsABody};
  for (std::size_t a_body = kContactsABody; a_body >= kLeastABody; --a_body)
    if (const Tables tables(scene, a_body); tables.bytes() <= kMostBytes) return tables;
  const Tables least(scene, kLeastABody);
  throw InputError("engine 'mujoco': unsupported: " + std::to_string(least.columns / 6) +
                   " free bodies (its constraint tables take no more than 2 GB)");
}

class Writer {
 public:
  explicit Writer(const EngineScene& scene) : scene_(scene), tables_(tables_for(scene)) {
    out_.precision(17);
  }

  std::string text() {
    const DynamicScene& from = scene_.scene();
    out_ << "<mujoco><compiler angle='radian' boundmass='0' boundinertia='0'/><option timestep='" << from.step
         << "' cone='elliptic' gravity='" << Triple{from.gravity_W} << "'"
         << (is_large() ? " solver='CG'" : "") << "/>";
    write_size();
    write_meshes();
    out_ << "<worldbody>";
    for (std::size_t b = 0; b < scene_.bodies().size(); ++b)
      if (scene_.bodies()[b].kind != ContactSide::link) write_body(b, {}, nullptr, 0);
    write_links(EngineScene::kNone, {});
    out_ << "</worldbody>";
    write_exempt();
    write_body_joints();
    out_ << "</mujoco>";
    return out_.str();
  }

 private:
  struct Triple {
    const Vector3& v;
    friend std::ostream& operator<<(std::ostream& out, const Triple& t) {
      return out << t.v.x() << ' ' << t.v.y() << ' ' << t.v.z();
    }
  };

  void write_pose(const Pose& X) {
    const Quaternion q = quaternion_of(X.R);
    out_ << " pos='" << Triple{X.p} << "' quat='" << q.w << ' ' << Triple{q.v} << "'";
  }

  bool is_large() const { return tables_.columns > kMostForNewton; }

  void write_size() {
    if (kHasArena) {
      out_ << "<size memory='" << kArenaBytes + kArenaBytesAContact * tables_.contacts << "'/>";
      return;
    }
    out_ << "<size njmax='" << tables_.rows << "' nconmax='" << tables_.contacts << "'";
    if (is_large()) out_ << " nstack='" << 1000000 + 200 * (tables_.rows + tables_.columns) << "'";
    out_ << "/>";
  }

  void write_meshes() {
    out_ << "<asset>";
    for (std::size_t s = 0; s < scene_.solids().size(); ++s) {
      const Hexahedron& solid = *scene_.solids()[s].solid;
      if (solid.is_box()) continue;
      out_ << "<mesh name='m" << s << "' vertex='";
      for (const Vector3& v : solid.vertices()) out_ << ' ' << Triple{v};
      out_ << "'/>";
    }
    out_ << "</asset>";
  }

  void write_solids(const EngineScene::Body& body) {
    for (const SolidIndex s : body.solids) {
      const EngineScene::Solid& solid = scene_.solids()[s];
      out_ << "<geom name='s" << s << "'";
      if (solid.solid->is_box())
        out_ << " type='box' size='" << Triple{solid.solid->half_extents()} << "'";
      else
        out_ << " type='mesh' mesh='m" << s << "'";
      write_pose(solid.X_BS);
      out_ << " condim='3' friction='" << scene_.surface(s).friction << " 0 0'/>";
    }
  }

  /// @param joint null: free, or on the ground
  void write_body(std::size_t index, const Pose& X_PB, const EngineScene::Joint* joint, std::size_t number) {
    const EngineScene::Body& body = scene_.bodies()[index];
    out_ << "<body name='b" << index << "'";
    write_pose(joint == nullptr ? body.X_WB : X_PB);
    out_ << ">";
    if (body.kind == ContactSide::body) out_ << "<freejoint name='f" << index << "'/>";
    if (joint != nullptr) write_joint(*joint, body, number);
    if (body.kind != ContactSide::ground) {
      const double least = kThinnest * std::max({body.moments.x(), body.moments.y(), body.moments.z()});
      out_ << "<inertial pos='0 0 0' mass='" << body.mass << "' diaginertia='"
           << Triple{Vector3(body.moments.cwiseMax(least))} << "'/>";
    }
    write_solids(body);
    if (joint != nullptr) write_links(index, body.X_WB);
    out_ << "</body>";
  }

  void write_joint(const EngineScene::Joint& joint, const EngineScene::Body& child, std::size_t number) {
    const SceneJoint& source = *joint.source;
    const Pose X_BW = inverse(child.X_WB);
    out_ << "<joint name='j" << number << "' type='"
         << (source.kind == JointKind::revolute ? "hinge" : "slide") << "' pos='"
         << Triple{transform(X_BW, source.p_W)} << "' axis='" << Triple{rotate(X_BW.R, source.axis_W)}
         << "' ref='" << source.value << "'";
    constexpr double kFar = 1e6;  // one of the two stops alone: the other is as far as none
    if (std::isfinite(source.lower) || std::isfinite(source.upper))
      out_ << " limited='true' range='" << std::max(source.lower, -kFar) << ' '
           << std::min(source.upper, kFar) << "'";
    // A brake as hard as joints between bodies: with MuJoCo's default softness it lets its load sink.
    out_ << " solreffriction='" << hardest_solref() << "' solimpfriction='" << kHardest << "'/>";
  }

  /// The links that joints hang on a body; kNone: on the ground.
  void write_links(std::size_t parent, const Pose& X_WP) {
    const auto joints = scene_.joints();
    for (std::size_t j = 0; j < joints.size(); ++j)
      if (joints[j].parent == parent)
        write_body(joints[j].child, compose(inverse(X_WP), scene_.bodies()[joints[j].child].X_WB), &joints[j],
                   j);
  }

  void write_exempt() {
    out_ << "<contact>";
    for (const auto& [a, b] : scene_.exempt_bodies())
      out_ << "<exclude body1='b" << a << "' body2='b" << b << "'/>";
    out_ << "</contact>";
  }

  /// As hard as MuJoCo holds a constraint: within two steps, at its largest impedance.
  static constexpr std::string_view kHardest = "0.9999 0.9999 0.001 0.5 2";
  std::string hardest_solref() const {
    std::ostringstream text;
    text.precision(17);
    text << 2.0 * scene_.scene().step << " 1";
    return text.str();
  }

  void write_body_joints() {
    const auto joints = scene_.body_joints();
    if (joints.empty()) return;
    out_ << "<equality>";
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const std::vector<Vector3> points = shared_points(scene_, joints[j]);
      const Pose X_CW = inverse(scene_.bodies()[joints[j].child].X_WB);
      for (std::size_t k = 0; k < points.size(); ++k) {
        out_ << "<connect name='" << connect_name(j, k) << "' body1='b" << joints[j].child << "'";
        if (joints[j].parent != EngineScene::kNone) out_ << " body2='b" << joints[j].parent << "'";
        out_ << " anchor='" << Triple{transform(X_CW, points[k])} << "' solref='" << hardest_solref()
             << "' solimp='" << kHardest << "'/>";
      }
    }
    out_ << "</equality>";
  }

  const EngineScene& scene_;
  Tables tables_;
  std::ostringstream out_;
};

}  // namespace

std::string model_text(const EngineScene& scene) { return Writer(scene).text(); }

}  // namespace touchstone::physics::mujoco_dynamics
