#include <algorithm>

#include "contact_core/broadphase/register_broadphases.hpp"
#include "contact_core/broadphase/world_spheres.hpp"

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
    is_first_update_ = true;
  }

  void update(std::span<const Pose> poses, std::span<const std::uint32_t> moved) noexcept override {
    if (is_first_update_)
      for (std::uint32_t object = 0; object < table_.objects(); ++object) place(object, poses);
    else
      for (std::uint32_t object : moved) place(object, poses);
    is_first_update_ = false;
  }

  std::size_t find_pairs(PairCursor& cursor, std::span<SolidPair> block) noexcept override {
    std::size_t count = 0;
    for (SolidIndex a = cursor.next.a; a < table_.solids(); ++a) {
      const SolidIndex others = table_.first_solid[table_.object_of[a] + 1];
      const SolidIndex start = a == cursor.next.a ? std::max(others, cursor.next.b) : others;
      for (SolidIndex b = start; b < table_.solids(); ++b) {
        if (!may_touch(sphere_W_[a], sphere_W_[b], margin_)) continue;
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
  void place(std::uint32_t object, std::span<const Pose> poses) noexcept {
    for (std::uint32_t s = table_.first_solid[object]; s < table_.first_solid[object + 1]; ++s)
      sphere_W_[s] = world_sphere(table_.sphere_S[s], poses[s]);
  }

  SolidTable table_{{}, {0}, {}};
  std::vector<Sphere> sphere_W_;
  double margin_ = 0.0;
  bool is_first_update_ = true;
};

}  // namespace

std::unique_ptr<Broadphase> make_brute_force_broadphase() { return std::make_unique<BruteForce>(); }

}  // namespace touchstone
