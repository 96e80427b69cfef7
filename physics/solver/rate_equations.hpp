#pragma once

#include <cstddef>
#include <vector>

/// @file
/// Linear equations that are coupled by few rates alone.

namespace touchstone::physics {

/// Equations own_e y_e + of_e . w = right_e for y, coupled by rates w = w_0 + sum of left_e y_e: as many as
/// contacts have rows, of bodies that have few. They are eliminated for w (Woodbury, Inverting Modified
/// Matrices, 1950), which costs their number times the square of the rates', not its third power.
///
/// Where own is next to nothing, as of rows that stop, y is what w misses over it, which rounding spoils:
/// each is made a little larger, and iterative refinement takes that out again. Owns its memory.
class RateEquations {
 public:
  /// Rates that take part: the others' entries are 0.
  struct Reach {
    std::size_t first, end;
  };
  /// For as many: no allocation while there are no more.
  void reserve(std::size_t equations, std::size_t rates);
  /// No equations; w_0 = 0.
  void begin(std::size_t rates);
  /// Adds one: its entries of left and of are to be written within its reach.
  void add(Reach reach, double own, double right);
  /// Of the equation that was added last, by rate.
  double* left() { return &left_[left_.size() - rates_]; }
  double* of() { return &of_[of_.size() - rates_]; }
  /// w_0, by rate.
  double* start() { return start_.data(); }
  /// @return false where there is no solution.
  bool solve();
  double solution(std::size_t equation) const { return y_[equation]; }
  /// Multiplications of the last solve().
  double work() const { return work_; }

 private:
  struct Equation {
    Reach reach;
    double own, right, by_own;
  };
  void assemble();
  bool factor();
  void correct(bool is_first);
  void find_missed();

  std::size_t rates_ = 0;
  double work_ = 0.0;
  std::vector<Equation> equations_;
  std::vector<double> left_, of_;  // by equation, then rate
  std::vector<double> start_, w_, y_, missed_;
  std::vector<double> A_;
  std::vector<std::size_t> pivots_;
};

}  // namespace touchstone::physics
