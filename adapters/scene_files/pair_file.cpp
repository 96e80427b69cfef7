#include "touchstone/adapters/scene_files/pair_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "touchstone/adapters/scene_files/text_file.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using Json = nlohmann::json;

// Why one case is invalid; never leaves this file.
struct BadCase {
  std::string reason;
};

// Why the whole file is refused: a field that nobody reads may be one that is misspelt.
struct BadField {
  std::string reason;
};

std::string shown(const Json& value) {
  std::string text = value.dump();
  if (text.size() > 40) text = text.substr(0, 40) + "...";
  return text;
}

const Json& member(const Json& object, const char* key, const std::string& where) {
  if (!object.is_object()) throw BadCase{where + ": expected an object, got " + shown(object)};
  const auto found = object.find(key);
  if (found == object.end()) throw BadCase{where + ": missing '" + key + "'"};
  return *found;
}

void require_fields(const Json& object, std::initializer_list<const char*> known, const std::string& where) {
  if (!object.is_object()) return;  // the reader of its members says so
  for (const auto& item : object.items()) {
    if (std::find(known.begin(), known.end(), item.key()) != known.end()) continue;
    throw BadField{(where.empty() ? "" : where + ": ") + "unknown field '" + item.key() +
                   "'; known: " + joined(known)};
  }
}

double read_number(const Json& value, const std::string& where) {
  if (value.is_number()) return value.get<double>();
  if (value.is_string()) {
    const std::string& text = value.get_ref<const std::string&>();
    for (const char* word : {"NaN", "nan", "Infinity", "-Infinity", "inf", "-inf"})
      if (text == word) throw BadCase{where + ": not finite: " + text};
    if (!text.empty() && text.front() == '\x01')
      throw BadCase{where + ": beyond the range of a double: " + text.substr(1)};
  }
  throw BadCase{where + ": expected a number, got " + shown(value)};
}

std::vector<double> read_numbers(const Json& value, std::size_t count, const std::string& where) {
  if (!value.is_array() || value.size() != count)
    throw BadCase{where + ": expected " + std::to_string(count) + " numbers, got " + shown(value)};
  std::vector<double> numbers;
  for (const Json& item : value) numbers.push_back(read_number(item, where));
  return numbers;
}

Vector3 read_vector(const Json& value, const std::string& where) {
  const std::vector<double> v = read_numbers(value, 3, where);
  return {v[0], v[1], v[2]};
}

WarpPolicy read_warp(const Json& shape, const std::string& where) {
  if (!shape.contains("warped")) return WarpPolicy::within_tolerance;
  const Json& warped = shape["warped"];
  if (warped == "refuse") return WarpPolicy::refuse;
  if (warped == "within_tolerance") return WarpPolicy::within_tolerance;
  if (warped == "accept") return WarpPolicy::accept;
  throw BadCase{where + ": warped: unknown " + shown(warped) + "; known: refuse, within_tolerance, accept"};
}

// @param lengths_per_metre of the file's unit.
Hexahedron read_shape(const Json& shape, double lengths_per_metre, const std::string& where) {
  const Json& type = member(shape, "type", where);
  if (type == "box") {
    require_fields(shape, {"type", "size"}, where);
    const Vector3 size = read_vector(member(shape, "size", where), where + ": size");
    return Hexahedron::from_size(size / lengths_per_metre, where);
  }
  if (type != "convex") throw BadCase{where + ": unknown type " + shown(type) + "; known: box, convex"};
  require_fields(shape, {"type", "vertices", "warped"}, where);
  const Json& list = member(shape, "vertices", where);
  if (!list.is_array()) throw BadCase{where + ": vertices: expected a list, got " + shown(list)};
  std::vector<Vector3> vertices;
  for (const Json& item : list)
    vertices.push_back(read_vector(item, where + ": vertex " + std::to_string(vertices.size())) /
                       lengths_per_metre);
  return Hexahedron::from_vertices(vertices, read_warp(shape, where), where);
}

Pose read_matrix(const Json& value, double lengths_per_metre, const std::string& where) {
  std::vector<double> entries;
  if (value.is_array() && value.size() == 16) {
    entries = read_numbers(value, 16, where);
  } else if (value.is_array() && value.size() == 4) {
    for (const Json& row : value)
      for (double entry : read_numbers(row, 4, where)) entries.push_back(entry);
  } else {
    throw BadCase{where + ": expected 4 rows of 4 numbers, got " + shown(value)};
  }
  Matrix4 X;
  for (int i = 0; i < 16; ++i)
    X(i / 4, i % 4) = i < 12 && i % 4 == 3 ? entries[i] / lengths_per_metre : entries[i];
  return pose_from_matrix(X, where);
}

Pose read_pose(const Json& pose, double lengths_per_metre, const std::string& where) {
  if (pose == "identity") return {};
  if (pose.is_object() && pose.contains("matrix")) {
    require_fields(pose, {"matrix"}, where);
    return read_matrix(pose["matrix"], lengths_per_metre, where);
  }
  require_fields(pose, {"position", "quaternion_wxyz"}, where);
  Pose X;
  X.p = read_vector(member(pose, "position", where), where + ": position") / lengths_per_metre;
  const std::vector<double> q =
      read_numbers(member(pose, "quaternion_wxyz", where), 4, where + ": quaternion_wxyz");
  X.R = rotation_from_quaternion(q[0], q[1], q[2], q[3], where);
  return X;
}

PosedPair read_pair(const Json& item, double lengths_per_metre) {
  const Json& shapes = member(item, "shapes", "case");
  if (!shapes.is_array() || shapes.size() != 2) throw BadCase{"shapes: expected two, got " + shown(shapes)};
  const Json& poses = member(item, "poses", "case");
  const bool identity = poses == "identity";
  if (!identity && (!poses.is_array() || poses.size() != 2))
    throw BadCase{"poses: expected two, got " + shown(poses)};
  PosedPair pair{{read_shape(shapes[0], lengths_per_metre, "shape 0"),
                  read_shape(shapes[1], lengths_per_metre, "shape 1")},
                 {}};
  for (std::size_t i = 0; i < 2 && !identity; ++i)
    pair.X_WS[i] = read_pose(poses[i], lengths_per_metre, "pose " + std::to_string(i));
  for (int i = 0; i < 2; ++i) {
    WorldVertices world;
    world_vertices(pair.solids[i], pair.X_WS[i], world);
    if (!std::isfinite(largest_coordinate(world)))
      throw BadCase{"pose " + std::to_string(i) + ": a world vertex is beyond the range of a double"};
  }
  return pair;
}

ExactAnswer read_exact(const Json& exact) {
  require_fields(exact, {"class", "signed_distance", "normal"}, "exact");
  const Json& name = member(exact, "class", "exact");
  ExactAnswer answer{PairClass::separated, "", std::nullopt};
  bool known = false;
  for (PairClass pair_class : {PairClass::separated, PairClass::touching, PairClass::penetrating})
    if (name == std::string(to_string(pair_class))) answer.pair_class = pair_class, known = true;
  if (!known)
    throw BadCase{"exact: class: unknown " + shown(name) + "; known: separated, touching, penetrating"};
  const Json& distance = member(exact, "signed_distance", "exact");
  if (!distance.is_string())
    throw BadCase{"exact: signed_distance: expected a decimal as text, got " + shown(distance)};
  answer.signed_distance = distance.get<std::string>();
  if (exact.contains("normal") && !exact["normal"].is_null())
    answer.normal = read_vector(exact["normal"], "exact: normal");
  return answer;
}

CapturedAnswer read_captured(const Json& captured) {
  require_fields(captured, {"by", "status", "separation", "normal", "points"}, "captured");
  CapturedAnswer answer;
  const Json& by = member(captured, "by", "captured");
  if (!by.is_string()) throw BadCase{"captured: by: expected text, got " + shown(by)};
  answer.by = by.get<std::string>();
  const Json& status = member(captured, "status", "captured");
  if (status != "overlapping" && status != "separated")
    throw BadCase{"captured: status: unknown " + shown(status) + "; known: overlapping, separated"};
  answer.contact = status == "overlapping";
  if (!answer.contact) return answer;
  answer.separation = read_number(member(captured, "separation", "captured"), "captured: separation");
  answer.n_AB_W = read_vector(member(captured, "normal", "captured"), "captured: normal");
  const Json& points = member(captured, "points", "captured");
  if (!points.is_array() || points.empty() || points.size() > kMaxManifoldPoints)
    throw BadCase{"captured: points: expected 1 to 8, got " + shown(points)};
  for (const Json& item : points) {
    const std::string where = "captured: point " + std::to_string(answer.points.size());
    require_fields(item, {"a", "b", "separation"}, where);
    answer.points.push_back({read_vector(member(item, "a", where), where + ": a"),
                             read_vector(member(item, "b", where), where + ": b"),
                             read_number(member(item, "separation", where), where + ": separation"), 0});
  }
  return answer;
}

std::string read_text(const Json& item, const char* key) {
  return item.is_object() && item.contains(key) && item[key].is_string() ? item[key].get<std::string>()
                                                                         : std::string();
}

std::string read_id(const Json& item) {
  if (item.is_object() && item.contains("id")) {
    const Json& id = item["id"];
    if (id.is_string() && !id.get_ref<const std::string&>().empty()) return id.get<std::string>();
    if (id.is_number_integer()) return id.dump();
  }
  return {};
}

PairCase read_case(const Json& item, double lengths_per_metre, std::size_t index) {
  PairCase result;
  result.id = read_id(item);
  result.why_hard = read_text(item, "why_hard");
  result.expected_error = read_text(item, "expected_error");
  try {
    if (!item.is_object()) throw BadCase{"expected an object, got " + shown(item)};
    if (result.id.empty()) throw BadCase{"missing 'id' (text or a whole number)"};
    PosedPair pair = read_pair(item, lengths_per_metre);
    if (item.contains("exact")) result.exact = read_exact(item["exact"]);
    if (item.contains("captured")) result.captured = read_captured(item["captured"]);
    result.pair = std::move(pair);
  } catch (const BadCase& bad) {
    result.invalid_reason = bad.reason;
  } catch (const InputError& error) {
    result.invalid_reason = error.what();
  }
  if (result.id.empty()) result.id = "#" + std::to_string(index);
  return result;
}

// Checks the keys that every case must have, valid or not.
void check_case_fields(const Json& item, double lengths_per_metre) {
  require_fields(item, {"id", "shapes", "poses", "exact", "captured", "why_hard", "expected_error"}, "");
  for (const char* key : {"exact", "captured"}) {
    if (lengths_per_metre != 1.0 && item.is_object() && item.contains(key))
      throw BadField{std::string("'") + key + "' is in metres, so that its file's length must be m"};
  }
}

// Lengths a metre in the file's unit.
double read_units(const Json& root) {
  if (!root.is_object() || !root.contains("units")) return 1.0;
  const Json& units = root["units"];
  if (!units.is_object()) throw BadField{"units: expected an object with 'length', got " + shown(units)};
  require_fields(units, {"length"}, "units");
  const Json& length = units.contains("length") ? units["length"] : Json("m");
  if (length == "m") return 1.0;
  if (length == "mm") return 1000.0;
  throw BadField{"units: length: unknown unit " + shown(length) + "; known: m, mm"};
}

bool is_number_character(char c) {
  return (c >= '0' && c <= '9') || c == '+' || c == '-' || c == '.' || c == 'e' || c == 'E';
}

// The JSON library refuses a whole file for one 1e400. Such numbers become marked strings, which only their
// case refuses.
std::string with_overflows_marked(const std::string& text) {
  std::string out;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string || !(c == '-' || (c >= '0' && c <= '9'))) {
      out += c;
      if (c == '\\' && in_string && i + 1 < text.size()) out += text[++i];
      if (c == '"') in_string = !in_string;
      continue;
    }
    std::size_t end = i;
    while (end < text.size() && is_number_character(text[end])) ++end;
    const std::string token = text.substr(i, end - i);
    const bool overflows = !std::isfinite(std::strtod(token.c_str(), nullptr));
    out += overflows ? "\"\\u0001" + token + "\"" : token;
    i = end - 1;
  }
  return out;
}

// The column is named only where the text is as in the file.
[[noreturn]] void malformed(const std::filesystem::path& path, const std::string& text, bool marked,
                            const Json::parse_error& error) {
  const std::size_t end = std::min(error.byte == 0 ? 0 : error.byte - 1, text.size());
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n');
  const std::size_t line_start = end == 0 ? std::string::npos : text.rfind('\n', end - 1);
  const std::size_t column = line_start == std::string::npos ? end + 1 : end - line_start;
  std::string reason = error.what();
  const std::size_t syntax = reason.find("syntax error");
  if (syntax != std::string::npos) reason = reason.substr(syntax);
  throw InputError(path.string() + ":" + std::to_string(line) + (marked ? "" : ":" + std::to_string(column)) +
                   ": malformed JSON: " + reason);
}

// A case needs five levels. The library and our texts of wrong values recurse, so depth is bounded before
// either.
constexpr int kMaxDepth = 64;

Json parse_text(const std::filesystem::path& path, const std::string& text, bool marked) {
  const auto refuse_depth = [&](int depth, Json::parse_event_t, Json&) {
    if (depth > kMaxDepth)
      throw InputError(path.string() + ": nested deeper than " + std::to_string(kMaxDepth) + " levels");
    return true;
  };
  try {
    return Json::parse(text, refuse_depth);
  } catch (const Json::parse_error& error) {
    malformed(path, text, marked, error);
  } catch (const Json::out_of_range&) {
    if (marked) throw InputError(path.string() + ": a number is beyond the range of a double");
    return parse_text(path, with_overflows_marked(text), true);
  }
}

Json to_json(const Vector3& v) { return Json::array({v.x(), v.y(), v.z()}); }

Json to_json(const Hexahedron& solid) {
  refuse_rounded({&solid, 1}, "pair file");
  if (solid.is_box()) return {{"type", "box"}, {"size", to_json(2.0 * solid.half_extents())}};
  Json vertices = Json::array();
  for (const Vector3& p : solid.vertices()) vertices.push_back(to_json(p));
  Json out = {{"type", "convex"}, {"vertices", vertices}};
  if (solid.is_warped()) out["warped"] = "accept";
  return out;
}

Json to_json(const Pose& X) {
  Json rows = Json::array();
  const Matrix4 matrix = matrix_from_pose(X);
  for (int row = 0; row < 4; ++row)
    rows.push_back(Json::array({matrix(row, 0), matrix(row, 1), matrix(row, 2), matrix(row, 3)}));
  return {{"matrix", rows}};
}

Json to_json(const CapturedAnswer& answer) {
  Json out = {{"by", answer.by}, {"status", answer.contact ? "overlapping" : "separated"}};
  if (!answer.contact) return out;
  out["separation"] = answer.separation;
  out["normal"] = to_json(answer.n_AB_W);
  out["points"] = Json::array();
  for (const ContactPoint& point : answer.points)
    out["points"].push_back(
        {{"a", to_json(point.p_A_W)}, {"b", to_json(point.p_B_W)}, {"separation", point.separation}});
  return out;
}

Json to_json(const PairCase& item) {
  Json out = {{"id", item.id},
              {"shapes", Json::array({to_json(item.pair->solids[0]), to_json(item.pair->solids[1])})},
              {"poses", Json::array({to_json(item.pair->X_WS[0]), to_json(item.pair->X_WS[1])})}};
  if (!item.why_hard.empty()) out["why_hard"] = item.why_hard;
  if (item.exact) {
    out["exact"] = {{"class", std::string(to_string(item.exact->pair_class))},
                    {"signed_distance", item.exact->signed_distance}};
    if (item.exact->normal) out["exact"]["normal"] = to_json(*item.exact->normal);
  }
  if (item.captured) out["captured"] = to_json(*item.captured);
  return out;
}

// Whether it is UTF-8.
bool is_text(const std::string& id) {
  try {
    Json(id).dump();
  } catch (const Json::type_error&) {
    return false;
  }
  return true;
}

}  // namespace

std::vector<PairCase> load_pairs(const std::filesystem::path& path) {
  // Cases come as a bare list, or in an object that gives their units.
  const Json root = parse_text(path, scene_files::read_text_file(path), false);
  const bool has_cases = root.is_object() && root.contains("cases");
  const Json& list = has_cases ? root["cases"] : root;
  if (!list.is_array())
    throw InputError(path.string() + ": expected a list of cases, or an object with 'cases'");
  std::string which;  // the case that is being read
  std::vector<PairCase> cases;
  std::map<std::string, std::size_t> first_with_id;
  try {
    if (has_cases) require_fields(root, {"units", "cases"}, "");
    const double lengths_per_metre = read_units(root);
    for (const Json& item : list) {
      const std::size_t index = cases.size();
      const std::string id = read_id(item);
      which = "case '" + (id.empty() ? "#" + std::to_string(index) : id) + "': ";
      check_case_fields(item, lengths_per_metre);
      cases.push_back(read_case(item, lengths_per_metre, index));
      // A replay names a case by its id, which must be the only one.
      const auto [found, is_new] = first_with_id.emplace(cases.back().id, index);
      if (!is_new)
        throw InputError(path.string() + ": cases " + std::to_string(found->second) + " and " +
                         std::to_string(index) + " (counted from 0) have the same id '" + cases.back().id +
                         "'");
    }
  } catch (const BadField& bad) {
    throw InputError(path.string() + ": " + which + bad.reason);
  }
  return cases;
}

std::string pairs_text(std::span<const PairCase> cases) {
  std::ostringstream text;
  text << "[";
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (!cases[i].pair) throw InputError("case '" + cases[i].id + "' is invalid and cannot be saved");
    if (!is_text(cases[i].id))
      throw InputError("case #" + std::to_string(i) + ": its id is no UTF-8 and cannot be saved");
    // The library writes the shortest decimal (at most 17 digits) that reads back as the same double. What an
    // engine says of itself may be no UTF-8.
    text << (i == 0 ? "\n" : ",\n") << to_json(cases[i]).dump(-1, ' ', false, Json::error_handler_t::replace);
  }
  text << "\n]\n";
  return text.str();
}

void save_pairs(const std::filesystem::path& path, std::span<const PairCase> cases) {
  std::string text;
  try {
    text = pairs_text(cases);
  } catch (const InputError& error) {
    throw InputError(path.string() + ": " + error.what());
  }
  std::filesystem::path partial = path;
  partial += ".partial";
  std::ofstream stream(partial, std::ios::binary);
  stream << text;
  stream.close();
  std::error_code error;
  if (stream) std::filesystem::rename(partial, path, error);
  if (!stream || error) {
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    throw InputError(path.string() + ": cannot be written");
  }
}

}  // namespace touchstone
