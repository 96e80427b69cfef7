#pragma once

#include <vector>

#include "touchstone/contact_core/broadphase/broadphase.hpp"
#include "touchstone/examples/measures/truth/oracle.hpp"

namespace touchstone::measures {

struct SwarmSize {
  std::size_t objects = 0;
  std::size_t hexahedra_each = 1;

  std::size_t hexahedra() const { return objects * hexahedra_each; }
};

/// Objects that all drift and turn in a cube that gives each hexahedron 4 m3; an object is one box of 0.1 to
/// 1 m an edge, or a loose block of them, 1 m apart.
struct Swarm {
  std::vector<HexahedronTree> trees;
  std::vector<const HexahedronTree*> pointers;
  std::vector<Hexahedron> solids;
  std::vector<std::uint32_t> object_of;   ///< one a solid
  std::vector<std::uint32_t> all;         ///< every object
  std::vector<std::vector<Pose>> frames;  ///< X_WS of every solid
};

Swarm make_swarm(const SwarmSize& size, std::size_t frames, std::uint64_t seed);

/// Pairs of solids of different objects within the margin, from all pairs: bounding spheres that are further
/// apart settle most of them.
std::vector<SolidPair> true_pairs(const Swarm& swarm, std::span<const Pose> poses, double margin,
                                  const Oracle& oracle, int threads);

/// The same of `candidates`: given what several broadphases found, what one misses and another finds shows.
std::vector<SolidPair> confirmed_pairs(const Swarm& swarm, std::span<const Pose> poses, double margin,
                                       std::vector<SolidPair> candidates, const Oracle& oracle, int threads);

}  // namespace touchstone::measures
