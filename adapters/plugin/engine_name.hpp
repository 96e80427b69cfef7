#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "touchstone/adapters/plugin/utf8.hpp"

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
