#include "touchstone/examples/station/flight/bytes.hpp"

#include <fmt/format.h>

#include <cstdint>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::station {

std::string hex_of(std::string_view bytes) {
  std::string out;
  for (const char byte : bytes) out += fmt::format("{:02x}", static_cast<std::uint8_t>(byte));
  return out;
}

std::string bytes_of(std::string_view hex) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string out;
  if (hex.size() % 2 != 0) throw InputError("an odd number of hexadecimal digits");
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    const std::size_t high = kDigits.find(hex[i]), low = kDigits.find(hex[i + 1]);
    if (high == kDigits.npos || low == kDigits.npos) throw InputError("no hexadecimal digits");
    out += static_cast<char>(16 * high + low);
  }
  return out;
}

std::string hash_of(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char byte : bytes) hash = (hash ^ static_cast<std::uint8_t>(byte)) * 0x100000001b3;
  return fmt::format("{:016x}", hash);
}

}  // namespace touchstone::station
