#include "touchstone/examples/robot_files/kept_covers.hpp"

#include <unistd.h>

#include <bit>
#include <fstream>
#include <string>
#include <system_error>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/files/json.hpp"
#include "touchstone/examples/program/files/sha256.hpp"

namespace touchstone::robot_files {
namespace {

namespace fs = std::filesystem;

using program::Json;
using program::json;
using program::vector3_of;

/// To be raised where the fit's answers change: covers that were kept before are then fitted anew.
constexpr const char* kFormat = "touchstone kept cover 1";

void append(std::string& bytes, std::uint64_t word) {
  for (int i = 0; i < 8; ++i) bytes += static_cast<char>(word >> (8 * i) & 0xff);
}

void append(std::string& bytes, double value) { append(bytes, std::bit_cast<std::uint64_t>(value)); }

std::string key_of(const TriangleMesh& mesh, const FitOptions& asked) {
  std::string bytes = kFormat;
  append(bytes, asked.over);
  append(bytes, static_cast<std::uint64_t>(asked.repairs));
  append(bytes, static_cast<std::uint64_t>(asked.tries));
  append(bytes, std::uint64_t{mesh.vertices.size()});
  for (const Vector3& v : mesh.vertices)
    for (int i = 0; i < 3; ++i) append(bytes, v[i]);
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t i : t) append(bytes, std::uint64_t{i});
  return program::sha256(bytes);
}

Json json_of(const std::string& key, const Fit& fit) {
  Json hexahedra = Json::array();
  for (const FittedHexahedron& each : fit.hexahedra) {
    Json vertices = Json::array();
    for (const Vector3& v : each.vertices) vertices.push_back(json(v));
    hexahedra.push_back(
        {{"vertices_m", vertices}, {"excess_m", each.excess}, {"farthest_m", json(each.farthest)}});
  }
  return {{"format", kFormat}, {"key", key}, {"excess_m", fit.excess}, {"hexahedra", hexahedra}};
}

Fit fit_of(const Json& json, const std::string& key) {
  if (json.at("format") != kFormat) throw std::runtime_error("another format");
  if (json.at("key") != key) throw std::runtime_error("it is of another mesh, or error, than its name says");
  Fit fit;
  fit.excess = json.at("excess_m");
  for (const Json& each : json.at("hexahedra")) {
    FittedHexahedron& out = fit.hexahedra.emplace_back();
    const Json& vertices = each.at("vertices_m");
    if (vertices.size() != 8) throw std::runtime_error("a hexahedron has eight vertices");
    for (std::size_t i = 0; i < 8; ++i) out.vertices[i] = vector3_of(vertices[i]);
    out.excess = each.at("excess_m");
    out.farthest = vector3_of(each.at("farthest_m"));
  }
  if (fit.hexahedra.empty()) throw std::runtime_error("no hexahedron");
  return fit;
}

}  // namespace

KeptCovers::KeptCovers(fs::path folder) : folder_(std::move(folder)) {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (!fs::is_directory(folder_, error))
    throw InputError("--covers: " + folder_.string() + " is no folder, and cannot be made one");
}

std::optional<Fit> KeptCovers::find(const TriangleMesh& mesh, const FitOptions& asked) const {
  if (!asked.regions.empty()) return std::nullopt;
  const std::string key = key_of(mesh, asked);
  const fs::path file = folder_ / (key + ".cover.json");
  std::error_code none;
  if (!fs::exists(file, none)) return std::nullopt;
  const std::string text = program::read_file(file.string(), "--covers");
  try {
    return fit_of(Json::parse(text), key);
  } catch (const std::exception& error) {
    throw InputError(file.string() + ": no kept cover: " + error.what() + "; remove it to fit anew");
  }
}

void KeptCovers::keep(const TriangleMesh& mesh, const FitOptions& asked, const Fit& fit) const {
  if (!asked.regions.empty()) return;
  const std::string key = key_of(mesh, asked);
  const fs::path file = folder_ / (key + ".cover.json"),
                 temporary = folder_ / ("." + key + "." + std::to_string(::getpid()));
  std::error_code error;
  if (fs::exists(file, error)) return;
  std::ofstream out(temporary, std::ios::binary);
  out << json_of(key, fit).dump(1) << '\n';
  out.close();
  if (out) fs::rename(temporary, file, error);
  if (!out || error) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw InputError("--covers: " + file.string() + " cannot be written");
  }
}

}  // namespace touchstone::robot_files
