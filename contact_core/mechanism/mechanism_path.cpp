#include "touchstone/contact_core/mechanism/mechanism_path.hpp"

#include <algorithm>
#include <cmath>

#include "touchstone/contact_core/broadphase/swept_sphere.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/norms.hpp"

// Bounds on a chain's derivatives.
//
// On a path where joint values go evenly, with q' their rates, the links fall into sections that turn as one.
// Section k hangs on section i through a joint with unit axis a that is fixed in i. With w an angular
// velocity and ' the derivative by s:
//   revolute   w_k  = w_i + q' a,   w_k' = w_i' + q' w_i x a,   w_k'' = w_i'' + q' (w_i' x a + w_i x (w_i x
//   a)) prismatic  w_k  = w_i.
// A point is the sum of vectors each fixed in a section, from where it hangs on to where the next one does,
// and of shifts q a, fixed in direction in the inner section. A vector v fixed in a section has
//   v'   = w x v
//   v''  = w' x v + w x (w x v)
//   v''' = w'' x v + 2 w' x (w x v) + w x (w' x v) + w x (w x (w x v)),
// and a shift (q a)'' = 2 q' a' + q a'', (q a)''' = 3 q' a'' + q a'''.
//
// |w x v| varies slowly: its derivative is w' x v + w x (w x v), of which the second part is at right angles
// to w x v, so that d|w x v|/ds <= |w'| |v|. With values at s = 1/2, from which no s is further than 1/2:
//   |w x v| <= |w x v|_half + |w'| |v| / 2,   |w| <= |w|_half + |w'| / 2,   |w'| <= |w'|_half + |w''| / 2,
// and never more than the sums of the parts' own bounds. Parallel axes have w_i x a = 0 and so w' = 0: the
// bounds are a circle's there.
//
// Along n: n . (w x (w x v)) = (n x w) . (w x v), so |n . v''| <= |n x w| |w x v| + |w'| |v|. And a second
// bound, sharp for small motions: |n . p''| <= |n . p''|_half + |p'''| / 2. The smaller one counts.
//
// Rounding: with u = 2^-53 every unit vector here is off by less than Section::slack, (128 + 2 |q|) u a
// joint: frames are orthonormal to 32u (kFrameTolerance), turns and products are off by (45 + 2 |q|) u (see
// rounding()). It is added where a bound on a product could come out as 0; sums and products of bounds are
// enlarged by kEnlarge.

namespace touchstone {
namespace {

constexpr double kEnlarge = 1.0 + 0x1p-30;

Vector3 second_derivative(const Vector3& turn, const Vector3& turn_change, const Vector3& v) {
  return cross(turn_change, v) + cross(turn, cross(turn, v));
}

/// Bounds |turn x v| of a section's vector. @param length of v.
template <class Section>
double rate_of_vector(const Section& section, const Vector3& v_W, double length) {
  const double w = section.turn;
  return std::min(w * length,
                  norm(cross(section.turn_W, v_W)) + (0.5 * section.change + section.slack * w) * length);
}

}  // namespace

MechanismPath::MechanismPath(const Mechanism& mechanism)
    : mechanism_(&mechanism),
      q0_(mechanism.value_count()),
      q1_(mechanism.value_count()),
      start_(mechanism.links().size()),
      end_(mechanism.links().size()),
      half_(mechanism.links().size()),
      section_of_(mechanism.links().size(), 0),
      standing_(mechanism.links().size(), 0),
      reach_(mechanism.links().size(), 0.0) {
  sections_.reserve(mechanism.joints().size() + 1);
  set(Pose{}, mechanism.reference(), mechanism.reference());
}

void MechanismPath::take_values(const Pose& X_WB, std::span<const double> from,
                                std::span<const double> to) noexcept {
  X_WB_ = rigid_frame(X_WB);
  std::copy(from.begin(), from.end(), q0_.begin());
  std::copy(to.begin(), to.end(), q1_.begin());
  largest_value_ = 0.0;
  for (std::size_t i = 0; i < q0_.size(); ++i)
    largest_value_ = std::max({largest_value_, std::abs(q0_[i]), std::abs(q1_[i])});
}

void MechanismPath::set(const Pose& X_WB, std::span<const double> from, std::span<const double> to) noexcept {
  take_values(X_WB, from, to);
  sweep(0.0, start_);
  divide_into_sections();
  has_end_ = false;
  finish();
}

void MechanismPath::lay(const Pose& X_WB, std::span<const double> from, std::span<const double> to,
                        std::span<const Pose> X_WL) noexcept {
  take_values(X_WB, from, to);
  if (X_WL.empty())
    sweep(0.0, start_);
  else
    stand(X_WL);
  divide_into_sections();
  has_end_ = false;
}

void MechanismPath::rest(const Pose& X_WB, std::span<const double> values,
                         std::span<const Pose> X_WL) noexcept {
  take_values(X_WB, values, values);
  stand(X_WL);
  std::copy(start_.begin(), start_.end(), end_.begin());
  divide_into_sections();
  has_end_ = true;
}

void MechanismPath::finish() noexcept {
  if (has_end_) return;
  sweep(1.0, end_);
  has_end_ = true;
}

double MechanismPath::value_at(std::uint32_t value, double s) const noexcept {
  if (s <= 0.0) return q0_[value];
  if (s >= 1.0) return q1_[value];
  return q0_[value] + s * (q1_[value] - q0_[value]);
}

void MechanismPath::values_at(double s, std::span<double> out) const noexcept {
  for (std::uint32_t i = 0; i < out.size(); ++i) out[i] = value_at(i, s);
}

// The joint's axis passes through (or shifts along) its frame's origin, which the inner link carries.
BodyState MechanismPath::across(const Mechanism::Joint& joint, const BodyState& inner,
                                double s) const noexcept {
  const bool is_fixed = joint.value == Mechanism::kNone;
  const double q = is_fixed ? 0.0 : value_at(joint.value, s);
  BodyState outer;
  outer.X_WO = Mechanism::across(joint, inner.X_WO, q);
  take_rates(joint, inner, outer);
  return outer;
}

/// Of the outer link as it stands.
void MechanismPath::take_rates(const Mechanism::Joint& joint, const BodyState& inner,
                               BodyState& outer) const noexcept {
  outer.centre_W = outer.X_WO.p;
  outer.angular_velocity_W = inner.angular_velocity_W;
  outer.velocity_W = point_velocity(inner, outer.centre_W);
  if (joint.value == Mechanism::kNone) return;
  const double rate = q1_[joint.value] - q0_[joint.value];
  if (rate == 0.0) return;
  const Vector3 joint_W = rate * rotate(inner.X_WO.R, joint.axis_P);
  if (joint.kind == JointKind::prismatic) {
    outer.velocity_W += joint_W;
  } else {
    outer.angular_velocity_W += joint_W;
    outer.velocity_W += cross(joint_W, outer.centre_W - transform(inner.X_WO, joint.X_PJ.p));
  }
}

void MechanismPath::stand(std::span<const Pose> X_WL) noexcept {
  BodyState& base = start_[mechanism_->base()];
  base = {};
  base.X_WO = X_WB_;
  base.centre_W = X_WB_.p;
  for (const std::uint32_t j : mechanism_->outwards()) {
    const Mechanism::Joint& joint = mechanism_->joints()[j];
    start_[joint.outer].X_WO = X_WL[joint.outer];
    take_rates(joint, start_[joint.inner], start_[joint.outer]);
  }
}

void MechanismPath::sweep(double s, std::vector<BodyState>& out) const noexcept {
  BodyState& base = out[mechanism_->base()];
  base = {};
  base.X_WO = X_WB_;
  base.centre_W = X_WB_.p;
  for (const std::uint32_t j : mechanism_->outwards()) {
    const Mechanism::Joint& joint = mechanism_->joints()[j];
    out[joint.outer] = across(joint, out[joint.inner], s);
  }
}

BodyState MechanismPath::at(std::uint32_t link, double s) const noexcept {
  if (s <= 0.0 || !moves(link)) return start_[link];
  if (s >= 1.0 && has_end_) return end_[link];
  const std::span<const std::uint32_t> chain = mechanism_->chain(link);
  BodyState state = start_[mechanism_->joints()[chain[standing_[link]]].inner];
  for (const std::uint32_t j : chain.subspan(standing_[link]))
    state = across(mechanism_->joints()[j], state, s);
  return state;
}

void MechanismPath::divide_into_sections() noexcept {
  // The base is a section that stands.
  sections_.clear();
  sections_.emplace_back().entry_W = X_WB_.p;
  const std::uint32_t base = mechanism_->base();
  section_of_[base] = standing_[base] = 0;
  reach_[base] = 0.0;
  half_[base] = X_WB_;
  // Joint by joint outwards: its reach, section, pose half-way, and what stands before it.
  for (const std::uint32_t j : mechanism_->outwards()) {
    const Mechanism::Joint& joint = mechanism_->joints()[j];
    const bool is_fixed = joint.value == Mechanism::kNone;
    const double shift = joint.kind != JointKind::prismatic
                             ? 0.0
                             : std::max(std::abs(q0_[joint.value]), std::abs(q1_[joint.value]));
    reach_[joint.outer] = reach_[joint.inner] + norm(joint.X_PJ.p) + shift + norm(joint.X_JC.p);
    if (!is_fixed && q0_[joint.value] != q1_[joint.value]) {
      add_section(joint);
      section_of_[joint.outer] = static_cast<std::uint32_t>(sections_.size()) - 1;
    } else {
      section_of_[joint.outer] = section_of_[joint.inner];
    }
    half_[joint.outer] = !moves(joint.outer) ? start_[joint.outer].X_WO
                                             : Mechanism::across(joint, half_[joint.inner],
                                                                 is_fixed ? 0.0 : value_at(joint.value, 0.5));
    standing_[joint.outer] = standing_[joint.inner] + (moves(joint.outer) ? 0 : 1);
  }
}

MechanismPath::Rates MechanismPath::rates_of_vector(const Section& section,
                                                    const Vector3& v_W) const noexcept {
  const double length = norm(v_W), w = section.turn;
  const double first = rate_of_vector(section, v_W, length);
  return {first, w * first + section.change * length,
          (section.change2 + w * section.change) * length + (2.0 * section.change + w * w) * first};
}

/// The outer section's turning, from the inner's, of which it is a copy so far.
void MechanismPath::turn_on(Section& section, const Vector3& axis_W, double rate) const noexcept {
  const double w = section.turn, size = std::abs(rate);
  const double axis_rate = section.axis_rate;
  const Vector3 turn_W = section.turn_W;
  section.turn_W += rate * axis_W;
  section.turn_change_W += rate * cross(turn_W, axis_W);
  section.change2 += size * (section.change + w * axis_rate);
  section.change += size * axis_rate;
  const double largest = w + size;
  section.change = std::min(section.change, norm(section.turn_change_W) + 0.5 * section.change2 +
                                                section.slack * largest * largest);
  section.turn = std::min(largest, norm(section.turn_W) + 0.5 * section.change + section.slack * largest);
}

void MechanismPath::add_section(const Mechanism::Joint& joint) noexcept {
  // The joint's axis and place are taken half-way along the path.
  const std::uint32_t inner_index = section_of_[joint.inner];
  const Section& inner = sections_[inner_index];
  const Pose& X_WP = half_[joint.inner];
  const Vector3 axis_W = rotate(X_WP.R, joint.axis_P);
  const double rate = q1_[joint.value] - q0_[joint.value];
  const Vector3 vector_W = transform(X_WP, joint.X_PJ.p) - inner.entry_W;
  const Rates of_vector = rates_of_vector(inner, vector_W), of_axis = rates_of_vector(inner, axis_W);

  // The part from the inner section's entry to this joint turns with that section.
  Section section = inner;
  section.inner = inner_index;
  section.slack = (128.0 + 2.0 * largest_value_) * kUnitRoundoff *
                  static_cast<double>(mechanism_->chain(joint.outer).size() + 1);
  section.length = norm(vector_W);
  section.vector_rate = of_vector.first;
  section.axis_rate = of_axis.first;
  section.shift = section.shift_rate = 0.0;
  section.entry_W += vector_W;
  Vector3 carried_W = vector_W;
  section.entry_rates.first += of_vector.first;
  section.entry_rates.second += of_vector.second;
  section.entry_rates.third += of_vector.third;
  // The joint adds a shift along its axis, or a turn.
  if (joint.kind == JointKind::prismatic) {
    const double c = std::abs(rate);
    section.shift = std::max(std::abs(q0_[joint.value]), std::abs(q1_[joint.value]));
    section.shift_rate = c;
    const Vector3 shift_W = value_at(joint.value, 0.5) * axis_W;
    carried_W += shift_W;
    section.entry_W += shift_W;
    section.entry_rates.first += c + section.shift * of_axis.first;
    section.entry_rates.second += 2.0 * c * of_axis.first + section.shift * of_axis.second;
    section.entry_rates.third += 3.0 * c * of_axis.second + section.shift * of_axis.third;
    section.entry_acceleration_W += (2.0 * rate) * cross(inner.turn_W, axis_W);
  } else {
    turn_on(section, axis_W, rate);
  }
  section.entry_acceleration_W += second_derivative(inner.turn_W, inner.turn_change_W, carried_W);
  sections_.push_back(section);
}

MechanismPath::Acceleration MechanismPath::acceleration_of(std::uint32_t link,
                                                           const Vector3& p_L) const noexcept {
  const Section& section = sections_[section_of_[link]];
  Acceleration out;
  out.r_W = transform(half_[link], p_L) - section.entry_W;
  out.at_half_W =
      section.entry_acceleration_W + second_derivative(section.turn_W, section.turn_change_W, out.r_W);
  out.rates = rates_of_vector(section, out.r_W);
  out.rates.first += section.entry_rates.first;
  out.rates.second += section.entry_rates.second;
  out.rates.third += section.entry_rates.third;
  return out;
}

/// Bounds |n x turn|.
double MechanismPath::rate_across(const Section& section, const Vector3& n_W) const noexcept {
  return std::min(section.turn,
                  norm(cross(n_W, section.turn_W)) + 0.5 * section.change + section.slack * section.turn);
}

/// Adds the vectors and shifts between the base and a section's entry, term by term inwards.
double MechanismPath::curvature_inwards(const Section& innermost, const Vector3& n_W) const noexcept {
  double sum = 0.0;
  for (const Section* outer = &innermost; outer != sections_.data(); outer = &sections_[outer->inner]) {
    const Section& section = sections_[outer->inner];
    const double across = rate_across(section, n_W);
    sum += across * outer->vector_rate + section.change * outer->length;
    sum += 2.0 * outer->shift_rate * std::min(across, outer->axis_rate) +
           outer->shift * (across * outer->axis_rate + section.change);
  }
  return sum;
}

double MechanismPath::curvature_bound(std::uint32_t link, const BodyState& state, const Vector3& p_W,
                                      const Vector3& n_W) const noexcept {
  double bound = 0.0;
  curvature_bounds(link, state, {&p_W, 1}, n_W, {&bound, 1});
  return bound;
}

void MechanismPath::curvature_bounds(std::uint32_t link, const BodyState& state,
                                     std::span<const Vector3> points_W, const Vector3& n_W,
                                     std::span<double> out) const noexcept {
  std::fill(out.begin(), out.end(), 0.0);
  if (!moves(link)) return;
  const Along along = along_of(link, n_W);
  const Pose X_LW = inverse(state.X_WO);
  for (std::size_t i = 0; i < points_W.size(); ++i)
    out[i] = curvature_along(along, transform(X_LW, points_W[i]));
}

MechanismPath::Along MechanismPath::along_of(std::uint32_t link, const Vector3& n_W) const noexcept {
  const Section& section = sections_[section_of_[link]];
  return {link, n_W, rate_across(section, n_W), curvature_inwards(section, n_W)};
}

double MechanismPath::curvature_along(const Along& along, const Vector3& p_L) const noexcept {
  if (!moves(along.link)) return 0.0;
  const Section& section = sections_[section_of_[along.link]];
  const Acceleration p = acceleration_of(along.link, p_L);
  const double near_half =
      std::abs(dot(along.n_W, p.at_half_W)) + 0.5 * p.rates.third + section.slack * p.rates.second;
  const double rate_within = p.rates.first - section.entry_rates.first;
  const double sum = (along.across * rate_within + section.change * norm(p.r_W)) + along.inwards;
  return std::min(sum, near_half) * kEnlarge;
}

MotionBounds MechanismPath::bounds(std::uint32_t link, const BodyState& state,
                                   const Vector3& p_W) const noexcept {
  if (!moves(link)) return {0.0, 0.0, 0.0, 0.0};
  const Vector3 p_L = transform(inverse(state.X_WO), p_W);
  return {speed_bound(link, p_L), acceleration_bound(link, p_L), turn_bound(link), turn_change_bound(link)};
}

double MechanismPath::speed_bound(std::uint32_t link, const Vector3& p_L) const noexcept {
  if (!moves(link)) return 0.0;
  const Section& section = sections_[section_of_[link]];
  const Vector3 r_W = transform(half_[link], p_L) - section.entry_W;
  return (section.entry_rates.first + rate_of_vector(section, r_W, norm(r_W))) * kEnlarge;
}

void MechanismPath::speed_bounds(std::uint32_t link, std::span<const Sphere> spheres_L,
                                 std::span<double> out) const noexcept {
  std::fill(out.begin(), out.end(), 0.0);
  if (!moves(link)) return;
  const Section& section = sections_[section_of_[link]];
  const Pose& X_WL = half_[link];
  const double turn = turn_bound(link);
  for (std::size_t i = 0; i < spheres_L.size(); ++i) {
    const Vector3 r_W = transform(X_WL, spheres_L[i].centre) - section.entry_W;
    const double of_centre = (section.entry_rates.first + rate_of_vector(section, r_W, norm(r_W))) * kEnlarge;
    out[i] = of_centre + turn * spheres_L[i].radius;
  }
}

double MechanismPath::acceleration_bound(std::uint32_t link, const Vector3& p_L) const noexcept {
  if (!moves(link)) return 0.0;
  const Section& section = sections_[section_of_[link]];
  const Vector3 r_W = transform(half_[link], p_L) - section.entry_W;
  return (section.entry_rates.second + rates_of_vector(section, r_W).second) * kEnlarge;
}

double MechanismPath::turn_bound(std::uint32_t link) const noexcept {
  return sections_[section_of_[link]].turn * kEnlarge;
}

double MechanismPath::turn_change_bound(std::uint32_t link) const noexcept {
  return sections_[section_of_[link]].change * kEnlarge;
}

// A curve is within |p''| / 8 of its chord at the same s.
double MechanismPath::bulge(std::uint32_t link, const Vector3& p_L) const noexcept {
  if (!moves(link)) return 0.0;
  const Acceleration p = acceleration_of(link, p_L);
  const double slack = sections_[section_of_[link]].slack;
  const double second =
      std::min(p.rates.second, norm(p.at_half_W) + 0.5 * p.rates.third + slack * p.rates.second);
  const Vector3 from_W = transform(start_[link].X_WO, p_L), to_W = transform(at(link, 1.0).X_WO, p_L);
  const double of_length = bulge_of_path_length(p.rates.first * kEnlarge, from_W, to_W);
  return std::min(0.125 * second * kEnlarge, of_length) + 2.0 * rounding(link, p_L);
}

// A product of two rotations rounds each entry by 3u at most, 9u in the Frobenius norm; an
// elementary rotation is off by 18u plus its angle's 2u |q|. A joint takes three products: rotations are off
// by (45 + 2 |q|) u a joint. A transform rounds by 7u of the point's distance from the world's origin, three
// of them a joint. All lengths together are within `reach`.
double MechanismPath::rounding(std::uint32_t link, const Vector3& p_L) const noexcept {
  const auto joints = static_cast<double>(mechanism_->chain(link).size() + 1);
  const double reach = 2.0 * norm_inf(X_WB_.p) + reach_[link] + norm(p_L);
  return joints * (72.0 + 2.0 * largest_value_) * kUnitRoundoff * reach;
}

}  // namespace touchstone
