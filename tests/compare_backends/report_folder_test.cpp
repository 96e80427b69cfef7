// Where reports are written: whatever else is there stays as it is.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/program/files/report_files.hpp"
#include "touchstone/examples/program/files/report_manifest.hpp"
#include "touchstone/examples/program/files/sha256.hpp"
#include "touchstone/examples/program/terminal/engine_log.hpp"
#include "touchstone/examples/program/terminal/program.hpp"
#include "touchstone/tests/support/program_test.hpp"

namespace touchstone::comparison {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

const std::vector<std::string> kNames = {"results.json", "results.csv", "figures/a.svg", "figures/b.svg"};

std::vector<ReportFile> report(const std::string& content) {
  std::vector<ReportFile> files;
  for (const std::string& name : kNames) files.emplace_back(name, name + " " + content);
  return files;
}

class ReportFolder : public FolderTest {
 protected:
  fs::path put(const fs::path& path, const std::string& content) const {
    fs::create_directories((folder_ / path).parent_path());
    std::ofstream(folder_ / path) << content;
    return folder_ / path;
  }

  /// Every file below, by its relative path; links are not followed.
  std::map<std::string, std::string> all() const {
    std::map<std::string, std::string> files;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder_))
      if (entry.is_regular_file() && !entry.is_symlink())
        files[entry.path().lexically_relative(folder_).string()] = read(entry.path());
    return files;
  }

  std::string refusal(const fs::path& folder) const {
    const auto before = all();
    std::string said;
    try {
      check_report_folder(folder, kNames);
    } catch (const InputError& error) {
      said = error.what();
    }
    EXPECT_EQ(all(), before);
    return said;
  }

  /// Checks, writes and reads back.
  void expect_written(const fs::path& folder, const std::string& content) const {
    EXPECT_NO_THROW(check_report_folder(folder, kNames));
    EXPECT_EQ(place_report(folder, report(content), true), folder);
    for (const std::string& name : kNames) EXPECT_EQ(read(folder / name), name + " " + content);
  }
};

TEST(Sha256, MeetsTheStandardsExamplesAndEveryPadding) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  // As sha256sum has it, about the lengths where the padding takes one block more.
  for (const std::size_t length : {1u, 54u, 55u, 56u, 57u, 63u, 64u, 65u, 119u, 120u, 128u}) {
    const std::string text(length, 'x');
    FILE* const pipe = popen(("printf '" + text + "' | sha256sum").c_str(), "r");
    char digits[65] = {};
    ASSERT_EQ(std::fread(digits, 1, 64, pipe), 64u);
    pclose(pipe);
    EXPECT_EQ(sha256(text), digits) << length;
  }
}

TEST_F(ReportFolder, AThesisAndNotesBesideTheReportSurviveEveryRun) {
  put("report/thesis/chapter.txt", "years of work");
  put("report/notes.md", "mine");
  put("report/figures/own.svg", "mine too");
  const auto before = all();
  for (const char* content : {"first", "second", "third"}) {
    expect_written(folder_ / "report", content);
    auto after = all();
    for (const auto& [name, text] : before) EXPECT_EQ(after[name], text) << name;
    EXPECT_EQ(after.size(), before.size() + kNames.size() + 1) << "temporary files were left";
  }
}

TEST_F(ReportFolder, AFileOfOursThatSomebodyChangedIsRefusedByName) {
  expect_written(folder_ / "report", "first");
  put("report/results.csv", "with a column of mine");
  EXPECT_THAT(refusal(folder_ / "report"),
              HasSubstr("report/results.csv has changed since an earlier run wrote it"));
  fs::remove(folder_ / "report/results.csv");
  expect_written(folder_ / "report", "second");
}

TEST_F(ReportFolder, AFileOfAnothersAtOurNameIsRefusedByNameBeforeTheRun) {
  for (const std::string& name : kNames) {
    const fs::path report =
        folder_ / ("report_" + fs::path(name).stem().string() + "_" + fs::path(name).extension().string());
    put(report / name, "mine");
    EXPECT_THAT(refusal(report),
                HasSubstr((report / name).string() + " is there and no earlier run wrote it"));
  }
  // A file where a folder of ours would be, a folder where a file would be, and a link.
  put("blocked/figures", "a file");
  EXPECT_THAT(refusal(folder_ / "blocked"), HasSubstr("blocked/figures is no folder"));
  put("folder/results.csv/mine", "x");
  EXPECT_THAT(refusal(folder_ / "folder"), HasSubstr("folder/results.csv is there"));
  put("elsewhere.json", "mine");
  fs::create_directory(folder_ / "linked");
  fs::create_symlink(folder_ / "elsewhere.json", folder_ / "linked/results.json");
  EXPECT_THAT(refusal(folder_ / "linked"), HasSubstr("linked/results.json is there"));
}

TEST_F(ReportFolder, AFolderWithAResultsJsonThatNoManifestListsIsNoReport) {
  put("project/results.json", "of another program");
  put("project/source.c", "mine");
  EXPECT_THAT(refusal(folder_ / "project"),
              HasSubstr("project/results.json is there and no earlier run wrote it"));
}

TEST_F(ReportFolder, AForgedManifestLeadsNowhere) {
  const fs::path mine = put("precious.txt", "mine");
  for (const std::string& name : {std::string("../precious.txt"), std::string("a\0b", 3)}) {
    Manifest manifest{"anything", true, {}};
    manifest.files.push_back(manifest_entry(name, "mine"));
    put(std::string("report/") + kManifestName, manifest_text(manifest));
    EXPECT_THAT(refusal(folder_ / "report"), HasSubstr("names a file outside its folder"));
  }
  for (const char* text : {"", "{", "[]", "{\"schema\": 1}"}) {
    put(std::string("report/") + kManifestName, text);
    const std::string said = refusal(folder_ / "report");
    EXPECT_THAT(said, HasSubstr(std::string("report/") + kManifestName + ": is ")) << text;
    EXPECT_THAT(said, Not(HasSubstr("json.exception")));
  }
  EXPECT_EQ(read(mine), "mine");
}

TEST_F(ReportFolder, FilesThatOnlyTheEarlierRunWroteGoUnlessSomebodyChangedThem) {
  std::vector<ReportFile> files = report("first");
  files.emplace_back("figures/gone.svg", "old");
  files.emplace_back("figures/edited.svg", "old");
  write_report_folder(folder_ / "report", files);
  put("report/figures/edited.svg", "mine now");
  expect_written(folder_ / "report", "second");
  EXPECT_FALSE(fs::exists(folder_ / "report/figures/gone.svg"));
  EXPECT_EQ(read(folder_ / "report/figures/edited.svg"), "mine now");
}

TEST_F(ReportFolder, ALinkAndTheWorkingFolderAreOutputsLikeAnyOther) {
  put("real/notes.md", "mine");
  fs::create_directory_symlink(folder_ / "real", folder_ / "link");
  for (const char* content : {"first", "second"}) {
    expect_written(folder_ / "link", content);
    EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
    EXPECT_EQ(read(folder_ / "real/results.json"), std::string("results.json ") + content);
  }
  const fs::path back = fs::current_path();
  fs::current_path(folder_ / "real");
  expect_written(".", "third");
  expect_written("", "fourth");
  expect_written("./", "fifth");
  fs::current_path(back);
  EXPECT_EQ(read(folder_ / "real/notes.md"), "mine");
  fs::create_directory_symlink(folder_ / "nowhere", folder_ / "dangling");
  EXPECT_THAT(refusal(folder_ / "dangling"), HasSubstr("is a link to nothing"));
}

TEST_F(ReportFolder, AFolderOnAnotherDeviceIsAnOutputLikeAnyOther) {
  std::string name = "/dev/shm/touchstone_test.XXXXXX";
  if (mkdtemp(name.data()) == nullptr) GTEST_SKIP() << "no /dev/shm";
  fs::create_directory_symlink(name, folder_ / "report");
  expect_written(folder_ / "report", "first");
  expect_written(folder_ / "report", "second");
  fs::remove_all(name);
}

/// A file system of a few bytes at a folder; nothing where that is not allowed.
class SmallDisk {
 public:
  SmallDisk(const fs::path& folder, const std::string& size) : folder_(folder) {
    fs::create_directory(folder);
    is_there_ = mount("tmpfs", folder.c_str(), "tmpfs", 0, ("size=" + size).c_str()) == 0;
  }
  ~SmallDisk() {
    if (is_there_) umount(folder_.c_str());
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  bool is_there() const { return is_there_; }

 private:
  fs::path folder_;
  bool is_there_;
};

TEST_F(ReportFolder, AMountPointIsAnOutputLikeAnyOther) {
  const SmallDisk disk(folder_ / "disk", "1m");
  if (!disk.is_there()) GTEST_SKIP() << "no mount is allowed here";
  put("disk/notes.md", "mine");
  expect_written(folder_ / "disk", "first");
  expect_written(folder_ / "disk", "second");
  EXPECT_EQ(read(folder_ / "disk/notes.md"), "mine");
}

TEST_F(ReportFolder, AFullDiskLeavesWhatWasThere) {
  const SmallDisk disk(folder_ / "disk", "64k");
  if (!disk.is_there()) GTEST_SKIP() << "no mount is allowed here";
  put("disk/notes.md", "mine");
  expect_written(folder_ / "disk", "first");
  const auto before = all();
  std::vector<ReportFile> large = report("second");
  large.emplace_back("figures/large.svg", std::string(100'000, 'x'));
  try {
    place_report(folder_ / "disk", large, true);
    FAIL() << "a full disk was a success";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("figures/large.svg: No space left on device"));
  }
  EXPECT_EQ(all(), before);
  expect_written(folder_ / "disk", "third");
}

/// Bounds the size of the files that a process writes: more fails, as on a full disk.
class FileLimit {
 public:
  explicit FileLimit(rlim_t bytes) : handler_(signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit now{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &now);
  }
  ~FileLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, handler_);
  }
  FileLimit(const FileLimit&) = delete;
  FileLimit& operator=(const FileLimit&) = delete;

 private:
  rlimit before_{};
  sighandler_t handler_;
};

TEST_F(ReportFolder, AWriteThatFailsInTheMiddleLeavesWhatWasThere) {
  expect_written(folder_ / "report", "first");
  const auto before = all();
  std::vector<ReportFile> large = report("second");
  large.emplace_back("large.html", std::string(10'000, 'x'));
  {
    const FileLimit limit(5000);
    EXPECT_THROW(place_report(folder_ / "report", large, true), std::runtime_error);
    EXPECT_THROW(place_report(folder_ / "new/report", large, true), std::runtime_error);
  }
  EXPECT_EQ(all(), before);
  EXPECT_FALSE(fs::exists(folder_ / "new")) << "a folder that it made for nothing";
}

TEST_F(ReportFolder, APartialReportDoesNotReplaceACompleteOne) {
  expect_written(folder_ / "report", "whole");
  EXPECT_EQ(place_report(folder_ / "report", report("some"), false), folder_ / "report/partial");
  EXPECT_EQ(read(folder_ / "report/results.json"), "results.json whole");
  EXPECT_EQ(read(folder_ / "report/partial/results.json"), "results.json some");
  EXPECT_EQ(place_report(folder_ / "report", report("more"), false), folder_ / "report/partial");
  EXPECT_EQ(read(folder_ / "report/partial/results.json"), "results.json more");
  // In a folder without one it stands where a complete one would, and gives place to it.
  EXPECT_EQ(place_report(folder_ / "fresh", report("some"), false), folder_ / "fresh");
  expect_written(folder_ / "fresh", "whole");
}

TEST_F(ReportFolder, AFileThatCameDuringTheRunIsKeptAndTheReportToo) {
  EXPECT_EQ(refusal(folder_ / "report"), "");
  put("report/results.csv", "came in between");
  EXPECT_EQ(place_report(folder_ / "report", report("first"), true), folder_ / "report/unplaced_1");
  EXPECT_EQ(place_report(folder_ / "report", report("second"), true), folder_ / "report/unplaced_2");
  EXPECT_EQ(read(folder_ / "report/results.csv"), "came in between");
  EXPECT_EQ(read(folder_ / "report/unplaced_1/results.csv"), "results.csv first");
}

TEST_F(ReportFolder, ARunThatDiedBetweenTwoNamesLeavesFilesThatTheNextOneKnows) {
  expect_written(folder_ / "report", "first");
  // Both manifests in one, and some of the files renamed: as a crash leaves it.
  Manifest both = *read_manifest(folder_ / "report");
  for (const auto& [name, content] : report("second")) both.files.push_back(manifest_entry(name, content));
  put(std::string("report/") + kManifestName, manifest_text(both));
  put("report/results.csv", "results.csv second");
  expect_written(folder_ / "report", "third");
}

TEST_F(ReportFolder, AReportOfAnotherProgramIsNotReplaced) {
  Manifest manifest{"dynamics_run", true, {manifest_entry("results.json", "theirs")}};
  put("report/results.json", "theirs");
  put(std::string("report/") + kManifestName, manifest_text(manifest));
  EXPECT_THAT(refusal(folder_ / "report"), HasSubstr("holds a report of dynamics_run; name another folder"));
  EXPECT_EQ(place_report(folder_ / "report", report("ours"), true), folder_ / "report/unplaced_1");
  EXPECT_EQ(read(folder_ / "report/results.json"), "theirs");
}

TEST_F(ReportFolder, StreamedFilesStandBesideAReportAndOthersFilesAndReplaceNeither) {
  put("report/notes.csv", "mine");
  const std::vector<std::string> names = {"a.csv", "b.csv"};
  for (const char* content : {"first", "second"}) {
    expect_written(folder_ / "report", content);
    EXPECT_NO_THROW(StreamedFile::check("--record", folder_ / "report", names));
    for (const std::string& name : names) {
      StreamedFile file(folder_ / "report", name);
      std::ofstream(file.path()) << name << content;
      EXPECT_EQ(file.keep(), "");
      EXPECT_EQ(read(folder_ / "report" / name), name + content);
    }
    { const StreamedFile given_up(folder_ / "report", "a.csv"); }
    EXPECT_EQ(read(folder_ / "report/a.csv"), std::string("a.csv") + content);
    EXPECT_EQ(all().size(), 1 + kNames.size() + 1 + names.size() + 1);
  }
  put("report/a.csv", "edited");
  EXPECT_THROW(StreamedFile::check("--record", folder_ / "report", names), InputError);
  StreamedFile late(folder_ / "report", "a.csv");
  EXPECT_THAT(late.keep(), HasSubstr("a.csv has changed since an earlier run wrote it"));
  EXPECT_EQ(read(folder_ / "report/a.csv"), "edited");
  EXPECT_EQ(read(folder_ / "report/notes.csv"), "mine");
}

/// The exit code of a process whose standard streams go to the file.
int run_apart(const fs::path& file, const std::function<int()>& body) {
  const pid_t process = fork();
  if (process == 0) {
    const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0666);
    dup2(descriptor, STDOUT_FILENO);
    dup2(descriptor, STDERR_FILENO);
    _exit(body());
  }
  int status = 0;
  waitpid(process, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_F(ReportFolder, WhatEnginesPrintIsKeptApartAndCounted) {
  const int code = run_apart(folder_ / "out", [] {
    const EngineLog log;
    std::printf("engine: one\n");
    print_now("ours\n");
    std::fputs("engine: two\nengine: three\n", stderr);
    std::fflush(stdout);
    const bool is_kept = log.text().find("engine: one\n") != std::string::npos;
    return is_kept ? static_cast<int>(engine_log_lines()) : 100;
  });
  EXPECT_EQ(code, 3);
  EXPECT_EQ(read(folder_ / "out"), "ours\n");
}

TEST_F(ReportFolder, AnEngineThatEndsTheProcessHasItsLastWords) {
  const int code = run_apart(folder_ / "out", [] {
    const EngineLog log;
    std::fputs("engine: a rotation is no number\n", stderr);
    std::abort();
    return 0;
  });
  EXPECT_EQ(code, 128 + SIGABRT);
  EXPECT_EQ(read(folder_ / "out"), "engine: a rotation is no number\n");
}
#endif

TEST_F(ReportFolder, WhatCannotBeWrittenToIsRefusedBeforeTheRun) {
  for (const char* folder : {"/proc/no_such/report", "/proc/self", "/dev/null", "/dev/null/x"})
    EXPECT_THAT(refusal(folder), HasSubstr(std::string("--output ") + folder)) << folder;
  put("file", "x");
  EXPECT_THAT(refusal(folder_ / "file"), HasSubstr("is not a folder"));
  EXPECT_EQ(refusal(folder_ / "deep/deeper/report"), "");
  EXPECT_FALSE(fs::exists(folder_ / "deep")) << "what was tried is left";
}

}  // namespace
}  // namespace touchstone::comparison
