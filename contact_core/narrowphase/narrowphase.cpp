#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

namespace touchstone {

std::string_view to_string(PairStatus status) {
  switch (status) {
    case PairStatus::separated:
      return "separated";
    case PairStatus::overlapping:
      return "overlapping";
    case PairStatus::undecided:
      return "undecided";
    case PairStatus::failed:
      return "failed";
    case PairStatus::unsupported:
      return "unsupported";
  }
  return "invalid PairStatus";
}

std::string_view to_string(QueryKind kind) {
  switch (kind) {
    case QueryKind::overlap:
      return "overlap";
    case QueryKind::distance:
      return "distance";
    case QueryKind::manifold:
      return "manifold";
  }
  return "invalid QueryKind";
}

}  // namespace touchstone
