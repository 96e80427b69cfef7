#pragma once

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <stdexcept>
#include <string>
#include <vector>

namespace touchstone::station {

/// The station as a user starts it, on a port that is free.
class RunningStation {
 public:
  /// @param options besides --port 0 and the scene.
  explicit RunningStation(const std::string& scene, const std::vector<std::string>& options = {}) {
    std::array<int, 2> said{};
    if (pipe(said.data()) != 0) throw std::runtime_error("no pipe");
    process_ = fork();
    if (process_ == 0) {
      dup2(said[1], 1);
      close(said[0]);
      std::vector<std::string> words = {STATION, "--port", "0", "--scene", scene};
      words.insert(words.end(), options.begin(), options.end());
      std::vector<char*> arguments;
      for (std::string& word : words) arguments.push_back(word.data());
      arguments.push_back(nullptr);
      execv(STATION, arguments.data());
      _exit(127);
    }
    close(said[1]);
    char letter = 0;
    // The account of a robot's meshes comes before the address.
    while (line_.find("http://") == std::string::npos) {
      line_.clear();
      while (read(said[0], &letter, 1) == 1 && letter != '\n') line_ += letter;
      if (line_.empty()) break;
    }
    said_ = said[0];
  }
  ~RunningStation() {
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
    close(said_);
  }
  RunningStation(const RunningStation&) = delete;
  RunningStation& operator=(const RunningStation&) = delete;

  /// Where it serves, e.g. "http://127.0.0.1:40001/".
  std::string address() const {
    const std::size_t begin = line_.find("http://");
    return begin == std::string::npos ? "" : line_.substr(begin, line_.find(' ', begin) - begin);
  }

 private:
  pid_t process_ = -1;
  int said_ = -1;
  std::string line_;
};

/// Flies the tip to `goal` in the world by the page's own hand, without turning it, from now on.
inline constexpr const char* kFlyTo = R"js((async () => {
  const {positionOf, rotationOf} = await import('/frames.js');
  const {add, subtract, turn, conjugate} = await import('/algebra.js');
  const {station, hand} = touchstoneStation;
  window.flyTo = goal => {
    clearInterval(window.flying);
    window.flying = goal && setInterval(() => {
      const tip = station.scene.tips[station.frame.tip], {poses} = station.frame.methods.at(-1);
      const rotation = rotationOf(poses, tip.object);
      const way = subtract(goal, add(positionOf(poses, tip.object), turn(rotation, tip.position)));
      window.away = Math.hypot(...way);
      hand.assist = turn(conjugate(rotation), way).map(one => Math.max(-1, Math.min(1, one / 0.37)));
    }, 30);
    if (!goal) hand.assist = null;
  };
  return true;
})())js";

}  // namespace touchstone::station
