#include "touchstone/examples/compare_backends/run/workers/signs_of_life.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <new>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "touchstone/adapters/process_engine/process_engine.hpp"

namespace touchstone::comparison {
namespace {

static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

class WatchedNarrowphase final : public Narrowphase {
 public:
  WatchedNarrowphase(std::unique_ptr<Narrowphase> inner, SignsOfLife& signs)
      : inner_(std::move(inner)), signs_(signs) {}

  std::string_view name() const noexcept override { return inner_->name(); }
  const Capabilities& capabilities() const noexcept override { return inner_->capabilities(); }
  void build(std::span<const Hexahedron> solids) override {
    signs_.give();
    inner_->build(solids);
    signs_.give();
  }
  bool set_solids(SolidIndex first, std::span<const Hexahedron> solids) override {
    return inner_->set_solids(first, solids);
  }
  std::unique_ptr<Workspace> make_workspace() const override { return inner_->make_workspace(); }
  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override {
    signs_.give();
    inner_->evaluate(input, output, workspace);
    signs_.give();
  }

 private:
  std::unique_ptr<Narrowphase> inner_;
  SignsOfLife& signs_;
};

}  // namespace

SignsOfLife::SignsOfLife(const std::filesystem::path& file) {
  static const int counts_forks = pthread_atfork(nullptr, nullptr, [] { ++forks_; });
  if (counts_forks != 0) throw std::bad_alloc();
  made_in_ = forks_;
  using Count = std::atomic<std::uint64_t>;
  const int opened = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (opened < 0) throw std::runtime_error(file.string() + " cannot be opened");
  // A file that is made longer is filled with zeros, which is a count of none. Its bytes are taken here: on a
  // full disk a hole would end whoever touches it.
  int error = posix_fallocate(opened, 0, sizeof(Count));
  void* memory = MAP_FAILED;
  if (error == 0) {
    memory = mmap(nullptr, sizeof(Count), PROT_READ | PROT_WRITE, MAP_SHARED, opened, 0);
    if (memory == MAP_FAILED) error = errno;
  }
  close(opened);
  if (error != 0)
    throw std::runtime_error(file.string() + " cannot be made: " + std::system_category().message(error));
  count_ = std::launder(static_cast<Count*>(memory));
}

bool Patience::is_over(Clock::time_point now) {
  const Clock::duration since = std::min<Clock::duration>(now - polled_, kMostAPoll);
  polled_ = now;
  const std::uint64_t count = signs_.count();
  waited_ = count == last_ ? waited_ + since : Clock::duration{};
  last_ = count;
  in_all_ += since;
  return waited_ > limit() || is_too_long();
}

std::chrono::milliseconds Patience::limit() const { return last_ == 0 ? kLimitsOfAStart * limit_ : limit_; }

SignsOfLife::~SignsOfLife() { munmap(count_, sizeof *count_); }

BackendRegistry::NarrowphaseEntry watched(const BackendRegistry::NarrowphaseEntry& entry,
                                          SignsOfLife& signs) {
  BackendRegistry::NarrowphaseEntry out = entry;
  out.make = [make = entry.make, &signs] {
    signs.give();
    auto narrowphase = std::make_unique<WatchedNarrowphase>(make(), signs);
    signs.give();
    return narrowphase;
  };
  return out;
}

}  // namespace touchstone::comparison
