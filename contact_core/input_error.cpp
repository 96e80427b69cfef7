#include "touchstone/contact_core/input_error.hpp"

#include <sstream>

namespace touchstone {

void reject(std::string_view object, const std::string& reason) {
  throw InputError(std::string(object) + ": " + reason);
}

std::string figure(double value) {
  std::ostringstream text;
  text.precision(6);
  text << value;
  return text.str();
}

}  // namespace touchstone
