#include "touchstone/examples/station/flight/bytes.hpp"

#include <fmt/format.h>

#include <cstdint>

namespace touchstone::station {

std::string hash_of(std::string_view bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char byte : bytes) hash = (hash ^ static_cast<std::uint8_t>(byte)) * 0x100000001b3;
  return fmt::format("{:016x}", hash);
}

}  // namespace touchstone::station
