#include "touchstone/adapters/plugin/plugin.hpp"

#include <gmock/gmock.h>

#include <cfenv>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "touchstone/adapters/plugin/engine_name.hpp"
#include "touchstone/adapters/plugin/utf8.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/support/ask.hpp"

namespace touchstone {
namespace {

using testing::HasSubstr;

std::string refusal(const std::string& library) {
  BackendRegistry registry;
  try {
    register_plugin(registry, library);
  } catch (const InputError& error) {
    EXPECT_TRUE(registry.narrowphases().empty());
    return error.what();
  }
  return "";
}

TEST(Plugin, IsABackendByItsOwnName) {
  BackendRegistry registry;
  EXPECT_EQ(register_plugin(registry, SEPARATING_AXES_C), "separating_axes_c");
  EXPECT_EQ(register_plugin(registry, NATIVE_THROUGH_C), "native_through_c");
  const auto narrowphase = registry.make_narrowphase("native_through_c");
  const std::vector<Hexahedron> solids(2, Hexahedron::from_size({1, 1, 1}));
  narrowphase->build(solids);
  const std::vector<Pose> poses = {at(0, 0, 0), at(1.5, 0, 0)};
  EXPECT_EQ(ask(*narrowphase, poses, {.kind = QueryKind::distance}).geometry.separation, 0.5);
}

// The registry may go while a narrowphase is still in use: its library stays.
TEST(Plugin, OutlivesTheRegistry) {
  std::unique_ptr<Narrowphase> narrowphase;
  {
    BackendRegistry registry;
    register_plugin(registry, SEPARATING_AXES_C);
    narrowphase = registry.make_narrowphase("separating_axes_c");
  }
  const std::vector<Hexahedron> solids(2, Hexahedron::from_size({1, 1, 1}));
  narrowphase->build(solids);
  const std::vector<Pose> poses = {at(0, 0, 0), at(0.5, 0, 0)};
  EXPECT_EQ(ask(*narrowphase, poses, {}).status, PairStatus::overlapping);
}

TEST(Plugin, WhatIsNoneIsRefusedByName) {
  EXPECT_THAT(refusal("./no_such_file.so"), HasSubstr("no_such_file.so"));
  EXPECT_THAT(refusal(NO_PLUGIN), HasSubstr("exports no touchstone_plugin"));
  EXPECT_THAT(refusal(NEXT_VERSION_PLUGIN), HasSubstr("version 2 of the interface, this is 1"));
  EXPECT_THAT(refusal(INCOMPLETE_PLUGIN), HasSubstr("lacks a function"));
  EXPECT_THAT(refusal(MISNAMED_PLUGIN), HasSubstr("its name is not up to 64 letters, digits and _ - + ."));
  EXPECT_THAT(refusal(BOASTFUL_PLUGIN), HasSubstr("its resolution is negative or no figure"));
}

TEST(Plugin, WhatIsNoTextBecomesOneLineOfIt) {
  EXPECT_EQ(engine_text("caf\xC3\xA9 \xE2\x88\x9E"), "caf\xC3\xA9 \xE2\x88\x9E");
  EXPECT_EQ(engine_text("a\nb\x1B[31m\x7F\xC2\x9B"), "a b [31m  ");
  // Not UTF-8: a byte of Latin-1, an end that is missing, a longer form, half a UTF-16 pair, beyond U+10FFFF.
  EXPECT_EQ(engine_text("\xE9t\xC3"), "?t?");
  EXPECT_EQ(engine_text("\xC0\xAF\xED\xA0\x80\xF4\x90\x80\x80"), "?????????");
  EXPECT_EQ(engine_text(std::string(255, 'x') + "\xC3\xA9"), std::string(255, 'x'));
  EXPECT_TRUE(is_utf8("") && is_utf8("caf\xC3\xA9 \xE2\x88\x9E \xF0\x9F\x9B\xB0"));
  EXPECT_FALSE(is_utf8("caf\xE9") || is_utf8("caf\xC3") || is_utf8("\xED\xA0\x80"));
  BackendRegistry registry;
  register_plugin(registry, UNTIDY_PLUGIN);
  EXPECT_EQ(registry.narrowphase("bad").description, "two lines,  [31mred, caf?");
  try {
    registry.make_narrowphase("bad")->build(std::vector<Hexahedron>(100, Hexahedron::from_size({1, 1, 1})));
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()), "plug-in bad: " + std::string(256, '?'));
  }
}

TEST(Plugin, ANameIsTakenOnce) {
  BackendRegistry registry;
  register_plugin(registry, SEPARATING_AXES_C);
  EXPECT_THROW(register_plugin(registry, SEPARATING_AXES_C), InputError);
}

class BadPlugin : public testing::Test {
 protected:
  void SetUp() override {
    register_plugin(registry, BAD_PLUGIN);
    narrowphase = registry.make_narrowphase("bad");
    narrowphase->build(solids);
    for (SolidIndex b = 1; b < solids.size(); ++b) pairs.push_back({0, b});
  }
  BackendRegistry registry;
  std::unique_ptr<Narrowphase> narrowphase;
  std::vector<Hexahedron> solids{7, Hexahedron::from_size({1, 1, 1})};
  std::vector<Pose> poses{7};
  std::vector<SolidPair> pairs;
};

TEST_F(BadPlugin, NonsenseIsFailedAndSaidOnce) {
  testing::internal::CaptureStderr();
  const Answers answers = ask(*narrowphase, pairs, poses, {.kind = QueryKind::manifold});
  const Answers again = ask(*narrowphase, pairs, poses, {.kind = QueryKind::manifold});
  EXPECT_EQ(
      testing::internal::GetCapturedStderr(),
      "touchstone: plug-in bad, pair 0 of 6: its status is none, or was not written; counted as failed\n");
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(answers.status[i], PairStatus::failed) << i;
    EXPECT_TRUE(std::isnan(answers.geometry[i].separation)) << i;
    EXPECT_EQ(answers.geometry[i].point_count, 0) << i;
  }
  EXPECT_EQ(answers.status[5], PairStatus::overlapping);
  EXPECT_EQ(again.status, answers.status);
}

TEST_F(BadPlugin, ARefusedSolidIsAnInputError) {
  const std::vector<Hexahedron> many(1000, Hexahedron::from_size({1, 1, 1}));
  try {
    narrowphase->build(many);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "plug-in bad: solid 999 is one too many");
  }
}

/// A plug-in that misbehaves as it is told, asked about three pairs.
class RudePlugin {
 public:
  explicit RudePlugin(const char* how) {
    setenv("RUDE", how, 1);
    register_plugin(registry_, RUDE_PLUGIN);
  }
  ~RudePlugin() { unsetenv("RUDE"); }
  RudePlugin(const RudePlugin&) = delete;
  RudePlugin& operator=(const RudePlugin&) = delete;

  std::vector<PairStatus> statuses() {
    const auto narrowphase = registry_.make_narrowphase("rude");
    narrowphase->build(std::vector<Hexahedron>(4, Hexahedron::from_size({1, 1, 1})));
    const std::vector<SolidPair> pairs = {{0, 1}, {0, 2}, {0, 3}};
    return ask(*narrowphase, pairs, std::vector<Pose>(4), {.kind = QueryKind::distance}).status;
  }

 private:
  BackendRegistry registry_;
};

TEST(RudePlugins, WhatTheyThrowEndsAtTheInterface) {
  const std::vector<PairStatus> failed(3, PairStatus::failed), separated(3, PairStatus::separated);
  for (const char* how : {"throw", "throw_number"}) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(RudePlugin(how).statuses(), failed);
    EXPECT_EQ(testing::internal::GetCapturedStderr(),
              "touchstone: plug-in rude, pair 0 of 3: it throws an exception; counted as failed\n");
  }
  EXPECT_EQ(RudePlugin("throw_at_destroy").statuses(), separated);
  for (const char* how : {"throw_at_create", "throw_at_build"}) {
    try {
      RudePlugin(how).statuses();
      ADD_FAILURE() << how;
    } catch (const InputError& error) {
      EXPECT_STREQ(error.what(), "plug-in rude: it throws an exception");
    }
  }
}

// Whatever is computed after them has the same bits, and traps nothing.
TEST(RudePlugins, LeaveTheFloatingPointAsItWas) {
  volatile long double long_one = 1.0L, long_three = 3.0L;  // x87 has a mode of its own
  const long double long_third = long_one / long_three;
  for (const char* how : {"rounding_at_load", "rounding", "flush", "trap", "precision"}) {
    EXPECT_EQ(RudePlugin(how).statuses(), std::vector<PairStatus>(3, PairStatus::separated));
    volatile double one = 1.0, three = 3.0, least = std::numeric_limits<double>::denorm_min();
    EXPECT_EQ(one / three, 0x1.5555555555555p-2) << how;
    EXPECT_EQ(long_one / long_three, long_third) << how;
    EXPECT_EQ(std::fegetround(), FE_TONEAREST) << how;
    EXPECT_GT(least * one, 0.0) << how;
  }
}

}  // namespace
}  // namespace touchstone
