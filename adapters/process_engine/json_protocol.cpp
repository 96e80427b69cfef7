#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "touchstone/adapters/plugin/engine_name.hpp"
#include "touchstone/adapters/process_engine/protocol.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/narrowphase/answer_check.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"

namespace touchstone::process_engine {
namespace {

using nlohmann::json;

/// No answer is longer: a longer line is refused.
constexpr std::size_t kLongestLine = 1 << 14;

void append(std::string& out, double value) {
  if (!std::isfinite(value)) {
    out += "null";
    return;
  }
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  out.append(digits.data(), end);
}

void append(std::string& out, std::span<const double> values) {
  out += '[';
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) out += ',';
    append(out, values[i]);
  }
  out += ']';
}

/// An unsigned whole number below 2^64: not 30.5, not -1.
std::uint64_t whole_number(const json& value) {
  if (!value.is_number_unsigned()) throw std::runtime_error("no whole number");
  return value.get<std::uint64_t>();
}

PairStatus status_named(const std::string& name) {
  for (int i = 0; i <= static_cast<int>(PairStatus::unsupported); ++i)
    if (name == to_string(static_cast<PairStatus>(i))) return static_cast<PairStatus>(i);
  return static_cast<PairStatus>(255);
}

Vector3 vector_at(const json& of, const char* key) {
  const json& v = of.at(key);
  if (v.size() != 3) throw std::runtime_error("no vector");
  return {v[0].get<double>(), v[1].get<double>(), v[2].get<double>()};
}

class JsonProtocol final : public Protocol {
 public:
  std::size_t largest_question() const override { return 256; }

  void write_solids(std::span<const double> corners, std::string& out) const override {
    out += R"({"solids":[)";
    for (std::size_t i = 0; i < corners.size(); i += 24) {
      if (i > 0) out += ',';
      append(out, corners.subspan(i, 24));
    }
    out += "]}\n";
  }

  void write_question(const Question& question, std::string& out) const override {
    const NarrowphaseInput& input = question.input;
    for (std::size_t k = 0; k < question.pairs.size(); ++k) {
      const auto [a, b] = input.pairs[question.pairs[k]];
      out += R"({"pair":)" + std::to_string(number(question, k)) + R"(,"query":")";
      out += to_string(input.query.kind);
      out += R"(","max_separation":)";
      append(out, input.query.max_separation);
      if (input.query.kind == QueryKind::manifold) {
        out += R"(,"max_points":)" + std::to_string(input.query.max_points) + R"(,"max_point_separation":)";
        append(out, input.query.max_point_separation);
      }
      out += R"(,"a":)" + std::to_string(a) + R"(,"b":)" + std::to_string(b) + R"(,"X_WA":)";
      append(out, {input.poses[a].R.data(), 12});
      out += R"(,"X_WB":)";
      append(out, {input.poses[b].R.data(), 12});
      out += "}\n";
    }
  }

  std::size_t wanted(const Question& question, std::string_view reply) const override {
    const auto lines = static_cast<std::size_t>(std::count(reply.begin(), reply.end(), '\n'));
    const std::size_t open = reply.size() - (reply.rfind('\n') + 1);  // npos + 1 is 0
    if (lines >= question.pairs.size() || open >= kLongestLine) return 0;
    return kLongestLine - open;
  }

  Decoded read_reply(const Question& question, std::string_view reply,
                     const NarrowphaseOutput& output) const override {
    std::size_t whole = 0;  // bytes of the lines that were asked for
    for (std::size_t k = 0; k < question.pairs.size() && whole < reply.size(); ++k)
      whole = std::min(reply.find('\n', whole), reply.size() - 1) + 1;
    if (whole < reply.size()) return {0, "it writes more than was asked"};
    for (std::size_t k = 0; k < question.pairs.size(); ++k) {
      const std::size_t end = reply.find('\n');
      if (end == std::string_view::npos)
        return {k, reply.size() >= kLongestLine ? "its line does not end" : "its reply is short"};
      const json line = json::parse(reply.substr(0, end), nullptr, false);
      reply.remove_prefix(end + 1);
      if (!line.is_object()) return {k, "its line is no JSON object"};
      try {
        if (whole_number(line.at("pair")) != number(question, k))
          return {k, "its answers are in another order than the pairs"};
        read_answer(line, question.input.query, question.pairs[k], output);
      } catch (const std::exception&) {
        return {k, "its line lacks a field or has one of another type"};
      }
    }
    return {question.pairs.size(), nullptr};
  }

 private:
  /// Different in every question, so that an answer to an earlier one shows.
  static std::uint64_t number(const Question& question, std::size_t k) {
    return std::uint64_t{question.batch} * 256 + k;
  }

  static void read_answer(const json& line, const Query& query, std::uint32_t i,
                          const NarrowphaseOutput& output) {
    output.status[i] = status_named(line.at("status").get<std::string>());
    if (query.kind == QueryKind::overlap) return;
    PairGeometry& geometry = output.geometry[i];
    geometry = no_geometry(kInfinity);
    if (output.status[i] > PairStatus::undecided || line.value("separation", json()).is_null()) return;
    geometry.separation = line.at("separation").get<double>();
    geometry.n_AB_W = vector_at(line, "n_AB_W");
    geometry.p_A_W = vector_at(line, "p_A_W");
    geometry.p_B_W = vector_at(line, "p_B_W");
    if (query.kind != QueryKind::manifold) return;
    const json& points = line.at("points");
    geometry.point_count = static_cast<std::int32_t>(std::min<std::size_t>(points.size(), 1000));
    const std::span<ContactPoint> slots = output.points_of(i, query);
    for (std::size_t p = 0; p < std::min(points.size(), slots.size()); ++p)
      slots[p] = {vector_at(points[p], "p_A_W"), vector_at(points[p], "p_B_W"),
                  points[p].at("separation").get<double>(),
                  static_cast<std::uint32_t>(whole_number(points[p].value("feature_id", json(0u))))};
  }
};

}  // namespace

Greeting parse_greeting(std::string_view line) {
  const json greeting = json::parse(line, nullptr, false);
  if (!greeting.is_object()) throw InputError("its first line is no JSON object");
  const char* const lacks = "its first line lacks touchstone, name or format, or has a field of another type";
  try {
    const json bits = greeting.value("scalar_bits", json(64));
    if (!greeting.at("touchstone").is_number_integer() || !bits.is_number_integer()) throw InputError(lacks);
    const auto version = greeting.at("touchstone").get<std::int64_t>();
    if (version != 1) throw InputError("speaks version " + std::to_string(version) + ", this is 1");
    Greeting out;
    out.name = greeting.at("name").get<std::string>();
    if (!is_engine_name(out.name)) throw InputError(kNoEngineName);
    out.description = greeting.value("description", "");
    const auto format = greeting.at("format").get<std::string>();
    if (format != "binary" && format != "json") throw InputError("format '" + format + "' is none");
    out.is_binary = format == "binary";
    Capabilities& of = out.capabilities;
    of.distance = greeting.value("distance", false);
    of.penetration = greeting.value("penetration", false);
    of.manifold = greeting.value("manifold", false);
    of.overlap_complete = greeting.value("overlap_complete", true);
    of.deterministic = greeting.value("deterministic", true);
    of.scalar_bits = static_cast<int>(std::clamp<std::int64_t>(bits.get<std::int64_t>(), 0, 1 << 16));
    of.resolution.absolute = greeting.value("absolute_resolution", 0.0);
    of.resolution.relative = greeting.value("relative_resolution", 0.0);
    // JSON has no infinity: null claims nothing of depths.
    const json depth = greeting.value("depth_resolution", json(0.0));
    of.resolution.of_depth = depth.is_null() ? kInfinity : depth.get<double>();
    if (const char* const wrong = broken_capabilities(of)) throw InputError(wrong);
    return out;
  } catch (const json::exception&) {
    throw InputError(lacks);
  }
}

std::unique_ptr<Protocol> make_json_protocol() { return std::make_unique<JsonProtocol>(); }

}  // namespace touchstone::process_engine
