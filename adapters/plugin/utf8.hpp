#pragma once

#include <cstddef>
#include <string_view>

namespace touchstone {

/// Bytes of the UTF-8 character that `text` begins with; 0 where it begins with none.
inline std::size_t utf8_bytes(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (text.empty()) return 0;
  const unsigned first = byte(0);
  const std::size_t count = first < 0x80                    ? 1
                            : first >= 0xC2 && first < 0xE0 ? 2
                            : first >= 0xE0 && first < 0xF0 ? 3
                            : first >= 0xF0 && first < 0xF5 ? 4
                                                            : 0;
  if (count == 0 || count > text.size()) return 0;
  for (std::size_t i = 1; i < count; ++i)
    if ((byte(i) & 0xC0U) != 0x80) return 0;
  // Longer than needed, halves of UTF-16 pairs, beyond U+10FFFF.
  const unsigned second = count > 1 ? byte(1) : 0;
  const bool is_none = (first == 0xE0 && second < 0xA0) || (first == 0xED && second >= 0xA0) ||
                       (first == 0xF0 && second < 0x90) || (first == 0xF4 && second >= 0x90);
  return is_none ? 0 : count;
}

inline bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t count = utf8_bytes(text);
    if (count == 0) return false;
    text.remove_prefix(count);
  }
  return true;
}

}  // namespace touchstone
