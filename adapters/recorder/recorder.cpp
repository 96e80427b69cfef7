#include "touchstone/adapters/recorder/recorder.hpp"

#include <fcntl.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <thread>

#include "touchstone/adapters/recorder/record_writer.hpp"
#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

using recorder::Row;

constexpr std::size_t kLongestName = 2000;  // [bytes] twice that and two quotes fit a field

int open_file(const std::string& path) {
  // Non-blocking: a pipe without a reader is an error now, not a wait for ever.
  const int descriptor =
      ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NONBLOCK, 0666);  // NOLINT(*-vararg)
  if (descriptor < 0) throw InputError("record '" + path + "': " + std::strerror(errno));
  return descriptor;
}

int make_non_blocking(int descriptor) {
  const int flags = fcntl(descriptor, F_GETFL);                         // NOLINT(*-vararg)
  if (flags < 0 || fcntl(descriptor, F_SETFL, flags | O_NONBLOCK) < 0)  // NOLINT(*-vararg)
    throw InputError("record: descriptor " + std::to_string(descriptor) + ": " + std::strerror(errno));
  return descriptor;
}

void fill(Row& row, const ShownPose& pose) {
  row.kind = Row::Kind::pose;
  row.a = pose.object;
  for (int i = 0; i < 9; ++i) row.values[i] = pose.X_WO.R(i / 3, i % 3);
  for (int i = 0; i < 3; ++i) row.values[9 + i] = pose.X_WO.p(i);
}

void put(const PairGeometry& g, double* out) {
  out[0] = g.separation;
  for (int i = 0; i < 3; ++i) out[1 + i] = g.n_AB_W(i), out[4 + i] = g.p_A_W(i), out[7 + i] = g.p_B_W(i);
}

void fill(Row& row, const ContactEvent& event) {
  row.kind = Row::Kind::event;
  row.event = event.kind;
  row.a = event.a, row.b = event.b;
  row.solids = event.solids;
  row.part = event.part;
  row.values[0] = event.s;
  put(event.geometry, &row.values[1]);
  put(event.geometry_at_end, &row.values[11]);
}

}  // namespace

struct Recorder::State {
  State(int descriptor, const RecorderOptions& options)
      : ring(options.rows), when_full(options.when_full), writer(descriptor, ring, names, options.patience) {
    thread = std::thread([this] { writer.run(); });
  }

  recorder::RowRing ring;
  recorder::NameTable names;
  WhenFull when_full;
  recorder::RecordWriter writer;
  std::thread thread;
  bool is_closed = false;
  std::uint64_t lost = 0;  // since the last frame that found room
  std::atomic<std::uint64_t> offered{0}, dropped{0};

  bool find_room(std::size_t rows) {
    if (is_closed || rows > ring.size()) return false;
    if (ring.room() >= rows) return true;
    if (when_full == WhenFull::drop) return false;
    ring.wait_for_more_room(rows);
    return true;
  }
};

Recorder::Recorder(const std::string& path, const RecorderOptions& options)
    : state_(std::make_unique<State>(open_file(path), options)) {}

Recorder::Recorder(int descriptor, const RecorderOptions& options)
    : state_(std::make_unique<State>(make_non_blocking(descriptor), options)) {}

Recorder::~Recorder() { close(); }

void Recorder::add_object(const OutputObject& object) {
  if (object.name.size() > kLongestName) {
    throw InputError("record: the name of object '" + object.name.substr(0, 32) + "...' has " +
                     std::to_string(object.name.size()) + " bytes, more than " +
                     std::to_string(kLongestName));
  }
  if (state_->names.size() + 1 >= state_->ring.size()) {
    throw InputError("record: object '" + object.name + "' is one more than a frame has rows for (" +
                     std::to_string(state_->ring.size()) + ", see RecorderOptions)");
  }
  state_->names.add(object);
}

void Recorder::write(const OutputFrame& frame) noexcept {
  State& s = *state_;
  s.offered.fetch_add(1, std::memory_order_relaxed);
  const std::size_t rows = 1 + frame.poses.size() + frame.events.size();
  if (!s.find_room(rows)) {
    ++s.lost;
    s.dropped.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  Row& first = s.ring.free_row(0);
  first.kind = Row::Kind::frame;
  first.frame = frame.frame;
  first.lost = s.lost;
  first.rows = static_cast<std::uint32_t>(rows - 1);
  first.values[0] = frame.time;
  std::size_t next = 1;
  for (const ShownPose& pose : frame.poses) fill(s.ring.free_row(next++), pose);
  for (const ContactEvent& event : frame.events) fill(s.ring.free_row(next++), event);
  s.ring.publish(rows);
  s.lost = 0;
  s.writer.wake();
}

OutputStatus Recorder::status() const noexcept {
  const State& s = *state_;
  return {s.offered.load(std::memory_order_relaxed), s.writer.delivered(),
          s.dropped.load(std::memory_order_relaxed) + s.writer.lost(), s.writer.errors(),
          s.writer.last_error()};
}

void Recorder::close() noexcept {
  if (state_->is_closed) return;
  state_->is_closed = true;
  state_->writer.stop(state_->lost);
  state_->thread.join();
}

}  // namespace touchstone
