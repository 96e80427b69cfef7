#include "touchstone/tests/measures/fake_backends.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"

#include <cmath>

namespace touchstone::measures::testing {
namespace {

Capabilities all_but_overlap() {
  Capabilities capabilities;
  capabilities.distance = capabilities.penetration = capabilities.manifold = true;
  return capabilities;
}

class FakeNarrowphase final : public PairByPair {
 public:
  explicit FakeNarrowphase(std::string name) : PairByPair(std::move(name), all_but_overlap()) {}

 private:
  void answer(const NarrowphaseInput& input, std::size_t i, const NarrowphaseOutput& output) const override {
    const Vector3& p_WA = input.poses[input.pairs[i].a].p;
    const double gap = input.poses[input.pairs[i].b].p.x() - p_WA.x() - 1.0;
    output.status[i] = status(gap);
    if (input.query.kind == QueryKind::overlap) return;
    const bool has_answer =
        output.status[i] != PairStatus::failed && output.status[i] != PairStatus::unsupported;
    const double separation = !has_answer || name_ == "not_a_number" ? kNaN
                              : name_ == "off_by_1e-3"               ? gap + 1e-3
                                                                     : gap;
    const Vector3 n = Vector3::UnitX(), p_A = p_WA + n * 0.5;
    output.geometry[i] = {separation, n, p_A, p_A + n * separation, 0};
    if (input.query.kind != QueryKind::manifold || !has_answer || gap > 0) return;
    for (int c = 0; c < 4; ++c) {
      const Vector3 corner = p_A + Vector3(0, c & 1 ? 0.5 : -0.5, c & 2 ? 0.5 : -0.5);
      output.points[i * static_cast<std::size_t>(input.query.max_points) + static_cast<std::size_t>(c)] = {
          corner, corner + n * separation, separation, 0};
    }
    output.geometry[i].point_count = 4;
  }

  PairStatus status(double gap) const {
    if (name_ == "unsupported") return PairStatus::unsupported;
    if (name_ == "failing") return PairStatus::failed;
    if (name_ == "undecided") return PairStatus::undecided;
    if (name_ == "missing_contacts") return PairStatus::separated;
    if (name_ == "seeing_phantoms") return PairStatus::overlapping;
    return gap > 0 ? PairStatus::separated : PairStatus::overlapping;
  }
};

}  // namespace

PairSet cubes(const std::vector<double>& gaps) {
  PairSet set;
  set.name = "cubes";
  set.description = "unit cubes side by side";
  for (const double gap : gaps) {
    const auto first = static_cast<SolidIndex>(set.solids.size());
    for (int i = 0; i < 2; ++i) set.solids.push_back(Hexahedron::from_size({1, 1, 1}));
    set.poses.push_back({});
    set.poses.push_back({Matrix3::Identity(), {1.0 + gap, 0, 0}});
    set.pairs.push_back({first, first + 1});
  }
  return set;
}

PairTruth CubeOracle::truth(const WorldVertices& a, const WorldVertices& b) const {
  const double gap = b.x[0] - a.x[7];
  const PairClass pair_class = gap > 0   ? PairClass::separated
                               : gap < 0 ? PairClass::penetrating
                                         : PairClass::touching;
  return {pair_class, gap, Vector3::UnitX(), true};
}

double CubeOracle::surface_distance(const WorldVertices&, const Vector3&) const { return kNaN; }
double CubeOracle::patch_area(const WorldVertices&, const WorldVertices&, const Vector3&, double) const {
  return 1.0;
}

void register_fakes(BackendRegistry& registry) {
  for (const char* name : {"right", "missing_contacts", "seeing_phantoms", "off_by_1e-3", "not_a_number",
                           "unsupported", "failing", "undecided"}) {
    registry.add(BackendRegistry::NarrowphaseEntry{
        name, "a fake", [name] { return std::make_unique<FakeNarrowphase>(name); }, {}});
  }
}

}  // namespace touchstone::measures::testing
