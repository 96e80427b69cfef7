// The program as a user runs it.

#include <gmock/gmock.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <thread>

#include "touchstone/tests/support/program_test.hpp"

namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class DynamicsRun : public touchstone::ProgramTest {
 protected:
  DynamicsRun() : ProgramTest(DYNAMICS_RUN) {}
  fs::path report() const { return folder_ / "report"; }
  std::string to_report() const { return " --repetitions 1 --out " + report().string(); }

  /// One line on the error stream, exit code 2, nothing written.
  void expect_refused(const std::string& arguments, const std::string& reason) const {
    expect_refusal(arguments + to_report(), {"dynamics_run: ", reason});
    EXPECT_FALSE(fs::exists(report())) << arguments;
  }
};

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) out.push_back(line);
  return out;
}

std::size_t columns(const std::string& line) {
  return static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) + 1;
}

#ifdef TOUCHSTONE_ROBOTS
/// Half a second of free fall from the middle of its limits: the boom ends lower, and no energy is made.
TEST_F(DynamicsRun, ARobotWithMeshesFalls) {
  const Outcome outcome = run("--robot " TOUCHSTONE_ROBOTS
                              "/mesh_arm/urdf/mesh_arm.urdf --over box --backend native --reference native" +
                              to_report());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("upper/boom: mesh"));
  const json scene = json::parse(read(report() / "results.json"))["scenes"][0];
  EXPECT_EQ(scene["runs"].size(), 1u);
  EXPECT_LT(scene["runs"][0]["energy_made_j"].get<double>(), 1e-9);
  EXPECT_GT(scene["runs"][0]["energy_lost_j"].get<double>(), 1.0);
}

// As of a steering hinge, which has an inertia and no shape: the arm beyond it falls all the same.
TEST_F(DynamicsRun, ARobotFallsOnALinkWithoutHexahedra) {
  const auto link = [](const std::string& name, const std::string& shape) {
    return "<link name='" + name +
           "'><inertial><origin xyz='0.1 0 0'/><mass value='1'/><inertia ixx='0.01' ixy='0' ixz='0' "
           "iyy='0.01' "
           "iyz='0' izz='0.01'/></inertial>" +
           shape + "</link>";
  };
  const auto joint = [](const std::string& name, const std::string& parent, const std::string& child) {
    return "<joint name='" + name + "' type='continuous'><parent link='" + parent + "'/><child link='" +
           child + "'/><origin xyz='0.2 0 0'/><axis xyz='0 1 0'/></joint>";
  };
  const std::string box = "<collision><geometry><box size='0.2 0.1 0.1'/></geometry></collision>";
  const std::filesystem::path file =
      write("hinge.urdf", "<robot name='hinge'>" + link("base", box) + link("hinge", "") + link("boom", box) +
                              joint("steer", "base", "hinge") + joint("turn", "hinge", "boom") + "</robot>");
  const Outcome outcome =
      run("--robot " + file.string() + " --backend native --reference native" + to_report());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const json scene = json::parse(read(report() / "results.json"))["scenes"][0];
  EXPECT_LT(scene["runs"][0]["energy_made_j"].get<double>(), 1e-9);
}
#endif

TEST_F(DynamicsRun, WritesResultsSeriesContactsAndPlots) {
  // A deadline that is kept on a busy machine too.
  const Outcome outcome =
      run("--scene 08_pushed_offset --backend native edge_face --deadline 1" + to_report());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("build on native: within the scene's limits"));
  EXPECT_THAT(outcome.out, HasSubstr("edge_face: not run: "));
  const json results = json::parse(read(report() / "results.json"));
  const json scene = results["scenes"][0];
  EXPECT_EQ(scene["scene"], "08_pushed_offset");
  EXPECT_EQ(scene["build_on"], "native");
  EXPECT_EQ(scene["deadline_us"], 1e6);
  EXPECT_EQ(results["build_on"], "native");
  const json native = scene["runs"][0];
  EXPECT_EQ(native["steps"], 1000);
  for (const json& answer : native["answers"]) EXPECT_EQ(answer["holds"], true) << answer;
  EXPECT_NEAR(native["answers"][0]["found"][0].get<double>(), 2.188, 5e-4);
  EXPECT_GT(native["step_us"]["median"].get<double>(), 0.0);
  EXPECT_GE(native["step_us"]["p99_9"].get<double>(), native["step_us"]["median"].get<double>());
  EXPECT_LT(native["unexplained_momentum_ns"].get<double>(), 1e-14);
  EXPECT_TRUE(native["last"].contains("oru"));
  EXPECT_TRUE(scene["runs"][1].contains("not_run"));

  const std::vector<std::string> table = lines(read(report() / "results.csv"));
  ASSERT_EQ(table.size(), 1 + scene["runs"].size());
  for (const std::string& line : table) EXPECT_EQ(columns(line), columns(table[0])) << line;

  const std::vector<std::string> series = lines(read(report() / "series/08_pushed_offset.native.csv"));
  ASSERT_EQ(series.size(), 1002u);  // header, the start, each step
  EXPECT_THAT(series[0], StartsWith("time_s,momentum_x_ns,"));
  EXPECT_THAT(series[0], HasSubstr(",oru.attitude_w,oru.attitude_x,oru.attitude_y,oru.attitude_z"));
  for (const std::string& line : series) ASSERT_EQ(columns(line), columns(series[0])) << line;
  const std::vector<std::string> contacts = lines(read(report() / "contacts/08_pushed_offset.native.csv"));
  ASSERT_GT(contacts.size(), 500u);  // from a margin before the impact on
  for (const std::string& line : contacts) ASSERT_EQ(columns(line), columns(contacts[0])) << line;
  EXPECT_THAT(contacts.back(), HasSubstr(",oru/body,tip/probe,overlapping,"));
  EXPECT_FALSE(fs::exists(report() / "series/08_pushed_offset.exact.csv"));  // the reference, not asked for

  const std::string plot = read(report() / "plots/08_pushed_offset.svg");
  EXPECT_THAT(plot, StartsWith("<svg "));
  for (const char* panel :
       {"contact force on an object", "momentum, magnitude", "angular momentum", "energy [J]"})
    EXPECT_THAT(plot, HasSubstr(panel));
  EXPECT_EQ(plot.find("nan"), std::string::npos);
}

TEST_F(DynamicsRun, EveryNthStepIsRecordedAndParametersAreSet) {
  const fs::path file = write(
      "fall.yaml",
      "name: fall\nparameters: {push: 0}\nframe_rate: 50\ncontact_gap: 1.0e-9\npolicy: cue\nduration: 0.1\n"
      "objects: [{name: ball, hexahedra: [{name: b, box: {size: [1, 1, 1]}}]}]\n"
      "dynamics:\n  step: 0.001\n  bodies: [{object: ball, kind: dynamic, mass: 1, velocity: [$push, 0, "
      "0]}]\n"
      "  conserved: [momentum, energy]\n"
      "  answers: [{of: ball, figure: velocity, value: [0, 0, 0], tolerance: 1.0e-12}]\n");
  const std::string base = "--scene " + file.string() + " --backend native --reference native";
  ASSERT_EQ(run(base + " --every 30" + to_report()).code, 0);
  EXPECT_EQ(lines(read(report() / "series/fall.native.csv")).size(), 1u + 1u + 3u + 1u);  // the last one, too
  json scene = json::parse(read(report() / "results.json"))["scenes"][0];
  EXPECT_EQ(scene["answers_hold"], true);
  ASSERT_EQ(run(base + " --set push=2" + to_report()).code, 0);
  scene = json::parse(read(report() / "results.json"))["scenes"][0];
  EXPECT_EQ(scene["answers_hold"], false);
  EXPECT_EQ(scene["parameters"]["push"], 2.0);
  EXPECT_EQ(scene["runs"][0]["answers"].size(), 0u);
  EXPECT_NEAR(scene["runs"][0]["last"]["ball"]["p_m"][0].get<double>(), 0.2, 1e-12);
  EXPECT_EQ(scene["runs"][0]["momentum_drift_ns"], 0.0);
}

TEST_F(DynamicsRun, AReferenceThatIsNotRunIsNoReference) {
  const Outcome outcome =
      run("--scene 08_pushed_offset --backend native --reference edge_face" + to_report());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("none is within the scene's limits; it is the least off: no reference"));
  const json scene = json::parse(read(report() / "results.json"))["scenes"][0];
  EXPECT_EQ(scene["runs"][0]["pose_error_m"], nullptr);
}

TEST_F(DynamicsRun, ABodyThatTurnsTooFarStopsTheRunAndIsNamed) {
  const fs::path file = write(
      "spin.yaml",
      "name: spin\nframe_rate: 50\ncontact_gap: 1.0e-9\npolicy: cue\nduration: 0.1\n"
      "objects: [{name: top, hexahedra: [{name: b, box: {size: [1, 1, 1]}}]}]\n"
      "dynamics:\n  step: 0.001\n  bodies: [{object: top, kind: dynamic, mass: 1, turn: [0, 0, 1.0e+6]}]\n");
  const Outcome outcome = run("--scene " + file.string() + " --backend native" + to_report());
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              HasSubstr("native: stopped at 0.000000 s: turn: object 'top': it would turn by more "
                        "than 64 rad in a step"));
  EXPECT_THAT(outcome.out, HasSubstr("build on: none: none went through"));
  const json scene = json::parse(read(report() / "results.json"))["scenes"][0];
  EXPECT_EQ(scene["runs"][0]["steps"], 0);
  EXPECT_EQ(scene["build_on"], nullptr);
}

TEST_F(DynamicsRun, BadOptionsAndInputAreRefusedInOneLine) {
  // Options with no such scene, backend or value are named.
  expect_refused("--scene no_such", "--scene no_such: there is no such scene; --list names them");
  expect_refused("--scene 8 --backend nobody", "nobody");
  expect_refused("--scene 8 --reference nobody", "nobody");
  expect_refused("--scene 8 --every 0", "--every");
  expect_refused("--scene 8 --deadline 0", "--deadline");
  expect_refused("--scene 8 --set speed", "--set 'speed': expected NAME=VALUE");
  expect_refused("--scene 8 --set speed=fast", "--set 'speed=fast': the value is no finite number");
  expect_refused("--scene 08_pushed_centred --set speed=1", "the scene has no parameter 'speed'");
  expect_refused("--scenes " + (folder_ / "nowhere").string(), "cannot be read");
  expect_refused("--nonsense", "--nonsense");
  // Files are named with the line that is wrong.
  const fs::path bad =
      write("bad.yaml",
            "name: bad\nframe_rate: 50\ncontact_gap: 1.0e-9\npolicy: cue\nduration: 1\n"
            "objects: [{name: o, hexahedra: [{name: b, box: {size: [1, 1, 1]}}]}]\n"
            "dynamics:\n  step: 0.001\n  bodies:\n    - {object: o, kind: dynamic, mass: -3}\n");
  expect_refused("--scene " + bad.string(), bad.string() + ":10: object 'o': the mass is -3");
  const fs::path massless =
      write("massless.yaml",
            "name: massless\nframe_rate: 50\ncontact_gap: 1.0e-9\npolicy: cue\nduration: 1\n"
            "objects: [{name: o, hexahedra: [{name: b, box: {size: [1, 1, 1]}}]}]\n"
            "dynamics:\n  step: 0.001\n  bodies: [{object: o, mass: 0}]\n  mechanisms:\n    - name: m\n"
            "      joints: [{name: j, kind: revolute, child: o, position: [0, 0, 0], axis: [0, 0, 1]}]\n");
  expect_refused("--scene " + massless.string(),
                 massless.string() + ":11: mechanism 'm', joint 'j': nothing with inertia moves with it");
  expect_refused("--scene 08_pushed_offset 8", "--scene: '08_pushed_offset' is given twice");
}

TEST_F(DynamicsRun, NothingOfAnybodyElsesIsReplaced) {
  expect_files_of_others_are_kept(
      "--scene 08_pushed_offset --backend native --every 100 --repetitions 1 --out ",
      {"results.json", "results.csv", "series/08_pushed_offset.native.csv",
       "contacts/08_pushed_offset.native.csv", "plots/08_pushed_offset.svg"});
}

TEST_F(DynamicsRun, ListsScenesAndBackendsAndHelps) {
  const Outcome list = run("--list");
  EXPECT_EQ(list.code, 0);
  for (const char* name : {"08_pushed_centred", "09_backdriven_16t", "native"})
    EXPECT_THAT(list.out, HasSubstr(name));
  const auto row = [&](const std::string& feature) {
    const std::size_t start = list.out.find("\n  " + feature + "  ");
    return start == std::string::npos ? "" : list.out.substr(start, list.out.find('\n', start + 1) - start);
  };
  EXPECT_THAT(row("hexahedra that are no boxes"), HasSubstr("yes"));
  EXPECT_THAT(row("inertia of rotors"), HasSubstr("yes"));
  if (list.out.find("\n  ode  ") != std::string::npos) {
    EXPECT_THAT(row("hexahedra that are no boxes"), HasSubstr("ours"));  // of any narrowphase
    EXPECT_THAT(row("latches"), HasSubstr("-"));
  }
  const Outcome help = run("--help");
  EXPECT_EQ(help.code, 0);
  EXPECT_THAT(help.out, HasSubstr("--backend"));
}

std::string falling(const std::string& duration) {
  return "name: long\nframe_rate: 50\ncontact_gap: 1.0e-9\npolicy: cue\nduration: " + duration +
         "\nobjects: [{name: o, hexahedra: [{name: b, box: {size: [1, 1, 1]}}]}]\n"
         "dynamics: {step: 0.001, bodies: [{object: o, kind: dynamic, mass: 1}]}\n";
}

TEST_F(DynamicsRun, AnInterruptBeforeAnythingIsMeasuredLeavesNoReport) {
  // More steps than any machine does before the signal; timeout passes its code on.
  const fs::path file = write("long.yaml", falling("10000"));
  const fs::path out = folder_ / "interrupted";
  const std::string command = std::string("timeout --preserve-status -s INT 0.5 ") + DYNAMICS_RUN +
                              " --scene " + file.string() + " --backend native --every 1000000 --out " +
                              report().string() + " >" + out.string() + " 2>&1";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_THAT(read(out), HasSubstr("interrupted: no report was written"));
  EXPECT_FALSE(fs::exists(report()));
}

TEST_F(DynamicsRun, AnInterruptLeavesAPartialReportOfTheRunsThatAreDone) {
  write("a.yaml", falling("0.1"));
  write("b.yaml", falling("10000"));
  const auto [outcome, seconds] =
      run_until("--scene " + (folder_ / "a.yaml").string() + " " + (folder_ / "b.yaml").string() +
                    " --backend native edge_face --reference native --every 1000000" + to_report(),
                std::chrono::milliseconds(1000), SIGTERM);
  EXPECT_EQ(outcome.code, 143) << outcome.err;
  EXPECT_LT(seconds, 1.0);
  EXPECT_THAT(outcome.err, HasSubstr("interrupted: what was measured so far is a partial report: "));
  const json results = json::parse(read(report() / "results.json"));
  EXPECT_EQ(results["partial"], true);
  EXPECT_EQ(results["not_measured"], json({"b"}));
  ASSERT_EQ(results["scenes"].size(), 1u);
  EXPECT_EQ(results["scenes"][0]["reason"], "nothing touches: every backend would do");
  EXPECT_EQ(results["build_on"], nullptr);
  EXPECT_EQ(results["reason"], "the run ended before all scenes were done");
  for (const std::string& line : lines(read(report() / "results.csv")))
    EXPECT_TRUE(line.ends_with(",partial") || line.ends_with(",1")) << line;
  EXPECT_TRUE(fs::exists(report() / "series/a.native.csv"));
}

TEST_F(DynamicsRun, AStepThatTakesLongerThanTheDeadlineIsSaidAndScenesHaveOneVerdict) {
  const fs::path file = write("fall.yaml", falling("0.1"));
  const Outcome outcome = run("--scene 08_pushed_offset " + file.string() +
                              " --backend native --reference native --deadline 1e-9" + to_report());
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("build on native: none keeps the deadline of 0.001 us at 99.9 %; "));
  EXPECT_THAT(outcome.out, HasSubstr("no verdict: nothing touches: every backend would do"));
  EXPECT_THAT(outcome.out,
              HasSubstr("over all 2 scenes build on native: none keeps every deadline, it is late in 1"));
  const json results = json::parse(read(report() / "results.json"));
  EXPECT_EQ(results["scenes"][0]["runs"][0]["late"], true);
  EXPECT_EQ(results["scenes"][1]["build_on"], nullptr);
  EXPECT_EQ(results["build_on"], "native");
}

TEST_F(DynamicsRun, ASceneOfMoreStepsThanThereIsRoomForIsRefusedByFile) {
  const fs::path endless = write("endless.yaml", falling("1.0e+9"));
  expect_refused("--scene 8 " + endless.string(), endless.string() + ": ");
  for (const char* duration : {"900000", "20000"}) {
    const fs::path file = write("long.yaml", falling(duration));
    expect_refused("--scene 8 " + file.string(), file.string() + ": a duration of ");
  }
  const fs::path file = write("long.yaml", falling("5000"));
  expect_refused("--scene " + file.string(), file.string() + ": 5e+06 steps of 1 objects and joints");
}

}  // namespace
