#include "touchstone/adapters/recorder/record_writer.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <tuple>

namespace touchstone::recorder {
namespace {

constexpr std::size_t kTextBytes = std::size_t{64} << 10;
constexpr int kPollTime = 20;  // [ms]

auto key(ObjectHandle handle) { return std::tuple(handle.slot, handle.generation); }

/// A pipe without a reader, or a limit on the file's size, is an error of write(), not the program's end.
void block_write_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGPIPE);
  sigaddset(&signals, SIGXFSZ);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

}  // namespace

void NameTable::add(const OutputObject& object) {
  Entry entry{object.handle, csv_field(object.name)};
  const std::lock_guard lock(mutex_);
  const auto place = std::lower_bound(entries_.begin(), entries_.end(), entry.handle,
                                      [](const Entry& a, ObjectHandle b) { return key(a.handle) < key(b); });
  if (place != entries_.end() && place->handle == entry.handle) return;
  entries_.insert(place, std::move(entry));
}

std::size_t NameTable::size() const {
  const std::lock_guard lock(mutex_);
  return entries_.size();
}

void NameTable::put(CsvText& text, int column, ObjectHandle object) const {
  {
    const std::lock_guard lock(mutex_);
    const auto place =
        std::lower_bound(entries_.begin(), entries_.end(), object,
                         [](const Entry& a, ObjectHandle b) { return key(a.handle) < key(b); });
    if (place != entries_.end() && place->handle == object) return text.put(column, place->field);
  }
  text.put(column, "#");
  text.put(column, std::uint64_t{object.slot});
  text.put(column, ".");
  text.put(column, std::uint64_t{object.generation});
}

RecordWriter::RecordWriter(int descriptor, RowRing& ring, const NameTable& names,
                           std::chrono::milliseconds patience)
    : descriptor_(descriptor), ring_(ring), names_(names), patience_(patience), text_(kTextBytes) {
  struct stat what {};
  is_file_ = fstat(descriptor, &what) == 0 && S_ISREG(what.st_mode);
  if (is_file_) base_ = std::max<std::int64_t>(0, lseek(descriptor, 0, SEEK_CUR));
}

RecordWriter::~RecordWriter() { ::close(descriptor_); }

void RecordWriter::run() {
  block_write_signals();
  while (true) {
    const std::uint32_t seen = signal_.load(std::memory_order_acquire);
    const bool stops = stops_.load(std::memory_order_acquire);  // before the ring: nothing comes after it
    if (write_frame()) continue;
    flush();
    if (stops) break;
    signal_.wait(seen, std::memory_order_acquire);
  }
  write_end();
}

bool RecordWriter::write_frame() {
  if (ring_.available() == 0) return false;
  const Row first = ring_.row(0);
  frame_is_broken_ = false;
  to_note_ += first.lost;
  put_first_lines(first.frame);
  for (std::uint32_t i = 0; i <= first.rows; ++i) put_row(ring_.row(i), first.frame);
  ring_.release(first.rows + 1);
  last_frame_ = first.frame;
  if (frame_is_broken_) {
    ++to_note_;
    lost_.fetch_add(1, std::memory_order_relaxed);
    return true;
  }
  frame_end_ = position();
  noted_since_safe_ += noted_in_frame_;
  noted_in_frame_ = 0;
  ++frames_since_safe_;
  return true;
}

void RecordWriter::put_first_lines(std::uint64_t frame) {
  if (position() == 0) {
    text_.start_line(kHeader);
    text_.end_header();
  }
  if (to_note_ == 0 || !make_room()) return;
  text_.start_line("lost");
  text_.put(kFrame, frame);
  text_.put(kCount, to_note_);
  text_.end_line();
  noted_in_frame_ = to_note_;
  to_note_ = 0;
}

void RecordWriter::put_row(const Row& row, std::uint64_t frame) {
  if (frame_is_broken_ || !make_room()) return;
  constexpr std::array<std::string_view, 3> kRecords{"frame", "pose", "event"};
  text_.start_line(kRecords[static_cast<std::size_t>(row.kind)]);
  text_.put(kFrame, frame);
  if (row.kind == Row::Kind::frame) {
    text_.put(kTime, row.values[0]);
    text_.put(kCount, std::uint64_t{row.rows});
  }
  if (row.kind == Row::Kind::pose) put_pose(row);
  if (row.kind == Row::Kind::event) put_event(row);
  text_.end_line();
}

void RecordWriter::put_pose(const Row& row) {
  names_.put(text_, kObject, row.a);
  for (int i = 0; i < 12; ++i) text_.put(kPose + i, row.values[i]);
}

void RecordWriter::put_event(const Row& row) {
  names_.put(text_, kObject, row.a);
  if (!(row.b == ObjectHandle{})) names_.put(text_, kOther, row.b);
  text_.put(kSolid, std::uint64_t{row.solids.a});
  text_.put(kOtherSolid, std::uint64_t{row.solids.b});
  text_.put(kEvent, to_string(row.event));
  text_.put(kPart, std::uint64_t{row.part});
  text_.put(kS, row.values[0]);
  for (int i = 0; i < 20; ++i) text_.put(kSeparation + i, row.values[1 + i]);
}

void RecordWriter::write_end() {
  frame_is_broken_ = false;
  to_note_ += lost_at_end_;
  put_first_lines(last_frame_);
  if (frame_is_broken_) return;
  text_.start_line("end");
  text_.put(kFrame, last_frame_);
  text_.put(kCount, delivered());
  text_.end_line();
  frame_end_ = position();
  flush();
}

bool RecordWriter::make_room() { return text_.has_room_for_line() || flush(); }

bool RecordWriter::flush() {
  if (text_.size() == 0) return true;
  if (const int error = send_all(text_.text())) {
    cut_off(error);
    return false;
  }
  written_ = position();
  text_.clear();
  safe_ = frame_end_;
  delivered_.fetch_add(frames_since_safe_, std::memory_order_relaxed);
  frames_since_safe_ = noted_since_safe_ = 0;
  return true;
}

void RecordWriter::cut_off(int error) {
  errors_.fetch_add(1, std::memory_order_relaxed);
  last_error_.store(error, std::memory_order_relaxed);
  lost_.fetch_add(frames_since_safe_, std::memory_order_relaxed);
  to_note_ += frames_since_safe_ + noted_since_safe_ + noted_in_frame_;
  frames_since_safe_ = noted_since_safe_ = noted_in_frame_ = 0;
  text_.clear();
  written_ = frame_end_ = safe_;
  frame_is_broken_ = true;
  if (!is_file_) return;
  const std::int64_t end = base_ + static_cast<std::int64_t>(safe_);
  if (ftruncate(descriptor_, end) == 0) lseek(descriptor_, end, SEEK_SET);
}

int RecordWriter::send_all(std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(descriptor_, text.data(), text.size());
    if (count > 0) {
      text.remove_prefix(static_cast<std::size_t>(count));
    } else if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
      if (const int error = wait_until_writable()) return error;
    } else if (count == 0 || errno != EINTR) {
      return count == 0 ? EIO : errno;
    }
  }
  return 0;
}

int RecordWriter::wait_until_writable() {
  if (stops_.load(std::memory_order_acquire)) {
    const auto now = std::chrono::steady_clock::now();
    if (gives_up_ == std::chrono::steady_clock::time_point{}) gives_up_ = now + patience_;
    if (now >= gives_up_) return ETIMEDOUT;
  }
  pollfd waiting{descriptor_, POLLOUT, 0};
  poll(&waiting, 1, kPollTime);  // what it finds wrong, write() reports
  return 0;
}

}  // namespace touchstone::recorder
