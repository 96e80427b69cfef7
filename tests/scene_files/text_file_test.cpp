#include "touchstone/adapters/scene_files/text_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <functional>

#include "touchstone/adapters/scene_files/pair_file.hpp"
#include "touchstone/adapters/scene_files/scene_file.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using scene_files::kLargestFile;
using scene_files::read_text_file;

class TextFile : public ::testing::Test {
 protected:
  ~TextFile() override { std::filesystem::remove(path_); }

  const std::filesystem::path path_ =
      std::filesystem::path(::testing::TempDir()) /
      (std::string("text_file_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

// Returns the text that follows the file's name in the message of the scene reader, the same as the pair
// reader's; or "accepted".
std::string error_of(const std::filesystem::path& path) {
  const auto message = [&](const std::function<void()>& load) -> std::string {
    try {
      load();
    } catch (const InputError& error) {
      const std::string what = error.what();
      EXPECT_TRUE(what.starts_with(path.string() + ": ")) << what;
      return what.substr(path.string().size() + 2);
    }
    return "accepted";
  };
  const std::string scene = message([&] { load_scene(path); });
  EXPECT_EQ(scene, message([&] { load_pairs(path); }));
  return scene;
}

TEST_F(TextFile, KeepsEveryByte) {
  const std::string text("a\r\n\0b", 5);
  std::ofstream(path_, std::ios::binary) << text;
  EXPECT_EQ(read_text_file(path_), text);
  std::ofstream(path_, std::ios::trunc).flush();
  EXPECT_EQ(read_text_file(path_), "");
}

TEST_F(TextFile, WhatIsNoRegularFileIsRefusedUnread) {
  EXPECT_EQ(error_of("/dev/zero"), "cannot be read: not a regular file");
  EXPECT_EQ(error_of(::testing::TempDir()), "cannot be read: not a regular file");
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);  // opening it would wait for a writer
  EXPECT_EQ(error_of(path_), "cannot be read: not a regular file");
  EXPECT_EQ(error_of("/nonexistent/file"), "cannot be read");
}

TEST_F(TextFile, ALargerFileThanTheLimitIsRefused) {
  std::ofstream(path_).flush();
  std::filesystem::resize_file(path_, kLargestFile + 1);
  EXPECT_EQ(error_of(path_), "cannot be read: larger than 64 MiB");
  std::filesystem::resize_file(path_, kLargestFile);
  EXPECT_EQ(read_text_file(path_).size(), kLargestFile);
}

TEST_F(TextFile, ALinkIsFollowed) {
  std::filesystem::create_symlink("/dev/zero", path_);
  EXPECT_EQ(error_of(path_), "cannot be read: not a regular file");
}

}  // namespace
}  // namespace touchstone
