#include "touchstone/contact_core/input_error.hpp"

#include <algorithm>
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

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

}  // namespace touchstone
