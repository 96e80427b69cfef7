#include "touchstone/contact_core/mechanism/mechanism.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

// A normalised axis is off unit length by a few eps; 1e-9 separates that from one never normalised.
constexpr double kUnitTolerance = 1e-9;

}  // namespace

std::string_view to_string(JointKind kind) {
  constexpr std::array<std::string_view, 3> kNames{"fixed", "revolute", "prismatic"};
  return kNames[static_cast<std::size_t>(kind)];
}

Pose rigid_frame(const Pose& X) {
  if (orthonormality_defect(X.R) <= kFrameTolerance) return X;
  Pose out = X;
  const Vector3 x = X.R.col(0) / norm(X.R.col(0));
  const Vector3 y = X.R.col(1) - dot(x, X.R.col(1)) * x;
  out.R.col(0) = x;
  out.R.col(1) = y / norm(y);
  out.R.col(2) = cross(out.R.col(0), out.R.col(1));
  return out;
}

/// Fills a Mechanism step by step; each step counts on those before it.
struct Mechanism::Builder {
  Mechanism& m;
  std::unordered_map<std::string, std::uint32_t> link_index, joint_index;

  std::string label() const { return "mechanism '" + m.name() + "'"; }
  std::string joint_label(const std::string& joint) const { return label() + ", joint '" + joint + "'"; }
  std::string link_label(const std::string& link) const { return label() + ", link '" + link + "'"; }

  void take_links() {
    if (m.name().empty()) throw InputError("mechanism: no name");
    if (m.description_.links.empty()) throw InputError(label() + ": no link");
    for (const LinkDescription& link : m.description_.links) {
      const auto index = static_cast<std::uint32_t>(m.links_.size());
      if (link.name.empty() || link.name.find('/') != std::string::npos)
        throw InputError(label() + ": link " + std::to_string(index) + " has " +
                         (link.name.empty() ? "no name" : "a '/' in its name '" + link.name + "'"));
      if (!link_index.emplace(link.name, index).second)
        throw InputError(link_label(link.name) + ": the name occurs twice");
      check_mass(link);
      Link& out = m.links_.emplace_back();
      out.name = link.name;
      out.mass = link.mass;
      out.first_solid = static_cast<std::uint32_t>(m.solids_.size());
      out.solid_count = static_cast<std::uint32_t>(link.solids.size());
      if (link.solids.empty()) continue;
      out.tree = std::make_shared<const HexahedronTree>(link.solids, m.name() + "." + link.name);
      for (const PlacedHexahedron& placed : link.solids) {
        m.solids_.push_back(placed.solid);
        m.link_of_.push_back(index);
      }
    }
  }

  void check_mass(const LinkDescription& link) const {
    const MassProperties& mass = link.mass;
    const auto fail = [&](const std::string& reason) {
      throw InputError(link_label(link.name) + ": " + reason);
    };
    if (!std::isfinite(mass.mass) || mass.mass < 0.0)
      fail("the mass is " + figure(mass.mass) + " kg, not a number >= 0");
    if (!is_finite(mass.centre_L)) fail("the centre of mass is not finite");
    if (!is_finite(mass.inertia_about_L)) fail("the point that the inertia is about is not finite");
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const double entry = mass.inertia_L(i, j);
        if (!std::isfinite(entry) || entry != mass.inertia_L(j, i) || (i == j && entry < 0.0))
          fail("inertia entry (" + std::to_string(i) + ", " + std::to_string(j) + ") is " + figure(entry) +
               ": the matrix must be symmetric with a diagonal >= 0");
      }
  }

  std::uint32_t link_named(const std::string& name, const std::string& by) const {
    const auto found = link_index.find(name);
    if (found == link_index.end()) throw InputError(by + ": no link '" + name + "'");
    return found->second;
  }

  void take_joints() {
    for (const JointDescription& joint : m.description_.joints) {
      const auto index = static_cast<std::uint32_t>(m.joints_.size());
      // Each joint needs a name of its own and valid figures.
      if (joint.name.empty()) throw InputError(label() + ": joint " + std::to_string(index) + " has no name");
      if (!joint_index.emplace(joint.name, index).second)
        throw InputError(joint_label(joint.name) + ": the name occurs twice");
      check_joint(joint);
      const std::string by = joint_label(joint.name);
      const bool is_fixed = joint.kind == JointKind::fixed;
      // The description is copied, with a rigid frame and a unit axis.
      Joint out{};
      out.name = joint.name;
      out.kind = joint.kind;
      out.inner = link_named(joint.parent, by);
      out.outer = link_named(joint.child, by);
      out.X_PJ = rigid_frame(joint.X_PJ);
      out.axis_J = is_fixed ? Vector3(Vector3::UnitZ()) : Vector3(joint.axis_J / norm(joint.axis_J));
      out.value = kNone;
      out.lower = joint.lower, out.upper = joint.upper;
      out.rate = joint.rate, out.effort = joint.effort;
      if (out.inner == out.outer) throw InputError(by + ": joins link '" + joint.parent + "' to itself");
      // A joint that moves gets a joint value.
      if (!is_fixed) {
        out.value = static_cast<std::uint32_t>(m.reference_.size());
        m.reference_.push_back(0.0);
      }
      m.joints_.push_back(out);
    }
  }

  void check_joint(const JointDescription& joint) const {
    const std::string by = joint_label(joint.name);
    validate_pose(joint.X_PJ, by + ", X_PJ");
    if (joint.kind == JointKind::fixed) return;
    if (!is_finite(joint.axis_J) || !(std::abs(norm(joint.axis_J) - 1.0) <= kUnitTolerance))
      throw InputError(by + ": the axis has length " + figure(norm(joint.axis_J)) + ", not 1");
    if (!(joint.lower <= joint.upper))
      throw InputError(by + ": limits from " + figure(joint.lower) + " to " + figure(joint.upper) +
                       " hold no value");
    if (!(joint.rate >= 0.0)) throw InputError(by + ": the rate is " + figure(joint.rate) + ", not >= 0");
    if (!(joint.effort >= 0.0))
      throw InputError(by + ": the effort is " + figure(joint.effort) + ", not >= 0");
  }

  /// Walks outwards from the base, turning round the joints that are met from their child's side.
  void hang_on_base() {
    const std::string& base = m.description_.base;
    m.base_ = base.empty() ? 0 : link_named(base, label() + ", base");
    // Each link lists its joints.
    std::vector<std::vector<std::uint32_t>> joints_at(m.links_.size());
    for (std::uint32_t j = 0; j < m.joints_.size(); ++j) {
      joints_at[m.joints_[j].inner].push_back(j);
      joints_at[m.joints_[j].outer].push_back(j);
    }
    // Breadth first: a link that is reached twice closes a loop.
    std::vector<std::uint8_t> reached(m.links_.size(), 0), crossed(m.joints_.size(), 0);
    reached[m.base_] = 1;
    std::vector<std::uint32_t> front{m.base_};
    for (std::size_t next = 0; next < front.size(); ++next) {
      for (const std::uint32_t j : joints_at[front[next]]) {
        if (crossed[j]) continue;
        crossed[j] = 1;
        Joint& joint = m.joints_[j];
        if (joint.inner != front[next]) turn_round(joint);
        joint.only_shifts = joint.X_PJ.R == Matrix3::Identity();
        joint.axis_P = rotate(joint.X_PJ.R, joint.axis_J);
        if (reached[joint.outer]) throw InputError(joint_label(joint.name) + ": closes a loop");
        reached[joint.outer] = 1;
        m.links_[joint.outer].joint = j;
        m.outwards_.push_back(j);
        front.push_back(joint.outer);
      }
    }
    // Every link has to hang on the base.
    for (std::uint32_t i = 0; i < reached.size(); ++i)
      if (!reached[i])
        throw InputError(link_label(m.links_[i].name) + ": no joint leads to it from base '" +
                         m.links_[m.base_].name + "'");
  }

  /// X_PC = X_PJ J(q), so X_CP = J(q)^-1 X_PJ^-1, and J(q)^-1 is J(q) about the reversed axis.
  static void turn_round(Joint& joint) {
    std::swap(joint.inner, joint.outer);
    joint.X_JC = inverse(joint.X_PJ);
    joint.X_PJ = Pose{};
    joint.axis_J = -joint.axis_J;
    joint.backwards = true;
  }

  void list_chains() {
    m.first_in_chain_.push_back(0);
    for (std::uint32_t link = 0; link < m.links_.size(); ++link) {
      for (std::uint32_t at = link; m.links_[at].joint != kNone; at = m.joints_[m.links_[at].joint].inner)
        m.chains_.push_back(m.links_[at].joint);
      std::reverse(m.chains_.begin() + m.first_in_chain_.back(), m.chains_.end());
      m.first_in_chain_.push_back(static_cast<std::uint32_t>(m.chains_.size()));
    }
  }

  void take_reference() {
    const std::vector<double>& given = m.description_.reference;
    if (!given.empty() && given.size() != m.reference_.size())
      throw InputError(label() + ": " + std::to_string(given.size()) + " reference values for " +
                       std::to_string(m.reference_.size()) + " joints that move");
    for (const Joint& joint : m.joints_) {
      if (joint.value == kNone) continue;
      const double q = given.empty() ? 0.0 : given[joint.value];
      if (!std::isfinite(q) || q < joint.lower || q > joint.upper)
        throw InputError(joint_label(joint.name) + ": reference value " + figure(q) + " is not within " +
                         figure(joint.lower) + " and " + figure(joint.upper));
      m.reference_[joint.value] = q;
    }
  }

  void exempt(std::uint32_t a, std::uint32_t b) {
    const std::size_t count = m.solids_.size();
    m.exempt_[a * count + b] = m.exempt_[b * count + a] = 1;
  }

  void exempt_links(const Link& a, const Link& b) {
    for (std::uint32_t i = 0; i < a.solid_count; ++i)
      for (std::uint32_t j = 0; j < b.solid_count; ++j) exempt(a.first_solid + i, b.first_solid + j);
  }

  /// A link, or one of its solids, as a range of solids.
  Link range_named(const std::string& name) const {
    const std::string by = label() + ", exempt pair";
    const std::size_t slash = name.find('/');
    Link range = m.links_[link_named(name.substr(0, slash), by)];
    if (slash == std::string::npos) return range;
    const std::string solid = name.substr(slash + 1);
    for (std::uint32_t i = 0; i < range.solid_count; ++i) {
      if (range.tree->solids()[i].name != solid) continue;
      range.first_solid += i;
      range.solid_count = 1;
      return range;
    }
    throw InputError(by + ": link '" + range.name + "' has no hexahedron '" + solid + "'");
  }

  void take_exemptions() {
    m.exempt_.assign(m.solids_.size() * m.solids_.size(), 0);
    for (const Link& link : m.links_) exempt_links(link, link);
    for (const Joint& joint : m.joints_) exempt_links(m.links_[joint.inner], m.links_[joint.outer]);
    for (const ExemptPair& pair : m.description_.exempt_pairs) {
      const Link first = range_named(pair.first), second = range_named(pair.second);
      if (first.name == second.name)
        throw InputError(label() + ", exempt pair: '" + pair.first + "' and '" + pair.second +
                         "' are of one link, which is never checked against itself");
      exempt_links(first, second);
    }
  }
};

Mechanism::Mechanism(MechanismDescription description) : description_(std::move(description)) {
  Builder builder{*this, {}, {}};
  builder.take_links();
  builder.take_joints();
  builder.hang_on_base();
  builder.list_chains();
  builder.take_reference();
  builder.take_exemptions();
}

Mechanism Mechanism::with_base(std::string_view link) const {
  MechanismDescription description = description_;
  description.base = link;
  return Mechanism(std::move(description));
}

std::span<const std::uint32_t> Mechanism::chain(std::uint32_t link) const {
  return std::span(chains_).subspan(first_in_chain_[link], first_in_chain_[link + 1] - first_in_chain_[link]);
}

std::uint32_t Mechanism::find_link(std::string_view name) const {
  for (std::uint32_t i = 0; i < links_.size(); ++i)
    if (links_[i].name == name) return i;
  throw InputError("mechanism '" + this->name() + "': no link '" + std::string(name) + "'");
}

std::uint32_t Mechanism::find_joint(std::string_view name) const {
  for (std::uint32_t i = 0; i < joints_.size(); ++i)
    if (joints_[i].name == name) return i;
  throw InputError("mechanism '" + this->name() + "': no joint '" + std::string(name) + "'");
}

const PlacedHexahedron& Mechanism::placed(std::uint32_t solid) const {
  const Link& link = links_[link_of_[solid]];
  return link.tree->solids()[solid - link.first_solid];
}

std::string Mechanism::solid_name(std::uint32_t solid) const {
  return links_[link_of_[solid]].name + "/" + placed(solid).name;
}

bool Mechanism::is_within_limits(std::span<const double> q) const noexcept {
  if (q.size() != value_count()) return false;
  for (const Joint& joint : joints_) {
    if (joint.value == kNone) continue;
    if (!std::isfinite(q[joint.value]) || q[joint.value] < joint.lower || q[joint.value] > joint.upper)
      return false;
  }
  return true;
}

Pose Mechanism::across(const Joint& joint, const Pose& X_WP, double q) noexcept {
  // Identities are left out: no bit of a product with it would change.
  Pose X = joint.only_shifts ? Pose{X_WP.R, transform(X_WP, joint.X_PJ.p)} : compose(X_WP, joint.X_PJ);
  if (joint.kind == JointKind::revolute) {
    X.R = product(X.R, rotation_about(joint.axis_J, q));
  } else if (joint.kind == JointKind::prismatic) {
    X.p = transform(X, q * joint.axis_J);
  }
  return joint.backwards ? compose(X, joint.X_JC) : X;
}

void Mechanism::link_poses(const Pose& X_WB, std::span<const double> q, std::span<Pose> X_WL) const noexcept {
  X_WL[base_] = X_WB;
  for (const std::uint32_t j : outwards_) {
    const Joint& joint = joints_[j];
    X_WL[joint.outer] = across(joint, X_WL[joint.inner], joint.value == kNone ? 0.0 : q[joint.value]);
  }
}

}  // namespace touchstone
