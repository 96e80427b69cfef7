#include "touchstone/examples/program/terminal/text_table.hpp"

#include <gtest/gtest.h>

#include "touchstone/examples/compare_backends/names.hpp"

namespace touchstone::comparison {
namespace {

TEST(Wrapped, LeavesWhatFitsAndTheEndsOfLines) {
  EXPECT_EQ(wrapped(""), "");
  EXPECT_EQ(wrapped("\n\n"), "\n\n");
  EXPECT_EQ(wrapped("one two\n  three", 9), "one two\n  three");
}

TEST(Wrapped, GoesOnBelowWhereTheLastColumnBegins) {
  EXPECT_EQ(wrapped("one two three", 9), "one two\n  three");
  EXPECT_EQ(wrapped("  name  one two three four\nend", 16),
            "  name  one two\n        three\n        four\nend");
}

TEST(Wrapped, KeepsThousandsTogetherAndLeavesWhatHasNoSpace) {
  EXPECT_EQ(wrapped("all of 11 801 cases", 10), "all of\n  11 801\n  cases");
  EXPECT_EQ(wrapped("a/path/without/a/space", 10), "a/path/without/a/space");
  EXPECT_EQ(wrapped("see a/path/without/a/space", 10), "see\n  a/path/without/a/space");
}

TEST(Wrapped, CountsCharactersNotBytes) {
  EXPECT_EQ(wrapped("\u00e4\u00f6\u00fc \u00e4", 5), "\u00e4\u00f6\u00fc \u00e4");
}

// The least double stands for a wrong class where solids touch exactly.
TEST(FormatError, WhatIsNoLengthButNotRightIsAboveZero) {
  EXPECT_EQ(format_error(0.0), "0");
  EXPECT_EQ(format_error(5e-324), "> 0");
  EXPECT_EQ(format_error(3e-308), "3.0e-308");
}

}  // namespace
}  // namespace touchstone::comparison
