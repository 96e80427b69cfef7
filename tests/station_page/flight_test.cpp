// Flying from the page: what reaches the station, what is seen, heard and read.
#include "touchstone/tests/station_page/station_page_test.hpp"

namespace touchstone::station {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST_F(StationPage, FliesByKeyUntilContactStopsItAndSaysByWhom) {
  open();
  const double start = value("seen.tip(3)");
  browser_->press("KeyW");
  ASSERT_TRUE(becomes_true("seen.tip(3) > " + std::to_string(start + 0.2)));
  EXPECT_TRUE(becomes_true("document.getElementById('cue').textContent === 'blocked by wall'"));
  EXPECT_TRUE(becomes_true("document.getElementById('blocked').textContent.includes('Blocked by wall')"));
  EXPECT_THAT(value("seen.inputs().at(-1).translation"), ElementsAre(1, 0, 0));
  EXPECT_EQ(value("seen.tip(3)"), static_cast<double>(0.65f)) << "ours stands at the wall";

  // A tone, lower than that of contact; its loudness follows within some 8 ms of the audio clock.
  EXPECT_EQ(value("document.documentElement.dataset.tone"), "blocked");
  EXPECT_TRUE(becomes_true("Math.abs(touchstoneStation.sound.oscillator.frequency.value - 330) < 5"));
  EXPECT_TRUE(becomes_true("touchstoneStation.sound.gain.gain.value > 0.1"));
  browser_->press("KeyW", false);
  EXPECT_TRUE(becomes_true("document.getElementById('cue').textContent === 'contact'"));
  value("document.getElementById('sound').click()");
  EXPECT_TRUE(becomes_true("touchstoneStation.sound.gain.gain.value < 0.001"));

  // Let go: zero is sent once, and then nothing more.
  EXPECT_TRUE(becomes_true("seen.inputs().at(-1).translation[0] === 0"));
  const int sent = value("seen.inputs().length");
  browser_->wait(0.3);
  EXPECT_EQ(value("seen.inputs().length"), sent);
}

TEST_F(StationPage, MarksTheContactAndTheCommandBehindIt) {
  open();
  browser_->press("KeyW");
  ASSERT_TRUE(becomes_true("touchstoneStation.station.frame.methods[3].blocked"));
  // The point's colour is that of a blocked contact (0.80, 0.40, 0), over all that lies before it.
  const nlohmann::json point = value("seen.colourAt(touchstoneStation.station.frame.contacts[0].point)");
  EXPECT_NEAR(point[0].get<int>(), 204, 3) << point;
  EXPECT_NEAR(point[1].get<int>(), 102, 3) << point;
  EXPECT_NEAR(point[2].get<int>(), 0, 3) << point;
  // The arm's side, 0.9 m behind the tip's middle, turns bluish where the commanded arm lies within it.
  ASSERT_TRUE(
      becomes_true("Math.abs(touchstoneStation.station.frame.commanded.poses[8] - seen.tip(3)) > 0.1"));
  const std::string side = "seen.colourAt([seen.tip(3) - 0.9, 0, 0.1])";
  const nlohmann::json with = value(side);
  value("document.getElementById('show-ghost').click()");
  ASSERT_TRUE(becomes_true("!touchstoneStation.picture.ghost"));
  const nlohmann::json without = value(side);
  EXPECT_GT(with[2].get<int>() - with[0].get<int>(), without[2].get<int>() - without[0].get<int>() + 20)
      << with << " against " << without;
}

TEST_F(StationPage, FliesByGamepadBothHands) {
  browser_->run_before_pages(
      "window.pad={id:'stub',connected:true,axes:[0,0,0,0],buttons:Array.from({length:17},()=>({pressed:"
      "false,"
      "value:0}))};navigator.getGamepads=()=>[null,window.pad];");
  open();
  value("pad.axes[1] = -1");  // left stick forward
  ASSERT_TRUE(becomes_true("seen.inputs().length && seen.inputs().at(-1).translation[0] === 1"));
  EXPECT_TRUE(becomes_true("seen.tip(3) > -0.9"));
  value("pad.axes = [0.1, 0.1, 0.1, -0.1]");  // within the dead zone
  ASSERT_TRUE(becomes_true("seen.inputs().at(-1).translation[0] === 0"));
  EXPECT_THAT(value("seen.inputs().at(-1).rotation"), ElementsAre(0, 0, 0));
  value("pad.axes = [1, 0, -1, 0]; pad.buttons[7].value = 1");  // left stick right, right stick left, trigger
  ASSERT_TRUE(becomes_true("seen.inputs().at(-1).rotation[2] === 1"));
  EXPECT_THAT(value("seen.inputs().at(-1).translation"), ElementsAre(0, -1, 1));
  value("pad.buttons[9].pressed = true");
  ASSERT_TRUE(becomes_true("touchstoneStation.station.state.brakes"));
  browser_->wait(0.2);
  EXPECT_EQ(value("seen.controls().length"), 1) << "held down, it is one command";
}

TEST_F(StationPage, ShowsWhatTheSameHandMergesWithoutUs) {
  open();
  browser_->press("KeyC");
  browser_->press("KeyC", false);
  EXPECT_TRUE(becomes_true("touchstoneStation.station.screens.filter(screen => screen.main).length === 4"));
  browser_->press("KeyW");
  ASSERT_TRUE(becomes_true("touchstoneStation.station.frame.methods[1].depth > 0.1"));
  browser_->press("KeyW", false);
  const auto fact = [&](int i) -> std::string {
    return value("touchstoneStation.station.screens[" + std::to_string(i) + "].fact.textContent");
  };
  ASSERT_TRUE(becomes_true("touchstoneStation.station.screens[1].fact.textContent.startsWith('MERGED')"));
  EXPECT_THAT(fact(0), HasSubstr("MERGED"));
  EXPECT_THAT(fact(3), testing::Not(HasSubstr("MERGED")));
  EXPECT_TRUE(becomes_true("document.getElementById('methods').rows[0].cells[1].textContent.endsWith('mm')"));
  EXPECT_EQ(value("document.getElementById('methods').rows[3].cells[2].textContent"), "none");
  EXPECT_THAT(text("method-what"), HasSubstr("Merged, of what is checked: by exact arithmetic"));
  EXPECT_THAT(value("document.getElementById('methods').rows[3].cells[3].textContent").get<std::string>(),
              testing::StartsWith("0 of "));
  browser_->press("Digit1");
  browser_->press("Digit1", false);
  EXPECT_TRUE(becomes_true("document.getElementById('light').dataset.cue === 'merged'"));
}

TEST_F(StationPage, FliesToTheNearestThingByItselfUntilAHandTakesOver) {
  open();
  browser_->press("KeyY");
  browser_->press("KeyY", false);
  EXPECT_TRUE(becomes_true("touchstoneStation.station.frame.methods[3].blocked"));
  browser_->press("KeyS");
  EXPECT_TRUE(becomes_true("seen.inputs().at(-1).translation[0] === -1"));
  EXPECT_TRUE(becomes_true("!touchstoneStation.station.assisting"));
  browser_->press("KeyS", false);
  EXPECT_TRUE(becomes_true("seen.inputs().at(-1).translation.every(axis => axis === 0)"));
}

TEST_F(StationPage, SaysThatNothingIsNearEnoughToFlyTo) {
  open("{far: true}");
  ASSERT_EQ(value("touchstoneStation.station.frame.distances.length"), 0);
  browser_->press("KeyY");
  EXPECT_TRUE(
      becomes_true("document.getElementById('trouble').textContent.startsWith('Nothing is within 2 m')"));
  EXPECT_EQ(value("touchstoneStation.station.assisting"), false);
  EXPECT_EQ(value("document.getElementById('assist').getAttribute('aria-pressed')"), "false");
}

TEST_F(StationPage, PushesOnAgainstWhatItTouchesAlready) {
  open();
  // A hand's key ends the flight to what is nearest, in contact.
  const auto press_assist = [&] {
    browser_->press("KeyY");
    browser_->press("KeyY", false);
  };
  press_assist();
  ASSERT_TRUE(becomes_true("touchstoneStation.station.frame.methods[3].blocked"));
  browser_->press("KeyA");
  ASSERT_TRUE(becomes_true("!touchstoneStation.station.assisting"));
  browser_->press("KeyA", false);
  ASSERT_TRUE(becomes_true("seen.inputs().at(-1).translation.every(axis => axis === 0)"));
  ASSERT_LT(value("touchstoneStation.station.frame.distances[0].separation"), 0.002);
  // It goes on along the contact's normal, from whichever of the two solids that points.
  press_assist();
  EXPECT_TRUE(becomes_true("seen.inputs().at(-1).translation[0] === 1"));
  EXPECT_EQ(value("touchstoneStation.station.assisting"), true);
  EXPECT_THAT(text("trouble"), testing::Not(HasSubstr("Nothing")));
  EXPECT_EQ(value("(async () => { const {steerAssist} = await import('/assist.js'), {station, hand} = "
                  "touchstoneStation, frame = structuredClone(station.frame), [one] = frame.contacts; "
                  "Object.assign(one, {a: one.b, b: one.a, normal: one.normal.map(axis => -axis)}); "
                  "Object.assign(station, {frame, assistDirection: [0, 0, 0]}); steerAssist(); return "
                  "hand.assist[0]; })()"),
            1);
}

TEST_F(StationPage, SaysThatItIsThereAlreadyWhereNoContactSaysWhichWay) {
  open("{mute: true}");
  value("fake.sockets[0].x[3] = 0.649");
  ASSERT_TRUE(becomes_true("touchstoneStation.station.frame.distances[0].separation < 0.002"));
  browser_->press("KeyY");
  browser_->press("KeyY", false);
  EXPECT_TRUE(becomes_true("document.getElementById('trouble').textContent.startsWith('wall')"));
  EXPECT_THAT(text("trouble"), HasSubstr("within 2 mm of the hand already"));
  EXPECT_EQ(value("touchstoneStation.station.assisting"), false);
}

TEST_F(StationPage, SendsWhatTheKeysAndListsCommand) {
  open();
  // Keys, and the message that each sends.
  const std::pair<const char*, const char*> keys[] = {{"Space", "brakes===true"},
                                                      {"KeyV", "vernier===true"},
                                                      {"KeyM", "mode==='joint'"},
                                                      {"BracketRight", "joint===1"},
                                                      {"KeyT", "frame_of_command==='base'"},
                                                      {"KeyG", "latch===true"},
                                                      {"KeyH", "release===true"},
                                                      {"Home", "reset===true"}};
  for (const auto& [key, sent] : keys) {
    const std::string was = value("fake.received.length").dump();
    browser_->press(key);
    browser_->press(key, false);
    EXPECT_TRUE(
        becomes_true("fake.received.slice(" + was + ").some(m => m.type === 'control' && m." + sent + ")"))
        << key;
  }
  // Lists and switches.
  value(
      "document.getElementById('policy').value='hold';document.getElementById('policy').onchange({target:"
      "document.getElementById('policy')})");
  EXPECT_EQ(value("seen.controls().at(-1).policy"), "hold");
  value("document.getElementById('off').click()");
  EXPECT_THAT(value("seen.controls().at(-1).select").dump(), HasSubstr("\"on\":false"));
  value("document.querySelector('#fault-cameras input').click()");
  EXPECT_TRUE(becomes_true("touchstoneStation.station.screens.some(screen => screen.failed)"));
}

TEST_F(StationPage, SaysHowFastFullDeflectionIs) {
  open();
  EXPECT_EQ(text("rates"), "Full deflection: 370 mm/s, 4.0°/s");
  browser_->press("KeyV");
  EXPECT_TRUE(
      becomes_true("document.getElementById('rates').textContent === 'Full deflection: 20 mm/s, 0.6°/s'"));
  browser_->press("KeyM");
  EXPECT_TRUE(becomes_true("document.getElementById('rates').textContent === 'Full deflection: 4.0°/s'"));
}

TEST_F(StationPage, KeysDoNotFlyWhileSomethingIsTypedOrTheWindowIsLeft) {
  open();
  value("document.getElementById('instructor').open = true; document.getElementById('fault-late').focus()");
  browser_->press("KeyW");
  browser_->press("KeyW", false);
  value("document.activeElement.blur()");
  browser_->press("KeyA");
  ASSERT_TRUE(becomes_true("seen.inputs().length && seen.inputs().at(-1).translation[1] === 1"));
  EXPECT_EQ(value("seen.inputs().filter(input => input.translation[0]).length"), 0);
  value("dispatchEvent(new Event('blur'))");  // the key's end would go to another window
  EXPECT_TRUE(becomes_true("seen.inputs().at(-1).translation[1] === 0"));
}

TEST_F(StationPage, DebriefsWithPathAndEvents) {
  open();
  value("document.querySelector('[data-command=debrief]').click()");
  ASSERT_TRUE(becomes_true("document.getElementById('debrief').open"));
  EXPECT_THAT(text("debrief-text"), HasSubstr("Touch the wall: done, 3.0 s"));
  // From (-1, 0, 0) by (0, 0.2, 0.1) to (1, 0, 0): 2 * sqrt(1.05) m.
  EXPECT_THAT(text("debrief-text"), HasSubstr("path 2.05 m"));
  EXPECT_THAT(text("debrief-events"), HasSubstr("began arm.tip_lee"));
  EXPECT_EQ(value("document.querySelectorAll('#debrief-path polyline').length"), 2);
}

TEST_F(StationPage, SelectsWhatIsClicked) {
  open();
  const nlohmann::json at = value(
      "(() => { const {station, picture} = touchstoneStation, screen = station.screens[0], box = "
      "screen.element.getBoundingClientRect(), p = picture.place(screen, [0, -0.9, -0.5]); return [box.left "
      "+ "
      "p[0], box.top + p[1]]; })()");
  browser_->click(at[0], at[1]);
  EXPECT_TRUE(becomes_true("document.getElementById('selected').textContent.startsWith('block: free')"));
}

TEST_F(StationPage, DrivesJawsAndChoosesTheArmWhereThereAreSome) {
  open();
  EXPECT_EQ(value("document.getElementById('jaws').hidden && document.getElementById('tips').hidden"), true);
  const std::string tip = "{object: 1, position: [0.2, 0, 0], rotation: [0, 0, 0, 1], jaws: ";
  open("{tips: [" + tip + "[0, 1], name: 'tip_1'}, " + tip + "[], name: 'tip_2'}]}");
  ASSERT_TRUE(becomes_true("!document.getElementById('jaws').hidden"));
  EXPECT_EQ(value("document.getElementById('tip').options.length"), 2);
  browser_->press("KeyQ");
  EXPECT_TRUE(becomes_true("seen.inputs().length && seen.inputs().at(-1).grip === 1"));
  browser_->press("KeyQ", false);
  EXPECT_TRUE(becomes_true("seen.inputs().at(-1).grip === 0"));
  browser_->press("KeyE");
  EXPECT_TRUE(becomes_true("seen.inputs().at(-1).grip === -1"));
  browser_->press("KeyE", false);
  browser_->press("KeyN");
  browser_->press("KeyN", false);
  EXPECT_TRUE(becomes_true("fake.received.some(message => message.tip === 1)"));
  EXPECT_TRUE(becomes_true("document.getElementById('jaws').hidden")) << "the other tip has none";
}

}  // namespace
}  // namespace touchstone::station
