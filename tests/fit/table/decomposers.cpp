#include "touchstone/tests/fit/table/decomposers.hpp"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "touchstone/contact_core/fit/excess.hpp"

namespace touchstone::test {
namespace {

constexpr const char* kScript = TOUCHSTONE_DECOMPOSE_SCRIPT;
constexpr int kGivenUp = 124;     // timeout's exit code
constexpr int kNotInstalled = 3;  // the script's

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? "'\\''" : std::string(1, c);
  return out + "'";
}

struct Ended {
  int code;
  std::string said;  // on both streams
};

Ended run(const std::string& command) {
  Ended ended{-1, {}};
  std::FILE* const pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return ended;
  std::array<char, 4096> buffer;
  while (const std::size_t got = std::fread(buffer.data(), 1, buffer.size(), pipe))
    ended.said.append(buffer.data(), got);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) ended.code = WEXITSTATUS(status);
  return ended;
}

// The last line, where a traceback has what happened.
std::string last_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.substr(text.rfind('\n') + 1).substr(0, 80);
}

void write_mesh(const std::filesystem::path& path, const TriangleMesh& mesh) {
  std::ofstream file(path);
  file << mesh.vertices.size() << " " << mesh.triangles.size() << "\n";
  for (const Vector3& v : mesh.vertices) file << fmt::format("{} {} {}\n", v.x(), v.y(), v.z());
  for (const auto& t : mesh.triangles) file << t[0] << " " << t[1] << " " << t[2] << "\n";
}

Decomposition read_hulls(const std::filesystem::path& path) {
  std::ifstream file(path);
  Decomposition out;
  std::size_t hulls = 0;
  file >> out.seconds >> hulls;
  for (std::size_t i = 0; i < hulls && file; ++i) {
    std::size_t vertices = 0, triangles = 0;
    file >> vertices >> triangles;
    ConvexPiece hull;
    for (std::size_t v = 0; v < vertices && file; ++v) {
      Vector3 p;
      file >> p.x() >> p.y() >> p.z();
      hull.vertices.push_back(p);
    }
    for (std::size_t t = 0; t < triangles && file; ++t) {
      std::array<std::uint32_t, 3> corners{};
      file >> corners[0] >> corners[1] >> corners[2];
      hull.triangles.push_back(corners);
    }
    out.hulls.push_back(std::move(hull));
  }
  if (!file || out.hulls.empty()) out = {{}, 0.0, "no hulls"};
  return out;
}

// A tetrahedron as a hexahedron whose corners coincide: bound_excess() fills what its vertices span.
std::array<Vector3, 8> as_hexahedron(const Vector3& a, const Vector3& b, const Vector3& c,
                                     const Vector3& top) {
  return {a, top, b, top, c, top, c, top};  // bits x, y; z is the top
}

}  // namespace

FoundDecomposer find_decomposer(const DecomposerSetting& setting, const std::string& method) {
  const Ended ended = run(quoted(setting.python) + " " + quoted(kScript) + " has " + method);
  if (ended.code == 0) return {last_line(ended.said), {}};
  if (ended.code == kNotInstalled) return {{}, "not installed"};
  return {{}, last_line(ended.said)};
}

Decomposition decompose(const DecomposerSetting& setting, const std::string& method, const TriangleMesh& mesh,
                        const std::filesystem::path& folder) {
  const std::filesystem::path input = folder / "mesh.txt", output = folder / "hulls.txt";
  write_mesh(input, weld(mesh));
  std::filesystem::remove(output);
  const Ended ended =
      run(fmt::format("OMP_NUM_THREADS=1 timeout {} {} {} {} {} {}", setting.longest, quoted(setting.python),
                      quoted(kScript), method, quoted(input.string()), quoted(output.string())));
  if (ended.code == kGivenUp) return {{}, 0.0, fmt::format("not done in {:.0f} s", setting.longest)};
  if (ended.code != 0)
    return {{}, 0.0, ended.said.empty() ? fmt::format("exit code {}", ended.code) : last_line(ended.said)};
  return read_hulls(output);
}

std::size_t count_triangles(const std::vector<ConvexPiece>& hulls) {
  std::size_t count = 0;
  for (const ConvexPiece& hull : hulls) count += hull.triangles.size();
  return count;
}

double bound_hulls_excess(const MeshDistance& mesh, const std::vector<ConvexPiece>& hulls,
                          double resolution) {
  double most = 0.0;
  for (const ConvexPiece& hull : hulls) {
    Vector3 middle = Vector3::Zero();
    for (const Vector3& v : hull.vertices) middle += v / static_cast<double>(hull.vertices.size());
    for (const auto& t : hull.triangles) {
      const std::array<Vector3, 8> part =
          as_hexahedron(hull.vertices[t[0]], hull.vertices[t[1]], hull.vertices[t[2]], middle);
      if (bound_excess(mesh, part, resolution, std::max(most, resolution)).most <= most) continue;
      most = std::max(most, bound_excess(mesh, part, resolution).most);
    }
  }
  return most;
}

}  // namespace touchstone::test
