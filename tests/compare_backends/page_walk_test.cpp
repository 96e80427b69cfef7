#include <fmt/format.h>
#include <gmock/gmock.h>

#include "touchstone/examples/compare_backends/page/html_report.hpp"
#include "touchstone/tests/support/page_in_browser.hpp"

// A walk through a run's page on a desk's window and on a phone's.

namespace touchstone::comparison {
namespace {

using ::testing::HasSubstr;

constexpr int kDesk = 1440, kPhone = 390, kPhoneHeight = 844;

// The page as a reader meets it: the first screen, the width, every entry of the contents.
const char* const kWalk = R"(
  const box=id=>{const e=document.getElementById(id);return e?e.getBoundingClientRect():null};
  const first=document.querySelector('#verdict strong');
  found={inner:innerWidth,width:document.scrollingElement.scrollWidth,
    verdict_end:first.getBoundingClientRect().bottom,verdict:first.textContent,
    order:[...document.querySelectorAll('main>section')].map(e=>e.id),
    titled:[...document.querySelectorAll('main>section')].every(e=>e.querySelector('h2')),
    choose:box('choose').top<box('verdict').top,links:[]};
  document.querySelectorAll('details').forEach(e=>e.open=true);
  found.opened_width=document.scrollingElement.scrollWidth;
  for(const a of document.querySelectorAll('#contents a')){
    const target=document.querySelector(a.getAttribute('href'));
    if(!target){found.links.push(a.textContent+': leads nowhere');continue}
    a.click();
    const top=target.getBoundingClientRect().top, end=document.scrollingElement.scrollHeight-innerHeight-scrollY;
    const strip=document.getElementById('contents').getBoundingClientRect();
    const cover=strip.height<innerHeight/2?strip.bottom:0;
    found.links.push(a.textContent+(top>=cover-1&&(top<innerHeight/4||end<2)?'':': not brought into view, '+top));
  }
)";

// Of every figure's texts: those that its picture cuts, and pairs of labels that lie on each other.
const char* const kTexts = R"(
  document.querySelectorAll('details').forEach(e=>e.open=true);
  found={plots:0,texts:0,cut:[],over:[]};
  for(const svg of document.querySelectorAll('svg.plot:not(.key)')){
    ++found.plots;
    const frame=svg.getBoundingClientRect(), name=svg.getAttribute('aria-label');
    const texts=[...svg.querySelectorAll('text')].map(e=>[e.textContent,e.getBoundingClientRect(),e]);
    found.texts+=texts.length;
    for(const [text,box] of texts)
      if(box.left<frame.left-1||box.right>frame.right+1||box.top<frame.top-1||box.bottom>frame.bottom+1)
        found.cut.push(name+': '+text);
    const labels=texts.filter(([,,e])=>e.classList.contains('label'));
    labels.forEach(([text,a],i)=>labels.slice(i+1).forEach(([other,b])=>{
      const wide=Math.min(a.right,b.right)-Math.max(a.left,b.left), high=Math.min(a.bottom,b.bottom)-Math.max(a.top,b.top);
      if(wide>1&&high>0.3*Math.min(a.height,b.height))found.over.push(name+': '+text+' / '+other)}));
  }
)";

class PageWalk : public PageInBrowser {
 protected:
  /// The page of a small run with a scene, broadphases and threads.
  std::string real_page() {
    const std::string report = (folder_ / "report").string();
    const std::string command = COMPARE_BACKENDS
                                " --quick --count 40 --families random touching --scene " SCENES
                                "/tunnelling_plates.yaml --output " +
                                report;
    EXPECT_EQ(std::system((command + " >/dev/null 2>&1").c_str()), 0);
    return read(report + "/report.html");
  }
};

TEST_F(PageWalk, AtADesksAndAPhonesWidth) {
  const std::string page = real_page();
  if (page.find("id='choices'") == std::string::npos) GTEST_SKIP() << "without `exact` there is no verdict";
  for (const int width : {kDesk, kPhone}) {
    SCOPED_TRACE(width);
    const nlohmann::json seen = look(page, kWalk, width, kPhoneHeight);
    EXPECT_EQ(seen["faults"], nlohmann::json::array());
    EXPECT_EQ(seen["requests"], nlohmann::json::array());
    ASSERT_TRUE(seen["found"].is_object()) << seen;
    const nlohmann::json& found = seen["found"];
    ASSERT_EQ(found["inner"], width) << "the browser has another window";
    EXPECT_LE(found["width"], width);
    EXPECT_LE(found["opened_width"], width) << "with everything folded open";
    EXPECT_LE(found["verdict_end"], kPhoneHeight) << "the verdict is not on the first screen";
    EXPECT_FALSE(found["verdict"].get<std::string>().empty());
    EXPECT_TRUE(found["choose"]) << "what is asked comes before the verdict";
    EXPECT_TRUE(found["titled"]);
    EXPECT_EQ(found["links"].size(), found["order"].size()) << "an entry a section";
    for (const auto& link : found["links"])
      EXPECT_EQ(link.get<std::string>().find(':'), std::string::npos) << link;
  }
}

TEST_F(PageWalk, TheWalkSeesAWidePageAndADeadLink) {
  const nlohmann::json seen = look(
      "<html><head><meta name='viewport' content='width=device-width'></head><body><nav id='contents'><a "
      "href='#none'>gone</a></nav><main><section id='choose'><h2>a</h2></section><section "
      "id='verdict'><h2>b</h2>"
      "<div style='height:900px;width:500px'></div><strong>c</strong></section></main></body></html>",
      kWalk, kPhone, kPhoneHeight);
  ASSERT_TRUE(seen["found"].is_object()) << seen;
  EXPECT_GE(seen["found"]["width"], 500);
  EXPECT_GT(seen["found"]["verdict_end"], kPhoneHeight);
  EXPECT_EQ(seen["found"]["links"][0], "gone: leads nowhere");
}

TEST_F(PageWalk, NoTextOfAFigureIsCutOrLiesOnAnother) {
  const nlohmann::json seen = look(real_page(), kTexts);
  ASSERT_TRUE(seen["found"].is_object()) << seen;
  EXPECT_GT(seen["found"]["plots"], 10);
  EXPECT_EQ(seen["found"]["cut"], nlohmann::json::array());
  EXPECT_EQ(seen["found"]["over"], nlohmann::json::array());
}

// Thirteen backends whose lines end at nearly the same heights, and one that ends early.
TEST_F(PageWalk, LabelsOfManyLinesStandApart) {
  // Thirteen lines of threads, close together.
  Report report;
  for (int b = 0; b < 13; ++b) {
    report.backends.emplace_back(fmt::format("backend_of_some_{}", b), "made up");
    for (const int threads : {1, 2, 4}) {
      ThreadResult run;
      run.backend = report.backends.back().first;
      run.threads = threads;
      run.pass.median_ns = (1000.0 + b) / threads;
      run.pass.repetitions = 9;
      report.thread_runs.push_back(run);
    }
  }
  // Three lines of broadphases, with one gap.
  for (const std::size_t objects : {100u, 1000u, 10000u}) {
    for (const char* name : {"backend_of_some_0", "brute_force", "late"}) {
      BroadphaseResult result;
      result.name = name;
      result.size.objects = objects;
      result.size.hexahedra_each = 1;
      result.frame.median_ns = 1e3 * static_cast<double>(objects);
      if (result.name == "brute_force") result.frame.median_ns *= 1e-2 * static_cast<double>(objects);
      if (objects < 10000 || result.name != "brute_force") report.broadphases.push_back(result);
    }
  }
  // No label is cut or over another one.
  const nlohmann::json seen = look(html_report(report), kTexts);
  ASSERT_TRUE(seen["found"].is_object()) << seen;
  EXPECT_EQ(seen["found"]["cut"], nlohmann::json::array());
  EXPECT_EQ(seen["found"]["over"], nlohmann::json::array());
}

TEST_F(PageWalk, TheWatchSeesCutTextsAndLabelsOnEachOther) {
  const nlohmann::json seen = look(
      "<html><head></head><body><svg class='plot' aria-label='p' viewBox='0 0 100 100' width='100' "
      "height='100'>"
      "<text x='-20' y='50'>cut</text><text class='label' x='20' y='50'>one</text><text class='label' x='22' "
      "y='51'>two</text></svg></body></html>",
      kTexts);
  ASSERT_TRUE(seen["found"].is_object()) << seen;
  EXPECT_THAT(seen["found"]["cut"].dump(), HasSubstr("p: cut"));
  EXPECT_THAT(seen["found"]["over"].dump(), HasSubstr("p: one / two"));
}

}  // namespace
}  // namespace touchstone::comparison
