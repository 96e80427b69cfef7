#pragma once

#include "touchstone/contact_core/fit/fit.hpp"

namespace touchstone::test {

/// Options of a fit that keeps to an error [m], with the repairs that tests have time for.
inline FitOptions within(double over) {
  FitOptions options;
  options.over = over;
  options.repairs = 3;
  return options;
}

}  // namespace touchstone::test
