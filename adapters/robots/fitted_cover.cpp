#include "touchstone/adapters/robots/fitted_cover.hpp"

#include <algorithm>
#include <bit>
#include <map>
#include <memory>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

/// FNV-1a over 64-bit words.
class Hash {
 public:
  void add(std::uint64_t word) { value_ = (value_ ^ word) * 0x100000001b3U; }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

std::uint64_t hash_of(const TriangleMesh& mesh) {
  Hash hash;
  for (const Vector3& v : mesh.vertices)
    for (int i = 0; i < 3; ++i) hash.add(std::bit_cast<std::uint64_t>(v[i]));
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t i : t) hash.add(i);
  return hash.value();
}

struct Covered {
  TriangleMesh mesh;
  MeshCover cover;
};

/// Covers by the hash of their meshes.
using Cache = std::multimap<std::uint64_t, Covered>;

double size_of(const TriangleMesh& mesh) {
  Bounds bounds;
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t i : t) bounds.add(mesh.vertices[i]);
  const Vector3 side = bounds.high - bounds.low;
  const double middle = side.sum() - side.maxCoeff() - side.minCoeff();
  return middle > 0.0 ? std::min(bounds.diagonal(), 3.0 * middle) : bounds.diagonal();
}

FitOptions fit_options(const FittedCoverOptions& options, const TriangleMesh& mesh, const std::string& name) {
  FitOptions out;
  out.over = options.over > 0.0 ? options.over : options.over_share * size_of(mesh);
  out.repairs = options.repairs;
  if (options.progress)
    out.progress = [&options, &name](std::string_view stage, double share) {
      options.progress(name, stage, share);
    };
  return out;
}

MeshCover cover(const TriangleMesh& mesh, const std::string& name, const FittedCoverOptions& options) {
  validate(mesh, name);
  const FitOptions asked = fit_options(options, mesh, name);
  std::optional<Fit> fit;
  if (options.find) fit = options.find(mesh, asked);
  const bool is_new = !fit.has_value();
  try {
    if (is_new) fit = fit_hexahedra(mesh, asked);
  } catch (const InputError& error) {
    throw InputError("mesh '" + name + "': " + error.what());
  }
  if (options.check) options.check(mesh, *fit, name);
  if (is_new && options.keep) options.keep(mesh, asked, *fit);
  MeshCover cover;
  cover.error = fit->excess;
  cover.solids = make_tree(*fit, name).solids();
  return cover;
}

}  // namespace

CoverMesh fitted_cover(const FittedCoverOptions& options) {
  return [options, cache = std::make_shared<Cache>()](const TriangleMesh& mesh, const std::string& name) {
    const std::uint64_t hash = hash_of(mesh);
    const auto [first, end] = cache->equal_range(hash);
    for (auto at = first; at != end; ++at)
      if (at->second.mesh.vertices == mesh.vertices && at->second.mesh.triangles == mesh.triangles)
        return at->second.cover;
    return cache->emplace(hash, Covered{mesh, cover(mesh, name, options)})->second.cover;
  };
}

}  // namespace touchstone
