#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/tests/proof/checks/narrowphase_checks.hpp"
#include "touchstone/tests/proof/pairs/byte_decoder.hpp"
#include "touchstone/tests/proof/pairs/pair_text.hpp"

// libFuzzer: `native` keeps its promises on whatever pair the bytes decode to. On a broken one it prints the
// pair and what broke, and aborts, so that the bytes are kept. With TOUCHSTONE_FUZZ_SKIP="text;text" in the
// environment failures that contain one of the texts do not count: "within 1e-14 S" looks past inaccuracy for
// everything else.

namespace {

bool contains_any(const std::string& failure, std::string_view texts) {
  while (!texts.empty()) {
    const std::string_view text = texts.substr(0, texts.find(';'));
    if (failure.find(text) != std::string::npos) return true;
    texts.remove_prefix(std::min(texts.size(), text.size() + 1));
  }
  return false;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchstone;
  static const char* const skipped = std::getenv("TOUCHSTONE_FUZZ_SKIP");
  const auto solids = proof::decode_pair({data, size});
  if (!solids) return 0;
  const auto native = make_native();
  const proof::CheckedPair checked = proof::check_against_exact(*solids, *native);
  bool counts = false;
  for (const std::string& failure : checked.failures)
    counts = counts || !contains_any(failure, skipped ? skipped : "");
  if (!counts) return 0;
  for (const std::string& failure : checked.failures) std::fprintf(stderr, "%s\n", failure.c_str());
  std::fprintf(stderr, "%s\n", proof::pair_text(*solids).c_str());
  std::abort();
}
