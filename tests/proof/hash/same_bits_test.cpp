#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <memory>
#include <string>

#include "touchstone/tests/proof/hash/run_hash.hpp"

// Hashes of this program's libraries against those compiled without Eigen's vectorisation.

namespace touchstone::proof {
namespace {

/// Returns the other program's output.
std::string printed(const std::string& options) {
  const std::string command = std::string(TOUCHSTONE_UNVECTORISED) + " " + options;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string out;
  std::array<char, 4096> buffer;
  for (std::size_t count; pipe && (count = std::fread(buffer.data(), 1, buffer.size(), pipe.get())) > 0;)
    out.append(buffer.data(), count);
  return out;
}

std::string line_of(std::uint64_t hash) {
  std::array<char, 18> text;
  std::snprintf(text.data(), text.size(), "%016llx\n", static_cast<unsigned long long>(hash));
  return text.data();
}

TEST(SameBits, TenThousandRigidPathRotationsAreTheSameWithAndWithoutEigensVectorisation) {
  constexpr std::size_t kCount = 10000;
  const std::string theirs = printed("--rotations " + std::to_string(kCount));
  ASSERT_EQ(theirs.size(), 17 * kCount);
  std::size_t differ = 0, i = 0;
  for (const std::uint64_t hash : path_rotation_hashes(kCount))
    differ += theirs.compare(17 * i++, 17, line_of(hash)) == 0 ? 0 : 1;
  EXPECT_EQ(differ, 0u);
}

TEST(SameBits, RunsDoNotDependOnWhatRanBefore) {
  const auto first = dynamics_hashes(20), again = dynamics_hashes(20);
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].hash, again[i].hash) << first[i].family;
  const auto flown = world_hashes(10), flown_again = world_hashes(10);
  for (std::size_t i = 0; i < flown.size(); ++i)
    EXPECT_EQ(flown[i].hash, flown_again[i].hash) << flown[i].family;
}

TEST(SameBits, EveryRunHasItsOwnAndEveryFrameShows) {
  const auto shorter = world_hashes(9), longer = world_hashes(10);
  for (std::size_t i = 0; i < longer.size(); ++i) {
    EXPECT_NE(longer[i].hash, shorter[i].hash) << longer[i].family;
    for (std::size_t k = 0; k < i; ++k) EXPECT_NE(longer[i].hash, longer[k].hash);
  }
}

}  // namespace
}  // namespace touchstone::proof
