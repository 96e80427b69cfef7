// The hard cases' files through the reader: what must be valid is, and bad inputs are refused for the stated
// reason.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "touchstone/adapters/scene_files/pair_file.hpp"

namespace touchstone {
namespace {

const std::filesystem::path kFolder = TOUCHSTONE_HARD_CASES;

std::vector<std::filesystem::path> files() {
  std::vector<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder))
    if (entry.path().extension() == ".json") found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  return found;
}

TEST(HardCaseFiles, EveryPairIsValidAndCarriesItsAnswer) {
  std::size_t count = 0;
  for (const std::filesystem::path& file : files()) {
    if (file.filename() == "bad_inputs.json") continue;
    for (const PairCase& item : load_pairs(file)) {
      ASSERT_TRUE(item.pair) << item.id << ": " << item.invalid_reason;
      ASSERT_TRUE(item.exact) << item.id;
      EXPECT_FALSE(item.why_hard.empty()) << item.id;
      const std::string& distance = item.exact->signed_distance;
      const PairClass by_sign = distance == "0"      ? PairClass::touching
                                : distance[0] == '-' ? PairClass::penetrating
                                                     : PairClass::separated;
      EXPECT_EQ(item.exact->pair_class, by_sign) << item.id;
      const bool warped = item.pair->solids[0].is_warped() || item.pair->solids[1].is_warped();
      EXPECT_EQ(warped, item.id.find("warped") != std::string::npos) << item.id;
      ++count;
    }
  }
  EXPECT_GE(count, 80u);
}

TEST(HardCaseFiles, EveryBadInputIsRefusedForItsReason) {
  const std::vector<PairCase> cases = load_pairs(kFolder / "bad_inputs.json");
  EXPECT_GE(cases.size(), 20u);
  for (const PairCase& item : cases) {
    EXPECT_FALSE(item.pair) << item.id;
    ASSERT_FALSE(item.expected_error.empty()) << item.id;
    EXPECT_NE(item.invalid_reason.find(item.expected_error), std::string::npos)
        << item.id << ": " << item.invalid_reason;
  }
}

TEST(HardCaseFiles, SavedAndReadAgainTheyAreTheSameBits) {
  const std::filesystem::path copy = std::filesystem::path(::testing::TempDir()) / "hard_cases_copy.json";
  for (const std::filesystem::path& file : files()) {
    if (file.filename() == "bad_inputs.json") continue;
    const std::vector<PairCase> cases = load_pairs(file);
    save_pairs(copy, cases);
    const std::vector<PairCase> back = load_pairs(copy);
    ASSERT_EQ(back.size(), cases.size());
    for (std::size_t i = 0; i < cases.size(); ++i) {
      ASSERT_TRUE(back[i].pair) << back[i].invalid_reason;
      for (int s = 0; s < 2; ++s) {
        EXPECT_EQ(back[i].pair->solids[s].vertices(), cases[i].pair->solids[s].vertices()) << cases[i].id;
        EXPECT_EQ(back[i].pair->X_WS[s].R, cases[i].pair->X_WS[s].R) << cases[i].id;
        EXPECT_EQ(back[i].pair->X_WS[s].p, cases[i].pair->X_WS[s].p) << cases[i].id;
      }
      EXPECT_EQ(back[i].exact->signed_distance, cases[i].exact->signed_distance);
    }
  }
}

}  // namespace
}  // namespace touchstone
