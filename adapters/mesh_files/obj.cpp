// OBJ: `v x y z` and `f a/b/c ...` with indices from 1, or from the end below 0. Materials, textures,
// normals, groups and curves say nothing about where the surface is, and are not read.
#include <charconv>

#include "touchstone/adapters/mesh_files/soup.hpp"
#include "touchstone/contact_core/fit/meshes/text_scanner.hpp"

namespace touchstone::mesh_files {
namespace {

constexpr std::size_t kReportEvery = 1 << 16;

std::uint32_t read_corner(std::string_view word, const TextScanner& text, std::size_t vertices) {
  const std::string_view index = word.substr(0, word.find('/'));
  long long value = 0;
  const auto [end, error] = std::from_chars(index.data(), index.data() + index.size(), value);
  if (error != std::errc{} || end != index.data() + index.size())
    text.fail("'" + TextScanner::shown(word) + "' is no vertex of a face");
  const auto count = static_cast<long long>(vertices);
  const long long at = value < 0 ? count + value : value - 1;
  if (at < 0 || at >= count)
    text.fail("vertex " + std::to_string(value) + " of a face, of " + std::to_string(count) + " so far");
  return static_cast<std::uint32_t>(at);
}

/// As a fan: a flat polygon's fan covers it, concave or not (winding numbers add up), and may cover more.
void read_face(TextScanner& text, Soup& soup, const ReadTask& task) {
  std::array<std::uint32_t, 3> corner{};
  std::size_t count = 0;
  for (std::string_view word = text.word_in_line(); !word.empty(); word = text.word_in_line()) {
    if (word == "\\") {  // the face goes on in the next line
      text.skip_line();
      continue;
    }
    const std::uint32_t next = read_corner(word, text, soup.vertices.size());
    if (++count <= 2) {
      corner[count - 1] = next;
      continue;
    }
    corner[2] = next;
    task.require_room(soup.triangles.size());
    soup.triangles.push_back(corner);
    corner[1] = next;
  }
  if (count < 3) text.fail("a face of " + std::to_string(count) + " vertices");
  soup.polygons_split += count > 3;
}

}  // namespace

Soup read_obj(std::string_view bytes, const ReadTask& task) {
  Soup soup;
  TextScanner text(bytes, task.file);
  std::size_t lines = 0;
  for (std::string_view word = text.word(); !word.empty(); word = text.word()) {
    if (word == "v") {
      Vector3 v;
      for (int i = 0; i < 3; ++i) v[i] = text.number(text.word_in_line());
      soup.vertices.push_back(v);
    } else if (word == "f") {
      read_face(text, soup, task);
    }
    text.skip_line();
    if (++lines % kReportEvery == 0) task.advance(text.share());
  }
  return soup;
}

}  // namespace touchstone::mesh_files
