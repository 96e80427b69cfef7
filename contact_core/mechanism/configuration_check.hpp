#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "touchstone/contact_core/geometry/hexahedron_tree.hpp"
#include "touchstone/contact_core/mechanism/mechanism.hpp"
#include "touchstone/contact_core/narrowphase/narrowphase.hpp"

/// @file
/// Whether configurations of a mechanism are free of contact. Motion planners ask this by the thousand, each
/// time about joint values that are unrelated to the last ones. Contact worlds answer another question: how
/// far a motion may go.

namespace touchstone {

/// An object that stands in the scene.
struct Obstacle {
  std::shared_ptr<const HexahedronTree> tree;
  Pose X_WO;
};

/// An object that a link holds.
struct CarriedObject {
  std::shared_ptr<const HexahedronTree> tree;
  std::string link;
  Pose X_LO;
};

/// The mechanism, obstacles and rules of a ConfigurationCheck.
struct ConfigurationScene {
  std::shared_ptr<const Mechanism> mechanism;
  Pose X_WB = {};  ///< of the base; put through rigid_frame()
  std::vector<Obstacle> obstacles = {};
  std::vector<CarriedObject> carried = {};
  /// Not checked, besides what the mechanism exempts. Each is a link, a tree's name, or `name/hexahedron` of
  /// either; one of the two at least is of the mechanism or carried.
  std::vector<ExemptPair> exempt = {};
};

/// Checks configurations of one mechanism among obstacles at rest. It checks the hexahedra of links and
/// carried objects against obstacles and against each other. It leaves out exempt pairs, a carried object
/// against the link that carries it, and pairs that no joint moves: those are the same in every
/// configuration.
///
/// A configuration is free when the narrowphase finds every checked pair `separated`, at X_WS =
/// compose(link pose, X_LS): touching is contact, and an undecided pair is not free. Answers do not depend on
/// which pairs the narrowphase is asked about, nor on their order.
///
/// Immutable once made; const use from several threads is safe, each with a Scratch of its own, where the
/// narrowphase's is (Capabilities::thread_safe).
class ConfigurationCheck {
 public:
  /// @throws InputError: no mechanism, tree or narrowphase, an invalid pose, two objects of one name, an
  /// unknown name, an exemption between obstacles, a solid that the narrowphase cannot represent.
  ConfigurationCheck(ConfigurationScene scene, std::unique_ptr<Narrowphase> narrowphase);
  ~ConfigurationCheck();
  ConfigurationCheck(const ConfigurationCheck&) = delete;
  ConfigurationCheck& operator=(const ConfigurationCheck&) = delete;

  const Mechanism& mechanism() const;

  /// A thread's memory; nothing else is written. It belongs to the check that made it, and ends with it.
  class Scratch {
   public:
    ~Scratch();
    Scratch(Scratch&&) noexcept;
    Scratch& operator=(Scratch&&) noexcept;

    /// The number of pairs that coarse tests left to the narrowphase, over all calls so far.
    std::uint64_t pairs_asked() const;

   private:
    friend class ConfigurationCheck;
    struct Memory;
    explicit Scratch(std::unique_ptr<Memory> memory);
    std::unique_ptr<Memory> memory_;
  };
  Scratch make_scratch() const;

  /// Ignores the joints' limits (Mechanism::is_within_limits()). Values that are not finite are not free.
  /// Does not allocate after a Scratch's first calls.
  /// @param q joint values [rad or m]. @pre q.size() == mechanism().value_count()
  bool is_free(std::span<const double> q, Scratch& scratch) const noexcept;

  /// is_free() of several configurations: out[i] is 1 where configuration i is free, else 0. Returns how many
  /// are.
  /// @param configurations one after another. @pre as many times value_count() values as `out` has places.
  std::size_t are_free(std::span<const double> configurations, std::span<std::uint8_t> out,
                       Scratch& scratch) const noexcept;

 private:
  struct State;
  std::unique_ptr<const State> state_;
};

}  // namespace touchstone
