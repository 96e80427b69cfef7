#pragma once

#include <memory>
#include <string>
#include <vector>

#ifdef BT_USE_DOUBLE_PRECISION
#include "touchstone/adapters/bullet/bullet.hpp"
#else
#include "touchstone/adapters/bullet/bullet_single.hpp"
#endif

#include "touchstone/tests/support/all_pairs.hpp"
#include "touchstone/tests/support/ask.hpp"
#include "touchstone/tests/support/random_poses.hpp"

namespace touchstone::test {

#ifdef BT_USE_DOUBLE_PRECISION
inline constexpr bool kDouble = true;
inline const std::string kBackend = "bullet";
inline void register_backend(BackendRegistry& registry) { register_bullet(registry); }
#else
inline constexpr bool kDouble = false;
inline const std::string kBackend = "bullet_single";
inline void register_backend(BackendRegistry& registry) { register_bullet_single(registry); }
#endif
inline const std::string kGjk = kBackend + "_gjk";

inline BackendRegistry make_registry() {
  BackendRegistry registry;
  register_backend(registry);
  return registry;
}

/// Solid 0 against solid 1.
inline Answer ask(const std::string& backend, const std::vector<Hexahedron>& solids,
                  const std::vector<Pose>& poses, const Query& query) {
  const auto narrowphase = make_registry().make_narrowphase(backend);
  narrowphase->build(solids);
  return ask(*narrowphase, poses, query);
}

}  // namespace touchstone::test
