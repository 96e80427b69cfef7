#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/physics/solver/rate_equations.hpp"
#include "touchstone/physics/solver/scaled_contacts.hpp"

/// @file
/// Newton's step on the natural map.

namespace touchstone::physics {

/// Steps of the semismooth Newton method on the natural map y - P(y - rho u) (Alart and Curnier, A Mixed
/// Formulation for Frictional Contact Problems Prone to Newton Like Solution Methods, 1991), the linear
/// systems kept regular by a proximal term. Open contacts and joint rows at their bounds are known
/// beforehand; the other rows are one system, eliminated as far as its profile reaches, or by the rates of
/// what they move where these are few (RateEquations).
class ContactNewton {
 public:
  void reserve(std::size_t rows);
  /// @param u velocities at y, scaled. @param step out. @param rho scales the natural map;
  /// does not change its roots.
  /// @return false where there is no solution.
  bool step(const ScaledProblem& problem, std::span<const double> y, std::span<const double> u, double rho,
            std::span<double> step);
  /// Multiplications of the last step's linear system.
  double work() const { return work_; }

 private:
  enum class Law : std::uint8_t { held, stopped, slipping };
  /// Of a contact that slips: its direction; friction's radius over the length of what is projected, 1 at
  /// most; how friction grows with the normal impulse; and how far the impulse along e is from its radius.
  struct Slip {
    double e[2];
    double ratio, friction, along;

    double across(double t1, double t2) const { return e[0] * t2 - e[1] * t1; }
  };

  void decide(std::span<double> step);
  void decide_contact(std::size_t contact, std::span<double> step);
  void gather(std::size_t equation, std::size_t row, double factor);
  void fill_stop(std::size_t row);
  void fill_slip(std::size_t contact);
  Slip slip_of(std::size_t contact) const;
  void fill();
  void find_profile();
  bool eliminate_rows();
  void meet_by_rates(std::span<const double> step);
  void add_stop(std::size_t row, RateEquations::Reach reach);
  void add_slip(std::size_t contact);
  bool solve_by_rates(std::span<double> step);

  const ScaledProblem* problem_ = nullptr;
  std::span<const double> y_, u_;
  double rho_ = 1.0;
  std::size_t n_ = 0, m_ = 0;
  double work_ = 0.0;
  std::vector<Law> law_;                      // by row
  std::vector<std::size_t> active_, before_;  // rows that are not held; how many of them come before a row
  std::vector<double> met_u_;                 // u after the steps of what is held
  std::vector<double> A_, right_;
  std::vector<std::size_t> end_, block_end_;  // of A_, by row; before elimination, by block
  RateEquations equations_;
  std::vector<double> held_w_;  // rates by the steps of what is held
};

}  // namespace touchstone::physics
