#include "touchstone/examples/measures/truth/oracle.hpp"

#ifdef TOUCHSTONE_HAS_EXACT
#include "touchstone/adapters/exact/contact_patch.hpp"
#include "touchstone/adapters/exact/signed_distance.hpp"
#endif

namespace touchstone::measures {

#ifdef TOUCHSTONE_HAS_EXACT

namespace {

class ExactOracle final : public Oracle {
 public:
  PairTruth truth(const WorldVertices& a, const WorldVertices& b) const override {
    const ExactResult result = exact_signed_distance(a, b);
    return {result.pair_class, result.separation, result.n_AB_W, result.normal_unique};
  }
  double surface_distance(const WorldVertices& solid, const Vector3& p) const override {
    return exact_surface_distance(solid, p);
  }
  double patch_area(const WorldVertices& a, const WorldVertices& b, const Vector3& n,
                    double limit) const override {
    return part_within(find_contact_patch(a, b, n), n, limit).area;
  }
};

}  // namespace

std::unique_ptr<Oracle> make_exact_oracle() { return std::make_unique<ExactOracle>(); }

#else

std::unique_ptr<Oracle> make_exact_oracle() { return nullptr; }

#endif

}  // namespace touchstone::measures
