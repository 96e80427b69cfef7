// How the page meets people: newcomers, phones, dark rooms, keyboards, screen readers.
#include "touchstone/tests/station_page/station_page_test.hpp"

namespace touchstone::station {
namespace {

using testing::IsEmpty;

constexpr const char* kAllOpen = "document.querySelectorAll('details').forEach(one => { one.open = true; })";

TEST_F(StationPage, TellsANewcomerOfGhostingOnce) {
  open("{}", "");
  ASSERT_TRUE(becomes_true("document.getElementById('help').open"));
  EXPECT_EQ(value("document.activeElement.id"), "start");
  // A newcomer's minute: at 200 words a minute the overlay is read within it.
  EXPECT_LT(value("document.getElementById('help').textContent.trim().split(/\\s+/).length").get<int>(), 150);
  browser_->press("KeyW");
  browser_->wait(0.2);
  EXPECT_EQ(value("seen.inputs().filter(input => input.translation[0]).length"), 0)
      << "the overlay is before the arm";
  browser_->press("KeyW", false);
  value("document.getElementById('start').click()");
  browser_->open("http://station.test/");
  ASSERT_TRUE(becomes_true("window.touchstoneStation && touchstoneStation.station.drawn > 0"));
  EXPECT_EQ(value("document.getElementById('help').open"), false);
}

TEST_F(StationPage, FitsAPhoneLightAndDark) {
  browser_->set_window(390, 844, true);
  for (const char* const scheme : {"light", "dark"}) {
    browser_->set_media({{{"name", "prefers-color-scheme"}, {"value", scheme}}});
    open();
    value(kAllOpen);
    EXPECT_EQ(value("document.documentElement.dataset.theme"), scheme);
    EXPECT_LE(value("document.documentElement.scrollWidth").get<int>(), 390);
    EXPECT_THAT(value("seen.faint()"), IsEmpty()) << scheme;
    EXPECT_THAT(value("seen.small()"), IsEmpty());
  }
  // A finger on `forward` flies, and lets go when it is lifted.
  const nlohmann::json at = value(
      "(() => { const box = document.querySelector('[data-axis=KeyW]').getBoundingClientRect(); return "
      "[box.left + 9, box.top + 9]; })()");
  browser_->call("Input.dispatchTouchEvent",
                 {{"type", "touchStart"}, {"touchPoints", {{{"x", at[0]}, {"y", at[1]}}}}});
  EXPECT_TRUE(becomes_true("seen.inputs().length && seen.inputs().at(-1).translation[0] === 1"));
  browser_->call("Input.dispatchTouchEvent",
                 {{"type", "touchEnd"}, {"touchPoints", nlohmann::json::array()}});
  EXPECT_TRUE(becomes_true("seen.inputs().at(-1).translation[0] === 0"));
}

TEST_F(StationPage, IsReadableOnADesktopInEachCue) {
  browser_->set_window(1440, 900);
  for (const char* const scheme : {"light", "dark"}) {
    browser_->set_media({{{"name", "prefers-color-scheme"}, {"value", scheme}}});
    open();
    value(kAllOpen);
    for (const char* const cue : {"clear", "near", "contact", "blocked", "merged"}) {
      value(std::string("document.getElementById('light').dataset.cue = '") + cue + "'");
      EXPECT_THAT(value("seen.faint()"), IsEmpty()) << scheme << ", " << cue;
    }
    EXPECT_LE(value("document.documentElement.scrollWidth").get<int>(), 1440);
  }
  EXPECT_THAT(value("seen.nameless()"), IsEmpty());
}

TEST_F(StationPage, FollowsAWindowThatIsResizedInFlight) {
  open();
  browser_->press("KeyW");
  for (const auto& [width, height] : {std::pair{700, 900}, {1400, 640}, {390, 700}, {1024, 600}}) {
    browser_->set_window(width, height);
    // The canvas has the pixels of its place, and each screen's picture is drawn where its frame stands.
    EXPECT_TRUE(becomes_true(R"((() => {
      const {renderer: {canvas, ratio}, station} = touchstoneStation, whole = canvas.getBoundingClientRect();
      return Math.abs(canvas.width - whole.width * ratio) <= 1 && Math.abs(canvas.height - whole.height * ratio) <= 1 &&
        station.screens.every(screen => Math.abs(screen.element.getBoundingClientRect().left - whole.left - screen.outer.left) < 1 &&
          Math.abs(screen.element.getBoundingClientRect().width - screen.outer.width) < 1);
    })())"))
        << width;
    EXPECT_LE(value("document.documentElement.scrollWidth").get<int>(), width);
  }
  browser_->press("KeyW", false);
}

TEST_F(StationPage, StandsStillForWhomMotionDisturbs) {
  browser_->set_media({{{"name", "prefers-reduced-motion"}, {"value", "reduce"}}});
  open();
  value("document.getElementById('light').dataset.cue = 'blocked'");
  EXPECT_EQ(value("getComputedStyle(document.querySelector('.lamp')).animationName"), "none");
}

TEST_F(StationPage, IsReachedByTabAndTurnsTheCameraThatHasTheFocus) {
  open();
  value("document.querySelectorAll('.cctv .screen')[2].focus()");
  const nlohmann::json before =
      value("[touchstoneStation.station.mounted[2].pan, touchstoneStation.station.orbit.azimuth]");
  browser_->press("ArrowLeft");
  EXPECT_TRUE(becomes_true("touchstoneStation.station.mounted[2].pan !== " + before[0].dump()));
  EXPECT_EQ(value("touchstoneStation.station.orbit.azimuth"), before[1]);
  EXPECT_NE(value("getComputedStyle(document.activeElement).outlineStyle"), "none");
}

}  // namespace
}  // namespace touchstone::station
