#include "touchstone/examples/robot_files/kept_covers.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "touchstone/adapters/robots/fitted_cover.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/tests/fit/meshes.hpp"
#include "touchstone/tests/support/program_test.hpp"

namespace touchstone::robot_files {
namespace {

using testing::HasSubstr;

class KeptCoversTest : public FolderTest {
 protected:
  /// As one run would: fits anew what is not kept.
  MeshCover cover(double over) {
    const KeptCovers kept(folder_ / "covers");
    FittedCoverOptions options;
    options.over = over;
    options.repairs = 2;
    options.find = [&](const TriangleMesh& mesh, const FitOptions& asked) { return kept.find(mesh, asked); };
    options.keep = [&](const TriangleMesh& mesh, const FitOptions& asked, const Fit& fit) {
      ++fitted_;
      kept.keep(mesh, asked, fit);
    };
    options.check = [&](const TriangleMesh&, const Fit&, const std::string&) { ++checked_; };
    return fitted_cover(options)(test::angle_mesh(), "angle");
  }
  std::vector<std::filesystem::path> files() const {
    std::vector<std::filesystem::path> out;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "covers"))
      out.push_back(entry.path());
    return out;
  }
  int fitted_ = 0, checked_ = 0;
};

TEST_F(KeptCoversTest, TheNextRunHasTheSameCoverToTheBitAndProvesItAnew) {
  const MeshCover first = cover(0.1), second = cover(0.1);
  EXPECT_EQ(fitted_, 1);
  EXPECT_EQ(checked_, 2);
  EXPECT_EQ(first.error, second.error);
  ASSERT_EQ(first.solids.size(), second.solids.size());
  for (std::size_t i = 0; i < first.solids.size(); ++i)
    EXPECT_EQ(first.solids[i].solid.vertices(), second.solids[i].solid.vertices());
  cover(0.2);  // another error is another cover
  EXPECT_EQ(fitted_, 2);
  EXPECT_EQ(files().size(), 2u);
}

TEST_F(KeptCoversTest, ADamagedFileIsNamedAndNotWrittenTo) {
  cover(0.1);
  const std::filesystem::path file = files().at(0);
  for (const std::string& text :
       std::vector<std::string>{"", "{}", "{\"format\": \"touchstone kept cover 1\", \"key\": \"0\"}"}) {
    std::ofstream(file) << text;
    try {
      cover(0.1);
      FAIL() << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(file.string() + ": no kept cover: ")) << text;
    }
    EXPECT_EQ(std::filesystem::file_size(file), text.size());
  }
  EXPECT_EQ(fitted_, 1);
}

TEST_F(KeptCoversTest, AFileInPlaceOfTheFolderIsRefused) {
  const std::filesystem::path file = write("covers", "mine");
  try {
    KeptCovers kept(file);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("is no folder"));
  }
}

}  // namespace
}  // namespace touchstone::robot_files
