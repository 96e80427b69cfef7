#pragma once

#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "touchstone/examples/compare_backends/names.hpp"
#include "touchstone/examples/measures/runs/backend_run.hpp"

// Bytes between the comparison and its worker: same build, same machine, so plain structs travel as they lie
// in memory.

namespace touchstone::comparison {

class ByteWriter {
 public:
  template <typename T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void put(const std::string& text) {
    put(text.size());
    bytes_ += text;
  }
  template <typename T>
  void put_list(const std::vector<T>& items) {
    put(items.size());
    for (const T& item : items) put(item);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class ByteReader {
 public:
  explicit ByteReader(std::string bytes) : bytes_(std::move(bytes)) {}
  template <typename T>
  void get(T& value) {
    std::memcpy(static_cast<void*>(&value), take(sizeof value), sizeof value);
  }
  void get(std::string& text) {
    std::size_t size = 0;
    get(size);
    text.assign(take(size), size);
  }
  template <typename T>
  void get_list(std::vector<T>& items) {
    for (std::size_t i = get_count(); i > 0; --i) get(items.emplace_back());
  }
  /// Of items that follow, each of which takes a byte at least.
  std::size_t get_count() {
    std::size_t count = 0;
    get(count);
    if (count > bytes_.size() - at_) throw std::runtime_error("is truncated");
    return count;
  }
  bool is_done() const { return at_ == bytes_.size(); }

 private:
  const char* take(std::size_t size) {
    if (size > bytes_.size() - at_) throw std::runtime_error("is truncated");
    at_ += size;
    return bytes_.data() + at_ - size;
  }
  std::string bytes_;
  std::size_t at_ = 0;
};

struct Job {
  std::vector<std::string> backends;
  MeasureOptions options;
  PairSet set;
};

std::string encode_job(const Job& job);
Job decode_job(std::string bytes);
std::string encode_answers(const std::vector<BackendAnswers>& answers);
std::vector<BackendAnswers> decode_answers(std::string bytes);

}  // namespace touchstone::comparison
