#include "touchstone/adapters/robots/simplify.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/mechanism/reference_overlaps.hpp"

namespace touchstone {
namespace {

/// Inertia about `to`, from that about the centre of mass (parallel-axis theorem).
Matrix3 shifted(const Matrix3& about_centre, double mass, const Vector3& from_centre) {
  return about_centre +
         mass * (dot(from_centre, from_centre) * Matrix3::Identity() - outer(from_centre, from_centre));
}

/// About the centre of mass, in the frame of X_AL's A.
MassProperties moved(const MassProperties& mass, const Pose& X_AL) {
  const Matrix3 about_centre =
      mass.inertia_L - (shifted(Matrix3::Zero(), mass.mass, mass.inertia_about_L - mass.centre_L));
  const Vector3 centre = transform(X_AL, mass.centre_L);
  return {mass.mass, centre, turned(X_AL.R, about_centre), centre};
}

MassProperties sum(const MassProperties& a, const MassProperties& b) {
  if (b.mass == 0.0) return a;
  if (a.mass == 0.0) return b;
  const MassProperties a0 = moved(a, {}), b0 = moved(b, {});
  const double mass = a0.mass + b0.mass;
  const Vector3 centre = (a0.mass * a0.centre_L + b0.mass * b0.centre_L) / mass;
  return {mass, centre,
          shifted(a0.inertia_L, a0.mass, centre - a0.centre_L) +
              shifted(b0.inertia_L, b0.mass, centre - b0.centre_L),
          centre};
}

struct Fuser {
  const Mechanism& robot;
  MechanismDescription out = {};
  std::vector<std::uint32_t> kept = {};  // by link: the one that it becomes part of
  std::vector<Pose> X_KL = {};           // its frame in that one's
  std::vector<std::size_t> place = {};   // of kept links in `out`

  void run() {
    const MechanismDescription& from = robot.description();
    out.name = from.name;
    out.base = from.base;
    out.facet_figures = from.facet_figures;
    kept.resize(robot.links().size());
    X_KL.resize(robot.links().size());
    place.resize(robot.links().size());
    kept[robot.base()] = robot.base();
    for (const std::uint32_t index : robot.outwards()) {
      const Mechanism::Joint& joint = robot.joints()[index];
      const bool is_fixed = joint.kind == JointKind::fixed;
      kept[joint.outer] = is_fixed ? kept[joint.inner] : joint.outer;
      if (is_fixed)
        X_KL[joint.outer] = rigid_frame(compose(X_KL[joint.inner], compose(joint.X_PJ, joint.X_JC)));
    }
    if (!out.base.empty()) out.base = robot.links()[kept[robot.base()]].name;
    add_links();
    add_joints();
    for (const ExemptPair& pair : from.exempt_pairs)
      for (const std::string& first : solids_of(pair.first))
        for (const std::string& second : solids_of(pair.second)) exempt(first, second);
  }

  /// Two that have become one link are exempt as they are.
  void exempt(const std::string& first, const std::string& second) {
    if (first.substr(0, first.find('/')) != second.substr(0, second.find('/')))
      out.exempt_pairs.push_back({first, second});
  }

  void add_links() {
    for (std::uint32_t i = 0; i < kept.size(); ++i) {
      if (kept[i] != i) continue;
      place[i] = out.links.size();
      out.links.push_back(robot.description().links[i]);
    }
    for (std::uint32_t i = 0; i < kept.size(); ++i) {
      if (kept[i] == i) continue;
      const LinkDescription& part = robot.description().links[i];
      LinkDescription& to = out.links[place[kept[i]]];
      for (PlacedHexahedron solid : part.solids) {
        solid.name.insert(0, part.name + ".");
        solid.X_OS = rigid_frame(compose(X_KL[i], solid.X_OS));
        to.solids.push_back(std::move(solid));
      }
      to.mass = sum(to.mass, moved(part.mass, X_KL[i]));
    }
  }

  void add_joints() {
    const MechanismDescription& from = robot.description();
    for (std::size_t i = 0; i < from.joints.size(); ++i) {
      JointDescription joint = from.joints[i];
      if (joint.kind == JointKind::fixed) continue;
      const std::uint32_t parent = robot.find_link(joint.parent);
      joint.X_PJ = rigid_frame(compose(X_KL[parent], joint.X_PJ));
      joint.parent = robot.links()[kept[parent]].name;
      if (kept[robot.find_link(joint.child)] != robot.find_link(joint.child))
        throw InputError("mechanism '" + from.name + "', joint '" + joint.name +
                         "': walked backwards from the base, it holds a fixed link");
      out.joints.push_back(joint);
    }
    out.reference = from.reference;
  }

  /// `link` or `link/solid` by its new name; of a link that was moved, each of its solids.
  std::vector<std::string> solids_of(const std::string& name) const {
    const std::size_t slash = name.find('/');
    const std::uint32_t link = robot.find_link(name.substr(0, slash));
    if (kept[link] == link) return {name};
    const std::string to = robot.links()[kept[link]].name + "/" + robot.links()[link].name + ".";
    if (slash != std::string::npos) return {to + name.substr(slash + 1)};
    std::vector<std::string> all;
    for (const PlacedHexahedron& solid : robot.description().links[link].solids)
      all.push_back(to + solid.name);
    return all;
  }
};

}  // namespace

MechanismDescription without_fixed_joints(const MechanismDescription& robot) {
  const Mechanism checked(robot);
  Fuser fuser{checked};
  fuser.run();
  return std::move(fuser.out);
}

std::vector<std::string> exempt_reference_overlaps(MechanismDescription& robot, Narrowphase& narrowphase) {
  const Mechanism checked(robot);
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> deepest;
  for (const ReferenceOverlap& overlap : find_reference_overlaps(checked, narrowphase)) {
    const std::uint32_t a = checked.link_of(overlap.solids.a), b = checked.link_of(overlap.solids.b);
    double& depth = deepest[{std::min(a, b), std::max(a, b)}];
    if (overlap.separation < depth) depth = overlap.separation;
  }
  std::vector<std::string> lines;
  for (const auto& [links, separation] : deepest) {
    const std::string &a = checked.links()[links.first].name, &b = checked.links()[links.second].name;
    robot.exempt_pairs.push_back({a, b});
    lines.push_back("links '" + a + "' and '" + b + "' overlap by " + figure(-separation) +
                    " m in the reference pose: not checked against each other");
  }
  return lines;
}

}  // namespace touchstone
