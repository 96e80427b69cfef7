#include "touchstone/adapters/scene_files/yaml_reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>

#include "touchstone/adapters/scene_files/text_file.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::scene_files {
namespace {

std::string kind_of(const YAML::Node& node) {
  switch (node.Type()) {
    case YAML::NodeType::Map:
      return "a map";
    case YAML::NodeType::Sequence:
      return "a list";
    case YAML::NodeType::Scalar:
      return "'" + node.Scalar() + "'";
    default:
      return "nothing";
  }
}

bool is_infinite_or_nan(std::string_view text) {
  if (!text.empty() && (text[0] == '-' || text[0] == '+')) text.remove_prefix(1);
  std::string lower(text.substr(text.substr(0, 1) == "." ? 1 : 0));
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? c + 32 : c; });
  return lower == "nan" || lower == "inf" || lower == "infinity";
}

// YAML::Load reads the first document only; what follows it must not be passed over in silence.
void require_one_document(const std::filesystem::path& path, const std::string& text) {
  std::istringstream lines(text);
  bool begun = false;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const bool marker = line.substr(0, 3) == "---" || line.substr(0, 3) == "...";
    if (marker && begun)
      throw InputError(path.string() + ":" + std::to_string(number) +
                       ": expected one YAML document, here it ends");
    if (!line.empty() && line[0] != '#') begun = true;
  }
}

}  // namespace

YAML::Node parse_yaml(const std::filesystem::path& path) {
  const std::string text = read_text_file(path);
  require_one_document(path, text);
  try {
    // Not LoadAll: in yaml-cpp 0.7 it never returns on text such as a line that starts with a comma.
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    std::string reason = error.msg;  // may quote a line end
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw InputError(path.string() + ":" + std::to_string(error.mark.line + 1) +
                     ": malformed YAML: " + reason);
  }
}

std::string YamlReader::file_and_line() const {
  const YAML::Mark mark = node_.Mark();
  return source_->file + (mark.line >= 0 ? ":" + std::to_string(mark.line + 1) : "");
}

void YamlReader::fail(const std::string& reason) const {
  throw InputError(file_and_line() + ": " + where_ + reason);
}

void YamlReader::require_keys(std::initializer_list<std::string_view> known) const {
  if (!node_.IsMap()) fail("expected a map with the keys " + joined(known) + ", got " + kind_of(node_));
  std::set<std::string> seen;
  for (const auto& entry : node_) {
    const YamlReader key(entry.first, *source_, where_);
    if (!entry.first.IsScalar()) key.fail("a key must be a word, got " + kind_of(entry.first));
    const std::string& name = entry.first.Scalar();
    if (known.size() > 0 && std::find(known.begin(), known.end(), name) == known.end())
      key.fail("unknown key '" + name + "'; known: " + joined(known));
    if (!seen.insert(name).second) key.fail("key '" + name + "' occurs twice");
  }
}

bool YamlReader::has(std::string_view key) const {
  return node_.IsMap() && node_[std::string(key)].IsDefined();
}

YamlReader YamlReader::at(std::string_view key) const {
  if (!has(key)) fail("missing '" + std::string(key) + "'");
  return YamlReader(node_[std::string(key)], *source_, where_).within(std::string(key));
}

std::vector<YamlReader> YamlReader::list() const {
  if (!node_.IsSequence()) fail("expected a list, got " + kind_of(node_));
  std::vector<YamlReader> items;
  for (const YAML::Node& item : node_) items.emplace_back(item, *source_, where_);
  return items;
}

std::string YamlReader::text() const {
  if (!node_.IsScalar()) fail("expected text, got " + kind_of(node_));
  return node_.Scalar();
}

double YamlReader::parameter(std::string_view name) const {
  const auto found = source_->parameters.find(std::string(name));
  if (found != source_->parameters.end()) return found->second;
  std::vector<std::string> names;
  for (const auto& entry : source_->parameters) names.push_back(entry.first);
  fail("unknown parameter '$" + std::string(name) + "'; known: " + (names.empty() ? "none" : joined(names)));
}

double YamlReader::number() const {
  const bool quoted = node_.IsScalar() && node_.Tag() == "!";
  if (!node_.IsScalar() || quoted)
    fail("expected a number, got " + (quoted ? "the text " : std::string()) + kind_of(node_));
  std::string_view text = node_.Scalar();
  if (text.substr(0, 1) == "$") return parameter(text.substr(1));
  if (text.substr(0, 2) == "-$") return -parameter(text.substr(2));
  if (is_infinite_or_nan(text)) fail("not finite: " + std::string(text));
  if (text.substr(0, 1) == "+") text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::result_out_of_range) fail("beyond the range of a double: " + std::string(text));
  if (error != std::errc() || end != text.data() + text.size())
    fail("expected a number, got " + kind_of(node_));
  return value;
}

int YamlReader::integer() const {
  const double value = number();
  if (value != std::floor(value) || std::abs(value) > 1e9)
    fail("expected a whole number, got " + kind_of(node_));
  return static_cast<int>(value);
}

std::vector<double> YamlReader::numbers(std::size_t count) const {
  const std::vector<YamlReader> items = list();
  if (items.size() != count)
    fail("expected " + std::to_string(count) + " numbers, got " + std::to_string(items.size()));
  std::vector<double> values;
  for (const YamlReader& item : items) values.push_back(item.number());
  return values;
}

Vector3 YamlReader::vector3() const {
  const std::vector<double> v = numbers(3);
  return {v[0], v[1], v[2]};
}

}  // namespace touchstone::scene_files
