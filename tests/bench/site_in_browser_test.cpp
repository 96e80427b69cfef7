#include <gmock/gmock.h>

#include "touchstone/tests/support/page_in_browser.hpp"

// The benchmark's site as a phone shows it.

namespace touchstone::comparison {
namespace {

constexpr const char* kPlan =
    R"({"schema": "touchstone.corpus/1", "name": "small", "version": "0.1", "sets": [
  {"name": "containment", "description": "boxes in boxes", "from": {"family": "containment", "seed": 7, "count": 20}},
  {"name": "touching", "description": "flush boxes", "from": {"family": "touching", "seed": 7, "count": 20}},
  {"name": "far", "description": "boxes that are far", "from": {"family": "far", "seed": 7, "count": 20}},
  {"name": "resting", "description": "boxes on boxes", "from": {"family": "resting", "seed": 7, "count": 20}}]})";

class SiteInBrowser : public PageInBrowser {
 protected:
  void make_site() const {
    write("plan.json", kPlan);
    const std::string at = "cd " + folder_.string() + " && ";
    const std::string corpus = at + BENCH " corpus corpus --freeze --manifest plan.json >/dev/null 2>&1";
    const std::string compare = at + COMPARE_BACKENDS
                                " --corpus corpus --no-broadphase --repetitions 1 --backend native edge_face "
                                "--output ours >/dev/null 2>&1";
    const std::string site = at + BENCH " site site ours/results.json --corpus corpus >/dev/null 2>&1";
    for (const std::string& command : {corpus, compare, site}) ASSERT_EQ(std::system(command.c_str()), 0);
  }
};

TEST_F(SiteInBrowser, OnAPhoneTablesScrollAndThePageDoesNot) {
  make_site();
  const std::string widths =
      "found={inner:innerWidth,page:document.scrollingElement.scrollWidth};"
      "const box=document.querySelector('#overlap .scroll'),engine=box&&box.querySelector('tbody th');"
      "if(box){box.scrollLeft=200;found.scrolled=box.scrollLeft;"
      "found.engine=engine.getBoundingClientRect().left-box.getBoundingClientRect().left;}";
  const nlohmann::json index = look(read(folder_ / "site/index.html"), widths, 390, 844);
  EXPECT_EQ(index.at("faults"), nlohmann::json::array());
  EXPECT_LE(index.at("found").at("page"), index.at("found").at("inner"));
  EXPECT_GT(index.at("found").at("scrolled"), 0);
  EXPECT_EQ(index.at("found").at("engine"), 0);  // it stays in sight

  const nlohmann::json cases = look(read(folder_ / "site/cases/containment.html"), widths, 390, 844);
  EXPECT_EQ(cases.at("faults"), nlohmann::json::array());
  EXPECT_LE(cases.at("found").at("page"), cases.at("found").at("inner"));
}

}  // namespace
}  // namespace touchstone::comparison
