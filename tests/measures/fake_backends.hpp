#pragma once

#include <memory>
#include <string>
#include <vector>

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/examples/measures/truth/oracle.hpp"

// Unit cubes side by side along x: everything about a pair follows from its gap.

namespace touchstone::measures::testing {

/// `gaps.size()` pairs of unit cubes with these gaps along x [m].
PairSet cubes(const std::vector<double>& gaps);

/// Knows cubes() and nothing else.
class CubeOracle final : public Oracle {
 public:
  PairTruth truth(const WorldVertices& a, const WorldVertices& b) const override;
  double surface_distance(const WorldVertices& solid, const Vector3& p) const override;
  double patch_area(const WorldVertices& a, const WorldVertices& b, const Vector3& n,
                    double limit) const override;
};

/// A narrowphase that needs no build and answers one pair after another, whatever wrong way it is given.
class PairByPair : public Narrowphase {
 public:
  std::string_view name() const noexcept override { return name_; }
  const Capabilities& capabilities() const noexcept override { return capabilities_; }
  void build(std::span<const Hexahedron>) override {}
  std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }
  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace&) const noexcept final {
    for (std::size_t i = 0; i < input.pairs.size(); ++i) answer(input, i, output);
  }

 protected:
  PairByPair(std::string name, const Capabilities& capabilities)
      : name_(std::move(name)), capabilities_(capabilities) {}
  virtual void answer(const NarrowphaseInput& input, std::size_t i,
                      const NarrowphaseOutput& output) const = 0;

  std::string name_;

 private:
  Capabilities capabilities_;
};

/// right, missing_contacts, seeing_phantoms, off_by_1e-3, not_a_number, unsupported, failing, undecided: each
/// wrong in the way it is named. right allocates nothing; every one has a name of its own.
void register_fakes(BackendRegistry& registry);

}  // namespace touchstone::measures::testing
