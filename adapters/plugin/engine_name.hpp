#pragma once

#include <cstddef>
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

}  // namespace touchstone
