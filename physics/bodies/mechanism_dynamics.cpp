#include "touchstone/physics/bodies/mechanism_dynamics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "touchstone/contact_core/geometry/matrix3.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/scene/motion.hpp"
#include "touchstone/physics/bodies/runge_kutta.hpp"

namespace touchstone::physics {
namespace {

using PlacedBody = MechanismDynamics::PlacedBody;

/// The rigid body's own inertia about its origin.
void take_own_inertia(const BodyInertia& inertia, PlacedBody& body) {
  const Vector3& c = body.c_W;
  const Vector3 mc = inertia.mass * c;
  const double squared = inertia.mass * dot(c, c);
  body.C = inertia.mass * Matrix3::Identity();
  body.B = skew(mc);
  body.A = body.I_W - outer(mc, c);
  for (int i = 0; i < 3; ++i) body.A(i, i) += squared;
}

/// Adds the outer body's inertia, at offset r, to the inner body's, as blocks of X^T I X (Featherstone 2.66).
void add_shifted(const Matrix3& A, const Matrix3& B, const Matrix3& C, const Vector3& r, PlacedBody& inner) {
  Matrix3 rC, rB, Cr;  // r x C, r x B^T, (r x C) x r
  for (int j = 0; j < 3; ++j) rC.col(j) = cross(r, C.col(j)), rB.col(j) = cross(r, B.row(j));
  for (int i = 0; i < 3; ++i) Cr.row(i) = cross(rC.row(i), r);
  // A - B r + r B^T - r C r; -(B r) is (r B^T)^T, and r C r symmetric.
  inner.A += (A + (rB + rB.transpose())) - Cr;
  inner.B += B + rC;
  inner.C += C;
}

Vector3 moment_of_axis(bool is_revolute, const PlacedBody& body) {
  return is_revolute ? rotate(body.A, body.axis_W) : rotate(body.B, body.axis_W);
}
Vector3 force_of_axis(bool is_revolute, const PlacedBody& body) {
  return is_revolute ? rotate_back(body.B, body.axis_W) : rotate(body.C, body.axis_W);
}
constexpr std::size_t kStages = MechanismDynamics::kStages;
static_assert(kStages == kRungeKuttaStages);
using StageWeights = RungeKutta::Weights;
using Method = RungeKutta;

/// Where motion changes at a rate w, order p leaves (w h)^(p + 1) and order 6 over r h (r w h)^7: not less
/// whatever w, as far as it is above rounding, if r^(p + 1) is 2^(53 (6 - p) / 7) or more: r = 8.1, 51, 1090
/// for orders 4, 3, 2. Four times that, for order 2 sixteen times, makes up for their constants
/// (MechanismDynamics.ShortFlightsLeaveNoMoreThanTheirWholeStep).
const Method& method_for(double share) {
  return share > 1.0 / 204 ? kOrder4 : share > 1.0 / 17500 ? kOrder3 : kOrder2;
}
constexpr double kShareOfOrder4 = 1.0 / 32;
// Of rates: the estimated error of order 4 is 1/128 of rounding or less. Where it was, it was
// within 8.3e-16 of order 6 (20 000 flights of random arms of 1 to 7 joints at 1e-5 to 30 rad/s, weightless
// or not, 0.1 to 10 ms).
constexpr double kMostLeft = 0x1p-60;
// That this would leave more is plain: it is about z^2, and z^5 is left.
constexpr double kMostChange = 0x1p-20;

double largest_of(std::span<const double> values) {
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}
double largest_change(std::span<const double> from, std::span<const double> to) {
  double largest = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) largest = std::max(largest, std::abs(to[i] - from[i]));
  return largest;
}

/// Whether order 4 leaves nothing, by its slopes: with z = w h the first two differ, at the second and third
/// the difference is less by z / 2, and so is what all four bend; the order's error is about z^2 times that.
bool is_smooth(double h, std::span<const double> qd, const MechanismDynamics::Workspace& workspace) {
  const auto& slope = workspace.slope;
  const double first = largest_change(slope[0], slope[1]);
  double second = largest_change(slope[1], slope[2]);
  for (std::size_t i = 0; i < qd.size(); ++i)
    second = std::max(second, std::abs((slope[0][i] - slope[1][i]) - (slope[2][i] - slope[3][i])));
  if (second == 0.0) return true;
  if (first == 0.0) return false;
  const double z = 2.0 * second / first;
  return (h * second) * (z * z) <= kMostLeft * largest_of(qd);
}
/// By the first two alone: not where it cannot be.
bool may_be_smooth(double h, std::span<const double> qd, const MechanismDynamics::Workspace& workspace) {
  return h * largest_change(workspace.slope[0], workspace.slope[1]) <= kMostChange * largest_of(qd);
}

double weighted(const StageWeights& weights, const std::array<std::vector<double>, kStages>& stages,
                std::size_t count, std::size_t i) {
  double sum = 0.0;
  for (std::size_t k = 0; k < count; ++k) sum += weights[k] * stages[k][i];
  return sum;
}

double along_axis(bool is_revolute, const PlacedBody& body, const Vector3& n, const Vector3& f) {
  return dot(body.axis_W, is_revolute ? n : f);
}

}  // namespace

MechanismDynamics::MechanismDynamics(const Mechanism& mechanism, std::span<const BodyInertia> links)
    : mechanism_(&mechanism) {
  const std::string name = "mechanism '" + mechanism.name() + "'";
  if (!links.empty() && links.size() != mechanism.links().size())
    throw InputError(name + ": " + std::to_string(links.size()) + " inertias for " +
                     std::to_string(mechanism.links().size()) + " links");
  std::vector<BodyInertia> inertias;
  for (std::size_t i = 0; i < mechanism.links().size(); ++i) {
    const std::string link = name + ", link '" + mechanism.links()[i].name + "'";
    inertias.push_back(links.empty() ? inertia_of(mechanism.links()[i].mass, link) : links[i]);
    validate(inertias.back(), Thinness::thin, link);
  }
  for (auto* vector : {&rotors_, &moved_masses_}) vector->assign(mechanism.value_count(), 0.0);
  gather_bodies();
  set_links(inertias);
  require_inertia();
}

void MechanismDynamics::gather_bodies() {
  body_of_.assign(mechanism_->links().size(), kBase);
  X_BL_.assign(mechanism_->links().size(), Pose{});
  for (const std::uint32_t j : mechanism_->outwards()) {
    const Mechanism::Joint& joint = mechanism_->joints()[j];
    const Pose X_IJ = compose(X_BL_[joint.inner], joint.X_PJ);
    if (joint.value == Mechanism::kNone) {
      body_of_[joint.outer] = body_of_[joint.inner];
      X_BL_[joint.outer] = compose(X_IJ, joint.X_JC);
    } else {
      body_of_[joint.outer] = static_cast<std::uint32_t>(bodies_.size());
      X_BL_[joint.outer] = joint.X_JC;
      bodies_.push_back({body_of_[joint.inner], joint.value, joint.kind == JointKind::revolute, X_IJ,
                         joint.axis_J, BodyInertia{}});
    }
  }
}

void MechanismDynamics::set_links(std::span<const BodyInertia> links) noexcept {
  for (Body& body : bodies_) body.inertia = BodyInertia{};
  for (const std::uint32_t j : mechanism_->outwards()) {
    const std::uint32_t link = mechanism_->joints()[j].outer;
    if (body_of_[link] == kBase) continue;
    BodyInertia& body = bodies_[body_of_[link]].inertia;
    body = combined(body, transform(X_BL_[link], links[link]));
  }
  for (double& mass : moved_masses_) mass = 0.0;
  for (const Body& body : bodies_)
    for (const Body* outer = &body;; outer = &bodies_[outer->inner]) {
      moved_masses_[outer->value] += body.inertia.mass;
      if (outer->inner == kBase) break;
    }
}

void MechanismDynamics::set_rotors(std::span<const double> inertias) {
  const auto is_good = [](double inertia) { return inertia >= 0.0 && std::isfinite(inertia); };
  if (inertias.size() != rotors_.size() || !std::all_of(inertias.begin(), inertias.end(), is_good))
    throw InputError("mechanism '" + mechanism_->name() + "': one rotor's inertia a joint value, >= 0");
  rotors_.assign(inertias.begin(), inertias.end());
}

void MechanismDynamics::require_inertia() const {
  Workspace workspace = make_workspace();
  const std::vector<double> zero(size(), 0.0);
  std::vector<double> M(size() * size());
  place(Pose{}, mechanism_->reference(), zero, workspace);
  mass_matrix(M, workspace);
  for (const Mechanism::Joint& joint : mechanism_->joints())
    if (joint.value != Mechanism::kNone && !(M[joint.value * size() + joint.value] > 0.0))
      throw InputError("mechanism '" + mechanism_->name() + "', joint '" + joint.name +
                       "': nothing with inertia moves with it");
}

MechanismDynamics::Workspace MechanismDynamics::make_workspace() const {
  Workspace out;
  out.bodies.resize(bodies_.size());
  out.q.resize(size());
  out.qd.resize(size());
  for (auto& stage : out.rate) stage.resize(size());
  for (auto& stage : out.slope) stage.resize(size());
  return out;
}

void MechanismDynamics::place(const Pose& X_WBase, std::span<const double> q, std::span<const double> qd,
                              Workspace& workspace) const noexcept {
  workspace.X_WBase = X_WBase;
  const Vector3 zero = Vector3::Zero();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    PlacedBody& out = workspace.bodies[i];
    const PlacedBody* inner = body.inner == kBase ? nullptr : &workspace.bodies[body.inner];
    const Matrix3& R_WI = inner ? inner->R_WB : X_WBase.R;
    const Vector3 w = inner ? inner->w_W : zero, v = inner ? inner->v_W : zero;
    const double value = q[body.value], rate = qd[body.value];

    // The joint's axis and offset follow from the inner body's attitude.
    const Matrix3 R_WJ = product(R_WI, body.X_IJ.R);
    out.rate = rate;
    out.axis_W = rotate(R_WJ, body.axis_B);
    out.arm_W = rotate(R_WI, body.X_IJ.p);
    // A revolute joint turns the body, a prismatic one shifts it; the bias holds the velocity products.
    if (body.is_revolute) {
      out.R_WB = product(R_WJ, rotation_about(body.axis_B, value));
      out.w_W = w + rate * out.axis_W;
      out.v_W = v + cross(w, out.arm_W);
      out.bias_w = rate * cross(w, out.axis_W);
      out.bias_v = cross(w, cross(w, out.arm_W));
    } else {
      out.R_WB = R_WJ;
      out.arm_W += value * out.axis_W;
      out.w_W = w;
      out.v_W = (v + cross(w, out.arm_W)) + rate * out.axis_W;
      out.bias_w = zero;
      out.bias_v = cross(w, cross(w, out.arm_W)) + (2.0 * rate) * cross(w, out.axis_W);
    }
    // Origin, centre of mass and inertia are expressed in the world's axes.
    out.origin_W = (inner ? inner->origin_W : X_WBase.p) + out.arm_W;
    out.c_W = rotate(out.R_WB, body.inertia.centre_B);
    out.I_W = turned(out.R_WB, body.inertia.inertia_B);
  }
}

void MechanismDynamics::inverse_dynamics(const Vector3& gravity_W, std::span<const double> qdd,
                                         std::span<double> tau, Workspace& workspace) const noexcept {
  const Vector3 zero = Vector3::Zero();
  // Accelerations go outwards from the base, with the force and moment that each body needs.
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    PlacedBody& b = workspace.bodies[i];
    const PlacedBody* inner = body.inner == kBase ? nullptr : &workspace.bodies[body.inner];
    const Vector3 alpha = inner ? inner->alpha : zero;
    const Vector3 a = inner ? inner->a : Vector3(-gravity_W);  // gravity as an acceleration of the base
    b.alpha = alpha + b.bias_w;
    b.a = (a + cross(alpha, b.arm_W)) + b.bias_v;
    (body.is_revolute ? b.alpha : b.a) += qdd[body.value] * b.axis_W;
    const Vector3 a_centre = (b.a + cross(b.alpha, b.c_W)) + cross(b.w_W, cross(b.w_W, b.c_W));
    b.f = body.inertia.mass * a_centre;
    b.n = (cross(b.c_W, b.f) + rotate(b.I_W, b.alpha)) + cross(b.w_W, rotate(b.I_W, b.w_W));
  }
  // Forces and moments go back inwards, and each joint takes the part along its axis.
  for (std::size_t i = bodies_.size(); i-- > 0;) {
    const Body& body = bodies_[i];
    const PlacedBody& b = workspace.bodies[i];
    tau[body.value] = along_axis(body.is_revolute, b, b.n, b.f) + rotors_[body.value] * qdd[body.value];
    if (body.inner == kBase) continue;
    PlacedBody& inner = workspace.bodies[body.inner];
    inner.f += b.f;
    inner.n += b.n + cross(b.arm_W, b.f);
  }
}

void MechanismDynamics::mass_matrix(std::span<double> M, Workspace& workspace) const noexcept {
  const std::size_t size = this->size();
  for (double& entry : M) entry = 0.0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) take_own_inertia(bodies_[i].inertia, workspace.bodies[i]);
  for (std::size_t i = bodies_.size(); i-- > 0;) {
    const Body& body = bodies_[i];
    const PlacedBody& b = workspace.bodies[i];
    if (body.inner != kBase) add_shifted(b.A, b.B, b.C, b.arm_W, workspace.bodies[body.inner]);
    Vector3 n = moment_of_axis(body.is_revolute, b), f = force_of_axis(body.is_revolute, b);
    M[body.value * size + body.value] = along_axis(body.is_revolute, b, n, f) + rotors_[body.value];
    Vector3 arm = b.arm_W;
    for (std::uint32_t j = body.inner; j != kBase; j = bodies_[j].inner) {
      const PlacedBody& inner = workspace.bodies[j];
      n += cross(arm, f);
      const double entry = along_axis(bodies_[j].is_revolute, inner, n, f);
      M[body.value * size + bodies_[j].value] = M[bodies_[j].value * size + body.value] = entry;
      arm = inner.arm_W;
    }
  }
}

bool MechanismDynamics::forward_dynamics(const Vector3& gravity_W, std::span<const double> tau,
                                         std::span<double> qdd, Workspace& workspace) const noexcept {
  // Each body starts from its rigid-body inertia and its velocity-dependent forces.
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    PlacedBody& b = workspace.bodies[i];
    take_own_inertia(bodies_[i].inertia, b);
    b.f = bodies_[i].inertia.mass * cross(b.w_W, cross(b.w_W, b.c_W));
    b.n = cross(b.c_W, b.f) + cross(b.w_W, rotate(b.I_W, b.w_W));
  }
  // From the tips to the base, articulated inertias and bias forces accumulate.
  for (std::size_t i = bodies_.size(); i-- > 0;) {
    const Body& body = bodies_[i];
    PlacedBody& b = workspace.bodies[i];
    b.U_n = moment_of_axis(body.is_revolute, b);
    b.U_f = force_of_axis(body.is_revolute, b);
    b.D = along_axis(body.is_revolute, b, b.U_n, b.U_f) + rotors_[body.value];
    b.u = tau[body.value] - along_axis(body.is_revolute, b, b.n, b.f);
    if (!(b.D > 0.0)) return false;
    if (body.inner == kBase) continue;
    const Vector3 n_over_D = b.U_n / b.D, f_over_D = b.U_f / b.D;
    const Matrix3 A = b.A - outer(n_over_D, b.U_n);
    const Matrix3 B = b.B - outer(n_over_D, b.U_f);
    const Matrix3 C = b.C - outer(f_over_D, b.U_f);
    const double gain = b.u / b.D;
    const Vector3 n = (b.n + (rotate(A, b.bias_w) + rotate(B, b.bias_v))) + gain * b.U_n;
    const Vector3 f = (b.f + (rotate_back(B, b.bias_w) + rotate(C, b.bias_v))) + gain * b.U_f;
    PlacedBody& inner = workspace.bodies[body.inner];
    add_shifted(A, B, C, b.arm_W, inner);
    inner.f += f;
    inner.n += n + cross(b.arm_W, f);
  }
  // From the base to the tips, the joint and body accelerations follow.
  bool is_sound = true;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& body = bodies_[i];
    PlacedBody& b = workspace.bodies[i];
    const PlacedBody* inner = body.inner == kBase ? nullptr : &workspace.bodies[body.inner];
    const Vector3 alpha = inner ? inner->alpha : Vector3(Vector3::Zero());
    const Vector3 a = inner ? inner->a : Vector3(-gravity_W);
    b.alpha = alpha + b.bias_w;
    b.a = (a + cross(alpha, b.arm_W)) + b.bias_v;
    const double acceleration = (b.u - (dot(b.U_n, b.alpha) + dot(b.U_f, b.a))) / b.D;
    (body.is_revolute ? b.alpha : b.a) += acceleration * b.axis_W;
    qdd[body.value] = acceleration;
    is_sound = is_sound && std::isfinite(acceleration);
  }
  return is_sound;
}

void MechanismDynamics::point_jacobian(std::uint32_t link, const Vector3& p_W, const Vector3& direction_W,
                                       std::span<double> J, const Workspace& workspace) const noexcept {
  for (double& entry : J) entry = 0.0;
  for (std::uint32_t i = body_of_[link]; i != kBase; i = bodies_[i].inner) {
    const PlacedBody& b = workspace.bodies[i];
    J[bodies_[i].value] = bodies_[i].is_revolute ? dot(b.axis_W, cross(p_W - b.origin_W, direction_W))
                                                 : dot(b.axis_W, direction_W);
  }
}

void MechanismDynamics::turn_jacobian(std::uint32_t link, const Vector3& axis_W, std::span<double> J,
                                      const Workspace& workspace) const noexcept {
  for (double& entry : J) entry = 0.0;
  for (std::uint32_t i = body_of_[link]; i != kBase; i = bodies_[i].inner)
    if (bodies_[i].is_revolute) J[bodies_[i].value] = dot(workspace.bodies[i].axis_W, axis_W);
}

Vector3 MechanismDynamics::point_velocity(std::uint32_t link, const Vector3& p_W,
                                          const Workspace& workspace) const noexcept {
  if (body_of_[link] == kBase) return Vector3::Zero();
  const PlacedBody& b = workspace.bodies[body_of_[link]];
  return b.v_W + cross(b.w_W, p_W - b.origin_W);
}

Vector3 MechanismDynamics::angular_velocity(std::uint32_t link, const Workspace& workspace) const noexcept {
  return body_of_[link] == kBase ? Vector3(Vector3::Zero()) : workspace.bodies[body_of_[link]].w_W;
}

Vector3 MechanismDynamics::point_acceleration(std::uint32_t link, const Vector3& p_W,
                                              const Vector3& gravity_W,
                                              const Workspace& workspace) const noexcept {
  if (body_of_[link] == kBase) return Vector3::Zero();
  const PlacedBody& b = workspace.bodies[body_of_[link]];
  const Vector3 r = p_W - b.origin_W;
  return ((b.a + gravity_W) + cross(b.alpha, r)) + cross(b.w_W, cross(b.w_W, r));
}

Vector3 MechanismDynamics::angular_acceleration(std::uint32_t link,
                                                const Workspace& workspace) const noexcept {
  return body_of_[link] == kBase ? Vector3(Vector3::Zero()) : workspace.bodies[body_of_[link]].alpha;
}

Vector3 MechanismDynamics::bias_acceleration(std::uint32_t link, const Vector3& p_W,
                                             const Workspace& workspace) const noexcept {
  if (body_of_[link] == kBase) return Vector3::Zero();
  const PlacedBody& outer = workspace.bodies[body_of_[link]];
  Vector3 sum = cross(outer.w_W, cross(outer.w_W, p_W - outer.origin_W));
  for (std::uint32_t i = body_of_[link]; i != kBase; i = bodies_[i].inner) {
    const PlacedBody& b = workspace.bodies[i];
    sum += b.bias_v + cross(b.bias_w, p_W - b.origin_W);
  }
  return sum;
}

Pose MechanismDynamics::link_pose(std::uint32_t link, const Workspace& workspace) const noexcept {
  if (body_of_[link] == kBase) return compose(workspace.X_WBase, X_BL_[link]);
  const PlacedBody& b = workspace.bodies[body_of_[link]];
  return compose(Pose{b.R_WB, b.origin_W}, X_BL_[link]);
}

double MechanismDynamics::kinetic_energy(const Workspace& workspace) const noexcept {
  double twice = 0.0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const PlacedBody& b = workspace.bodies[i];
    const Vector3 v = b.v_W + cross(b.w_W, b.c_W);
    twice += bodies_[i].inertia.mass * dot(v, v) + dot(b.w_W, rotate(b.I_W, b.w_W));
    const double rotor = rotors_[bodies_[i].value];
    if (rotor > 0.0) twice += rotor * (b.rate * b.rate);
  }
  return 0.5 * twice;
}

double MechanismDynamics::potential_energy(const Vector3& gravity_W,
                                           const Workspace& workspace) const noexcept {
  double sum = 0.0;
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    sum -= bodies_[i].inertia.mass * dot(gravity_W, workspace.bodies[i].origin_W + workspace.bodies[i].c_W);
  return sum;
}

Vector3 MechanismDynamics::linear_momentum(const Workspace& workspace) const noexcept {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const PlacedBody& b = workspace.bodies[i];
    sum += bodies_[i].inertia.mass * (b.v_W + cross(b.w_W, b.c_W));
  }
  return sum;
}

Vector3 MechanismDynamics::angular_momentum(const Workspace& workspace) const noexcept {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const PlacedBody& b = workspace.bodies[i];
    const Vector3 p = bodies_[i].inertia.mass * (b.v_W + cross(b.w_W, b.c_W));
    sum += cross(b.origin_W + b.c_W, p) + rotate(b.I_W, b.w_W);
  }
  return sum;
}

bool MechanismDynamics::begin_flight(const Vector3& gravity_W, std::span<const double> tau,
                                     std::span<const double> qd, Workspace& placed,
                                     Workspace& workspace) const noexcept {
  std::copy(qd.begin(), qd.end(), workspace.rate[0].begin());
  return forward_dynamics(gravity_W, tau, workspace.slope[0], placed);
}

bool MechanismDynamics::fly(const Pose& X_WBase, const Vector3& gravity_W, std::span<const double> tau,
                            double h, double share, std::span<double> q, std::span<double> qd,
                            Workspace& workspace) const noexcept {
  // A stage of the Runge-Kutta method places the links at a weighted state and finds its slopes.
  const auto run = [&](const Method& method, std::size_t first, std::size_t end) {
    for (std::size_t stage = first; stage < end; ++stage) {
      for (std::size_t i = 0; i < size(); ++i) {
        workspace.q[i] = q[i] + h * weighted(method.before[stage], workspace.rate, stage, i);
        workspace.rate[stage][i] = qd[i] + h * weighted(method.before[stage], workspace.slope, stage, i);
      }
      place(X_WBase, workspace.q, workspace.rate[stage], workspace);
      if (!forward_dynamics(gravity_W, tau, workspace.slope[stage], workspace)) return false;
    }
    return true;
  };
  // The order follows the share of the step; a large share needs smooth motion for order 4, or takes order 6.
  const Method* method = &method_for(share);
  bool is_done = false;
  if (share > kShareOfOrder4) {
    is_done = run(*method, 1, 2) && may_be_smooth(h, qd, workspace) && run(*method, 2, method->stages) &&
              is_smooth(h, qd, workspace);
    if (!is_done) method = &kOrder6;
  }
  if (!is_done && !run(*method, 1, method->stages)) return false;
  // The weighted slopes give the new state, which is taken only if it is finite.
  for (std::size_t i = 0; i < size(); ++i) {
    workspace.q[i] = q[i] + h * weighted(method->all, workspace.rate, method->stages, i);
    workspace.qd[i] = qd[i] + h * weighted(method->all, workspace.slope, method->stages, i);
    if (!std::isfinite(workspace.q[i]) || !std::isfinite(workspace.qd[i])) return false;
  }
  for (std::size_t i = 0; i < size(); ++i) q[i] = workspace.q[i], qd[i] = workspace.qd[i];
  return true;
}

bool MechanismDynamics::step(const Pose& X_WBase, const Vector3& gravity_W, std::span<const double> tau,
                             double h, std::span<double> q, std::span<double> qd,
                             Workspace& workspace) const noexcept {
  place(X_WBase, q, qd, workspace);
  if (!begin_flight(gravity_W, tau, qd, workspace, workspace) ||
      !fly(X_WBase, gravity_W, tau, h, 1.0, q, qd, workspace))
    return false;
  place(X_WBase, q, qd, workspace);
  return true;
}

}  // namespace touchstone::physics
