#include "touchstone/contact_core/fit/stl_file.hpp"

#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>

#include "touchstone/contact_core/fit/meshes/text_scanner.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

constexpr std::size_t kHeader = 84, kRecord = 50;

// STL is little-endian on every machine.
std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i)
    word |= std::uint32_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
  return word;
}

TriangleMesh parse_binary(const std::string& bytes, std::size_t count, double scale) {
  TriangleMesh mesh;
  mesh.vertices.reserve(3 * count);
  mesh.triangles.reserve(count);
  for (std::size_t t = 0; t < count; ++t) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      Vector3 p;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t at = kHeader + t * kRecord + 12 * (corner + 1) + 4 * axis;
        p(static_cast<Eigen::Index>(axis)) = scale * double{std::bit_cast<float>(word_at(bytes, at))};
      }
      mesh.vertices.push_back(p);
    }
    const auto first = static_cast<std::uint32_t>(3 * t);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

double number(TextScanner& text) {
  const std::string_view word = text.word();
  if (word.empty()) text.fail("the file ends in a triangle");
  return text.number(word);
}

TriangleMesh parse_ascii(const std::string& bytes, double scale, const std::string& name) {
  TriangleMesh mesh;
  TextScanner text(bytes, name);
  std::size_t corners = 0;
  bool is_in_solid = true;
  text.skip_line();  // "solid" and its name
  // Only solids, vertices and the ends of triangles matter; other words are skipped.
  for (std::string_view word = text.word(); !word.empty(); word = text.word()) {
    if (word == "solid" || word == "endsolid") {  // the rest of the line is a name, of any words
      if (corners != 0) text.fail("'" + std::string(word) + "' within a triangle");
      if (is_in_solid == (word == "solid"))
        text.fail("'" + std::string(word) + "' " + (is_in_solid ? "within" : "outside of") + " a solid");
      is_in_solid = !is_in_solid;
      text.skip_line();
    } else if (word == "vertex") {
      const double x = number(text), y = number(text), z = number(text);
      mesh.vertices.emplace_back(scale * x, scale * y, scale * z);
      ++corners;
    } else if (word == "endloop") {
      if (corners != 3) text.fail("a facet of " + std::to_string(corners) + " corners; STL has three");
      const auto end = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.triangles.push_back({end - 3, end - 2, end - 1});
      corners = 0;
    }
  }
  // The file has to end outside of triangles and solids.
  if (corners != 0) text.fail("the file ends in a triangle");
  if (is_in_solid) text.fail("the file ends in a solid: 'endsolid' is missing");
  return mesh;
}

// A binary header is text, or zeros, but its count of triangles, below 2^24, ends with a zero.
bool is_text(std::string_view bytes) { return bytes.find('\0') == std::string_view::npos; }

}  // namespace

std::optional<std::size_t> binary_stl_triangles(std::string_view bytes) {
  if (bytes.size() < kHeader) return std::nullopt;
  const std::size_t count = word_at(bytes, 80);
  if (bytes.size() != kHeader + kRecord * count) return std::nullopt;
  return count;
}

TriangleMesh parse_stl(const std::string& bytes, double scale, const std::string& name) {
  if (!(scale > 0.0) || !std::isfinite(scale))
    reject(name, "scale " + figure(scale) + " is not positive and finite");
  if (bytes.empty()) reject(name, "empty file");
  const bool is_ascii = bytes.starts_with("solid") && bytes.find("facet") != std::string::npos;
  TriangleMesh mesh;
  if (const auto triangles = binary_stl_triangles(bytes)) {
    mesh = parse_binary(bytes, *triangles, scale);
  } else if (is_ascii) {
    mesh = parse_ascii(bytes, scale, name);
  } else if (bytes.size() < kHeader) {
    reject(name, "no STL file: " + std::to_string(bytes.size()) + " bytes");
  } else if (is_text(std::string_view(bytes).substr(0, kHeader))) {
    reject(name, "no STL file: text that does not begin with 'solid', or has no facet");
  } else {
    const std::size_t count = word_at(bytes, 80);
    const std::size_t whole = (bytes.size() - kHeader) / kRecord;
    reject(name, (whole < count ? "cut off in triangle " + std::to_string(whole)
                                : "bytes after the last triangle") +
                     ": the header says " + std::to_string(count) + " triangles, the file has " +
                     std::to_string(bytes.size()) + " bytes");
  }
  validate(mesh, name);
  return mesh;
}

TriangleMesh read_stl(const std::string& path, double scale) {
  if (std::filesystem::is_directory(path)) reject(path, "is a folder, not a file");
  std::ifstream file(path, std::ios::binary);
  if (!file) reject(path, "cannot be read");
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (file.bad()) reject(path, "cannot be read");
  return parse_stl(bytes, scale, path);
}

}  // namespace touchstone
