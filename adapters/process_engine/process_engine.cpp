#include "touchstone/adapters/process_engine/process_engine.hpp"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cstdio>
#include <memory>
#include <mutex>
#include <utility>

#include "touchstone/adapters/c_interface/corners.hpp"
#include "touchstone/adapters/plugin/engine_name.hpp"
#include "touchstone/adapters/process_engine/child_process.hpp"
#include "touchstone/adapters/process_engine/protocol.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/narrowphase/answer_check.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/narrowphase/validate.hpp"

// Pairs go to the engine in large questions. Where one goes wrong, the engine is started anew and its pairs
// are asked one by one, so that the pair that did it is known by its number and the others are answered.

namespace touchstone {
namespace process_engine {
namespace {

/// The time limits of a question, and of each of its pairs, that do not count to those of all.
constexpr double kFreeLimits = 0.06, kFreeLimitsOfAPair = 1e-2;
/// Failures in a row without an answer after which an engine is given up, in what one workspace may take.
constexpr int kWorkspacesInVain = 4;

using Clock = std::chrono::steady_clock;

std::string seconds(std::chrono::milliseconds limit) {
  return figure(static_cast<double>(limit.count()) / 1000.0) + " s";
}

/// Sends `request` and reads until `wanted(reply)` is 0. Returns why that failed; "" where it did not.
template <class Wanted>
std::string converse(ChildProcess& child, std::string_view request, std::string& reply,
                     std::chrono::milliseconds limit, std::chrono::milliseconds in_all, Wanted&& wanted) {
  const Clock::time_point last = Clock::now() + in_all;
  for (std::size_t most = wanted(reply); most > 0 || !request.empty(); most = wanted(reply)) {
    if (most == 0) return "it answers before it was asked";
    switch (child.exchange(request, reply, most, limit)) {
      case ChildProcess::Turn::timed_out: {
        const std::string how = child.end();  // what it started may hold its pipes
        return "no answer within " + seconds(limit) + (how.empty() ? "" : " after " + how);
      }
      case ChildProcess::Turn::ended: {
        const std::string how = child.end();
        return how.empty() ? "it closed its input or output" : how;
      }
      case ChildProcess::Turn::wrote_or_read:
        if (Clock::now() > last) return "no answer within " + seconds(in_all);
    }
  }
  return "";
}

Greeting greet(ChildProcess& child, std::chrono::milliseconds limit) {
  std::string line;
  const auto until_newline = [](const std::string& so_far) -> std::size_t {
    return so_far.find('\n') == std::string::npos ? kLongestGreeting - so_far.size() : 0;
  };
  const std::string failure =
      converse(child, {}, line, kLimitsOfAStart * limit, kLimitsOfAStart * limit, until_newline);
  if (!failure.empty()) throw InputError("no greeting: " + failure);
  const std::size_t end = line.find('\n');
  if (end == std::string::npos) throw InputError("its first line does not end");
  if (end + 1 != line.size()) throw InputError("writes more than its greeting unasked");
  return parse_greeting(std::string_view(line).substr(0, end));
}

/// The engine as all its narrowphases know it.
struct Engine {
  ProcessEngineOptions options;
  Greeting greeting;
  std::unique_ptr<Protocol> protocol;
  mutable std::mutex telling;
  /// In a row, of all workspaces.
  mutable std::atomic<int> failures_in_vain = 0;
  mutable std::atomic<bool> is_given_up = false;

  /// As many as are answered soon, few at first.
  mutable std::atomic<std::size_t> pairs_of_a_question = 16;
  /// Of all workspaces [ns], beyond what is free.
  mutable std::atomic<std::int64_t> waited = 0;

  std::chrono::milliseconds of_a_question() const {
    return options.limits_of_a_question * options.time_limit;
  }
  bool has_used_its_time() const {
    return std::chrono::nanoseconds(waited) > options.limits_in_all * options.time_limit;
  }
  void count_question(std::size_t pairs, std::chrono::nanoseconds took) const {
    const double free = kFreeLimits + kFreeLimitsOfAPair * static_cast<double>(pairs);
    const auto beyond = took - std::chrono::duration<double, std::nano>(free * options.time_limit);
    if (beyond.count() > 0.0) waited += static_cast<std::int64_t>(beyond.count());
  }
  /// What answers a question as a whole keeps silent until then: a slow engine, or one on a busy machine, is
  /// asked less at a time. A crash is soon, too, but no answer.
  void suit_next_question(std::size_t pairs, Clock::duration took, bool is_answered) const {
    if (2 * took > options.time_limit)
      pairs_of_a_question = std::max<std::size_t>(1, pairs / 2);
    else if (is_answered && 4 * took < options.time_limit && pairs == pairs_of_a_question)
      pairs_of_a_question = std::min(2 * pairs, protocol->largest_question());
  }
  int most_in_vain() const { return kWorkspacesInVain * (options.max_restarts + 1); }
  /// An engine that hangs whatever it is asked would cost each workspace its restarts, minutes each. It stays
  /// given up, whatever processes that still run answer. Starts and questions under way count for nothing.
  void count_in_vain() const {
    if (++failures_in_vain >= most_in_vain()) is_given_up = true;
  }

  void tell(const std::string& what) const {
    const std::lock_guard lock(telling);
    const std::string line = "engine " + greeting.name + ": " + what;
    if (options.on_failure) {
      options.on_failure(line);
    } else {
      std::fprintf(stderr, "touchstone: %s\n", line.c_str());
    }
  }
};

struct Solids {
  std::vector<double> corners;
  std::size_t count = 0;
  std::uint64_t build = 0;
};

/// A process between two questions.
struct Running {
  std::unique_ptr<ChildProcess> child;
  std::uint64_t built = 0;  ///< of which solids it knows; 0: none
  std::uint32_t batch = 0;  ///< its last question's
};

/// Processes of workspaces that are gone, for the next ones: a start and the solids of a large set cost more
/// than its pairs.
class IdleProcesses {
 public:
  void give(Running running) {
    const std::lock_guard lock(mutex_);
    if (idle_.size() < kMostIdle) idle_.push_back(std::move(running));
  }
  /// Without a child where none of them still waits to be asked.
  Running take() {
    for (;;) {
      Running last = take_last();
      if (last.child == nullptr || last.child->is_silent()) return last;
    }
  }

 private:
  Running take_last() {
    const std::lock_guard lock(mutex_);
    if (idle_.empty()) return {};
    Running last = std::move(idle_.back());
    idle_.pop_back();
    return last;
  }

  static constexpr std::size_t kMostIdle = 16;
  std::mutex mutex_;
  std::vector<Running> idle_;
};

/// One process and what is said to it.
class Connection final : public Narrowphase::Workspace {
 public:
  Connection(std::shared_ptr<const Engine> engine, std::shared_ptr<IdleProcesses> idle)
      : engine_(std::move(engine)), idle_(std::move(idle)) {
    if (engine_->is_given_up) return;
    running_ = idle_->take();
    if (running_.child == nullptr) return;
    starts_ = 1;
    has_served_others_ = true;
  }
  ~Connection() override {
    if (running_.child == nullptr || engine_->is_given_up) return;
    try {
      idle_->give(std::move(running_));
    } catch (const std::exception&) {  // no memory: it has ended with what was to hold it
    }
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Asks the pairs of `asked` (indices into input.pairs); what gets no answer keeps what is in its slots.
  void ask(const Solids& solids, const NarrowphaseInput& input, const NarrowphaseOutput& output) {
    const std::span<const std::uint32_t> all(asked);
    std::size_t at = 0, one_by_one_until = 0;
    while (at < all.size()) {
      if (engine_->has_used_its_time() || !is_running(solids)) return give_up(all.subspan(at), output);
      const std::size_t most = at < one_by_one_until ? 1 : engine_->pairs_of_a_question.load();
      const auto part = all.subspan(at, std::min(most, all.size() - at));
      // A part without a failure is done.
      const auto [answered, failure] = ask_part({input, part, ++running_.batch}, output);
      at += answered;
      if (answered > 0)
        engine_->failures_in_vain = 0;
      else if (!failure.empty())
        engine_->count_in_vain();
      const bool had_served = std::exchange(has_served_others_, false);
      if (failure.empty()) continue;
      // After a failure the pairs left of the part are asked one by one, of a new process, to find the guilty
      // one. What an earlier workspace left behind is no pair's fault.
      drop();
      if (had_served) {
        starts_ = 0;
        engine_->tell("failed, " + failure +
                      ", in a process that had served before; a new one is asked again");
      } else if (part.size() == 1) {
        engine_->tell("failed, " + failure + " on pair " + std::to_string(part[0]));
        output.status[part[0]] = PairStatus::failed;
        at += 1 - answered;
      } else {
        engine_->tell("failed, " + failure + " within pairs " + std::to_string(part.front()) + " to " +
                      std::to_string(part.back()) + "; they are asked again one by one");
        one_by_one_until = at - answered + part.size();
      }
    }
  }

  /// Ends its process, which may be within a question.
  void drop() { running_ = {}; }

  std::vector<std::uint32_t> asked;

 private:
  struct Outcome {
    std::size_t answered = 0;
    std::string failure;
  };

  bool is_running(const Solids& solids) {
    while (running_.child == nullptr || running_.built != solids.build) {
      if (running_.child == nullptr) {
        if (has_used_restarts() || engine_->is_given_up) return false;
        ++starts_;
      }
      try {
        if (running_.child == nullptr) start();
        if (send(solids)) return true;
      } catch (const InputError& error) {
        engine_->tell(std::string("failed, ") + error.what());
      }
      drop();
      engine_->count_in_vain();
    }
    return true;
  }

  bool has_used_restarts() const { return starts_ > engine_->options.max_restarts; }

  void start() {
    running_ = {std::make_unique<ChildProcess>(engine_->options.command)};
    has_served_others_ = false;
    const Greeting now = greet(*running_.child, engine_->options.time_limit);
    if (now.name != engine_->greeting.name || now.is_binary != engine_->greeting.is_binary)
      throw InputError("it greets otherwise than before");
  }

  bool send(const Solids& solids) {
    request_.clear();
    engine_->protocol->write_solids(solids.corners, request_);
    std::string_view rest = request_;
    std::string unasked;
    const auto limit = engine_->options.time_limit;
    const auto in_all = engine_->of_a_question() * (1 + solids.count / engine_->protocol->largest_question());
    const Clock::time_point last = Clock::now() + in_all;
    while (!rest.empty()) {
      const auto turn = running_.child->exchange(rest, unasked, 1, limit);
      const bool moves = turn == ChildProcess::Turn::wrote_or_read && unasked.empty();
      if (moves && Clock::now() <= last) continue;
      const std::string how = moves                                   ? "not done within " + seconds(in_all)
                              : turn == ChildProcess::Turn::timed_out ? "no move within " + seconds(limit)
                              : unasked.empty()                       ? running_.child->end()
                                                                      : "it writes more than was asked";
      engine_->tell("failed, " + how + " on taking solids");
      return false;
    }
    running_.built = solids.build;
    return true;
  }

  Outcome ask_part(const Question& question, const NarrowphaseOutput& output) {
    const Protocol& protocol = *engine_->protocol;
    if (running_.child->has_more())
      return {0, "it writes more than was asked"};  // late, after an earlier reply
    request_.clear();
    reply_.clear();
    protocol.write_question(question, request_);
    const Clock::time_point begin = Clock::now();
    std::string failure =
        converse(*running_.child, request_, reply_, engine_->options.time_limit, engine_->of_a_question(),
                 [&](const std::string& so_far) { return protocol.wanted(question, so_far); });
    const Clock::duration took = Clock::now() - begin;
    engine_->count_question(question.pairs.size(), took);
    const Decoded decoded = protocol.read_reply(question, reply_, output);
    if (failure.empty() && decoded.problem != nullptr) failure = decoded.problem;
    engine_->suit_next_question(question.pairs.size(), took, failure.empty());
    if (!failure.empty()) return {decoded.answered, failure};
    if (running_.child->has_more()) return {0, "it writes more than was asked"};
    return {decoded.answered, ""};
  }

  void give_up(std::span<const std::uint32_t> unasked, const NarrowphaseOutput& output) {
    for (const std::uint32_t i : unasked)
      output.status[i] = PairStatus::failed;  // a reply not believed left more
    if (std::exchange(told_end_, true)) return;
    engine_->tell("given up after " + why_it_ends() + "; " + std::to_string(unasked.size()) +
                  " pairs here and all later ones are failed unasked");
  }

  std::string why_it_ends() const {
    if (engine_->has_used_its_time())
      return seconds(engine_->options.limits_in_all * engine_->options.time_limit) + " in its questions";
    if (has_used_restarts()) return std::to_string(engine_->options.max_restarts) + " restarts";
    return std::to_string(engine_->most_in_vain()) +
           " failures in a row without an answer, in all workspaces";
  }

  std::shared_ptr<const Engine> engine_;
  std::shared_ptr<IdleProcesses> idle_;
  Running running_;
  std::string request_, reply_;
  int starts_ = 0;                  ///< with the process that it began with
  bool has_served_others_ = false;  ///< its process, until the first question of this workspace is over
  bool told_end_ = false;
};

class ProcessNarrowphase final : public Narrowphase {
 public:
  explicit ProcessNarrowphase(std::shared_ptr<const Engine> engine) : engine_(std::move(engine)) {}

  std::string_view name() const noexcept override { return engine_->greeting.name; }
  const Capabilities& capabilities() const noexcept override { return engine_->greeting.capabilities; }
  void build(std::span<const Hexahedron> solids) override {
    refuse_rounded(solids, name());
    solids_ = {c_interface::corners_of(solids), solids.size(), solids_.build + 1};
  }
  std::unique_ptr<Workspace> make_workspace() const override {
    return std::make_unique<Connection>(engine_, idle_);
  }

  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override {
    assert(fits(input, output, solids_.count));
    const std::size_t count = input.pairs.size();
    const bool answers = is_answered(input.query.kind);
    std::fill_n(output.status.begin(), count, answers ? PairStatus::failed : PairStatus::unsupported);
    if (!output.geometry.empty()) std::fill_n(output.geometry.begin(), count, no_geometry());
    if (!answers) return;
    auto& connection = static_cast<Connection&>(workspace);
    try {
      connection.asked.clear();
      for (std::size_t i = 0; i < count; ++i)
        if (has_finite_poses(input.pairs[i], input.poses))
          connection.asked.push_back(static_cast<std::uint32_t>(i));
      connection.ask(solids_, input, output);
    } catch (const std::exception& error) {  // no memory: what was not answered is `failed` already
      connection.drop();
      std::fprintf(stderr, "touchstone: engine: %s\n", error.what());
    }
    judge(input.query, count, output);
  }

 private:
  bool is_answered(QueryKind kind) const noexcept {
    const Capabilities& of = capabilities();
    if (kind == QueryKind::manifold) return of.manifold;
    return kind == QueryKind::overlap || of.distance || of.penetration;
  }

  void judge(const Query& query, std::size_t count, const NarrowphaseOutput& output) const noexcept {
    std::size_t first = 0;
    const char* what = nullptr;
    if (settle_answers(query, count, output, first, what) == 0 || told_.exchange(true)) return;
    try {
      engine_->tell("failed, " + std::string(what) + ", on pair " + std::to_string(first) +
                    "; further answers like this are counted as failed without a word");
    } catch (const std::exception&) {
      return;  // no memory for the line; the pairs are `failed`
    }
  }

  std::shared_ptr<const Engine> engine_;
  std::shared_ptr<IdleProcesses> idle_ = std::make_shared<IdleProcesses>();
  Solids solids_;
  mutable std::atomic<bool> told_ = false;
};

}  // namespace
}  // namespace process_engine

std::string register_process_engine(BackendRegistry& registry, const ProcessEngineOptions& options) {
  using namespace process_engine;
  if (options.time_limit.count() <= 0) throw InputError("engine: time_limit must be above 0");
  auto engine = std::make_shared<Engine>();
  engine->options = options;
  ChildProcess child(options.command);
  try {
    engine->greeting = greet(child, options.time_limit);
  } catch (const InputError& error) {
    reject("engine " + options.command.front(), error.what());
  }
  engine->protocol = engine->greeting.is_binary ? make_binary_protocol() : make_json_protocol();
  const Greeting& greeting = engine->greeting;
  registry.add(BackendRegistry::NarrowphaseEntry{
      greeting.name,
      engine_text(greeting.description.empty() ? "process " + options.command.front() : greeting.description),
      [engine = std::shared_ptr<const Engine>(engine)] {
        return std::make_unique<ProcessNarrowphase>(engine);
      },
      {}});
  return greeting.name;
}

}  // namespace touchstone
