#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

// README.md has what the pipes carry.

namespace touchstone::process_engine {

/// The engine's first line.
struct Greeting {
  std::string name;
  std::string description;
  Capabilities capabilities;
  bool is_binary = true;
};
/// @throws InputError with what is wrong with it.
Greeting parse_greeting(std::string_view line);
inline constexpr std::size_t kLongestGreeting = 4096;

/// A part of a batch: the pairs at `pairs` of `input`, numbered from 0 in this order.
struct Question {
  const NarrowphaseInput& input;
  std::span<const std::uint32_t> pairs;
  std::uint32_t batch;
};

/// The decoded part of a reply: the first `answered` pairs are written; `problem`, a literal, is why no
/// more are, nullptr where all are.
struct Decoded {
  std::size_t answered = 0;
  const char* problem = nullptr;
};

class Protocol {
 public:
  virtual ~Protocol() = default;
  /// As many pairs as one question may have.
  virtual std::size_t largest_question() const = 0;
  virtual void write_solids(std::span<const double> corners, std::string& out) const = 0;
  virtual void write_question(const Question& question, std::string& out) const = 0;
  /// How many more bytes of the reply may be read; 0: it is complete.
  virtual std::size_t wanted(const Question& question, std::string_view reply) const = 0;
  /// The answers of a reply, perhaps a broken-off one, into the slots of their pairs.
  virtual Decoded read_reply(const Question& question, std::string_view reply,
                             const NarrowphaseOutput& output) const = 0;
};

std::unique_ptr<Protocol> make_binary_protocol();
std::unique_ptr<Protocol> make_json_protocol();

}  // namespace touchstone::process_engine
