#include "touchstone/contact_core/narrowphase/pair_class.hpp"

namespace touchstone {

std::string_view to_string(PairClass pair_class) {
  switch (pair_class) {
    case PairClass::separated:
      return "separated";
    case PairClass::touching:
      return "touching";
    case PairClass::penetrating:
      return "penetrating";
  }
  return "invalid PairClass";
}

}  // namespace touchstone
