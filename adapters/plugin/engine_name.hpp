#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace touchstone {

/// Whether an engine from outside may bear `name`: it becomes a part of file names, of pages and of lines on
/// terminals.
inline bool is_engine_name(std::string_view name) {
  constexpr std::size_t kLongest = 64;
  constexpr std::string_view kAllowed = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_+.-";
  return !name.empty() && name.size() <= kLongest && name.front() != '.' &&
         name.find_first_not_of(kAllowed) == std::string_view::npos;
}
inline constexpr const char* kNoEngineName = "its name is not up to 64 letters, digits and _ - + .";

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

/// What an engine from outside says of itself, as one line that terminals, pages and JSON take: control
/// characters become blanks, bytes that are no UTF-8 '?'; what is longer than 256 bytes is cut.
inline std::string engine_text(std::string_view text) {
  constexpr std::size_t kLongest = 256;
  std::string out;
  while (!text.empty()) {
    const std::size_t count = utf8_bytes(text);
    const bool is_control = text[0] == 0x7F || (count == 1 && static_cast<unsigned char>(text[0]) < 0x20) ||
                            (count == 2 && text[0] == '\xC2' && static_cast<unsigned char>(text[1]) < 0xA0);
    if (out.size() + (count == 0 ? 1 : count) > kLongest) break;
    if (count == 0)
      out += '?';
    else if (is_control)
      out += ' ';
    else
      out += text.substr(0, count);
    text.remove_prefix(count == 0 ? 1 : count);
  }
  return out;
}

}  // namespace touchstone
