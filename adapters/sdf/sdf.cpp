#include "touchstone/adapters/sdf/sdf.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <set>
#include <string_view>

#include "touchstone/adapters/robots/builder.hpp"
#include "touchstone/adapters/robots/mesh_path.hpp"
#include "touchstone/adapters/robots/mesh_units.hpp"
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
constexpr int kDeepest = 32;       // of models in models: more is a file that includes itself

/// A file that is read: the robot's own, or one that is included.
struct SourceFile {
  std::string name;
  tinyxml2::XMLDocument document = {};
  bool axes_are_in_model = false;  ///< unless they say otherwise: until 1.4
};

/// Names in a model: those of a nested one stand behind its own name.
struct Scope {
  std::string prefix;       ///< `arm::`, `arm::hand::`; empty: the outermost
  std::string model_frame;  ///< that of the model; empty: the outermost
};

struct Reader {
  const std::string& source;
  const RobotOptions& options;
  Robot robot = {};
  RobotBuilder builder{robot, options, source};
  std::vector<std::unique_ptr<SourceFile>> files = {};
  std::vector<const Element*> models = {};                 ///< the outermost first
  std::map<const Element*, Scope> scopes = {};             ///< by model
  std::map<std::string, Frame> frames = {};                ///< by full name
  std::set<const Element*> has_own_key = {};               ///< joints: see own_key()
  std::map<std::string, const Element*> joint_above = {};  // by child link
  std::map<std::string, std::size_t> link_index = {};

  [[noreturn]] void fail(const Element& at, const std::string& reason) const {
    const char* name = at.Attribute("name");
    throw InputError(place_of(at) + ": <" + at.Name() + ">" + (name ? " '" + std::string(name) + "'" : "") +
                     ": " + reason);
  }
  std::string place_of(const Element& at) const {
    return file_of(at).name + ":" + std::to_string(at.GetLineNum());
  }
  const SourceFile& file_of(const Element& at) const {
    for (const auto& file : files)
      if (&file->document == at.GetDocument()) return *file;
    return *files.front();
  }

  const Scope& scope_of(const Element& element) const {
    for (const tinyxml2::XMLNode* at = &element; at; at = at->Parent())
      if (const auto found = scopes.find(at->ToElement()); found != scopes.end()) return found->second;
    return scopes.at(models.front());
  }
  /// A name in the file as it stands for all models; empty: the outermost model's frame.
  std::string full_name(const std::string& name, const Element& in) const {
    if (name == "world") return "";
    const Scope& scope = scope_of(in);
    return name == "__model__" ? scope.model_frame : scope.prefix + name;
  }
  /// Of a joint, where `world` is the link that stands for the world.
  std::string full_link(const Element& element) const {
    const std::string name = text(element);
    return name == "world" ? name : full_name(name, element);
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

  /// @throws InputError: no XML, no `<sdf>`.
  const Element& parse(const std::string& xml, const std::string& name) {
    SourceFile& file = *files.emplace_back(std::make_unique<SourceFile>());
    file.name = name;
    if (file.document.Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS) {
      std::string reason = file.document.ErrorStr();
      std::replace(reason.begin(), reason.end(), '\n', ' ');
      throw InputError(name + ":" + std::to_string(file.document.ErrorLineNum()) + ": " + reason);
    }
    const Element* root = file.document.FirstChildElement("sdf");
    if (!root) throw InputError(name + ": no <sdf> element");
    const char* version = root->Attribute("version");
    for (const char* old : {"1.0", "1.2", "1.3", "1.4"})
      file.axes_are_in_model = file.axes_are_in_model || (version && std::string_view(version) == old);
    return *root;
  }

  /// The first model of a file, in it or in its world, where it may be included.
  const Element& model_in(const Element& root) {
    const Element* parent = &root;
    const Element* model = child(root, "model");
    if (const Element* world = child(root, "world"); world && !model) {
      parent = world;
      model = child(*world, "model");
    }
    if (model && model->NextSiblingElement("model"))
      robot.notes.push_back(file_of(root).name + ": only the first model is read");
    if (model) return *model;
    if (const Element* include = child(*parent, "include")) return included(*include);
    throw InputError(file_of(root).name + ": no <model>");
  }

  /// The model of the file that an `<include>` names.
  const Element& included(const Element& include) {
    if (files.size() > kMostFrames) fail(include, "is one of more than 1000");
    if (const Element* frame = child(include, "placement_frame")) fail(*frame, "is not read: give a pose");
    const std::filesystem::path file = file_named(include, text(required(include, "uri")));
    return model_in(parse(read_robot_text(file), file.string()));
  }

  std::filesystem::path file_named(const Element& include, std::string uri) const {
    while (!uri.empty() && uri.back() == '/') uri.pop_back();
    const std::filesystem::path from = file_of(include).name;
    try {
      if (uri.find("://") == std::string::npos && std::filesystem::is_directory(from.parent_path() / uri))
        uri = "file://" + (from.parent_path() / uri).string();
      const std::string scheme = uri.substr(0, uri.find("://") + 3);
      const bool is_folder = scheme == "file://" ? std::filesystem::is_directory(uri.substr(scheme.size()))
                                                 : uri.find('/', scheme.size()) == std::string::npos &&
                                                       uri.find("://") != std::string::npos;
      if (!is_folder) return mesh_path(uri, from, options.package_paths);
      const std::filesystem::path manifest = mesh_path(uri + "/model.config", from, options.package_paths);
      return manifest.parent_path() / newest_sdf(manifest);
    } catch (const InputError& error) {
      fail(include, error.what());
    }
  }

  /// Of a model's folder, as its model.config says.
  static std::filesystem::path newest_sdf(const std::filesystem::path& manifest) {
    const std::string xml = read_robot_text(manifest);
    tinyxml2::XMLDocument document;
    document.Parse(xml.data(), xml.size());
    std::string best = "model.sdf";
    std::pair<int, int> newest{-1, -1};  // 1.10 is newer than 1.4
    if (const Element* model = document.FirstChildElement("model"))
      each(*model, "sdf", [&](const Element& sdf) {
        const std::string version = sdf.Attribute("version") ? sdf.Attribute("version") : "0.0";
        std::pair<int, int> number{0, 0};
        const auto [dot, error] =
            std::from_chars(version.data(), version.data() + version.size(), number.first);
        if (dot != version.data() + version.size())
          std::from_chars(dot + 1, version.data() + version.size(), number.second);
        if (error == std::errc{} && number > newest) newest = number, best = text(sdf);
      });
    const std::filesystem::path file = std::filesystem::path(best).lexically_normal();
    if (best.empty() || file.is_absolute() || *file.begin() == "..")
      throw InputError(manifest.string() + ": '" + best + "' leaves its folder");
    return file;
  }

  void read(const Element& model) {
    robot.mechanism.name = name_of(model);
    add_model(model, {}, 0);
    bool has_world = false;
    for_all("joint", [&](const Element& joint) {
      has_world = has_world || text(required(joint, "parent")) == "world";
    });
    if (has_world) link_index["world"] = builder.add_link("world");
    for_all("link", [&](const Element& link) { take_link(link); });
    if (robot.mechanism.links.empty()) fail(model, "has no link");
    for_all("joint", [&](const Element& joint) { take_joint(joint); });
    hold(has_world);
  }

  /// Its names, and those of the models in it.
  void add_model(const Element& model, const Scope& scope, int depth) {
    if (depth > kDeepest) fail(model, "is in more than 32 others, or in itself");
    models.push_back(&model);
    if (!scopes.emplace(&model, scope).second) fail(model, "stands twice");
    each(model, "link", [&](const Element& link) { add_frame(link, "__model__"); });
    each(model, "joint", [&](const Element& joint) {
      const Element& under = required(joint, "child");
      add_frame(joint, text(under));
      if (!joint_above.emplace(full_link(under), &joint).second)
        fail(joint, "is the second above link '" + text(under) + "'");
    });
    each(model, "frame", [&](const Element& frame) {
      const char* to = frame.Attribute("attached_to");
      add_frame(frame, to && *to ? to : "__model__");
    });
    each(model, "model", [&](const Element& nested) { add_nested(nested, nested, scope, depth); });
    each(model, "include",
         [&](const Element& include) { add_nested(included(include), include, scope, depth); });
  }

  /// @param by the model itself, or the `<include>` that brings it: its name and pose count where it has
  /// some.
  void add_nested(const Element& model, const Element& by, const Scope& outer, int depth) {
    const Element* given = &by == &model ? nullptr : child(by, "name");
    const std::string name = given ? text(*given) : name_of(model);
    const bool is_merged = by.BoolAttribute("merge");
    const std::string frame = outer.prefix + (is_merged ? "_merged__" + name + "__model__" : name);
    const Element& posed = child(by, "pose") ? by : model;
    const Element* at = child(posed, "pose");
    const char* relative = at ? at->Attribute("relative_to") : nullptr;
    const std::string in = relative && *relative ? full_name(relative, by) : outer.model_frame;
    if (!frames.emplace(frame, Frame{&by, in, pose(posed)}).second) fail(by, "its name is taken");
    add_model(model, {is_merged ? outer.prefix : outer.prefix + name + "::", frame}, depth + 1);
  }

  template <class Action>
  void for_all(const char* name, const Action& action) const {
    for (const Element* model : models) each(*model, name, action);
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
    const std::string in = full_name(given && *given ? given : usually_in, element);
    const std::string name = full_name(name_of(element), element);
    const auto [taken, is_new] = frames.emplace(name, Frame{&element, in, pose(element)});
    if (is_new) return;
    // Until 1.6 a joint may be called as a link is: the name then means the link.
    const bool is_joint = std::string_view(element.Name()) == "joint";
    if (!is_joint || std::string_view(taken->second.element->Name()) != "link" ||
        !frames.emplace(own_key(name), Frame{&element, in, pose(element)}).second)
      fail(element, "its name is taken");
    has_own_key.insert(&element);
  }
  /// Of a joint's frame whose name a link has: no file can write it.
  static std::string own_key(const std::string& name) { return "joint\n" + name; }

  /// In the outermost model. @param name in full.
  Pose X_M(const std::string& name, const Element& asked_by) const {
    Pose X;
    std::string at = name;
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
    if (joint == joint_above.end()) return rigid_frame(X_M(link, asked_by));
    const std::string name = full_name(name_of(*joint->second), *joint->second);
    return rigid_frame(X_M(has_own_key.contains(joint->second) ? own_key(name) : name, asked_by));
  }

  void take_link(const Element& link) {
    const std::string name = full_name(name_of(link), link);
    const std::size_t index = builder.add_link(name);
    link_index[name] = index;
    const Pose X_LK = compose(inverse(X_ML(name, link)), X_M(name, link));  // K: the file's frame of the link
    if (const Element* inertial = child(link, "inertial")) take_mass(*inertial, X_LK, index);
    each(link, "collision", [&](const Element& collision) {
      const Element* at = child(collision, "pose");
      const char* relative = at ? at->Attribute("relative_to") : nullptr;
      const Pose X_KS =
          relative && *relative
              ? compose(inverse(X_M(name, link)),
                        compose(X_M(full_name(relative, collision), collision), pose(collision)))
              : pose(collision);
      const std::string label =
          place_of(collision) + ": link '" + name + "', collision '" + name_of(collision) + "'";
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
      builder.add_mesh_file(place, from_its_file(required(*shape, "uri")), scale);
    } else if (kind != "empty") {
      fail(*shape,
           "is no shape that becomes hexahedra: known are box, cylinder, sphere, capsule, ellipsoid, mesh");
    }
  }

  /// A mesh's relative name in an included file is one beside that file.
  std::string from_its_file(const Element& uri) const {
    const std::string name = text(uri);
    const SourceFile& file = file_of(uri);
    if (&file == files.front().get() || name.find("://") != std::string::npos) return name;
    return (std::filesystem::path(file.name).parent_path() / name).string();
  }

  void take_joint(const Element& from) {
    JointDescription joint;
    joint.name = full_name(name_of(from), from);
    joint.parent = full_link(required(from, "parent"));
    joint.child = full_link(required(from, "child"));
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
    const bool in_model =
        file_of(from).axes_are_in_model || (old && (text(*old) == "1" || text(*old) == "true"));
    if (given && *given)
      direction = rotate_back(X_MJ.R, rotate(X_M(full_name(given, from), from).R, direction));
    else if (in_model)
      direction = rotate_back(X_MJ.R, rotate(X_M(scope_of(from).model_frame, from).R, direction));
    if (!(norm(direction) > 0.0)) fail(xyz, "the axis has no direction");
    joint.axis_J = direction / norm(direction);
    if (child(axis, "mimic") || child(from, "mimic")) {
      if (options.mimic == MimicJoints::refuse) fail(from, "mimics another joint: they are not supported");
      robot.notes.push_back(file_of(from).name + ": joint '" + joint.name +
                            "' mimics another; here it moves by itself");
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
  Reader reader{source, options};
  reader.read(reader.model_in(reader.parse(xml, source)));
  check_mesh_units(source, options, reader.robot);
  return std::move(reader.robot);
}

Robot load_robot(const std::filesystem::path& file, const RobotOptions& options) {
  return parse_robot(read_robot_text(file), file.string(), options);
}

}  // namespace touchstone::sdf
