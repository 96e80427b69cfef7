#pragma once

#include <charconv>
#include <cstddef>
#include <string>
#include <string_view>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {

/// Words and numbers of a mesh's text file, with the line they stand in.
class TextScanner {
 public:
  /// @param file for messages. Both must outlive this.
  TextScanner(std::string_view text, std::string_view file) : text_(text), file_(file) {}

  std::size_t position() const { return at_; }  ///< in the text
  double share() const { return static_cast<double>(at_) / static_cast<double>(text_.size()); }

  /// The next word anywhere; empty at the end.
  std::string_view word() {
    while (at_ < text_.size() && is_space(text_[at_])) skip_one();
    return take_word();
  }
  /// The next word of this line; empty at its end.
  std::string_view word_in_line() {
    while (at_ < text_.size() && text_[at_] != '\n' && is_space(text_[at_])) ++at_;
    return take_word();
  }
  void skip_line() {
    while (at_ < text_.size() && text_[at_] != '\n') ++at_;
    if (at_ < text_.size()) skip_one();
  }

  /// @throws InputError naming the line: no number, or none that is finite.
  double number(std::string_view word) const {
    double value = 0.0;
    const char* first = word.data();
    if (!word.empty() && word[0] == '+') ++first;
    const auto [end, error] = std::from_chars(first, word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size())
      fail(word.empty() ? "a number is missing" : "'" + shown(word) + "' is no number");
    if (!(value - value == 0.0)) fail("a coordinate is " + shown(word) + ", not finite");
    return value;
  }

  [[noreturn]] void fail(const std::string& reason) const {
    reject(std::string(file_) + ":" + std::to_string(line_), reason);
  }
  /// A word as messages show it: short, and printable.
  static std::string shown(std::string_view word) {
    std::string out;
    for (const char c : word.substr(0, 40)) out += c >= ' ' && c <= '~' ? c : '?';
    return out;
  }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
  void skip_one() { line_ += text_[at_++] == '\n'; }
  std::string_view take_word() {
    const std::size_t first = at_;
    while (at_ < text_.size() && !is_space(text_[at_])) ++at_;
    return text_.substr(first, at_ - first);
  }

  std::string_view text_, file_;
  std::size_t at_ = 0, line_ = 1;
};

}  // namespace touchstone
