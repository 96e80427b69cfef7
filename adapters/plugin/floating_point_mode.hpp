#pragma once

#include <cfenv>
#include <cstdint>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

// Private to this folder.

namespace touchstone {

/// The thread's rounding mode, flushing of denormals, trapped exceptions and x87 precision, to be put back
/// after code that is not ours: a library that is linked with -ffast-math sets them where it is loaded, and
/// whatever is computed later would have other bits.
class FloatingPointMode {
 public:
  FloatingPointMode() noexcept : rounding_(std::fegetround()), control_(control()) {}

  /// Returns whether it had been changed.
  bool put_back() const noexcept {
    const bool is_other_control = control() != control_;
    if (is_other_control) set_control(control_);  // first: with traps on, even fesetround() may be trapped
    const bool is_other_rounding = std::fegetround() != rounding_;
    if (is_other_rounding) std::fesetround(rounding_);
    return is_other_rounding || is_other_control;
  }

 private:
#if defined(__SSE2__)
  static constexpr std::uint64_t kRaised = 0x3f;  // flags of what has happened: no part of the mode
  /// Of SSE, and above it that of x87, which computes with long double.
  static std::uint64_t control() noexcept {
    std::uint16_t x87 = 0;
    asm volatile("fnstcw %0" : "=m"(x87));
    return (_mm_getcsr() & ~kRaised) | std::uint64_t{x87} << 32;
  }
  static void set_control(std::uint64_t control) noexcept {
    const auto x87 = static_cast<std::uint16_t>(control >> 32);
    // What x87 has raised is cleared, as SSE's is: else it would trap where the mode put back traps it.
    asm volatile("fnclex\n\tfldcw %0" : : "m"(x87));
    _mm_setcsr(static_cast<unsigned>(control));
  }
#elif defined(__aarch64__)
  static std::uint64_t control() noexcept {
    std::uint64_t control = 0;
    asm volatile("mrs %0, fpcr" : "=r"(control));
    return control;
  }
  static void set_control(std::uint64_t control) noexcept { asm volatile("msr fpcr, %0" : : "r"(control)); }
#else
  static std::uint64_t control() noexcept { return 0; }  // the rounding mode alone
  static void set_control(std::uint64_t) noexcept {}
#endif

  int rounding_;
  std::uint64_t control_;
};

}  // namespace touchstone
