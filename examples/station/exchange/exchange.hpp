#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

// Threads exchange values here without a lock, so that none ever waits for another.

namespace touchstone::station {

/// The newest value of one writer for one reader: what was not read in time is overwritten (three slots, of
/// which the writer has one, the reader one, and the third changes hands).
template <class T>
class Latest {
 public:
  explicit Latest(const T& initial = T()) { slots_.fill(initial); }

  /// The writer's slot; holds some earlier value.
  T& back() { return slots_[back_]; }
  void publish() {
    back_ = static_cast<std::uint8_t>(middle_.exchange(back_ | kNew, std::memory_order_acq_rel) & kSlot);
  }

  /// True: front() is a newer one now.
  bool take() {
    if (!(middle_.load(std::memory_order_relaxed) & kNew)) return false;
    front_ = static_cast<std::uint8_t>(middle_.exchange(front_, std::memory_order_acq_rel) & kSlot);
    return true;
  }
  const T& front() const { return slots_[front_]; }

 private:
  static constexpr std::uint8_t kNew = 4, kSlot = 3;

  std::array<T, 3> slots_;
  std::uint8_t back_ = 0, front_ = 1;
  std::atomic<std::uint8_t> middle_{2};
};

/// A queue of fixed room from one writer to one reader. What finds no room is refused; the writer counts it.
template <class T>
class Ring {
 public:
  explicit Ring(std::size_t room, const T& initial = T()) : slots_(room + 1, initial) {}

  /// Where the writer may put the next one; null: there is no room.
  T* slot() {
    const std::size_t next = after(head_.load(std::memory_order_relaxed));
    return next == tail_.load(std::memory_order_acquire) ? nullptr
                                                         : &slots_[head_.load(std::memory_order_relaxed)];
  }
  void push() { head_.store(after(head_.load(std::memory_order_relaxed)), std::memory_order_release); }
  bool push(const T& value) {
    T* const at = slot();
    if (at == nullptr) return false;
    *at = value;
    push();
    return true;
  }

  /// The oldest one, or null.
  T* front() {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    return tail == head_.load(std::memory_order_acquire) ? nullptr : &slots_[tail];
  }
  void pop() { tail_.store(after(tail_.load(std::memory_order_relaxed)), std::memory_order_release); }

 private:
  std::size_t after(std::size_t i) const { return i + 1 == slots_.size() ? 0 : i + 1; }

  std::vector<T> slots_;
  std::atomic<std::size_t> head_{0}, tail_{0};
};

}  // namespace touchstone::station
