#include <cstdio>
#include <cstdlib>
#include <string>

#include "contact_core/native/native.hpp"
#include "tests/proof/byte_decoder.hpp"
#include "tests/proof/narrowphase_checks.hpp"
#include "tests/proof/pair_text.hpp"

// libFuzzer: `native` keeps its promises on whatever pair the bytes decode to. On a broken one it prints the
// pair and what broke, and aborts, so that the bytes are kept. With TOUCHSTONE_FUZZ_ONLY=word in the
// environment only failures that contain the word count ("status", say: to look past inaccuracy for wrong
// classes).

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchstone;
  static const char* const only = std::getenv("TOUCHSTONE_FUZZ_ONLY");
  const auto solids = proof::decode_pair({data, size});
  if (!solids) return 0;
  const auto native = make_native();
  const proof::CheckedPair checked = proof::check_against_exact(*solids, *native);
  bool counts = false;
  for (const std::string& failure : checked.failures)
    counts = counts || !only || failure.find(only) != std::string::npos;
  if (!counts) return 0;
  for (const std::string& failure : checked.failures) std::fprintf(stderr, "%s\n", failure.c_str());
  std::fprintf(stderr, "%s\n", proof::pair_text(*solids).c_str());
  std::abort();
}
