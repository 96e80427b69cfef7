#include "touchstone/contact_core/broadphase/native/sphere_tests.hpp"

#include <algorithm>
#include <cstdlib>
#include <string_view>

#include "touchstone/contact_core/broadphase/native/float_lanes.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace touchstone {
namespace {

using Group = SphereTests::Group;
using Hits = SphereTests::Hits;

std::uint32_t lanes_of(const Group& group) {
  return 0xffU >> (SphereTests::kLanes - std::min(group.end - group.first, SphereTests::kLanes));
}

/// By how much squares differ, of four positions: negative where spheres do not touch.
Floats slack(const SphereColumns& spheres, std::uint32_t of, std::uint32_t first) {
  const Floats dx = load_floats(spheres.x + first) - all_lanes(spheres.x[of]),
               dy = load_floats(spheres.y + first) - all_lanes(spheres.y[of]),
               dz = load_floats(spheres.z + first) - all_lanes(spheres.z[of]),
               sum = load_floats(spheres.radius + first) + all_lanes(spheres.radius[of]);
  return sum * sum - ((dx * dx + dy * dy) + dz * dz);
}

std::size_t test_by_four(const SphereColumns& spheres, std::span<const Group> groups, Hits* out) {
  const Floats doubt = all_lanes(spheres.doubt);
  std::size_t count = 0;
  for (const Group& group : groups) {
    const Floats low = slack(spheres, group.of, group.first),
                 high = slack(spheres, group.of, group.first + 4);
    const std::uint32_t met = (lane_mask(low >= 0.0F) | lane_mask(high >= 0.0F) << 4) & lanes_of(group);
    out[count] = {group.of, group.first, met, lane_mask(low > doubt) | lane_mask(high > doubt) << 4};
    count += met != 0 ? 1 : 0;
  }
  return count;
}

#if defined(__x86_64__)
/// The same, of the same bits.
[[gnu::target("avx2")]] std::size_t test_by_eight(const SphereColumns& spheres, std::span<const Group> groups,
                                                  Hits* out) {
  const __m256 doubt = _mm256_set1_ps(spheres.doubt), none = _mm256_setzero_ps();
  const float *const xs = spheres.x, *const ys = spheres.y, *const zs = spheres.z,
                     *const radii = spheres.radius;
  std::size_t count = 0;
  for (const Group& group : groups) {
    const std::uint32_t of = group.of, first = group.first;
    const __m256 dx = _mm256_sub_ps(_mm256_loadu_ps(xs + first), _mm256_set1_ps(xs[of])),
                 dy = _mm256_sub_ps(_mm256_loadu_ps(ys + first), _mm256_set1_ps(ys[of])),
                 dz = _mm256_sub_ps(_mm256_loadu_ps(zs + first), _mm256_set1_ps(zs[of])),
                 sum = _mm256_add_ps(_mm256_loadu_ps(radii + first), _mm256_set1_ps(radii[of]));
    const __m256 square =
        _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(dx, dx), _mm256_mul_ps(dy, dy)), _mm256_mul_ps(dz, dz));
    const __m256 by = _mm256_sub_ps(_mm256_mul_ps(sum, sum), square);
    const auto met = static_cast<std::uint32_t>(_mm256_movemask_ps(_mm256_cmp_ps(by, none, _CMP_GE_OQ)));
    const auto sure = static_cast<std::uint32_t>(_mm256_movemask_ps(_mm256_cmp_ps(by, doubt, _CMP_GT_OQ)));
    out[count] = {of, first, met & lanes_of(group), sure};
    count += out[count].met != 0 ? 1 : 0;
  }
  return count;
}
#endif

struct KindList {
  std::array<SphereTests::Kind, 2> of;
  std::size_t count;
};

const KindList& kinds() noexcept {
  static const KindList list = [] {
    KindList out{{{{"generic", test_by_four}, {}}}, 1};
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) out.of[out.count++] = {"avx2", test_by_eight};
#endif
    return out;
  }();
  return list;
}

}  // namespace

std::span<const SphereTests::Kind> SphereTests::available() noexcept {
  return {kinds().of.data(), kinds().count};
}

const SphereTests::Kind& SphereTests::chosen() noexcept {
  static const Kind& kind = []() -> const Kind& {
    const char* const wanted = std::getenv("TOUCHSTONE_ISA");
    for (const Kind& each : available())
      if (wanted != nullptr && std::string_view(wanted) == each.isa) return each;
    return available().back();
  }();
  return kind;
}

}  // namespace touchstone
