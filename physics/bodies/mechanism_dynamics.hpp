#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/no_index.hpp"
#include "touchstone/contact_core/mechanism/mechanism.hpp"
#include "touchstone/physics/bodies/inertia.hpp"

namespace touchstone::physics {

/// Forward and inverse dynamics of a mechanism whose base is held: the recursive Newton-Euler,
/// composite-rigid- body and articulated-body algorithms (Featherstone, Rigid Body Dynamics Algorithms, 2008,
/// tables 5.1, 6.2, 7.1). Links that no moving joint parts are one body. Vectors are in world axes about each
/// body's own origin, a point on its joint's axis: carrying them from body to body is a shift, and no digits
/// go to far origins.
///
/// Spans of joint figures are as Mechanism's: one for each joint that moves, in the order of joints(); rates
/// in rad/s or m/s, torques in N m or N. No method allocates but make_workspace(). Const use from several
/// threads is safe, each with its own workspace.
class MechanismDynamics {
 public:
  static constexpr std::size_t kStages = 7;  ///< of step()

  /// A body placed in the world, and scratch memory of the recursions.
  struct PlacedBody {
    Matrix3 R_WB;            ///< the joint's frame after its motion
    Vector3 origin_W;        ///< [m]
    Vector3 axis_W;          ///< of its joint
    Vector3 arm_W;           ///< from the inner body's origin
    Vector3 c_W;             ///< from the origin to the centre of mass
    Matrix3 I_W;             ///< about the centre of mass
    Vector3 w_W, v_W;        ///< angular velocity; velocity of the origin
    double rate;             ///< of its joint
    Vector3 bias_w, bias_v;  ///< acceleration at joint acceleration 0 and a resting inner body
    Matrix3 A, B, C;   ///< articulated or composite inertia about the origin: [n; f] = [A B; B' C] [w'; v']
    Vector3 n, f;      ///< moment about the origin, force
    Vector3 U_n, U_f;  ///< articulated inertia times the joint's axis
    double D, u;
    Vector3 alpha, a;  ///< angular acceleration, acceleration of the origin
  };
  /// Scratch memory, one a thread. @see make_workspace()
  struct Workspace {
    std::vector<PlacedBody> bodies;  ///< valid after place()
    Pose X_WBase;
    std::vector<double> q, qd;  // of step()
    std::array<std::vector<double>, kStages> rate, slope;
  };

  /// Keeps a reference to the mechanism.
  /// @param links inertia of every link in its frame; empty: those the mechanism carries.
  /// @throws InputError naming the mechanism and the link or joint: see validate(); another number of links;
  /// a joint that moves no inertia in the reference pose.
  explicit MechanismDynamics(const Mechanism& mechanism, std::span<const BodyInertia> links = {});

  /// The same for other inertias of the links, as after a latch: what was placed before no longer holds. Does
  /// not allocate. @pre one a link, valid; each joint that moves moves some.
  void set_links(std::span<const BodyInertia> links) noexcept;

  /// Inertias of rotors that turn with the joints alone, as the joints see them: gear ratio squared times the
  /// rotor's [kg m2] or, of joints that shift, [kg]. All 0 at first. Their gyroscopic effect and their
  /// momentum in the base's frame are left out (Featherstone 2008, section 9.6; MuJoCo's `armature`).
  /// @throws InputError naming the mechanism: another number than joint values, below 0 or not finite.
  void set_rotors(std::span<const double> inertias);
  std::span<const double> rotors() const { return rotors_; }

  /// Masses that move with the joints, by joint value [kg]: of the links outwards of each.
  std::span<const double> moved_masses() const { return moved_masses_; }

  const Mechanism& mechanism() const { return *mechanism_; }
  std::uint32_t size() const { return mechanism_->value_count(); }
  Workspace make_workspace() const;

  /// Poses, velocities and inertias in the world, for everything below.
  /// @param X_WBase of the base link, at rest. @pre size() values each, a workspace of this object.
  void place(const Pose& X_WBase, std::span<const double> q, std::span<const double> qd,
             Workspace& workspace) const noexcept;

  /// tau that makes the joints accelerate by qdd (recursive Newton-Euler). @pre place()
  void inverse_dynamics(const Vector3& gravity_W, std::span<const double> qdd, std::span<double> tau,
                        Workspace& workspace) const noexcept;
  /// The joint-space inertia matrix, size() x size() (composite rigid bodies). @pre place()
  void mass_matrix(std::span<double> M, Workspace& workspace) const noexcept;
  /// qdd under tau (articulated bodies). @pre place()
  /// @return false where some joint moves no inertia or the result is not finite.
  bool forward_dynamics(const Vector3& gravity_W, std::span<const double> tau, std::span<double> qdd,
                        Workspace& workspace) const noexcept;

  /// J such that J qd is the velocity along `direction_W` of the link's point now at p_W: so J^T f are the
  /// joint torques that balance a force f there. @pre place(), J.size() == size()
  void point_jacobian(std::uint32_t link, const Vector3& p_W, const Vector3& direction_W, std::span<double> J,
                      const Workspace& workspace) const noexcept;
  /// The same for the link's angular velocity about `axis_W`. @pre place(), J.size() == size()
  void turn_jacobian(std::uint32_t link, const Vector3& axis_W, std::span<double> J,
                     const Workspace& workspace) const noexcept;
  Vector3 point_velocity(std::uint32_t link, const Vector3& p_W, const Workspace& workspace) const noexcept;
  Vector3 angular_velocity(std::uint32_t link, const Workspace& workspace) const noexcept;
  /// Accelerations of the link's point now at p_W and of its turning, as forward_dynamics() found them.
  /// @pre forward_dynamics() under the same gravity, or begin_flight()
  Vector3 point_acceleration(std::uint32_t link, const Vector3& p_W, const Vector3& gravity_W,
                             const Workspace& workspace) const noexcept;
  Vector3 angular_acceleration(std::uint32_t link, const Workspace& workspace) const noexcept;
  /// Acceleration of the link's point now at p_W while no rate changes: the change of point_jacobian() along
  /// the motion times the rates [m/s2]. @pre place()
  Vector3 bias_acceleration(std::uint32_t link, const Vector3& p_W,
                            const Workspace& workspace) const noexcept;
  Pose link_pose(std::uint32_t link, const Workspace& workspace) const noexcept;
  double kinetic_energy(const Workspace& workspace) const noexcept;                              ///< [J]
  double potential_energy(const Vector3& gravity_W, const Workspace& workspace) const noexcept;  ///< [J]
  /// Momentum of the links that move, about the world's origin.
  Vector3 linear_momentum(const Workspace& workspace) const noexcept;   ///< [N s]
  Vector3 angular_momentum(const Workspace& workspace) const noexcept;  ///< [N m s]

  /// q and qd over `h` [s] at constant joint torques: an explicit Runge-Kutta method of order 6 (Hairer,
  /// Norsett, Wanner, Solving Ordinary Differential Equations I, II.5), or of 4 as in fly(). Places the
  /// bodies anew.
  /// @return false, q and qd unchanged, where forward_dynamics() fails or the result is not finite.
  bool step(const Pose& X_WBase, const Vector3& gravity_W, std::span<const double> tau, double h,
            std::span<double> q, std::span<double> qd, Workspace& workspace) const noexcept;
  /// The same in two parts, for several lengths from one start: what they have in common, and the rest.
  /// @param placed at the start, may be the workspace itself. @return as forward_dynamics().
  bool begin_flight(const Vector3& gravity_W, std::span<const double> tau, std::span<const double> qd,
                    Workspace& placed, Workspace& workspace) const noexcept;
  /// @param share of a whole step that `h` is: a small one goes by a method of order 4, 3 or 2, which is then
  /// as exact as order 6 is over the whole. Where motion changes so slowly that order 4 is off by less than
  /// rounding, it goes by that, too. Places the bodies anywhere. @return as step().
  /// @pre begin_flight() with the same q and qd, and since then nothing else in the workspace.
  bool fly(const Pose& X_WBase, const Vector3& gravity_W, std::span<const double> tau, double h, double share,
           std::span<double> q, std::span<double> qd, Workspace& workspace) const noexcept;

 private:
  static constexpr std::uint32_t kBase = kNoIndex;

  /// Links that move as one, outwards from a joint.
  struct Body {
    std::uint32_t inner;  // body that it hangs on; kBase
    std::uint32_t value;  // of its joint
    bool is_revolute;
    Pose X_IJ;  // the joint's frame in the inner body's, at value 0
    Vector3 axis_B;
    BodyInertia inertia;
  };

  void gather_bodies();
  void require_inertia() const;

  const Mechanism* mechanism_;
  std::vector<double> rotors_;          // by joint value
  std::vector<double> moved_masses_;    // by joint value
  std::vector<Body> bodies_;            // inner ones first
  std::vector<std::uint32_t> body_of_;  // by link
  std::vector<Pose> X_BL_;              // by link, in its body's frame
};

}  // namespace touchstone::physics
