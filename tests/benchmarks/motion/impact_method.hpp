#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "touchstone/contact_core/geometry/hexahedron.hpp"
#include "touchstone/contact_core/motion/path.hpp"

// A method that says when two moving solids meet.

namespace touchstone::impact {

/// Two solids, each on an even way: its origin straight, its turn about one axis.
struct Motion {
  Hexahedron a, b;
  RigidPath path_a, path_b;
};

class Method {
 public:
  virtual ~Method() = default;
  virtual std::string_view name() const = 0;
  /// False: it sweeps without turning, whatever is asked.
  virtual bool turns() const { return true; }
  /// Not timed.
  virtual void set(const Motion& motion) = 0;
  /// Timed: the share of the way at which they meet; nothing: they do not.
  virtual std::optional<double> impact() = 0;
};

std::unique_ptr<Method> make_ours();
// Null where the program is built without.
std::unique_ptr<Method> make_bullet_gjk_cast();
std::unique_ptr<Method> make_bullet_subsimplex_cast();
std::unique_ptr<Method> make_bullet_continuous();
std::unique_ptr<Method> make_fcl_indep();
std::unique_ptr<Method> make_fcl_libccd();
std::unique_ptr<Method> make_fcl_naive();
std::unique_ptr<Method> make_fcl_naive_1000();
/// Two cubes of which one goes past the other, by every setting of FCL's; nothing where there is none.
void print_fcl_check();

}  // namespace touchstone::impact
