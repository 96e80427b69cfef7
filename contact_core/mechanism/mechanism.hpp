#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"
#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/scene/scene.hpp"

/// @file
/// Arms: rigid links joined by revolute, prismatic and fixed joints into a tree, any link of which may be the
/// base.

namespace touchstone {

/// The motion that a joint lets its child have: none, turn about its axis [rad], shift along it [m].
enum class JointKind : std::uint8_t { fixed, revolute, prismatic };
/// The enumerator's name.
std::string_view to_string(JointKind kind);

/// Mass and inertia of a link, kept for dynamics; nothing here reads them.
struct MassProperties {
  double mass = 0.0;                          ///< [kg], >= 0; 0: not known
  Vector3 centre_L = Vector3::Zero();         ///< centre of mass in the link's frame [m]
  Matrix3 inertia_L = Matrix3::Zero();        ///< in the link's axes [kg m2]
  Vector3 inertia_about_L = Vector3::Zero();  ///< the point that inertia_L is about [m]
};

/// One rigid part of a mechanism. Its solids are placed in its frame L.
struct LinkDescription {
  std::string name;
  std::vector<PlacedHexahedron> solids = {};  ///< X_OS in the link's frame; may be none
  MassProperties mass = {};
};

/// At value q the child's frame stands in the parent's at X_PJ * J(q): J turns by q [rad], right-handed about
/// axis_J, or shifts by q [m] along it; q = 0: the child's frame is the joint's.
struct JointDescription {
  std::string name;
  JointKind kind = JointKind::fixed;
  std::string parent;
  std::string child;
  Pose X_PJ = {};
  Vector3 axis_J = Vector3::UnitZ();  ///< unit; not read if fixed
  double lower = -kInfinity;          ///< [rad] or [m]
  double upper = kInfinity;
  double rate = kInfinity;    ///< largest |dq/dt| [rad/s] or [m/s], >= 0
  double effort = kInfinity;  ///< largest torque [N m] or force [N], >= 0
};

/// A mechanism as plain data, nothing checked: what Mechanism is made from.
struct MechanismDescription {
  std::string name;
  std::vector<LinkDescription> links;
  std::vector<JointDescription> joints;
  /// The link that is held; empty: the first. Joints whose child is nearer to it than their parent are walked
  /// backwards; their values keep their meaning.
  std::string base = {};
  /// A value for each joint that moves, in the order of `joints`; empty: all 0. See reference_overlaps.hpp.
  std::vector<double> reference = {};
  /// Pairs that are not checked, besides links that a joint joins. Each name is a link or `link/hexahedron`.
  std::vector<ExemptPair> exempt_pairs = {};
  std::vector<FacetFigure> facet_figures = {};  ///< of round parts; `object` is the link
};

/// Frames that joints are built from may be this far from orthonormal (a few roundings): chains multiply
/// them, and bounds on paths count on lengths.
inline constexpr double kFrameTolerance = 0x1p-48;
/// X where it is orthonormal within kFrameTolerance, else made so (Gram-Schmidt): the first column keeps its
/// direction, the second stays in their plane.
/// @pre is_valid_pose(X).
Pose rigid_frame(const Pose& X);

/// A checked mechanism: a tree of links held by its base. Immutable; const use from several threads is safe.
class Mechanism {
 public:
  static constexpr std::uint32_t kNone = kNoIndex;

  /// A link and its place in the tree.
  struct Link {
    std::string name;
    std::shared_ptr<const HexahedronTree> tree;  ///< named `mechanism.link`; null: no solids
    MassProperties mass;
    std::uint32_t joint = kNone;    ///< that joins it to the next link towards the base; none: the base
    std::uint32_t first_solid = 0;  ///< its solids' indices in solids() start here
    std::uint32_t solid_count = 0;
  };

  /// A joint as seen from the base: X_PC(q) = X_PJ * J(q) * X_JC.
  struct Joint {
    std::string name;
    JointKind kind;
    std::uint32_t inner, outer;  ///< links: inner is nearer to the base
    Pose X_PJ;                   ///< in the inner link
    Vector3 axis_J;              ///< reversed where the joint is walked backwards
    Pose X_JC;                   ///< of the outer link; the identity unless walked backwards
    bool backwards;
    bool only_shifts;     ///< X_PJ does not turn: most joints
    Vector3 axis_P;       ///< in the inner link
    std::uint32_t value;  ///< index of its value; kNone: fixed
    double lower, upper, rate, effort;
  };

  /// @throws InputError naming the mechanism, the link or joint and the figure: no link, a name that is
  /// empty, taken or unknown, a loop, a link that no joint reaches, a frame that is no rigid transform, an
  /// axis off unit length by more than 1e-9, limits that are crossed or not numbers, negative rates, efforts
  /// or masses, reference values out of limits, an exempt pair that names nothing or one link twice.
  explicit Mechanism(MechanismDescription description);

  /// The same mechanism held by another link. @throws InputError when there is no such link.
  Mechanism with_base(std::string_view link) const;

  const MechanismDescription& description() const { return description_; }
  const std::string& name() const { return description_.name; }
  std::uint32_t base() const { return base_; }
  /// The links in the description's order, whichever the base is.
  const std::vector<Link>& links() const { return links_; }
  const std::vector<Joint>& joints() const { return joints_; }
  /// The number of joints that move, and so the size of every span of joint values, in the order of joints().
  std::uint32_t value_count() const { return static_cast<std::uint32_t>(reference_.size()); }
  std::span<const double> reference() const { return reference_; }
  /// Joints from the base outwards: each follows the joint that moves its inner link.
  std::span<const std::uint32_t> outwards() const { return outwards_; }
  /// The joints between the base and `link`, from the base.
  std::span<const std::uint32_t> chain(std::uint32_t link) const;

  /// @throws InputError when the name is unknown.
  std::uint32_t find_link(std::string_view name) const;
  std::uint32_t find_joint(std::string_view name) const;

  /// All hexahedra, through the links in order, and where each belongs.
  const std::vector<Hexahedron>& solids() const { return solids_; }
  std::uint32_t link_of(std::uint32_t solid) const { return link_of_[solid]; }
  const PlacedHexahedron& placed(std::uint32_t solid) const;
  std::string solid_name(std::uint32_t solid) const;  ///< `link/hexahedron`

  /// True for solids of one link, of two links that a joint joins, and of the pairs listed.
  bool is_exempt(std::uint32_t solid_a, std::uint32_t solid_b) const {
    return exempt_[solid_a * solids_.size() + solid_b] != 0;
  }

  /// A finite value within its limits for each joint that moves.
  bool is_within_limits(std::span<const double> q) const noexcept;

  /// X_WC across one joint at value q.
  static Pose across(const Joint& joint, const Pose& X_WP, double q) noexcept;
  /// Forward kinematics: X_WL of every link, from the base outwards. No allocation. A link's pose depends on
  /// its chain's values alone, with one order of operations: the same bits everywhere.
  /// @pre q.size() == value_count(), X_WL.size() == links().size(); see kFrameTolerance for X_WB.
  void link_poses(const Pose& X_WB, std::span<const double> q, std::span<Pose> X_WL) const noexcept;

 private:
  struct Builder;

  MechanismDescription description_;
  std::uint32_t base_ = 0;
  std::vector<Link> links_;
  std::vector<Joint> joints_;
  std::vector<double> reference_;
  std::vector<std::uint32_t> outwards_;
  std::vector<std::uint32_t> chains_, first_in_chain_;
  std::vector<Hexahedron> solids_;
  std::vector<std::uint32_t> link_of_;
  std::vector<std::uint8_t> exempt_;  // by solid and solid
};

}  // namespace touchstone
