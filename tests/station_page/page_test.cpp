// The page by itself.
#include "touchstone/tests/station_page/station_page_test.hpp"

namespace touchstone::station {
namespace {

TEST_F(StationPage, LoadsWithoutAFaultAndAsksNobodyElse) {
  open();
  EXPECT_GE(browser_->requests().size(), 10u) << "page, style and modules";
  for (const std::string& address : browser_->requests())
    EXPECT_TRUE(address.rfind("http://station.test/", 0) == 0 || address.rfind("data:", 0) == 0) << address;
  EXPECT_EQ(value("fake.sockets.map(socket => socket.url + ' ' + socket.protocol)"),
            nlohmann::json({"ws://station.test/socket touchstone-station-1"}));
  EXPECT_EQ(value("document.querySelectorAll('.cctv .screen').length"), 4);
  // Every screen has a picture: its middle is not the colour behind the screens.
  EXPECT_TRUE(becomes_true("touchstoneStation.renderer.faceCount === 36 * 4"));
}

TEST_F(StationPage, SaysWhatItNeedsWhereThereIsNoWebGl) {
  browser_->run_before_pages("HTMLCanvasElement.prototype.getContext = () => null; window.fakeOptions = {};" +
                             read(FAKE_STATION));
  browser_->open("http://station.test/?fly");
  EXPECT_TRUE(becomes_true("document.getElementById('trouble').textContent.includes('WebGL2')"));
}

}  // namespace
}  // namespace touchstone::station
