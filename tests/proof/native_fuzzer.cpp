#include <cstdio>
#include <cstdlib>

#include "contact_core/native/native.hpp"
#include "tests/proof/byte_decoder.hpp"
#include "tests/proof/narrowphase_checks.hpp"
#include "tests/proof/pair_text.hpp"

// libFuzzer: `native` keeps its promises on whatever pair the bytes decode to. On a broken one it prints the
// pair and what broke, and aborts, so that the bytes are kept.

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchstone;
  const auto solids = proof::decode_pair({data, size});
  if (!solids) return 0;
  const auto native = make_native();
  const proof::CheckedPair checked = proof::check_against_exact(*solids, *native);
  if (checked.failures.empty()) return 0;
  for (const std::string& failure : checked.failures) std::fprintf(stderr, "%s\n", failure.c_str());
  std::fprintf(stderr, "%s\n", proof::pair_text(*solids).c_str());
  std::abort();
}
