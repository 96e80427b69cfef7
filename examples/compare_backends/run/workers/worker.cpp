#include "touchstone/examples/compare_backends/run/workers/worker.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <fstream>
#include <iostream>
#include <thread>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/run/workers/job_io.hpp"
#include "touchstone/examples/compare_backends/run/workers/signs_of_life.hpp"
#include "touchstone/examples/program/terminal/interruption.hpp"

extern char** environ;

namespace touchstone::comparison {
namespace {

namespace fs = std::filesystem;

// A folder of its own that goes away with it, and when a signal ends the program.
class TemporaryFolder {
 public:
  TemporaryFolder() : path_(make()), on_interrupt_([this] { return remove(); }) {}
  ~TemporaryFolder() { remove(); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  static fs::path make() {
    std::string name = fs::absolute(fs::temp_directory_path() / "compare_backends.XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder can be made: " + name);
    return name;
  }
  std::string remove() const {
    std::error_code error;
    fs::remove_all(path_, error);
    return "";
  }

  fs::path path_;
  OnInterrupt on_interrupt_;
};

std::string read_file(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write_file(const fs::path& path, const std::string& bytes) {
  std::ofstream stream(path, std::ios::binary);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) throw std::runtime_error(path.string() + " cannot be written: is the disk full?");
}

// Starts a program in a process group of its own, so that what an engine starts ends with it. What the engine
// prints is not our output, nor is our input its own.
int start(pid_t& process, const fs::path& program, std::vector<std::string> command) {
  std::vector<char*> argv;
  for (std::string& word : command) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  const int error = posix_spawn(&process, program.c_str(), &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

bool has_ended(pid_t process) {
  siginfo_t how{};
  return waitid(P_PID, static_cast<id_t>(process), &how, WEXITED | WNOHANG | WNOWAIT) != 0 || how.si_pid != 0;
}

// Ends the program, where it still runs, and what it started. Returns how it ended.
int end(pid_t process) {
  kill(-process, SIGKILL);  // while its number is still its own
  int status = 0;
  waitpid(process, &status, 0);
  return status;
}

// Runs the program to its end, which gives signs of life in a file of `folder`. Returns "" or how it failed;
// a hang is noted in the worker, too.
std::string run_program(const Worker& worker, const fs::path& folder, std::vector<std::string> arguments,
                        const Progress& progress) {
  const fs::path& program = worker.program;
  // The program comes first, then its own arguments, then those of the job.
  const fs::path life = folder / "life";
  const SignsOfLife signs(life);
  arguments.insert(arguments.begin() + 1, life.string());
  arguments.insert(arguments.begin(), worker.arguments.begin(), worker.arguments.end());
  arguments.insert(arguments.begin(), program.string());
  pid_t process = 0;
  if (const int error = start(process, program, std::move(arguments))) {
    return fmt::format("{} cannot be started: {}", program.filename().string(), std::strerror(error));
  }
  // Workers do not outlive an interrupted run.
  const OnInterrupt end_it([process] {
    kill(-process, SIGKILL);
    return std::string();
  });
  // Polling lets progress and interrupts through.
  Patience patience(signs, worker.time_limit, Patience::Clock::now());
  try {
    while (!has_ended(process)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      if (progress) progress(0.0);
      if (!patience.is_over(Patience::Clock::now())) continue;
      end(process);
      *worker.hang = patience.is_too_long()
                         ? fmt::format("{} took more than {:.3g} s in all", program.filename().string(),
                                       patience.allowed_in_all().count())
                         : fmt::format("{} gave no answer within {:g} s", program.filename().string(),
                                       1e-3 * static_cast<double>(patience.limit().count()));
      return *worker.hang;
    }
  } catch (...) {
    end(process);
    throw;
  }
  // A worker that died is reported in words, as a failure of its backends.
  const int status = end(process);
  stop_if_interrupted();  // then it was we who ended it, which is no result
  if (WIFSIGNALED(status)) {
    return fmt::format("{} died: {}", program.filename().string(), strsignal(WTERMSIG(status)));
  }
  if (WEXITSTATUS(status) != 0) {
    return fmt::format("{} ended with exit code {}", program.filename().string(), WEXITSTATUS(status));
  }
  return "";
}

std::vector<BackendAnswers> all_failed(const Worker& worker, std::span<const std::string> backends,
                                       const PairSet& set, const std::string& failure) {
  std::vector<BackendAnswers> answers(backends.size());
  for (std::size_t b = 0; b < backends.size(); ++b) {
    answers[b].name = backends[b];
    for (const auto& [name, description] : worker.backends) {
      if (name == backends[b]) answers[b].description = description;
    }
    answers[b].failure = failure;
    for (QueryAnswers& query : answers[b].queries) {
      query.status.assign(set.cases(), PairStatus::failed);
      query.geometry.resize(set.cases());
      query.points.resize(set.cases() * kMaxManifoldPoints);
    }
  }
  return answers;
}

// Whether each answers again one of the cases, none twice.
bool are_later(std::span<const measures::LaterAnswer> answers, QueryKind kind, std::size_t cases) {
  const std::size_t points = kind == QueryKind::manifold ? kMaxManifoldPoints : 0;
  std::size_t next = 0;
  for (const measures::LaterAnswer& each : answers) {
    if (each.index < next || each.index >= cases || each.status > PairStatus::unsupported ||
        each.points.size() != points)
      return false;
    next = each.index + 1;
  }
  return true;
}

// Whether the answers are those backends', each to all cases.
bool fit(std::span<const BackendAnswers> answers, std::span<const std::string> backends, std::size_t cases) {
  const auto fits = [&](const QueryAnswers& of, QueryKind kind) {
    return of.status.size() == cases && (kind == QueryKind::overlap || of.geometry.size() == cases) &&
           (kind != QueryKind::manifold || of.points.size() == cases * kMaxManifoldPoints) &&
           are_later(of.later, kind, cases) &&
           std::all_of(of.status.begin(), of.status.end(),
                       [](PairStatus status) { return status <= PairStatus::unsupported; });
  };
  if (answers.size() != backends.size()) return false;
  for (std::size_t b = 0; b < backends.size(); ++b) {
    if (answers[b].name != backends[b]) return false;
    for (const QueryKind kind : measures::kQueryKinds)
      if (!fits(answers[b].queries[index_of(kind)], kind)) return false;
    const QueryAnswers& moved = answers[b].perturbed;
    if (!moved.status.empty() && !fits(moved, QueryKind::manifold)) return false;
  }
  return true;
}

}  // namespace

bool Worker::offers(std::string_view name) const {
  return std::any_of(backends.begin(), backends.end(),
                     [&](const auto& backend) { return backend.first == name; });
}

Worker describe_worker(const fs::path& program, const std::vector<std::string>& arguments,
                       std::chrono::milliseconds time_limit) {
  Worker worker;
  worker.time_limit = time_limit;
  worker.program = program;
  worker.arguments = arguments;
  const TemporaryFolder folder;
  const fs::path answer = folder.path() / "backends";
  worker.failure = run_program(worker, folder.path(), {"--describe", answer.string()}, {});
  if (!worker.failure.empty()) return worker;
  std::ifstream stream(answer);
  for (std::string name, description; std::getline(stream, name) && std::getline(stream, description);) {
    worker.backends.emplace_back(name, description);
  }
  if (worker.backends.empty()) worker.failure = program.filename().string() + " named no backends";
  return worker;
}

std::vector<BackendAnswers> run_in_worker(const Worker& worker, std::span<const std::string> backends,
                                          const PairSet& set, const MeasureOptions& options,
                                          const Progress& progress) {
  if (!worker.hang->empty())
    return all_failed(worker, backends, set, *worker.hang + " in an earlier set; it is not asked again");
  const TemporaryFolder folder;
  const fs::path job = folder.path() / "job", answers = folder.path() / "answers";
  write_file(job, encode_job({{backends.begin(), backends.end()}, options, set}));
  const std::string failure =
      run_program(worker, folder.path(), {"--run", job.string(), answers.string()}, progress);
  if (!failure.empty()) return all_failed(worker, backends, set, failure);
  // An engine writes where it likes in the worker's memory: what comes back may be anything.
  try {
    std::vector<BackendAnswers> decoded = decode_answers(read_file(answers));
    if (fit(decoded, backends, set.cases())) return decoded;
  } catch (const std::exception&) {
  }
  return all_failed(worker, backends, set, worker.program.filename().string() + " wrote no readable answers");
}

int worker_main(int argc, char** argv, const std::function<void(BackendRegistry&)>& add_backends) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  prctl(PR_SET_PDEATHSIG, SIGKILL);                   // nobody waits for it then
  std::ofstream("/proc/self/oom_score_adj") << 1000;  // where memory ends, this ends before who started it
  try {
    BackendRegistry registry;
    add_backends(registry);
    // The program asks for the names of the backends first.
    if (arguments.size() == 3 && arguments[0] == "--describe") {
      std::ofstream stream(arguments[2]);
      for (const auto& entry : registry.narrowphases())
        stream << entry.name << "\n" << entry.description << "\n";
      return stream ? 0 : 1;
    }
    // A job comes as one file, and its answers go back as another.
    if (arguments.size() == 4 && arguments[0] == "--run") {
      SignsOfLife signs(arguments[1]);
      const Job job = decode_job(read_file(arguments[2]));
      signs.give();  // the start ends here
      std::deque<BackendRegistry::NarrowphaseEntry> named;
      std::vector<const BackendRegistry::NarrowphaseEntry*> entries;
      for (const std::string& name : job.backends)
        entries.push_back(&named.emplace_back(watched(registry.narrowphase(name), signs)));
      const std::vector<BackendAnswers> answers =
          run_backends(entries, job.set, job.options, [&signs](double) { signs.give(); });
      signs.give();
      const std::string encoded = encode_answers(answers);
      signs.give();
      write_file(arguments[3], encoded);
      return 0;
    }
  } catch (const std::exception& error) {
    std::cerr << arguments[0] << ": " << error.what() << "\n";
    return 1;
  }
  std::cerr << "a worker of compare_backends: it is started by that program\n";
  return 2;
}

}  // namespace touchstone::comparison
