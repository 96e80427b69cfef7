#include "touchstone/adapters/sdf/sdf.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <string_view>

#include "touchstone/adapters/robots/builder.hpp"
#include "touchstone/adapters/robots/text_file.hpp"
#include "touchstone/contact_core/geometry/matrix3.hpp"

namespace touchstone::sdf {
namespace {

using Element = tinyxml2::XMLElement;

/// A frame of the model: where it is, in another one.
struct Frame {
  const Element* element;
  std::string in;  // empty: the model
  Pose X;
};

constexpr int kMostFrames = 1000;  // in a chain: more is a ring

struct Reader {
  const std::string& source;
  const RobotOptions& options;
  Robot robot = {};
  RobotBuilder builder{robot, options, source};
  bool axes_are_in_model = false;  ///< unless they say otherwise: until 1.4
  std::map<std::string, Frame> frames = {};
  std::map<std::string, const Element*> joint_above = {};  // by child link
  std::map<std::string, std::size_t> link_index = {};

  [[noreturn]] void fail(const Element& at, const std::string& reason) const {
    const char* name = at.Attribute("name");
    throw InputError(source + ":" + std::to_string(at.GetLineNum()) + ": <" + at.Name() + ">" +
                     (name ? " '" + std::string(name) + "'" : "") + ": " + reason);
  }

  std::string name_of(const Element& element) const {
    const char* name = element.Attribute("name");
    if (!name || !*name) fail(element, "has no name");
    return name;
  }
  static const Element* child(const Element& of, const char* name) { return of.FirstChildElement(name); }
  const Element& required(const Element& of, const char* name) const {
    const Element* found = child(of, name);
    if (!found) fail(of, std::string("has no <") + name + ">");
    return *found;
  }
  static std::string text(const Element& element) {
    const char* text = element.GetText();
    const std::string_view all = text ? text : "";
    const std::size_t first = all.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos) return "";
    return std::string(all.substr(first, all.find_last_not_of(" \t\r\n") + 1 - first));
  }

  std::vector<double> numbers(const Element& element, std::size_t count) const {
    std::vector<double> out;
    const std::string all = text(element);
    for (std::size_t at = 0; (at = all.find_first_not_of(" \t\r\n", at)) != std::string::npos;) {
      const std::size_t end = std::min(all.find_first_of(" \t\r\n", at), all.size());
      const std::size_t first = at + (all[at] == '+' ? 1 : 0);
      double value = 0.0;
      const auto [stop, error] = std::from_chars(all.data() + first, all.data() + end, value);
      if (error != std::errc{} || stop != all.data() + end || !std::isfinite(value))
        fail(element, "'" + all.substr(at, std::min<std::size_t>(end - at, 40)) + "' is no finite number");
      out.push_back(value);
      at = end;
    }
    if (out.size() != count)
      fail(element, std::to_string(out.size()) + " numbers where " + std::to_string(count) + " are expected");
    return out;
  }
  double number(const Element& of, const char* name) const { return numbers(required(of, name), 1)[0]; }
  Vector3 vector(const Element& of, const char* name) const {
    const std::vector<double> v = numbers(required(of, name), 3);
    return {v[0], v[1], v[2]};
  }

  Pose pose(const Element& of) const {
    const Element* element = child(of, "pose");
    if (!element || text(*element).empty()) return {};
    const char* format = element->Attribute("rotation_format");
    if (format && std::string_view(format) == "quat_xyzw") {
      const std::vector<double> v = numbers(*element, 7);
      return {rotation_from_quaternion(v[6], v[3], v[4], v[5], "pose"), {v[0], v[1], v[2]}};
    }
    const std::vector<double> v = numbers(*element, 6);
    Vector6 position;
    const double unit = element->BoolAttribute("degrees") ? std::numbers::pi / 180.0 : 1.0;
    for (int i = 0; i < 6; ++i) position[i] = v[i] * (i < 3 ? 1.0 : unit);
    return pose_from_position_vector(position);
  }

  void read(const Element& model) {
    robot.mechanism.name = name_of(model);
    for (const char* name : {"include", "model"})
      if (const Element* found = child(model, name)) fail(*found, "is not read: write its links out");
    each(model, "link", [&](const Element& link) { add_frame(link, ""); });
    each(model, "joint", [&](const Element& joint) {
      const std::string under = text(required(joint, "child"));
      add_frame(joint, under);
      if (!joint_above.emplace(under, &joint).second) fail(joint, "is the second above link '" + under + "'");
    });
    each(model, "frame", [&](const Element& frame) {
      const char* to = frame.Attribute("attached_to");
      add_frame(frame, to ? to : "");
    });
    bool has_world = false;
    each(model, "joint",
         [&](const Element& joint) { has_world = has_world || text(required(joint, "parent")) == "world"; });
    if (has_world) link_index["world"] = builder.add_link("world");
    each(model, "link", [&](const Element& link) { take_link(link); });
    if (robot.mechanism.links.empty()) fail(model, "has no link");
    each(model, "joint", [&](const Element& joint) { take_joint(joint); });
    hold(has_world);
  }

  template <class Action>
  static void each(const Element& of, const char* name, const Action& action) {
    for (const Element* e = child(of, name); e; e = e->NextSiblingElement(name)) action(*e);
  }

  void hold(bool has_world) {
    if (has_world) return;
    for (const LinkDescription& link : robot.mechanism.links)
      if (!joint_above.contains(link.name)) {
        robot.mechanism.base = link.name;
        return;
      }
  }

  void add_frame(const Element& element, const std::string& usually_in) {
    const Element* pose_element = child(element, "pose");
    const char* given = pose_element ? pose_element->Attribute("relative_to") : nullptr;
    std::string in = given && *given ? given : usually_in;
    if (in == "__model__" || in == "world") in.clear();
    if (!frames.emplace(name_of(element), Frame{&element, in, pose(element)}).second)
      fail(element, "its name is taken");
  }

  /// In the model.
  Pose X_M(const std::string& name, const Element& asked_by) const {
    Pose X;
    std::string at = name == "__model__" || name == "world" ? "" : name;
    for (int depth = 0; !at.empty(); ++depth) {
      const auto found = frames.find(at);
      if (found == frames.end()) fail(asked_by, "there is no frame '" + at + "'");
      if (depth > kMostFrames) fail(asked_by, "frame '" + name + "' goes round in a ring");
      X = compose(found->second.X, X);
      at = found->second.in;
    }
    return X;
  }

  /// The link's frame here: that of the joint above it, else its own.
  Pose X_ML(const std::string& link, const Element& asked_by) const {
    const auto joint = joint_above.find(link);
    return rigid_frame(X_M(joint == joint_above.end() ? link : name_of(*joint->second), asked_by));
  }

  void take_link(const Element& link) {
    const std::string name = name_of(link);
    const std::size_t index = builder.add_link(name);
    link_index[name] = index;
    const Pose X_LK = compose(inverse(X_ML(name, link)), X_M(name, link));  // K: the file's frame of the link
    if (const Element* inertial = child(link, "inertial")) take_mass(*inertial, X_LK, index);
    each(link, "collision", [&](const Element& collision) {
      const Element* at = child(collision, "pose");
      const char* relative = at ? at->Attribute("relative_to") : nullptr;
      const Pose X_KS = relative && *relative ? compose(inverse(X_M(name, link)),
                                                        compose(X_M(relative, collision), pose(collision)))
                                              : pose(collision);
      const std::string label = source + ":" + std::to_string(collision.GetLineNum()) + ": link '" + name +
                                "', collision '" + name_of(collision) + "'";
      take_shape({index, name_of(collision), label, rigid_frame(compose(X_LK, X_KS))}, collision);
    });
  }

  void take_mass(const Element& inertial, const Pose& X_LK, std::size_t index) {
    const Pose X_LI = compose(X_LK, pose(inertial));
    MassProperties mass{child(inertial, "mass") ? number(inertial, "mass") : 1.0, X_LI.p, Matrix3::Identity(),
                        X_LI.p};
    if (const Element* inertia = child(inertial, "inertia")) {
      const auto entry = [&](const char* name, double otherwise) {
        return child(*inertia, name) ? number(*inertia, name) : otherwise;
      };
      Matrix3& I = mass.inertia_L;
      I(0, 0) = entry("ixx", 1.0), I(1, 1) = entry("iyy", 1.0), I(2, 2) = entry("izz", 1.0);
      I(0, 1) = I(1, 0) = entry("ixy", 0.0), I(0, 2) = I(2, 0) = entry("ixz", 0.0);
      I(1, 2) = I(2, 1) = entry("iyz", 0.0);
    }
    mass.inertia_L = turned(X_LI.R, mass.inertia_L);
    robot.mechanism.links[index].mass = mass;
  }

  void take_shape(const ShapePlace& place, const Element& collision) {
    const Element& geometry = required(collision, "geometry");
    const Element* shape = geometry.FirstChildElement();
    if (!shape) fail(geometry, "names no shape");
    const std::string_view kind = shape->Name();
    if (kind == "box") {
      builder.add_box(place, vector(*shape, "size"));
    } else if (kind == "cylinder") {
      builder.add_cylinder(place, number(*shape, "radius"), number(*shape, "length"));
    } else if (kind == "sphere") {
      builder.add_sphere(place, number(*shape, "radius"));
    } else if (kind == "capsule") {
      builder.add_capsule(place, number(*shape, "radius"), number(*shape, "length"));
    } else if (kind == "ellipsoid") {
      builder.add_ellipsoid(place, vector(*shape, "radii"));
    } else if (kind == "mesh") {
      if (const Element* part = child(*shape, "submesh")) fail(*part, "is not read: give the part as a file");
      const Vector3 scale = child(*shape, "scale") ? vector(*shape, "scale") : Vector3(1, 1, 1);
      builder.add_mesh_file(place, text(required(*shape, "uri")), scale);
    } else if (kind != "empty") {
      fail(*shape,
           "is no shape that becomes hexahedra: known are box, cylinder, sphere, capsule, ellipsoid, mesh");
    }
  }

  void take_joint(const Element& from) {
    JointDescription joint;
    joint.name = name_of(from);
    joint.parent = text(required(from, "parent"));
    joint.child = text(required(from, "child"));
    for (const std::string* link : {&joint.parent, &joint.child})
      if (!link_index.contains(*link)) fail(from, "there is no link '" + *link + "'");
    joint.kind = kind_of(from);
    const Pose X_ML_child = X_ML(joint.child, from);
    joint.X_PJ = rigid_frame(
        joint.parent == "world" ? X_ML_child : compose(inverse(X_ML(joint.parent, from)), X_ML_child));
    if (joint.kind != JointKind::fixed) {
      take_axis(from, X_ML_child, joint);
      robot.mechanism.reference.push_back(std::clamp(0.0, joint.lower, std::max(joint.lower, joint.upper)));
    }
    robot.mechanism.joints.push_back(joint);
  }

  JointKind kind_of(const Element& joint) const {
    const char* type = joint.Attribute("type");
    const std::string_view kind = type ? type : "";
    if (kind == "fixed") return JointKind::fixed;
    if (kind == "revolute" || kind == "continuous") return JointKind::revolute;
    if (kind == "prismatic") return JointKind::prismatic;
    fail(joint, "joints of type '" + std::string(kind) + "' are not supported");
  }

  void take_axis(const Element& from, const Pose& X_MJ, JointDescription& joint) {
    const Element& axis = required(from, "axis");
    const Element& xyz = required(axis, "xyz");
    Vector3 direction = vector(axis, "xyz");
    const char* given = xyz.Attribute("expressed_in");
    const Element* old = child(axis, "use_parent_model_frame");
    const bool in_model = axes_are_in_model || (old && (text(*old) == "1" || text(*old) == "true"));
    if (given && *given)
      direction = rotate_back(X_MJ.R, rotate(X_M(given, from).R, direction));
    else if (in_model)
      direction = rotate_back(X_MJ.R, direction);
    if (!(norm(direction) > 0.0)) fail(xyz, "the axis has no direction");
    joint.axis_J = direction / norm(direction);
    if (child(axis, "mimic") || child(from, "mimic")) {
      if (options.mimic == MimicJoints::refuse) fail(from, "mimics another joint: they are not supported");
      robot.notes.push_back(source + ": joint '" + joint.name + "' mimics another; here it moves by itself");
    }
    if (const Element* limit = child(axis, "limit"))
      take_limits(*limit, std::string_view(from.Attribute("type")), joint);
  }

  /// Figures of 1e16 stand for none in files.
  void take_limits(const Element& limit, std::string_view type, JointDescription& joint) const {
    constexpr double kNone = 1e16;
    const auto read = [&](const char* name, double& value, bool below_0_is_none) {
      const Element* found = child(limit, name);
      if (!found || text(*found).find("inf") != std::string::npos) return;
      const double given = number(limit, name);
      if (std::abs(given) < kNone && !(below_0_is_none && given < 0.0)) value = given;
    };
    if (type != "continuous") {
      read("lower", joint.lower, false);
      read("upper", joint.upper, false);
    }
    read("velocity", joint.rate, true);
    read("effort", joint.effort, true);
  }
};

}  // namespace

Robot parse_robot(const std::string& xml, const std::string& source, const RobotOptions& options) {
  tinyxml2::XMLDocument document;
  if (document.Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS) {
    std::string reason = document.ErrorStr();
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw InputError(source + ":" + std::to_string(document.ErrorLineNum()) + ": " + reason);
  }
  const Element* root = document.FirstChildElement("sdf");
  if (!root) throw InputError(source + ": no <sdf> element");
  const Element* model = root->FirstChildElement("model");
  if (const Element* world = root->FirstChildElement("world"); world && !model)
    model = world->FirstChildElement("model");
  if (!model) throw InputError(source + ": no <model>");
  Reader reader{source, options};
  const char* version = root->Attribute("version");
  for (const char* old : {"1.0", "1.2", "1.3", "1.4"})
    reader.axes_are_in_model = reader.axes_are_in_model || (version && std::string_view(version) == old);
  if (model->NextSiblingElement("model"))
    reader.robot.notes.push_back(source + ": only the first model is read");
  reader.read(*model);
  return std::move(reader.robot);
}

Robot load_robot(const std::filesystem::path& file, const RobotOptions& options) {
  return parse_robot(read_robot_text(file), file.string(), options);
}

}  // namespace touchstone::sdf
