#pragma once

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "touchstone/tests/support/program_test.hpp"

namespace touchstone {

/// The page in a browser. Needs Chromium, which is for such tests alone: where it is missing they are
/// skipped, and fail where TOUCHSTONE_NEEDS_BROWSER is set, as .ci/run does.
class PageInBrowser : public ProgramTest {
 protected:
  PageInBrowser()
      : ProgramTest(CHROMIUM " --headless --no-sandbox --disable-gpu --no-first-run --hide-scrollbars") {}
  void SetUp() override {
    if (!std::string_view(CHROMIUM).empty()) return;
    const std::string why = "the page needs Chromium (Debian: chromium or chromium-headless-shell)";
    if (std::getenv("TOUCHSTONE_NEEDS_BROWSER") != nullptr) FAIL() << why;
    GTEST_SKIP() << "NOT LOOKED AT: " << why;
  }

  /// The page after `script` ran at its end, in a window of this size [px]; what the script left in `found`
  /// comes back.
  nlohmann::json look(std::string page, const std::string& script, int width = 1440, int height = 900) {
    // Faults are kept from the start.
    const std::string watch =
        "<head><script>window.faults=[];addEventListener('error',e=>faults.push(String(e.message||e.type)),"
        "true);"
        "console.error=console.warn=(...a)=>faults.push(a.join(' '));</script>";
    page.replace(page.find("<head>"), 6, watch);
    // The script's answer, faults and requests go into the page as text that survives.
    const std::string tail =
        "<script>let found=null;try{" + script +
        "}catch(e){faults.push(String(e))}"
        "addEventListener('load',()=>setTimeout(()=>{const pre=document.createElement('pre');"
        "pre.id='found';pre.textContent=btoa(unescape(encodeURIComponent(JSON.stringify("
        "{found,faults,requests:[...performance.getEntriesByType('resource').map(r=>r.name),...[...document."
        "querySelectorAll('[src],link')].map(e=>e.src||e.href)]}))));"
        "document.body.appendChild(pre)},0))</script></body>";
    page.replace(page.rfind("</body>"), 7, tail);
    // The browser prints the page as it is in the end.
    const std::string file = write("page.html", page).string();
    const Outcome outcome =
        run("--user-data-dir=" + (folder_ / "profile").string() + " --window-size=" + std::to_string(width) +
            "," + std::to_string(height) + " --virtual-time-budget=5000 --dump-dom file://" + file);
    const std::string open = "<pre id=\"found\">";
    const std::size_t from = outcome.out.find(open);
    if (from == std::string::npos) return {{"faults", {"no answer: " + outcome.err}}};
    const std::size_t begin = from + open.size();
    return nlohmann::json::parse(
        from_base64(outcome.out.substr(begin, outcome.out.find('<', begin) - begin)));
  }

  static std::string from_base64(const std::string& text) {
    std::string bytes;
    unsigned bits = 0, count = 0;
    for (const char c : text) {
      const std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
      const std::size_t digit = digits.find(c);
      if (digit == std::string_view::npos) break;
      bits = bits << 6 | static_cast<unsigned>(digit);
      if ((count += 6) >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 0xffu);
    }
    return bytes;
  }
};

}  // namespace touchstone
