#pragma once

#include <cstdint>
#include <string_view>

namespace touchstone {

/// The class of a pair, known without error; ground truths, cases and oracles carry it. A backend's
/// answer is a PairStatus, which does not distinguish touching from penetrating and may be no answer at all.
enum class PairClass : std::uint8_t {
  separated,
  touching,     ///< in contact, signed distance 0
  penetrating,  ///< signed distance < 0
};
/// The enumerator's name.
std::string_view to_string(PairClass pair_class);

}  // namespace touchstone
