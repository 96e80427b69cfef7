#pragma once

#include <array>
#include <cstring>
#include <string>
#include <string_view>

namespace touchstone::station {

/// The bytes of a value, as they lie in memory.
template <class T>
void append(std::string& bytes, const T& value) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), &value, sizeof(T));
  bytes.append(raw.data(), raw.size());
}

/// In two hexadecimal digits a byte.
std::string hex_of(std::string_view bytes);
/// The bytes that hex_of() wrote. @throws InputError for other text.
std::string bytes_of(std::string_view hex);

/// FNV-1a, in 16 hexadecimal digits.
std::string hash_of(std::string_view bytes);

}  // namespace touchstone::station
