#include <algorithm>

#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/broadphase/swept_sphere.hpp"

namespace touchstone {
namespace {

class BruteForce final : public Broadphase {
 public:
  std::string_view name() const noexcept override { return "brute_force"; }

  void build(const BroadphaseInput& input) override {
    SolidTable table = make_solid_table(input);
    std::vector<Sphere> spheres(table.solids());
    table_ = std::move(table);
    sphere_W_ = std::move(spheres);
    margin_ = input.margin;
    state_ = State::built;
  }

  bool set_object(std::uint32_t object, const HexahedronTree* tree, bool is_static) override {
    touchstone::set_object(table_, object, tree, is_static);
    sphere_W_.resize(table_.solids());
    return true;
  }

  bool find_partners(SolidIndex solid, std::vector<SolidIndex>& out) noexcept override {
    const std::uint32_t object = table_.object_of[solid];
    for (SolidIndex other = 0; other < table_.solids(); ++other)
      if (table_.object_of[other] != object && may_pair(std::min(solid, other), std::max(solid, other)))
        out.push_back(other);
    return true;
  }

  void update(std::span<const Pose> poses, std::span<const std::uint32_t> moved) noexcept override {
    take(State::posed, moved,
         [&](std::uint32_t s) { sphere_W_[s] = world_sphere(table_.sphere_S[s], poses[s]); });
  }

  bool update_paths(const SolidPaths& paths, std::span<const std::uint32_t> moved) noexcept override {
    swept_.resize(table_.solids()), box_.resize(table_.solids());
    take(State::swept, moved, [&](std::uint32_t s) {
      const double bulge = paths.bulge.empty() ? 0.0 : paths.bulge[s];
      swept_[s] = swept_sphere(table_.sphere_S[s], paths.from[s], paths.to[s], bulge);
      box_[s] = bounding_box(swept_[s], 0.5 * margin_);
    });
    return true;
  }

  std::size_t find_pairs(PairCursor& cursor, std::span<SolidPair> block) noexcept override {
    std::size_t count = 0;
    for (SolidIndex a = cursor.next.a; a < table_.solids(); ++a) {
      const SolidIndex others = table_.first_solid[table_.object_of[a] + 1];
      const SolidIndex start = a == cursor.next.a ? std::max(others, cursor.next.b) : others;
      for (SolidIndex b = start; b < table_.solids(); ++b) {
        if (!may_pair(a, b)) continue;
        if (count == block.size()) {
          cursor.next = {a, b};
          return count;
        }
        block[count++] = {a, b};
      }
    }
    cursor.next = {table_.solids(), 0};
    cursor.done = true;
    return count;
  }

 private:
  enum class State { built, posed, swept };

  template <class Place>
  void take(State kind, std::span<const std::uint32_t> moved, Place place) noexcept {
    if (state_ != kind)
      for (std::uint32_t s = 0; s < table_.solids(); ++s) place(s);
    else
      for (std::uint32_t object : moved)
        for (std::uint32_t s = table_.first_solid[object]; s < table_.first_solid[object + 1]; ++s) place(s);
    state_ = kind;
  }

  bool may_pair(SolidIndex a, SolidIndex b) const noexcept {
    const std::uint32_t of_a = table_.object_of[a], of_b = table_.object_of[b];
    if (table_.is_gone[of_a] || table_.is_gone[of_b]) return false;
    if (table_.is_static[of_a] && table_.is_static[of_b]) return false;
    if (state_ != State::swept) return may_touch(sphere_W_[a], sphere_W_[b], margin_);
    return overlap(box_[a], box_[b]) && may_touch(swept_[a], swept_[b], margin_);
  }

  SolidTable table_{{}, {0}, {}, {}, {}};
  std::vector<Sphere> sphere_W_;
  std::vector<SweptSphere> swept_;  // and their boxes, of paths
  std::vector<Box> box_;
  double margin_ = 0.0;
  State state_ = State::built;
};

}  // namespace

std::unique_ptr<Broadphase> make_brute_force_broadphase() { return std::make_unique<BruteForce>(); }

}  // namespace touchstone
