#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/mechanism/mechanism.hpp"
#include "touchstone/contact_core/motion/path.hpp"

namespace touchstone {

/// A mechanism's path over a frame: every joint value changes evenly from the actual to the commanded one,
/// q(s) = q0 + s (q1 - q0), which is exact at both ends. Bodies are links. The base stands still.
///
/// Const use from several threads is safe. set() and everything after it do not allocate.
class MechanismPath final : public MotionPath {
 public:
  /// A path at rest in the reference pose, with the base at the world's origin. Keeps a reference.
  explicit MechanismPath(const Mechanism& mechanism);

  /// @param X_WB of the base; put through rigid_frame(). @param from, to value_count() values each.
  /// @pre a valid pose and finite values.
  void set(const Pose& X_WB, std::span<const double> from, std::span<const double> to) noexcept;
  /// Like set(), but computes start and bounds only: for paths that are checked, not executed. at() is slower
  /// at the end. @param X_WL link_poses() at `from`, which need not be found again; or empty.
  void lay(const Pose& X_WB, std::span<const double> from, std::span<const double> to,
           std::span<const Pose> X_WL = {}) noexcept;
  /// Like set(), at rest. @param X_WL link_poses() at `values`.
  void rest(const Pose& X_WB, std::span<const double> values, std::span<const Pose> X_WL) noexcept;
  /// Computes the end, which lay() left out. The path is then as after set().
  void finish() noexcept;

  const Mechanism& mechanism() const { return *mechanism_; }
  const Pose& X_WB() const { return X_WB_; }
  std::span<const double> from() const { return q0_; }
  std::span<const double> to() const { return q1_; }
  /// @pre out.size() == value_count()
  void values_at(double s, std::span<double> out) const noexcept;
  /// False for links that stand still on this path, whatever else moves.
  bool moves(std::uint32_t link) const { return section_of_[link] != 0; }

  /// The bits of Mechanism::link_poses() at values_at(s); centre_W is the link's origin.
  BodyState at(std::uint32_t link, double s) const noexcept override;

  /// Bound over all of [0, 1]; see the source for what it is made of. For a path that only turns about one
  /// axis it is that of a circle; 0 (to rounding) along n where everything turns about n.
  double curvature_bound(std::uint32_t link, const BodyState& state, const Vector3& p_W,
                         const Vector3& n_W) const noexcept override;

  MotionBounds bounds(std::uint32_t link, const BodyState& state, const Vector3& p_W) const noexcept override;
  void curvature_bounds(std::uint32_t link, const BodyState& state, std::span<const Vector3> points_W,
                        const Vector3& n_W, std::span<double> out) const noexcept override;

  /// The terms of curvature_bound() that a link's points share along n. Void once another path is laid.
  struct Along {
    std::uint32_t link;
    Vector3 n_W;             ///< unit, fixed in the world
    double across, inwards;  ///< bounds on |n x angular velocity|, on |n . p''| of the section's entry
  };
  Along along_of(std::uint32_t link, const Vector3& n_W) const noexcept;
  /// curvature_bound() of a point fixed in the link.
  double curvature_along(const Along& along, const Vector3& p_L) const noexcept;

  /// Bounds over all of [0, 1] on the speed of a point fixed in the link [m], on the link's angular velocity
  /// [rad] and on that one's derivative.
  double speed_bound(std::uint32_t link, const Vector3& p_L) const noexcept;
  /// The same of any point within spheres fixed in the link: one bound each. @pre as many `out`.
  void speed_bounds(std::uint32_t link, std::span<const Sphere> spheres_L,
                    std::span<double> out) const noexcept;
  /// A bound on the acceleration of a point fixed in the link, in any direction [m].
  double acceleration_bound(std::uint32_t link, const Vector3& p_L) const noexcept;
  double turn_bound(std::uint32_t link) const noexcept;
  double turn_change_bound(std::uint32_t link) const noexcept;

  /// A bound on how far a point fixed in the link leaves the straight segment between its places at 0 and at
  /// 1 [m], for SolidPaths::bulge; it includes rounding.
  double bulge(std::uint32_t link, const Vector3& p_L) const noexcept;

  /// No point p_L of a pose from at() is further than this from the path in exact arithmetic [m].
  double rounding(std::uint32_t link, const Vector3& p_L) const noexcept;

 private:
  /// Bounds over [0, 1] on the derivatives of a vector or point by s [m].
  struct Rates {
    double first = 0.0, second = 0.0, third = 0.0;
  };

  /// A set of links that do not move relative to each other on this path. Section 0 is the base's. Vectors
  /// are those at s = 1/2.
  struct Section {
    std::uint32_t inner = 0;                         ///< the section it hangs on
    Vector3 entry_W = Vector3::Zero();               ///< where it does
    Vector3 turn_W = Vector3::Zero();                ///< angular velocity
    Vector3 turn_change_W = Vector3::Zero();         ///< its derivative
    double turn = 0.0, change = 0.0, change2 = 0.0;  ///< bounds on the angular velocity and two derivatives
    double slack = 0.0;                              ///< error of unit vectors as computed here
    Vector3 entry_acceleration_W = Vector3::Zero();  ///< second derivative of the entry
    Rates entry_rates;
    // From the inner section's entry to this one's: a vector fixed there, and a shift along a joint's axis.
    double length = 0.0;       ///< of the vector
    double vector_rate = 0.0;  ///< bound on |turn x vector| of the inner section
    double shift = 0.0;        ///< largest |q| of a prismatic joint; 0 otherwise
    double shift_rate = 0.0;   ///< |dq/ds| of it
    double axis_rate = 0.0;    ///< bound on |turn x axis| of the inner section
  };

  struct Acceleration {
    Vector3 at_half_W;  ///< of a point at s = 1/2
    Vector3 r_W;        ///< from its section's entry
    Rates rates;
  };

  double value_at(std::uint32_t value, double s) const noexcept;
  BodyState across(const Mechanism::Joint& joint, const BodyState& inner, double s) const noexcept;
  void take_values(const Pose& X_WB, std::span<const double> from, std::span<const double> to) noexcept;
  void sweep(double s, std::vector<BodyState>& out) const noexcept;
  void stand(std::span<const Pose> X_WL) noexcept;
  void take_rates(const Mechanism::Joint& joint, const BodyState& inner, BodyState& outer) const noexcept;
  void divide_into_sections() noexcept;
  void add_section(const Mechanism::Joint& joint) noexcept;
  void turn_on(Section& section, const Vector3& axis_W, double rate) const noexcept;
  double rate_across(const Section& section, const Vector3& n_W) const noexcept;
  double curvature_inwards(const Section& innermost, const Vector3& n_W) const noexcept;
  Rates rates_of_vector(const Section& section, const Vector3& v_W) const noexcept;
  Acceleration acceleration_of(std::uint32_t link, const Vector3& p_L) const noexcept;

  const Mechanism* mechanism_;
  Pose X_WB_;
  std::vector<double> q0_, q1_;
  std::vector<BodyState> start_, end_;  // by link; end_: where has_end_
  std::vector<Pose> half_;              // by link: at s = 1/2, which bounds alone look at
  std::vector<Section> sections_;
  std::vector<std::uint32_t> section_of_;  // by link
  std::vector<std::uint32_t>
      standing_;               // by link: how many joints of its chain come before the first that moves
  std::vector<double> reach_;  // by link: no longer than this from the base's origin [m]
  double largest_value_ = 0.0;
  bool has_end_ = false;
};

}  // namespace touchstone
