#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {

/// A file of this text in the tests' temporary folder, named after the running test.
inline std::filesystem::path written_file(const std::string& text, const std::string& ending) {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path path = std::filesystem::path(::testing::TempDir()) /
                                     (std::string(test->test_suite_name()) + "_" + test->name() + ending);
  std::ofstream(path) << text;
  return path;
}

/// Returns the complaint of `load` about a file of this text, after the file's name; "accepted" when nothing.
template <class Load>
std::string error_in_file(const std::string& text, const std::string& ending, Load load) {
  const std::filesystem::path path = written_file(text, ending);
  try {
    load(path);
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.find(path.string()), 0u) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message.substr(path.string().size() + 1);
  }
  return "accepted";
}

}  // namespace touchstone
