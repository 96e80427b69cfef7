#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace touchstone {

/// Bad input at set-up. what() is one line that names the object, and the face, vertex, file and line where
/// known. Thrown before anything has changed.
class InputError : public std::invalid_argument {
 public:
  explicit InputError(const std::string& message) : std::invalid_argument(message) {}
};

/// Throws an InputError: "`object`: `reason`".
[[noreturn]] void reject(std::string_view object, const std::string& reason);

/// A value as errors print it: six digits.
std::string figure(double value);

/// A list as errors print it: "a, b, c". @param text of an element; may be a member.
template <class List, class Text = std::identity>
std::string joined(const List& list, Text text = {}) {
  std::string all;
  for (const auto& each : list) all += (all.empty() ? "" : ", ") + std::string(std::invoke(text, each));
  return all;
}

/// A library's message as errors print it: spaces in place of newlines, none at the end.
std::string one_line(std::string text);

}  // namespace touchstone
