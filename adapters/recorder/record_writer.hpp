#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <string>
#include <vector>

#include "touchstone/adapters/recorder/csv_text.hpp"
#include "touchstone/adapters/recorder/row_ring.hpp"

// Private to this folder.

namespace touchstone::recorder {

/// Objects' names, already CSV fields: added by one thread, read by another.
class NameTable {
 public:
  void add(const OutputObject& object);
  std::size_t size() const;
  /// Of an object never announced: #slot.generation.
  void put(CsvText& text, int column, ObjectHandle object) const;

 private:
  struct Entry {
    ObjectHandle handle;
    std::string field;
  };
  mutable std::mutex mutex_;
  std::vector<Entry> entries_;  // sorted by slot, generation
};

/// The writing thread's work: rows out of the ring, as text, into a file.
class RecordWriter {
 public:
  /// Owns `descriptor`.
  RecordWriter(int descriptor, RowRing& ring, const NameTable& names, std::chrono::milliseconds patience);
  ~RecordWriter();
  RecordWriter(const RecordWriter&) = delete;
  RecordWriter& operator=(const RecordWriter&) = delete;

  /// Until stop(), and all rows are out.
  void run();
  void wake() {
    signal_.fetch_add(1, std::memory_order_release);
    signal_.notify_one();
  }
  /// @param lost frames dropped since the last one in the ring.
  void stop(std::uint64_t lost) {
    lost_at_end_ = lost;
    stops_.store(true, std::memory_order_release);
    wake();
  }

  std::uint64_t delivered() const { return delivered_.load(std::memory_order_relaxed); }
  std::uint64_t lost() const { return lost_.load(std::memory_order_relaxed); }
  std::uint64_t errors() const { return errors_.load(std::memory_order_relaxed); }
  int last_error() const { return last_error_.load(std::memory_order_relaxed); }

 private:
  bool write_frame();
  void write_end();
  void put_first_lines(std::uint64_t frame);
  void put_row(const Row& row, std::uint64_t frame);
  void put_pose(const Row& row);
  void put_event(const Row& row);
  bool make_room();
  bool flush();
  void cut_off(int error);
  std::uint64_t position() const { return written_ + text_.size(); }
  int send_all(std::string_view text);
  int wait_until_writable();

  const int descriptor_;
  bool is_file_ = false;
  std::int64_t base_ = 0;  // where in the file the record begins
  RowRing& ring_;
  const NameTable& names_;
  const std::chrono::milliseconds patience_;
  std::chrono::steady_clock::time_point gives_up_{};
  CsvText text_;

  // Positions in the file. All before safe_ is whole frames, and written.
  std::uint64_t written_ = 0;
  std::uint64_t frame_end_ = 0;
  std::uint64_t safe_ = 0;
  std::uint64_t frames_since_safe_ = 0;
  std::uint64_t noted_since_safe_ = 0;  // lost frames that the lines since safe_ tell of, up to frame_end_
  std::uint64_t noted_in_frame_ = 0;    // those that the lines after frame_end_ tell of
  std::uint64_t to_note_ = 0;           // lost frames that no line tells of yet
  std::uint64_t last_frame_ = 0;
  bool frame_is_broken_ = false;
  std::uint64_t lost_at_end_ = 0;

  std::atomic<std::uint32_t> signal_{0};
  std::atomic<bool> stops_{false};
  std::atomic<std::uint64_t> delivered_{0}, lost_{0}, errors_{0};
  std::atomic<int> last_error_{0};
};

}  // namespace touchstone::recorder
