#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "touchstone/examples/engine_check/world.hpp"

namespace touchstone::engine_check {
namespace {

constexpr double kDensity = 1000.0;

Pose at(double x, double y, double z) {
  Pose X;
  X.p = {x, y, z};
  return X;
}

Body box(const Vector3& size, const Pose& X_WS, bool fixed = false) {
  Body body{Hexahedron::from_size(size), X_WS};
  if (fixed) return body;
  body.mass = kDensity * size.x() * size.y() * size.z();
  const double k = body.mass / 12.0;
  const double x2 = size.x() * size.x(), y2 = size.y() * size.y(), z2 = size.z() * size.z();
  body.inertia = {k * (y2 + z2), k * (x2 + z2), k * (x2 + y2)};
  return body;
}

/// Upper side 0 of a slab at z = 0.
Body floor() { return box({40.0, 40.0, 1.0}, at(0.0, 0.0, -0.5), true); }

/// A square frustum about its centre of mass, half widths below and above.
struct Frustum {
  Body body;
  double below, above;  ///< heights of the faces against the centre of mass
};

Frustum frustum(double bottom, double top, double height) {
  // Sections of half width w(t) = bottom + (top - bottom) t, t in [0, 1]: integrals of w^2, t w^2 and so on.
  const double d = top - bottom;
  const auto moment = [&](int power) {  // of t^power (2w)^2, by its polynomial in t
    return 4.0 * (bottom * bottom / (power + 1) + 2.0 * bottom * d / (power + 2) + d * d / (power + 3));
  };
  const double area = moment(0), centre = moment(1) / area;
  const double zz = moment(2) / area - centre * centre;
  // Each square section has x2 = (2w)^2 / 12: the integral of (2w)^4 / 12.
  double fourth = 0.0;
  const std::array<double, 5> binomial = {1, 4, 6, 4, 1};
  for (int k = 0; k <= 4; ++k)
    fourth += 16.0 * binomial[k] * std::pow(bottom, 4 - k) * std::pow(d, k) / (k + 1);
  const double xx = fourth / 12.0 / area;
  std::array<Vector3, 8> v;
  for (int i = 0; i < 8; ++i) {
    const double w = (i & 1) != 0 ? top : bottom;
    v[i] = {(i & 4) != 0 ? w : -w, (i & 2) != 0 ? w : -w,
            (i & 1) != 0 ? height * (1.0 - centre) : -height * centre};
  }
  Body body{Hexahedron::from_vertices(v), Pose{}};
  body.mass = kDensity * area * height;
  const double side = body.mass * (xx + zz * height * height);
  body.inertia = {side, side, body.mass * 2.0 * xx};
  return {body, -height * centre, height * (1.0 - centre)};
}

World finished(World world) {
  world.end = world.bodies.back().X_WS.p;
  return world;
}

std::string with_hulls(const std::string& name, bool by_hulls) {
  return name + (by_hulls ? ", as hulls" : "");
}

}  // namespace

World stack(int count, bool by_hulls) {
  World world{with_hulls("stack of " + std::to_string(count) + " boxes", by_hulls), {floor()}};
  world.by_hulls = by_hulls;
  for (int i = 0; i < count; ++i) world.bodies.push_back(box({1, 1, 1}, at(0, 0, 0.5 + i)));
  return finished(world);
}

World written_stack(int count, Written how) {
  World world{"stack of " + std::to_string(count) + " cubes, corners " + to_string(how), {floor()}};
  world.by_hulls = true;
  std::mt19937 random(7);
  const auto draw = [&random] { return 2.0 * static_cast<double>(random()) / 0x1p32 - 1.0; };
  for (int i = 0; i < count; ++i) {
    const double w = draw(), x = draw(), y = draw(), z = draw();
    Pose X_SF, X_WF = at(0, 0, i - (i + 1) * 1e-3);
    X_SF.R = rotation_from_quaternion(w, x, y, z);
    X_SF.p = rotate(X_SF.R, {0, 0, -0.5});
    const double yaw = 0.3 * draw();
    X_WF.R = rotation_from_quaternion(std::cos(yaw / 2), 0, 0, std::sin(yaw / 2));
    const WrittenBlock block = written_block(box_corners({1, 1, 1}), X_SF, X_WF, how);
    Body& cube = world.bodies.emplace_back(box({1, 1, 1}, block.X_WS));
    cube.solid = block.solid();
  }
  return finished(world);
}

World frustum_stack(int count) {
  World world{"stack of " + std::to_string(count) + " frusta", {floor()}};
  world.by_hulls = true;
  const Frustum upright = frustum(0.6, 0.4, 0.5), upside_down = frustum(0.4, 0.6, 0.5);
  double z = 0.0;
  for (int i = 0; i < count; ++i, z += 0.5) {
    const Frustum& each = i % 2 == 0 ? upright : upside_down;
    world.bodies.push_back(each.body);
    world.bodies.back().X_WS = at(0, 0, z - each.below);
  }
  return finished(world);
}

World wall(int rows, bool by_hulls) {
  World world{with_hulls("wall of " + std::to_string(rows) + " rows", by_hulls), {floor()}};
  world.by_hulls = by_hulls;
  world.ode_aborts = by_hulls;
  world.steps = 200;
  const double length = 1.0, gap = 0.01;
  for (int row = 0; row < rows; ++row)
    for (int i = 0; i < rows - row; ++i)
      world.bodies.push_back(
          box({length, 0.5, 0.5}, at((i - 0.5 * (rows - row - 1)) * (length + gap), 0, 0.25 + 0.5 * row)));
  return finished(world);
}

World seams(bool by_hulls) {
  World world{with_hulls("slide over seams", by_hulls), {}};
  world.by_hulls = by_hulls;
  world.ode_aborts = by_hulls;
  world.friction = 0.3;
  world.step = 1.0 / 240.0;
  world.steps = 480;
  for (int i = 0; i < 20; ++i) world.bodies.push_back(box({0.5, 2, 1}, at(0.5 * i, 0, -0.5), true));
  world.bodies.push_back(box({0.6, 0.6, 0.3}, at(0.1, 0, 0.15)));
  Body& slider = world.bodies.back();
  const double speed = 5.0, loss = world.friction * kGravity * world.step;
  slider.velocity = {speed, 0, 0};
  const double n = std::floor(speed / loss);  // steps until it stands
  world.end = slider.X_WS.p + Vector3(world.step * (n * speed - loss * n * (n + 1.0) / 2.0), 0, 0);
  return world;
}

World toppling(double share) {
  const double side = 0.2, height = 1.0;
  World world{"lean of " + std::to_string(static_cast<int>(std::lround(100 * share))) + " % of tipping",
              {floor()}};
  world.friction = 0.9;
  world.step = 1.0 / 240.0;
  world.steps = 960;
  const double angle = share * std::atan2(side, height);
  const double c = std::cos(angle), s = std::sin(angle);
  // Turned about y, so that it rests on its edge at x = +side/2, which stays at x = side/2, z = 0.
  Pose X;
  X.R << c, 0, s, 0, 1, 0, -s, 0, c;
  const Vector3 edge = rotate(X.R, {0.5 * side, 0, -0.5 * height});
  X.p = Vector3(0.5 * side, 0, 0) - edge;
  world.bodies.push_back(box({side, side, height}, X));
  return world;
}

World shifted(World world, unsigned start) {
  world.seed = start;
  std::mt19937 random(start);
  const auto shift = [&] { return 1e-4 * (2.0 * static_cast<double>(random()) / 0x1p32 - 1.0); };
  for (Body& body : world.bodies) {
    if (start == 0 || body.mass == 0.0) continue;
    const Vector3 shifted(shift(), shift(), 0.0);
    body.X_WS.p += shifted;
    if (world.end && &body == &world.bodies.back()) *world.end += shifted;
  }
  return world;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void StepTimes::add(std::chrono::steady_clock::duration check, std::chrono::steady_clock::duration step,
                    std::size_t contacts) {
  using Microseconds = std::chrono::duration<double, std::micro>;
  check_.push_back(Microseconds(check).count());
  step_.push_back(Microseconds(step).count());
  step_with_[contacts].push_back(step_.back());
}

void StepTimes::finish(Outcome& out) {
  out.check_us = median(check_);
  out.step_us = median(step_);
  for (auto& [contacts, times] : step_with_) out.steps_with[contacts] = {times.size(), median(times)};
}

void Tracker::see_last(const Vector3& p) {
  rise_ = std::max(rise_, std::abs(p.z() - world_.bodies.back().X_WS.p.z()));
}

void Tracker::finish(std::size_t body, const Pose& X, const Vector3& v, const Vector3& w,
                     Outcome& out) const {
  const Vector3 drift = X.p - world_.bodies[body].X_WS.p;
  out.drift = std::max(out.drift, std::hypot(drift.x(), drift.y()));
  out.speed = std::max(out.speed, norm(v));
  out.turn = std::max(out.turn, norm(w));
  out.rise = rise_;
  if (body + 1 < world_.bodies.size()) return;
  out.end = X.p;
  out.lean = std::acos(std::clamp(X.R(2, 2), -1.0, 1.0));
}

}  // namespace touchstone::engine_check
