#include "touchstone/adapters/mujoco/solid_geoms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>

#include "touchstone/adapters/mujoco/geom_pose.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/geometry/reach.hpp"

namespace touchstone::mujoco {
namespace {

/// Geoms in the order of `solids`, but for those that are `refused`.
std::string model_text(std::span<const Hexahedron> solids, const std::vector<bool>& refused) {
  std::ostringstream assets, geoms;
  for (std::ostringstream* out : {&assets, &geoms}) {
    out->imbue(std::locale::classic());
    out->precision(std::numeric_limits<double>::max_digits10);
  }
  for (std::size_t i = 0; i < solids.size(); ++i) {
    if (refused[i]) continue;
    if (solids[i].is_box()) {
      const Vector3& half = solids[i].half_extents();
      geoms << "<geom type=\"box\" size=\"" << half.x() << ' ' << half.y() << ' ' << half.z() << "\"/>";
      continue;
    }
    assets << "<mesh name=\"" << i << "\" vertex=\"";
    for (const Vector3& v : solids[i].vertices()) assets << v.x() << ' ' << v.y() << ' ' << v.z() << ' ';
    assets << "\"/>";
    geoms << "<geom type=\"mesh\" mesh=\"" << i << "\"/>";
  }
  return "<mujoco><asset>" + assets.str() + "</asset><worldbody>" + geoms.str() + "</worldbody></mujoco>";
}

/// Null where MuJoCo refuses; its words are in `why`.
ModelHandle try_load(std::span<const Hexahedron> solids, const std::vector<bool>& refused, std::string& why) {
  // The loader sets the process's locale for a while.
  static std::mutex one_at_a_time;
  const std::scoped_lock lock(one_at_a_time);
  try {
    return load_model(model_text(solids, refused));
  } catch (const InputError& error) {
    why = error.what();
    return nullptr;
  }
}

}  // namespace

SolidGeoms::SolidGeoms(std::span<const Hexahedron> solids) {
  refuse_rounded(solids, "mujoco");
  require_version();
  geoms_.reserve(solids.size());
  for (const Hexahedron& solid : solids) geoms_.push_back({-1, {}, reach_of(solid)});
  compile(solids);
}

void SolidGeoms::compile(std::span<const Hexahedron> solids) {
  std::vector<bool> refused(solids.size(), false);
  std::string why;
  model_ = try_load(solids, refused, why);
  if (!model_) {  // which of them?
    for (std::size_t i = 0; i < solids.size(); ++i)
      refused[i] = try_load(solids.subspan(i, 1), {false}, why) == nullptr;
    model_ = try_load(solids, refused, why);
  }
  if (!model_) throw InputError(why);
  int id = 0;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    if (refused[i]) continue;
    geoms_[i].id = id++;
    if (is_mesh(geoms_[i].id)) measure(solids[i], geoms_[i]);
  }
}

void SolidGeoms::measure(const Hexahedron& solid, Geom& geom) {
  const auto mesh = static_cast<std::size_t>(model_->geom_dataid[geom.id]);
  const std::span stored(model_->mesh_vert + 3 * static_cast<std::ptrdiff_t>(model_->mesh_vertadr[mesh]),
                         3 * static_cast<std::size_t>(model_->mesh_vertnum[mesh]));
  const std::optional<Pose> X_SG = pose_in_solid(*model_, geom.id);
  if (!X_SG) return geom.refuse();  // its compiler overflows without a word
  geom.X_SG = *X_SG;
  double worst = 0.0;
  for (const Vector3& vertex : solid.vertices()) {
    double nearest = kInfinity;
    for (std::size_t k = 0; k < stored.size(); k += 3) {
      const Vector3 p_G(stored[k], stored[k + 1], stored[k + 2]);
      nearest = std::min(nearest, norm(transform(geom.X_SG, p_G) - vertex));
    }
    worst = std::max(worst, nearest);
  }
  if (!std::isfinite(worst)) return geom.refuse();
  rounding_ = std::max(rounding_, worst);
  has_meshes_ = true;
}

void SolidGeoms::place(SolidIndex solid, const Pose& X_WS, mjData& data) const {
  const Geom& geom = geoms_[solid];
  mujoco::place(data, geom.id, is_mesh(geom.id) ? compose(X_WS, geom.X_SG) : X_WS);
}

SolidGeoms::Found SolidGeoms::collide(SolidPair pair, mjData& data, std::span<EngineContact> contacts) const {
  const int a = geoms_[pair.a].id, b = geoms_[pair.b].id;
  const bool is_swapped = is_mesh(a) && !is_mesh(b);
  const mjfCollision check = own_collision_functions()[is_mesh(a) + is_mesh(b)];
  return {check(model_.get(), &data, contacts.data(), is_swapped ? b : a, is_swapped ? a : b, 0.0),
          is_swapped};
}

}  // namespace touchstone::mujoco
