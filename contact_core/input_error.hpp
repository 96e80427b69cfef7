#pragma once

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

}  // namespace touchstone
