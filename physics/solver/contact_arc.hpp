#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/physics/solver/scaled_contacts.hpp"

/// @file
/// Solutions of a softened contact problem as long as every contact goes on doing what it does.

namespace touchstone::physics {

/// A point on an arc: impulses y and softness s with the laws of open, sticking and slipping contacts, the
/// velocities being u = W y + b + s (y - anchor). Unknown is only what may change: nothing of an open
/// contact, its three impulses where it sticks, the normal one and the direction where it slips; and log s,
/// the last one. What ends the arc is a limit: a figure that is positive on it.
class ContactArc {
 public:
  /// `second`: of the two that slipping contacts have (an impulse, a slip) and joint rows within bounds.
  struct Limit {
    std::size_t block = 0;
    bool second = false;
  };

  void reserve(std::size_t rows);
  /// @param anchor of rows, kept; or empty: 0.
  void load(const ScaledContacts& problem, std::span<const double> anchor);
  /// The softest arc that is needed. @return false where there is none.
  bool begin();

  std::size_t unknowns() const { return m_ + 1; }
  std::span<const double> y() const { return y_; }
  double softness() const { return s_; }
  /// Unit of steps in an unknown.
  double unit(std::size_t unknown) const { return units_[unknown]; }

  /// Sets the equations up at the point. Returns the largest violation, in units of the largest |b|.
  double linearise();
  /// The last equation: steps at right angles to the tangent; along: the new tangent.
  void border_by(std::span<const double> tangent);
  /// The last equation: steps to where the limit is 0; along: the direction in which it grows.
  void border_by(Limit limit);
  /// Into step and along. @return false where there is no solution. Spoils the equations.
  bool solve(std::span<double> step, std::span<double> along);
  void move(std::span<const double> step);
  /// A distance along the tangent and its change, where log s changes by its share of `length`; the other
  /// unknowns by that of s / (1 + s), in which they are linear both where softness rules and where it hardly
  /// counts.
  void predict(std::span<const double> tangent, std::span<const double> curvature, double length);
  /// Change of the tangent since the point kept last, `length` ago, for predict().
  void find_curvature(std::span<const double> before, std::span<const double> tangent, double length,
                      std::span<double> curvature) const;
  /// The length to where what has this value and rate will be 0, predicted likewise; or infinity.
  double length_to_zero(double value, double rate, std::span<const double> tangent) const;
  /// As limits need them.
  void update_velocities();
  void keep();
  void go_back();

  /// Values of limits, in units of the largest |b| or impulse, at the point; and along the tangent.
  std::size_t limits() const { return 2 * problem_.blocks(); }
  static Limit limit(std::size_t i) { return {i / 2, i % 2 == 1}; }
  double value(Limit limit) const;
  void set_rates(std::span<const double> tangent);
  double rate(Limit limit, std::span<const double> tangent) const;
  /// Switches the block's status where its limit is 0: open or closed, stick or slip.
  /// @return the limit that is to grow from 0 on the next arc.
  Limit cross(Limit limit);

 private:
  /// still: no impulse moves it; closed: without friction.
  enum class Status : std::uint8_t { still, open, closed, slip, stick, lower, within, upper };

  static std::size_t unknowns(Status status);
  void number_unknowns();
  void set_status(std::size_t block);
  void move_unknowns(double factor, std::span<const double> step);
  void fill_velocities();
  void fill_row(std::size_t equation, std::size_t row);
  void fill_turn(std::size_t block);
  void add_velocity(std::size_t row, double factor);

  ScaledContacts problem_;
  std::span<const double> anchor_;
  std::size_t n_ = 0, m_ = 0;  // rows; unknowns but the softness
  double s_ = 1.0, kept_s_ = 1.0;
  double speed_ = 1.0, size_ = 1.0;         // of velocities, of impulses
  std::vector<Status> status_;              // by block
  std::vector<std::size_t> first_;          // by block: of its unknowns
  std::vector<double> y_, u_, slope_, du_;  // by row; slope: u by log s; du: along the tangent
  std::vector<double> e_;                   // by block: a contact's direction of friction where it slips
  std::vector<double> kept_y_, kept_e_;
  std::vector<double> units_;  // by unknown
  std::vector<double> G_;      // u by each unknown
  std::vector<double> A_;      // the equations, with two right-hand sides
};

}  // namespace touchstone::physics
