#include "touchstone/contact_core/native/native.hpp"

#include <cassert>

#include "touchstone/contact_core/narrowphase/validate.hpp"
#include "touchstone/contact_core/native/common/hull_pair.hpp"
#include "touchstone/contact_core/native/engine/evaluation.hpp"

namespace touchstone {
namespace {

class NativeNarrowphase final : public Narrowphase {
 public:
  NativeNarrowphase() {
    capabilities_.rounded_solids = true;
    capabilities_.distance = capabilities_.penetration = capabilities_.manifold = true;
    // World vertices 2 u, shift 1, projections 6, facet normals and their cross products 8, two bounds'
    // agreement 16 u.
    capabilities_.resolution.relative = 32 * native::kRoundoff;
  }

  std::string_view name() const noexcept override { return "native"; }
  const Capabilities& capabilities() const noexcept override { return capabilities_; }
  void build(std::span<const Hexahedron> solids) override {
    set_ = native::make_solid_set(solids);
    native::take_room(set_, solids.size());
  }
  bool set_solids(SolidIndex first, std::span<const Hexahedron> solids) override {
    native::set_solids(set_, first, solids);
    return true;
  }
  std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }

  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace&) const noexcept override {
    assert(fits(input, output, set_.kinds.size()));
    if (!set_.radii.empty())
      native::evaluate_rounded(set_, kernels_, input, output);
    else
      native::evaluate(set_, kernels_, input, output);
  }

 private:
  Capabilities capabilities_;
  const native::Kernels& kernels_ = native::kernels();
  native::SolidSet set_;
};

}  // namespace

std::unique_ptr<Narrowphase> make_native() { return std::make_unique<NativeNarrowphase>(); }

bool is_native(const Narrowphase& narrowphase) {
  return dynamic_cast<const NativeNarrowphase*>(&narrowphase) != nullptr;
}

void register_native(BackendRegistry& registry) {
  registry.add(BackendRegistry::NarrowphaseEntry{
      "native",
      "contact_core's own: certified overlap, signed distance and manifold of convex hexahedra",
      make_native,
      {}});
}

}  // namespace touchstone
