// A page that draws no more than there is time for.
#include "touchstone/tests/station_page/station_page_test.hpp"

namespace touchstone::station {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// Pictures of so many milliseconds each, one a `period`, from `window.now` on.
constexpr const char* kDraw =
    "window.draw = (pace, count, took, period = 20) => { for (let i = 0; i < count; ++i) pace.add(took, "
    "window.now = (window.now ?? 0) + period); return pace.at; }";

class StationPace : public StationPage {
 protected:
  void SetUp() override {
    StationPage::SetUp();
    if (browser_ == nullptr) return;
    open();
    value(std::string("(async () => { Object.assign(window, await import('/pace.js')); ") + kDraw +
          "; window.pace = new Pace(); })()");
  }
};

TEST_F(StationPace, DrawsLessWherePicturesAreLateAndNoLessThanThereIs) {
  EXPECT_EQ(value("draw(pace, 100, budget)"), 0) << "within the budget";
  EXPECT_EQ(value("draw(pace, 2, budget + 1)"), 0) << "two late ones are chance";
  EXPECT_EQ(value("draw(pace, 1, budget + 1)"), 1);
  EXPECT_EQ(value("pace.pixels"), 0.75);
  EXPECT_EQ(value("draw(pace, 300, 200)"), value("levels.length - 1"));
  EXPECT_EQ(value("draw(pace, 300, 200)"), value("levels.length - 1"));
  EXPECT_EQ(value("new Pace(true).at > 0"), true) << "software is known to be slow";
  EXPECT_EQ(value("draw(new Pace(), 1, 4 * budget + 1)"), 1) << "one that is far too late";
  EXPECT_EQ(value("draw(new Pace(), 1, 16 * budget + 1)"), value("levels.length - 1")) << "a stall";
}

TEST_F(StationPace, DrawsMoreAgainWhereThereIsTimeAndWaitsLongerWhereThatWasTooMuch) {
  value("draw(pace, 6, 200)");
  ASSERT_EQ(value("pace.at"), 2);
  EXPECT_EQ(value("draw(pace, 1000, budget - 1)"), 2) << "in time, but with none to spare";
  EXPECT_EQ(value("draw(pace, 199, 10)"), 2) << "for less than 4 s";
  EXPECT_EQ(value("draw(pace, 2, 10)"), 1);
  // That was too much: 8 s then, and after another time 16 s.
  ASSERT_EQ(value("draw(pace, 3, 200)"), 2);
  EXPECT_EQ(value("draw(pace, 399, 10)"), 2);
  EXPECT_EQ(value("draw(pace, 2, 10)"), 1);
  ASSERT_EQ(value("draw(pace, 3, 200)"), 2);
  EXPECT_EQ(value("draw(pace, 799, 10)"), 2);
  EXPECT_EQ(value("draw(pace, 2, 10)"), 1);
  EXPECT_EQ(value("draw(pace, 10000, 10)"), 0) << "and all in the end";
}

TEST_F(StationPace, ARaiseThatWasTakenBackHoldsByNoStandingStill) {
  value("draw(pace, 6, 200)");
  for (int i = 0; i < 4; ++i) {
    ASSERT_EQ(value("draw(pace, pace.wait / 20 + 1, 10)"), 1);
    ASSERT_EQ(value("draw(pace, 3, 200)"), 2);
  }
  ASSERT_EQ(value("pace.wait"), 64000);
  // Five minutes in which nothing is drawn are no calm, and say of no raise that it held.
  value("window.now += 300000");
  EXPECT_EQ(value("draw(pace, 3000, 10)"), 2);
  EXPECT_EQ(value("draw(pace, 300, 10)"), 1);
  EXPECT_EQ(value("pace.wait"), 64000);
  // One that was not tried before they began was not tried at their end either.
  value("window.tried = Object.assign(new Pace(), {at: 2}); draw(tried, 202, 10)");
  ASSERT_EQ(value("tried.at"), 1);
  value("window.now += 300000");
  EXPECT_EQ(value("draw(tried, 3, 200)"), 2);
  EXPECT_EQ(value("tried.wait"), 8000);
  // One under which pictures were in time for longer has held.
  value("window.held = Object.assign(new Pace(), {at: 2, wait: 8000}); draw(held, 402, 10)");
  ASSERT_EQ(value("held.at"), 1);
  EXPECT_EQ(value("draw(held, 1590, 40)"), 1);
  EXPECT_EQ(value("held.wait"), 8000);
  value("draw(held, 15, 40)");
  EXPECT_EQ(value("held.wait"), 4000);
  value("draw(held, 3, 200)");
  EXPECT_EQ(value("[held.at, held.wait]"), nlohmann::json({2, 4000}));
}

TEST_F(StationPace, DrawsMoreAgainWhereAPagesTurnIsLongerThanWhatWasToSpare) {
  value(
      "window.turn = (pace, count, period, took = period) => { for (let i = 0; i < count; ++i) { "
      "pace.turned(window.now = (window.now ?? 0) + period); pace.add(took, window.now); } return pace.at; "
      "}; "
      "window.at = () => Object.assign(new Pace(), {at: 2})");
  // No picture takes less than a turn, of 33 ms here.
  EXPECT_EQ(value("turn(at(), 1000, 1000 / 30)"), 0);
  EXPECT_EQ(value("turn(at(), 1000, 1000 / 30, 2000 / 30)"), value("levels.length - 1")) << "late is late";
  EXPECT_EQ(value("turn(at(), 1000, 1000 / 60, 2000 / 60)"), 2) << "two turns of 17 ms are not one";
  EXPECT_EQ(value("turn(at(), 1000, 1000 / 60)"), 0);
  EXPECT_EQ(value("turn(at(), 1000, 49, 51)"), value("levels.length - 1"))
      << "no turn makes more to spare than the budget";
  // A page whose turns become longer, and shorter again.
  EXPECT_EQ(value("window.pace = at(); turn(pace, 100, 1000 / 60, 40)"), 2);
  EXPECT_EQ(value("turn(pace, 200, 1000 / 30)"), 2) << "a turn of 17 ms was seen not long ago";
  EXPECT_EQ(value("turn(pace, 1000, 1000 / 30)"), 0);
  EXPECT_EQ(value("pace.at = 2; turn(pace, 1, 1000 / 60, 40); turn(pace, 500, 1000 / 60, 40)"), 2);
  EXPECT_TRUE(becomes_true("touchstoneStation.pace.shortest < 1000")) << "the page tells its turns";
}

TEST_F(StationPace, AHiddenTabIsNoStall) {
  // Turns stop while the page is hidden; two drawings are on their way then.
  value(R"((() => {
    const {renderer, station, pace} = touchstoneStation, ended = renderer.hasFinished, ask = window.requestAnimationFrame;
    const become = state => {
      Object.defineProperty(document, 'visibilityState', {value: state, configurable: true});
      Object.defineProperty(document, 'hidden', {value: state === 'hidden', configurable: true});
      document.dispatchEvent(new Event('visibilitychange'));
    };
    renderer.hasFinished = mark => {
      if (station.pending.length === 2 && station.pending.every(one => one.mark)) window.requestAnimationFrame = turn => { window.held = turn; };
      return !mark;
    };
    window.hide = () => { become('hidden'); touchstoneStation.latency.clear(); station.ages = []; station.intervals = []; };
    window.show = () => { window.requestAnimationFrame = ask; renderer.hasFinished = ended; become('visible'); ask(window.held); };
    window.taken = [];
    pace.add = took => { window.taken.push(took); };
  })())");
  browser_->press("KeyW");
  ASSERT_TRUE(becomes_true("window.held && touchstoneStation.station.pending.length === 2"));
  value("hide()");
  browser_->wait(4.0);
  value("show()");
  browser_->press("KeyW", false);
  browser_->press("KeyW");
  EXPECT_TRUE(becomes_true("touchstoneStation.latency.total > 0 && window.taken.length > 0"));
  EXPECT_LT(value("Math.max(...window.taken)"), 3500) << "no picture took so long";
  EXPECT_LT(value("touchstoneStation.latency.worst"), 3500) << "no hand that was let go came so late";
  EXPECT_LT(value("Math.max(...touchstoneStation.station.ages) / 1000"), 3500);
  EXPECT_LT(value("Math.max(0, ...touchstoneStation.station.intervals)"), 3500);
  // The judgement begins anew.
  value("draw(pace, 2, budget + 1); pace.rest(); window.now += 60000");
  EXPECT_EQ(value("draw(pace, 2, budget + 1)"), 0);
}

TEST_F(StationPace, SaysWhatItLeavesOut) {
  EXPECT_EQ(value("pace.says()"), "");
  EXPECT_EQ(value("pace.at = 2; pace.says()"),
            "drawn for speed with 75 % of the pixels each way, one CCTV picture at a time");
  EXPECT_THAT(value("pace.at = levels.length - 1; pace.says()").get<std::string>(), HasSubstr("no edges"));
  EXPECT_THAT(value("pace.says()").get<std::string>(), Not(HasSubstr("meshes")));
  EXPECT_THAT(value("pace.says(true)").get<std::string>(), HasSubstr("hexahedra for meshes"));
  // A choice by hand stays, however long pictures take.
  value("pace.fix(0.5); draw(pace, 100, 500)");
  EXPECT_EQ(value("[pace.pixels, pace.level.cctv > 4, pace.level.edges]"), nlohmann::json({0.5, true, true}));
  EXPECT_EQ(value("pace.says()"), "drawn with 0.5 of the pixels each way, as chosen");
}

TEST_F(StationPace, APageThatIsSlowToDrawLowersAndNeverQueues) {
  // Each drawing is said to end 120 ms after it was ordered.
  value(R"((() => {
    const {renderer, station} = touchstoneStation, ended = renderer.hasFinished.bind(renderer), ordered = new Map();
    window.queued = 0;
    renderer.hasFinished = mark => {
      if (!mark) return true;
      if (!ordered.has(mark)) ordered.set(mark, performance.now());
      window.queued = Math.max(window.queued, station.pending.length);
      return performance.now() - ordered.get(mark) > 120 && ended(mark);
    };
  })())");
  const int from = value("touchstoneStation.pace.at"),
            width = value("touchstoneStation.renderer.canvas.width");
  value("fake.sockets[0].wander = setInterval(() => { fake.sockets[0].x[3] += 1e-4; }, 20)");
  EXPECT_TRUE(becomes_true("touchstoneStation.pace.at > " + std::to_string(from)));
  EXPECT_TRUE(
      becomes_true("document.getElementById('drawn-for-speed').textContent.includes('drawn for speed')"));
  EXPECT_TRUE(becomes_true("touchstoneStation.renderer.canvas.width < " + std::to_string(width)));
  EXPECT_LE(value("window.queued").get<int>(), 2);
  EXPECT_GT(value("window.queued").get<int>(), 0);
}

TEST_F(StationPace, PicturesOfWhatIsLookedBackAtDoNotQueueEither) {
  ASSERT_TRUE(becomes_true("touchstoneStation.timeline.frames.length > 2"));
  // Drawings do not end; what is looked back at is to be drawn anew in each turn.
  value(R"((() => {
    const {renderer, station, pace} = touchstoneStation, {gl} = renderer, remove = gl.deleteSync.bind(gl);
    pace.add = () => {};
    pace.at = 0;
    const line = document.getElementById('line');
    line.value = '1';
    line.dispatchEvent(new Event('input'));
    renderer.hasFinished = mark => !mark;
    Object.assign(window, {marks: 0, deleted: 0, since: null});
    const mark = renderer.mark.bind(renderer);
    renderer.mark = () => { window.since ??= performance.now(); ++window.marks; return mark(); };
    gl.deleteSync = sync => { if (sync) ++window.deleted; remove(sync); };
    const turn = () => { station.dirty = true; requestAnimationFrame(turn); };
    const from = station.drawn;
    window.drawn = () => station.drawn - from;
    turn();
  })())");
  ASSERT_TRUE(becomes_true("window.drawn() > 0 && performance.now() - (window.since ?? Infinity) > 1000"));
  // Up to two before the first is given up, 2 s after it was ordered, and one for each that is; a mark each.
  EXPECT_TRUE(value("window.drawn() <= 2 + window.deleted && window.drawn() >= window.marks"))
      << value("[window.drawn(), window.marks, window.deleted]");
  EXPECT_TRUE(becomes_true("window.deleted >= 2")) << "a mark that is given up is deleted";
  EXPECT_LE(value("touchstoneStation.station.pending.length"), 2);
}

TEST_F(StationPace, AFrameThatLayInTheBrowserGivesWayToANewerOne) {
  // `take(frame, ago)`: a frame of this number that was sent so many ms ago is taken now.
  value(R"((() => {
    const {link, pace, picture, station} = touchstoneStation, takeFrame = link.takeFrame.bind(link), draw = picture.draw.bind(picture);
    window.shown = [];
    pace.at = 0;
    pace.add = () => {};
    link.takeFrame = data => { window.last = data; takeFrame(data); };
    picture.draw = (frame, ...of) => { window.shown.push(frame.frame); draw(frame, ...of); };
    window.take = (frame, ago) => {
      const view = new DataView(window.last.slice(0));
      view.setBigUint64(8, BigInt(frame), true);
      view.setFloat64(56, performance.now() * 1000 + link.offset - 1000 * ago, true);
      station.dirty = true;
      takeFrame(view.buffer);
    };
  })())");
  ASSERT_TRUE(becomes_true("window.last && (fake.dead = true)"));
  const std::string idle =
      "!touchstoneStation.link.newest && !touchstoneStation.station.pending.length && "
      "!touchstoneStation.station.dirty";
  ASSERT_TRUE(becomes_true(idle));
  // Nothing newer comes: it is shown all the same.
  value("shown.length = 0; take(900001, 60)");
  EXPECT_TRUE(becomes_true("shown.includes(900001)"));
  ASSERT_TRUE(becomes_true(idle));
  // A newer one comes after the page's turn began to wait for it.
  value("shown.length = 0; take(900002, 60); requestAnimationFrame(() => take(900003, 0))");
  EXPECT_TRUE(becomes_true("shown.includes(900003)"));
  EXPECT_EQ(value("shown.includes(900002)"), false);
  ASSERT_TRUE(becomes_true(idle));
  // One that came at once is drawn in the page's turn, before our own.
  value("shown.length = 0; take(900004, 0); requestAnimationFrame(() => { window.inTurn = [...shown]; })");
  EXPECT_TRUE(becomes_true("window.inTurn"));
  EXPECT_EQ(value("window.inTurn.includes(900004)"), true);
}

TEST_F(StationPace, CctvPicturesThatWaitHaveTheirTurnsWhereNothingChanges) {
  value(R"((() => {
    const {pace, picture, station} = touchstoneStation;
    pace.add = () => {};
    pace.at = levels.length - 1;
    fake.dead = station.dirty = true;  // all is drawn with the level's pixels once more
    window.turns = 0;
    window.count = () => {
      if (picture.stale.size) { ++window.turns; requestAnimationFrame(window.count); }
    };
  })())");
  ASSERT_TRUE(becomes_true("!touchstoneStation.link.newest && !touchstoneStation.station.dirty"));
  value(
      "(({picture, station}) => { station.screens.filter(screen => !screen.main).forEach(screen => "
      "picture.stale.add(screen)); count(); })(touchstoneStation)");
  ASSERT_TRUE(becomes_true("touchstoneStation.picture.stale.size === 0"));
  // Four pictures, of which the first may be due at once.
  EXPECT_GE(value("window.turns"), value("3 * levels.at(-1).every"));
}

TEST_F(StationPace, ACctvPictureThatWaitsHoldsUpNoFrame) {
  // A drawing does not end; without a new frame nothing more is ordered, though CCTV waits.
  value(R"((() => {
    const {renderer, station, picture, pace} = touchstoneStation;
    pace.add = () => {};
    pace.at = 2;
    fake.dead = true;
    window.ready = () => !touchstoneStation.link.newest && !station.pending.length && !picture.stale.size && !station.dirty;
  })())");
  ASSERT_TRUE(becomes_true("window.ready()"));
  value(R"((() => {
    const {renderer, station, picture} = touchstoneStation;
    renderer.hasFinished = mark => !mark;
    station.pending.push({frame: null, begun: performance.now(), mark: renderer.mark()});
    station.screens.filter(screen => !screen.main).forEach(screen => picture.stale.add(screen));
    window.from = station.drawn;
  })())");
  browser_->wait(0.4);
  EXPECT_EQ(value("touchstoneStation.station.drawn - window.from"), 0);
  value("touchstoneStation.renderer.hasFinished = () => true");
  EXPECT_TRUE(becomes_true("touchstoneStation.picture.stale.size === 0"));
}

TEST_F(StationPace, CctvPicturesThatWaitForTheirTurnComeToTheNewestFrameAll) {
  // Levels change by no measure of this machine's.
  value("(() => { const {pace} = touchstoneStation; pace.at = 4; pace.add = () => {}; })()");
  browser_->press("KeyW");
  ASSERT_TRUE(becomes_true("touchstoneStation.picture.stale.size > 0"));
  ASSERT_TRUE(becomes_true("seen.tip(3) > -0.5"));
  browser_->press("KeyW", false);
  ASSERT_TRUE(becomes_true("touchstoneStation.picture.stale.size === 0"));
  // The same pixels as all drawn anew; the main camera has come to rest.
  ASSERT_TRUE(
      becomes_true("(() => { const {drawn} = touchstoneStation.station, quiet = drawn === window.last; "
                   "window.last = drawn; return quiet; })()"));
  const nlohmann::json differing = value(R"((() => {
    const {station, picture, renderer: {gl, canvas}} = touchstoneStation;
    const read = () => { const all = new Uint8Array(4 * canvas.width * canvas.height); gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, all); return all; };
    const kept = read();
    picture.isMeasured = false;
    picture.draw(station.frame, station.screens, picture.theme);
    const anew = read();
    return [anew.filter((byte, i) => byte !== kept[i]).length, new Set(anew).size];
  })())");
  EXPECT_EQ(differing[0], 0) << "bytes of a kept picture differ";
  EXPECT_GT(differing[1].get<int>(), 20) << "there is a picture";
}

TEST_F(StationPace, LinesAreWholeHoweverFewPixelsThereAre) {
  value(
      "(() => { const {pace, station} = touchstoneStation; pace.at = levels.length - 1; pace.add = () => {}; "
      "station.dirty = true; })()");
  ASSERT_TRUE(becomes_true("touchstoneStation.renderer.detail === 0.25"));
  // Along a line across the first screen each pixel's column has one of the line's colour.
  const nlohmann::json covered = value(R"((() => {
    const {station, picture, renderer} = touchstoneStation, {gl} = renderer, screen = station.screens[0];
    picture.draw(station.frame, station.screens, picture.theme);
    renderer.openView(screen.box, {position: [0, 0, 0], rotation: [0, 0, 0, 1], fov: 1}, [0, 0, 0]);
    renderer.setMarks([{from: [-1, -0.13, -2], to: [1, 0.11, -2], width: 1, colour: [1, 1, 1, 1]}]);
    renderer.drawMarks();
    const [x, y, w, h] = renderer.place(screen.box), all = new Uint8Array(4 * w * h);
    gl.readPixels(x, y, w, h, gl.RGBA, gl.UNSIGNED_BYTE, all);
    const columns = Array.from({length: w}, (_, i) => Array.from({length: h}, (_, k) => all[4 * (k * w + i)]).some(Boolean));
    return [columns.lastIndexOf(true) - columns.indexOf(true) + 1, columns.filter(Boolean).length];
  })())");
  EXPECT_EQ(covered[0], covered[1]);
  EXPECT_GT(covered[0].get<int>(), 20);
}

TEST_F(StationPace, KnowsThatSoftwareDrawsAndSmoothesNothingThere) {
  // Chromium without a graphics card, which does not say so where it is asked for no slow context.
  EXPECT_EQ(value("touchstoneStation.renderer.software"), true);
  EXPECT_EQ(value("touchstoneStation.renderer.gl.getContextAttributes().antialias"), false);
}

TEST_F(StationPace, ALevelOfOtherPixelsKeepsTheCctvPicturesUntilTheirTurns) {
  value(
      "(() => { const {pace, station} = touchstoneStation; pace.at = 3; pace.add = () => {}; station.dirty = "
      "true; })()");
  ASSERT_TRUE(
      becomes_true("touchstoneStation.renderer.detail === 0.5 && !touchstoneStation.picture.stale.size"));
  const nlohmann::json found = value(R"((() => {
    const {station, picture, pace, renderer} = touchstoneStation, {gl, canvas} = renderer, width = canvas.width;
    const mean = screen => {
      const [x, y, w, h] = renderer.place(screen.box), all = new Uint8Array(4 * w * h), sum = [0, 0, 0];
      gl.readPixels(x, y, w, h, gl.RGBA, gl.UNSIGNED_BYTE, all);
      all.forEach((byte, i) => { if (i % 4 < 3) sum[i % 4] += byte / (w * h); });
      return sum;
    };
    const cctv = station.screens.filter(screen => !screen.main), before = cctv.map(mean);
    let chosen = null;
    const choose = picture.choose.bind(picture);
    picture.choose = (...of) => chosen = choose(...of);
    pace.at = 2;
    picture.draw(station.frame, station.screens, picture.theme, false);
    picture.choose = choose;
    const gap = new Uint8Array(4), [x, y, , h] = renderer.place(cctv[0].outer);
    gl.readPixels(x, y + h + 1, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, gap);
    return {wider: canvas.width > width, drawn: chosen.length, main: chosen.some(screen => screen.main), waiting: picture.stale.size,
      most: Math.max(...cctv.flatMap((screen, i) => mean(screen).map((value, k) => Math.abs(value - before[i][k])))), gap: [...gap], theme: picture.theme, before};
  })())");
  EXPECT_EQ(found["wider"], true);
  EXPECT_EQ(found["main"], true);
  EXPECT_LE(found["drawn"].get<int>(), 2) << "one CCTV picture at a time";
  EXPECT_GE(found["waiting"].get<int>(), 3);
  // Between the screens is the bezel (picture.js), 0.93 of full where the theme is light, 0.08 where dark.
  const std::vector<int> bezel =
      found["theme"] == "dark" ? std::vector{20, 23, 28} : std::vector{237, 241, 245};
  for (std::size_t i = 0; i < bezel.size(); ++i)
    EXPECT_NEAR(found["gap"][i].get<int>(), bezel[i], 1) << found["gap"] << found["theme"];
  EXPECT_LT(found["most"].get<double>(), 8.0) << "those that wait are blank: " << found;
  EXPECT_TRUE(becomes_true("!touchstoneStation.picture.stale.size"));
}

TEST_F(StationPace, NothingLargeIsPaintedOverTheCanvas) {
  const nlohmann::json large = value(R"((() => {
    const whole = touchstoneStation.renderer.canvas.getBoundingClientRect(), paints = colour => !/rgba\(.*, 0\)|transparent/.test(colour);
    return [...document.querySelectorAll('#screens *')].filter(node => {
      const style = getComputedStyle(node), box = node.getBoundingClientRect();
      const isPainted = paints(style.backgroundColor) || (parseFloat(style.borderTopWidth) > 0 && paints(style.borderTopColor)) || style.borderRadius !== '0px';
      return isPainted && box.width * box.height > 0.05 * whole.width * whole.height;
    }).map(node => `${node.tagName} ${node.className}`);
  })())");
  EXPECT_THAT(large, IsEmpty());
}

TEST_F(StationPace, SolidsOfWhatIsNotShownAreLeftOutOfTheCalls) {
  value("(async () => { Object.assign(window, await import('/renderer.js')); })()");
  // Four objects of 2, 1, 3 and 1 solids.
  EXPECT_EQ(value("runsOf([2, 3, 6, 7], null)"), nlohmann::json::parse("[[0, 7]]"));
  EXPECT_EQ(value("runsOf([2, 3, 6, 7], [false, true, true, false])"), nlohmann::json::parse("[[2, 4]]"));
  EXPECT_EQ(value("runsOf([2, 3, 6, 7], [true, false, false, true])"),
            nlohmann::json::parse("[[0, 2], [6, 1]]"));
  EXPECT_EQ(value("runsOf([2, 3, 6, 7], [true, false, false, true], 1)"), nlohmann::json::parse("[[0, 7]]"));
  EXPECT_EQ(value("runsOf([2, 3, 6, 7], [false, false, false, false])"), nlohmann::json::array());
  EXPECT_EQ(value("runsOf([], null)"), nlohmann::json::parse("[[0, 0]]"));
}

}  // namespace
}  // namespace touchstone::station
