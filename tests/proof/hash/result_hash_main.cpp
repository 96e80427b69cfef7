#include <charconv>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/native/simd/kernels.hpp"
#include "touchstone/tests/proof/hash/result_hash.hpp"
#include "touchstone/tests/proof/hash/run_hash.hpp"

// Prints one hash of all answers of `native` a family and one of all, then one a run of a contact world and
// of dynamics and one of all: the same on every compiler, processor, instruction set, thread count and batch
// size, with Eigen's vectorisation and without (result_hash_unvectorised). Which instruction set is used,
// contact_core itself decides; it is narrowed from outside by the environment variable TOUCHSTONE_ISA.

namespace {

using namespace touchstone;
using namespace touchstone::proof;

constexpr const char* kUsage =
    "usage: result_hash [--count N] [--seed N] [--threads N] [--batch N] [--cache] [--frames N] [--steps N]\n"
    "       result_hash --rotations N\n"
    "  --count      pairs a family (default 2000)\n"
    "  --batch      pairs a call (default 256)\n"
    "  --cache      ask twice with one pair cache, hash the second answers\n"
    "  --frames     of each run of a contact world (default 100)\n"
    "  --steps      of each run of dynamics (default 200)\n"
    "  --rotations  a hash for each of N rotations of paths, and no more\n"
    "TOUCHSTONE_ISA=generic|avx2|avx512 in the environment narrows the instruction set.\n";

bool read_number(const char* text, std::uint64_t& value) {
  if (text == nullptr) return false;
  const char* end = text + std::strlen(text);
  const auto [stop, error] = std::from_chars(text, end, value);
  return error == std::errc() && stop == end;
}

struct Options {
  HashOptions answers;
  std::size_t frames = 100, steps = 200, rotations = 0;
};

bool read_options(int argc, char** argv, Options& all) {
  HashOptions& options = all.answers;
  for (int i = 1; i < argc; ++i) {
    // One option without a value, the others with a number.
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
    else if (option == "--frames")
      all.frames = value;
    else if (option == "--steps")
      all.steps = value;
    else if (option == "--rotations")
      all.rotations = value;
    else
      return false;
  }
  return true;
}

void print(const std::vector<FamilyHash>& hashes, const char* total) {
  for (const FamilyHash& each : hashes)
    std::printf("%016" PRIx64 "  %.*s\n", each.hash, static_cast<int>(each.family.size()),
                each.family.data());
  std::printf("%016" PRIx64 "  %s\n", total_hash(hashes), total);
}

}  // namespace

int main(int argc, char** argv) {
  Options all;
  if (!read_options(argc, argv, all)) {
    std::fputs(kUsage, stderr);
    return 2;
  }
  for (const std::uint64_t hash : path_rotation_hashes(all.rotations)) std::printf("%016" PRIx64 "\n", hash);
  if (all.rotations > 0) return 0;
  const HashOptions& options = all.answers;
  std::fprintf(stderr, "%zu pairs a family, seed %" PRIu64 ", instruction set %s\n", options.count,
               options.seed, native::kernels().isa);
  print(result_hashes(options, make_native), "total");
  std::vector<FamilyHash> runs = world_hashes(all.frames);
  for (const FamilyHash& each : dynamics_hashes(all.steps)) runs.push_back(each);
  print(runs, "total of runs");
  return 0;
}
