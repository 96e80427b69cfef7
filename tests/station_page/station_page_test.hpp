#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "touchstone/tests/station_page/browser.hpp"
#include "touchstone/tests/support/program_test.hpp"

namespace touchstone::station {

/// The station's page in Chromium, against the made-up station of fake_station.js. Where there is no Chromium
/// these tests are skipped, and fail where TOUCHSTONE_NEEDS_BROWSER is set, as .ci/run does.
class StationPage : public FolderTest {
 protected:
  void SetUp() override {
    if (Browser::program().empty()) {
      const std::string why = "the page needs Chromium (Debian: chromium or chromium-headless-shell)";
      if (std::getenv("TOUCHSTONE_NEEDS_BROWSER") != nullptr) FAIL() << why;
      GTEST_SKIP() << "NOT LOOKED AT: " << why;
    }
    browser_ = std::make_unique<Browser>(folder_ / "profile");
    browser_->serve("http://station.test/", PAGE);
    browser_->run_before_pages(read(TESTED_IN_PAGE));
    browser_->set_window(1024, 600);  // few pixels: they are drawn by software
  }

  void TearDown() override {
    if (!browser_) return;
    EXPECT_THAT(browser_->faults(), testing::IsEmpty());
    EXPECT_THAT(browser_->strangers(), testing::IsEmpty());
    browser_.reset();
  }

  /// Opens the page; `options` are the made-up station's, `query` e.g. "?fly": without the overlay for
  /// newcomers.
  void open(const std::string& options = "{}", const std::string& query = "?fly") {
    browser_->run_before_pages("window.fakeOptions=" + options + ";" + read(FAKE_STATION));
    browser_->open("http://station.test/" + query);
    ASSERT_TRUE(browser_->becomes_true("touchstoneStation.station.drawn > 0")) << "no picture was drawn";
  }

  nlohmann::json value(const std::string& expression) { return browser_->evaluate(expression); }
  std::string text(const std::string& id) {
    return value("document.getElementById('" + id + "').textContent");
  }
  bool becomes_true(const std::string& expression) { return browser_->becomes_true(expression); }

  std::unique_ptr<Browser> browser_;
};

}  // namespace touchstone::station
