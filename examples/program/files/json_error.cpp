#include "touchstone/examples/program/files/json_error.hpp"

namespace touchstone::program {
namespace {

// As the library numbers its exceptions: json.nlohmann.me/home/exceptions.
constexpr int kParseError = 101, kKeyNotFound = 403;

/// The part of the text from `open` to before `close`; empty where there is none.
std::string part(const std::string& text, const std::string& open, char close, std::size_t skipped) {
  const std::size_t begin = text.find(open);
  if (begin == std::string::npos) return "";
  const std::size_t end = text.find(close, begin + skipped);
  return end == std::string::npos ? "" : text.substr(begin, end - begin);
}

}  // namespace

std::string reason_of(const nlohmann::json::exception& error) {
  const std::string text = error.what();
  if (error.id == kParseError) {
    const std::string place = part(text, "at line ", ':', 0);
    return place.empty() ? "is no JSON" : "is no JSON, " + place;
  }
  if (error.id == kKeyNotFound) {
    const std::string key = part(text, "'", '\'', 1);
    return key.empty() ? "lacks a value" : "has no " + key + "'";
  }
  return "holds a value of another kind than it should";
}

}  // namespace touchstone::program
