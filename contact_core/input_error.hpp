#pragma once

#include <stdexcept>
#include <string>

namespace touchstone {

/// Bad input at set-up. what() is one line that names the object, and the face, vertex, file and line where
/// known. Thrown before anything has changed.
class InputError : public std::invalid_argument {
 public:
  explicit InputError(const std::string& message) : std::invalid_argument(message) {}
};

}  // namespace touchstone
