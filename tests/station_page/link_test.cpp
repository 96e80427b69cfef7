// The page and the connection: newest frame wins, it comes back by itself, times are in one clock, it looks
// back.
#include "touchstone/tests/station_page/station_page_test.hpp"

namespace touchstone::station {
namespace {

TEST_F(StationPage, DrawsTheNewestFrameOnlyAndReportsEachAsSeen) {
  open();
  // Frames that come in one go, as after a stall: the last one is drawn, the others are counted.
  const nlohmann::json found = value(R"((() => {
    fake.dead = true;
    const socket = fake.sockets[0], {link} = touchstoneStation;
    link.take();
    const before = link.undrawn, seen = fake.received.length;
    for (let i = 0; i < 20; ++i) socket.step();
    return {left_out: link.undrawn - before, frame: socket.frame,
            seen: fake.received.slice(seen).filter(m => m.type === 'seen').map(m => m.frame)};
  })())");
  EXPECT_EQ(found["left_out"], 19);
  EXPECT_EQ(found["seen"].size(), 20u);
  EXPECT_EQ(found["seen"].back(), found["frame"]);
  EXPECT_TRUE(becomes_true("touchstoneStation.station.frame.frame === " + found["frame"].dump()));
}

TEST_F(StationPage, DrawsNothingAnewWhileNothingChanges) {
  open();
  // Once the window and the camera have settled.
  ASSERT_TRUE(
      becomes_true("(() => { const {drawn, frame} = touchstoneStation.station, quiet = drawn === "
                   "window.last; window.last = drawn; "
                   "return quiet && frame.frame > (window.from = window.from ?? frame.frame) + 10; })()"));
  const int drawn = value("touchstoneStation.station.drawn"),
            frame = value("touchstoneStation.station.frame.frame");
  ASSERT_TRUE(becomes_true("touchstoneStation.station.frame.frame > " + std::to_string(frame + 10)));
  EXPECT_EQ(value("touchstoneStation.station.drawn"), drawn);
  browser_->press(
      "KeyA");  // along an axis that the made-up arm has not: nothing moves, yet the input counts as drawn
  EXPECT_TRUE(becomes_true("fake.received.some(message => message.type === 'drawn')"));
  value("fake.sockets[0].x[3] += 1e-3");
  EXPECT_TRUE(becomes_true("touchstoneStation.station.drawn > " + std::to_string(drawn)));
}

TEST_F(StationPage, LeavesOutFramesThatItCannotRead) {
  open();
  value(R"((() => {
    fake.dead = true;
    const {link} = touchstoneStation, good = fake.sockets[0].encode(0, 0.65, false);
    window.shown = touchstoneStation.station.frame.frame;
    const flip = (at, value) => { const copy = good.slice(0); new DataView(copy).setUint32(at, value, true); return copy; };
    window.unread = [new ArrayBuffer(0), new ArrayBuffer(127), good.slice(0, good.byteLength - 8), flip(0, 7), flip(4, 9), flip(72, 4e9), flip(80, 4e9), flip(6, 3)]
      .map(bytes => { link.takeFrame(bytes); const before = link.unread; const frame = link.take(); return frame === null && link.unread === before + 1; });
  })())");
  EXPECT_EQ(value("window.unread.every(Boolean)"), true) << value("window.unread");
  value("fake.dead = false");
  EXPECT_TRUE(becomes_true("touchstoneStation.station.frame.frame > window.shown"));
}

TEST_F(StationPage, ConnectsAgainByItselfAndLetsGo) {
  open();
  browser_->press("KeyW");
  value("fake.down = true; fake.sockets[0].close()");
  ASSERT_TRUE(becomes_true("document.getElementById('link-text').textContent.includes('lost')"));
  EXPECT_EQ(value("touchstoneStation.hand.held.size"), 0);
  browser_->wait(0.4);
  value("fake.down = false");
  ASSERT_TRUE(becomes_true("document.getElementById('link-text').textContent === 'connected'"));
  EXPECT_TRUE(
      becomes_true("touchstoneStation.station.frame && fake.sockets.at(-1).frame - "
                   "touchstoneStation.station.frame.frame < 50"));
}

TEST_F(StationPage, ConnectsAgainWhereTheScenesTextWasLost) {
  open();
  value("fake.choose('second')");
  ASSERT_TRUE(becomes_true("touchstoneStation.station.frame?.serial === 2"));
  EXPECT_EQ(value("fake.sockets.length"), 1) << "its text came";
  value("fake.choose('third', true)");
  browser_->wait(0.5);
  EXPECT_EQ(value("fake.sockets.length"), 1) << "it may still come";
  ASSERT_TRUE(becomes_true("touchstoneStation.station.frame?.serial === 3"));
  EXPECT_EQ(value("touchstoneStation.station.scene.name"), "third");
  EXPECT_EQ(value("fake.sockets.length"), 2);
}

TEST_F(StationPage, CountsHandToPictureInTheBrowsersClock) {
  open();
  browser_->press("KeyW");
  ASSERT_TRUE(becomes_true("touchstoneStation.latency.total >= 3"));
  browser_->press("KeyW", false);
  const nlohmann::json drawn = value("fake.received.filter(m => m.type === 'drawn')");
  ASSERT_GE(drawn.size(), 3u);
  // The made-up station's clock is 5 s ahead of the browser's, and its answers take no time.
  EXPECT_NEAR(drawn.back()["offset"].get<double>(), 5e6, 1e3);
  // The page's worst figure is one of the differences between a drawn and its input's stamp.
  const nlohmann::json all = value(R"((() => {
    const {latency} = touchstoneStation;
    return {worst: latency.worst, total: latency.total, sum: latency.counts.reduce((a, b) => a + b), median: latency.percentile(0.5), most: latency.percentile(1)};
  })())");
  EXPECT_EQ(all["total"], all["sum"]);
  EXPECT_EQ(all["worst"], all["most"]);
  EXPECT_GT(all["median"].get<double>(), 0.0);
  EXPECT_EQ(value("(() => { const l = new touchstoneStation.latency.constructor(); for (let i = 1; i <= "
                  "1000; ++i) l.add(i / 10); "
                  "l.add(200); return [l.percentile(0.5), l.percentile(0.999), l.percentile(1), l.late, "
                  "l.total]; })()"),
            nlohmann::json({50.1, 100.0, 200.0, 1, 1001}));
  // Of many the last 100 000.
  EXPECT_EQ(value("(() => { const l = new touchstoneStation.latency.constructor(); for (let i = 0; i < "
                  "100010; ++i) l.add(i); "
                  "const most = l.percentile(1); l.add(7); return [l.percentile(0), most, l.percentile(0.5), "
                  "l.sorted.length]; })()"),
            nlohmann::json({7.0, 100009.0, 50009.0, 100000}));
}

TEST_F(StationPage, KnowsTheStationsClockThoughAnswersWait) {
  // Each answer to a ping comes 80 ms late, as behind a long turn of the page; frames do not.
  open("{late: 80}");
  ASSERT_TRUE(becomes_true("fake.received.filter(message => message.type === 'ping').length > 2"));
  ASSERT_TRUE(becomes_true("touchstoneStation.link.rtt < Infinity"));
  EXPECT_NEAR(value("touchstoneStation.link.offset").get<double>(), 5e6, 1e3);
}

TEST_F(StationPage, BoundsTheOffsetByEveryMessageAndAsksMoreOftenWhereItKnowsLittle) {
  open();
  // A minute at a tenth of a second: ways there of 0.3 to 50 ms, back of 20 to 200 ms; frames meanwhile of
  // 0.1 to 100 ms. The clocks drift apart as `drift`. Worst of the last 50 s [us]; the width; until the next
  // ping.
  const auto fly = [&](const std::string& drift, bool has_frames) {
    return value(R"((async (drift, hasFrames) => {
      const {Clock} = await import('/clock.js'), clock = new Clock();
      let seed = 1, worst = 0;
      const random = () => (seed = seed * 16807 % 2147483647) / 2147483647;
      for (let i = 0; i < 600; ++i) {
        const sent = i * 1e5, offset = 5e6 + drift * sent, there = 300 + 5e4 * random() ** 3, back = sent + there + 2e4 + 1.8e5 * random();
        clock.there(back, sent, sent + there + offset);
        clock.here(back, sent + there + offset);
        for (let k = 0; hasFrames && k < 5; ++k) {
          const from = sent + k * 2e4;
          clock.here(from + 100 + 1e5 * random() ** 2, from + offset);
        }
        if (i > 100) worst = Math.max(worst, Math.abs(clock.known.offset - offset));
      }
      return [worst, clock.known.rtt, clock.untilPing];
    })()" + drift +
                 ", " + (has_frames ? "true" : "false") + ")");
  };
  const nlohmann::json quiet = fly("0", true), drifting = fly("50e-6", true), blind = fly("0", false);
  EXPECT_LT(quiet[0], 500.0) << quiet;
  EXPECT_EQ(quiet[2], 1000) << quiet;
  EXPECT_LT(drifting[0], 1000.0) << drifting;
  EXPECT_LE(blind[0].get<double>(), blind[1].get<double>() / 2.0) << blind;
  EXPECT_EQ(blind[2], 100) << blind;
  // Of another connection nothing is known.
  EXPECT_EQ(value("(async () => { const {Clock} = await import('/clock.js'), clock = new Clock(); "
                  "clock.there(1, 0, 5); clock.here(1, 5); clock.forget(); return [clock.known.offset, "
                  "clock.known.rtt === Infinity, clock.untilPing]; })()"),
            nlohmann::json({0, true, 100}));
}

TEST_F(StationPage, LooksBackAndSavesWhatWasFlown) {
  // A flight that ends at a block.
  open();
  browser_->press("KeyW");
  ASSERT_TRUE(becomes_true("touchstoneStation.station.frame.methods[3].blocked"));
  browser_->press("KeyW", false);
  // Back to its start.
  value(
      "(() => { const line = document.getElementById('line'); line.value = '0'; line.dispatchEvent(new "
      "Event('input')); })()");
  EXPECT_TRUE(becomes_true("seen.tip(3) < -0.9"));
  // Saved, opened again, opened cut short, and opened though it is none.
  const nlohmann::json found = value(R"((async () => {
    const {timeline, station} = touchstoneStation, count = timeline.frames.length;
    const bytes = await timeline.file(station.hello, station.scene).arrayBuffer();
    const copy = new timeline.constructor(), {scene} = copy.open(bytes);
    let cut = 'taken';
    const short = new timeline.constructor();
    short.open(bytes.slice(0, bytes.byteLength - 5));
    try { new timeline.constructor().open(new ArrayBuffer(100)); } catch (fault) { cut = fault.message; }
    const same = copy.frames.every((frame, i) => new Uint8Array(frame).every((byte, k) => byte === new Uint8Array(timeline.frames[i])[k]));
    return {count, again: copy.frames.length, same, name: scene.name, short: short.frames.length, cut};
  })())");
  EXPECT_EQ(found["again"], found["count"]);
  EXPECT_EQ(found["same"], true);
  EXPECT_EQ(found["name"], "made_up");
  EXPECT_EQ(found["short"].get<int>(), found["count"].get<int>() - 1);
  EXPECT_EQ(found["cut"], "this is no saved flight");
  // Live again.
  value("document.getElementById('live').click()");
  EXPECT_TRUE(becomes_true("seen.tip(3) > 0.6"));
}

TEST_F(StationPage, AppliesFiveHundredMovingSolids) {
  open("{solids: 500, rate: 60}");
  EXPECT_EQ(value("touchstoneStation.station.frame.objects"), 504);
  const std::string last = "touchstoneStation.renderer.table[12 * 503]";
  const nlohmann::json before = value(last);
  EXPECT_TRUE(becomes_true(last + " !== " + before.dump())) << "the last one moves on the card too";
}

}  // namespace
}  // namespace touchstone::station
