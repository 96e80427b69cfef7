#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>

namespace touchstone {

/// A test with a folder of its own, which goes when the test does.
class FolderTest : public ::testing::Test {
 protected:
  FolderTest() {
    std::string name = (std::filesystem::temp_directory_path() / "touchstone_test.XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~FolderTest() override { std::filesystem::remove_all(folder_); }

  static std::string read(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  std::filesystem::path write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name) << content;
    return folder_ / name;
  }

  std::filesystem::path folder_;
};

/// A program as a user runs it.
class ProgramTest : public FolderTest {
 protected:
  explicit ProgramTest(std::string program) : program_(std::move(program)) {}

  struct Outcome {
    int code;
    std::string out, err;
  };
  Outcome run(const std::string& arguments) const {
    const std::filesystem::path out = folder_ / "out", err = folder_ / "err";
    const std::string command = program_ + " " + arguments + " >" + out.string() + " 2>" + err.string();
    const int status = std::system(command.c_str());
    Outcome outcome{WEXITSTATUS(status), read(out), read(err)};
    std::filesystem::remove(out);
    std::filesystem::remove(err);
    return outcome;
  }

  /// The run ends with exit code 2 and one line of error, which has these texts; one that names the program,
  /// "compare_backends: ", begins the line.
  void expect_refusal(const std::string& arguments, std::initializer_list<std::string> texts) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1)
        << arguments << ": " << outcome.err;
    const std::string name = std::filesystem::path(program_).filename().string() + ": ";
    for (const std::string& text : texts) {
      const std::size_t at = outcome.err.find(text);
      EXPECT_NE(at, std::string::npos) << arguments << ": " << outcome.err;
      if (text.compare(0, name.size(), name) == 0) {
        EXPECT_EQ(at, 0u) << arguments << ": " << outcome.err;
      }
    }
  }

  /// The outcome of a run that is sent a signal after a while, and how long it took from then on to the end
  /// [s].
  std::pair<Outcome, double> run_until(const std::string& arguments, std::chrono::milliseconds delay,
                                       int signal) const {
    const auto waits = [delay](const std::string&) {
      std::this_thread::sleep_for(delay);
      return true;
    };
    return run_until(arguments, waits, signal);
  }
  /// The same, as soon as `ready(what it has printed so far)`; or when it has ended, or a minute is over.
  template <class Ready, class = std::enable_if_t<std::is_invocable_r_v<bool, Ready, std::string>>>
  std::pair<Outcome, double> run_until(const std::string& arguments, const Ready& ready, int signal) const {
    // The program is the process itself, so that the signal is its.
    const std::filesystem::path out = folder_ / "out", err = folder_ / "err";
    const std::string command =
        "exec " + program_ + " " + arguments + " >" + out.string() + " 2>" + err.string();
    const pid_t process = fork();
    if (process == 0) {
      execl("/bin/sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
      _exit(127);
    }
    // As soon as it is ready, or too late, it gets the signal.
    const auto has_ended = [process] {
      siginfo_t info{};
      return waitid(P_PID, static_cast<id_t>(process), &info, WEXITED | WNOHANG | WNOWAIT) != 0 ||
             info.si_pid != 0;
    };
    const auto patience = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (!ready(read(out)) && !has_ended() && std::chrono::steady_clock::now() < patience)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    kill(process, signal);
    // From then on to its end.
    const auto start = std::chrono::steady_clock::now();
    int status = 0;
    waitpid(process, &status, 0);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), read(out), read(err)};
    std::filesystem::remove(out);
    std::filesystem::remove(err);
    return {outcome, elapsed.count()};
  }

  /// A run writes into a folder beside others' files, and again over its own; where another file has the name
  /// of one of its files, it ends with an error and leaves that file as it is.
  /// @param command what to run, up to the folder. @param names some of its files.
  void expect_files_of_others_are_kept(const std::string& command, std::initializer_list<const char*> names) {
    write("precious", "mine");
    for (int turn = 0; turn < 2; ++turn) EXPECT_EQ(run(command + folder_.string()).code, 0);
    EXPECT_EQ(read(folder_ / "precious"), "mine");
    for (const char* name : names) {
      EXPECT_TRUE(std::filesystem::exists(folder_ / name)) << name;
      const std::filesystem::path other = folder_ / "other";
      std::filesystem::create_directories((other / name).parent_path());
      write(std::string("other/") + name, "mine");
      const Outcome outcome = run(command + other.string());
      EXPECT_EQ(outcome.code, 2);
      const std::string refusal = std::string("other/") + name + " is there and no earlier run wrote it";
      EXPECT_NE(outcome.err.find(refusal), std::string::npos) << outcome.err;
      EXPECT_EQ(read(other / name), "mine");
      std::filesystem::remove_all(other);
    }
  }

 private:
  std::string program_;
};

}  // namespace touchstone
