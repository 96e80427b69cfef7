#include <charconv>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"
#include "touchstone/tests/proof/result_hash.hpp"

// Prints one hash of all answers of `native` a family and one of all: the same on every compiler, processor,
// instruction set, thread count and batch size. Which instruction set is used, contact_core itself decides;
// it is narrowed from outside by the environment variable TOUCHSTONE_ISA.

namespace {

using namespace touchstone;
using namespace touchstone::proof;

constexpr const char* kUsage =
    "usage: result_hash [--count N] [--seed N] [--threads N] [--batch N] [--cache]\n"
    "  --count   pairs a family (default 2000)\n"
    "  --batch   pairs a call (default 256)\n"
    "  --cache   ask twice with one pair cache, hash the second answers\n"
    "TOUCHSTONE_ISA=generic|avx2|avx512 in the environment narrows the instruction set.\n";

bool read_number(const char* text, std::uint64_t& value) {
  if (text == nullptr) return false;
  const char* end = text + std::strlen(text);
  const auto [stop, error] = std::from_chars(text, end, value);
  return error == std::errc() && stop == end;
}

bool read_options(int argc, char** argv, HashOptions& options) {
  for (int i = 1; i < argc; ++i) {
    const std::string_view option = argv[i];
    if (option == "--cache") {
      options.cache = true;
      continue;
    }
    std::uint64_t value = 0;
    if (!read_number(i + 1 < argc ? argv[++i] : nullptr, value)) return false;
    if (option == "--seed")
      options.seed = value;
    else if (option == "--count")
      options.count = value;
    else if (option == "--batch" && value > 0)
      options.batch = value;
    else if (option == "--threads" && value > 0 && value <= 1024)
      options.threads = static_cast<int>(value);
    else
      return false;
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  HashOptions options;
  if (!read_options(argc, argv, options)) {
    std::fputs(kUsage, stderr);
    return 2;
  }
  std::fprintf(stderr, "%zu pairs a family, seed %" PRIu64 ", instruction set %s\n", options.count,
               options.seed, native::kernels().isa);
  const auto hashes = result_hashes(options, make_native);
  for (const FamilyHash& each : hashes)
    std::printf("%016" PRIx64 "  %.*s\n", each.hash, static_cast<int>(each.family.size()),
                each.family.data());
  std::printf("%016" PRIx64 "  total\n", total_hash(hashes));
  return 0;
}
