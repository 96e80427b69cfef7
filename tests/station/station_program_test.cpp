#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <regex>

#include "touchstone/tests/support/program_test.hpp"

// touchstone_station as a user runs it.

namespace touchstone {
namespace {

class StationProgram : public ProgramTest {
 protected:
  StationProgram() : ProgramTest(TOUCHSTONE_STATION) {}

  /// From a signal to the end. A second is promised to who has the machine for himself: it is recorded.
  static void expect_soon(double seconds) {
    RecordProperty("ms_from_signal_to_end", static_cast<int>(1e3 * seconds));
    EXPECT_LT(seconds, 10.0);
  }
};

/// The last frame that a station has flown, whose address is in what it printed; 0: none yet.
int frame_of(const std::string& printed) {
  std::smatch found;
  if (!std::regex_search(printed, found, std::regex("http://(127.0.0.1:([0-9]+))/"))) return 0;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(found[2])));
  const int connection = socket(AF_INET, SOCK_STREAM, 0);
  std::string answer;
  if (connect(connection, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0) {
    const std::string request = "GET /status.json HTTP/1.1\r\nHost: " + found[1].str() + "\r\n\r\n";
    send(connection, request.data(), request.size(), MSG_NOSIGNAL);
    std::array<char, 2048> bytes{};
    for (ssize_t got = 0; (got = recv(connection, bytes.data(), bytes.size(), 0)) > 0;)
      answer.append(bytes.data(), static_cast<std::size_t>(got));
  }
  close(connection);
  return std::regex_search(answer, found, std::regex("\"frame\":([0-9]+)")) ? std::stoi(found[1]) : 0;
}

TEST_F(StationProgram, RecordsAFlightThatReplaysToTheSameBits) {
  const std::string file = (folder_ / "flight.jsonl").string();
  const Outcome flown = run("--port 0 --seconds 0.5 --record " + file);
  ASSERT_EQ(flown.code, 0) << flown.err;
  EXPECT_EQ(flown.out.rfind("http://127.0.0.1:", 0), 0U) << flown.out;
  const Outcome replayed = run("--replay " + file);
  EXPECT_EQ(replayed.code, 0) << replayed.err << replayed.out;
  EXPECT_NE(replayed.out.find("the same bits as recorded"), std::string::npos) << replayed.out;
  EXPECT_NE(replayed.out.find("frames 25, hash "), std::string::npos) << replayed.out;
}

TEST_F(StationProgram, AFlightWithDynamicsReplaysToTheSameBits) {
  const std::string file = (folder_ / "flight.jsonl").string();
  ASSERT_EQ(run("--port 0 --seconds 0.5 --dynamics --record " + file).code, 0);
  EXPECT_NE(read(file).find("\"dynamics\":true"), std::string::npos);
  const Outcome replayed = run("--replay " + file);
  EXPECT_EQ(replayed.code, 0) << replayed.err << replayed.out;
  EXPECT_NE(replayed.out.find("the same bits as recorded"), std::string::npos) << replayed.out;
  EXPECT_EQ(
      run("--port 0 --seconds 0.1 --dynamics --scene " TRAINING_SCRIPTS "/03_oru_by_arm_slide.yaml").err,
      "touchstone_station: --dynamics: the scene '03_oru_by_arm_slide' has none (dynamics with a guard)\n");
}

TEST_F(StationProgram, AReplayFindsTheSceneOfTheFlightAndSaysWhereItsFilesChanged) {
  const std::string blocks = R"(name: blocks
frame_rate: 50
duration: 60
contact_gap: 1.0e-6
policy: slide
objects:
  - {name: a, pose: {position: [0, 0, 0]}, hexahedra: [{name: s, box: {size: [1, 1, 1]}}]}
)";
  write("own_scene.yaml", blocks);
  const std::string script = write("own.yaml",
                                   "name: own\nscene: {file: own_scene.yaml}\nduration: 60\nhands: [{object: "
                                   "a, rates: [{time: 0}]}]\n")
                                 .string();
  const std::string file = (folder_ / "flight.jsonl").string();
  ASSERT_EQ(run("--port 0 --seconds 0.1 --scene " + script + " --record " + file).code, 0);
  Outcome replayed = run("--replay " + file);
  EXPECT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_EQ(replayed.out.find("are others"), std::string::npos) << replayed.out;
  write("own_scene.yaml", blocks + "# changed\n");
  replayed = run("--replay " + file);
  EXPECT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_NE(replayed.out.find("are others than when it was recorded"), std::string::npos) << replayed.out;
}

#ifdef TOUCHSTONE_ROBOTS
TEST_F(StationProgram, AFlightOfARobotReplaysToTheSameBits) {
  const std::string file = (folder_ / "robot.jsonl").string();
  const Outcome flown = run("--port 0 --soak --seconds 0.5 --over box --record " + file +
                            " --robot " TOUCHSTONE_ROBOTS "/mesh_arm/urdf/mesh_arm.urdf");
  ASSERT_EQ(flown.code, 0) << flown.err;
  EXPECT_NE(flown.out.find("boom.stl, 28 triangles, is 1 hexahedron"), std::string::npos) << flown.out;
  Outcome replayed = run("--over box --replay " + file);
  EXPECT_EQ(replayed.code, 0) << replayed.err << replayed.out;
  EXPECT_NE(replayed.out.find("the same bits as recorded"), std::string::npos) << replayed.out;
  EXPECT_EQ(replayed.out.find("are others"), std::string::npos) << replayed.out;
  // The rates that it names are flown; without them the SSRMS's, as before there were others.
  const std::string flight = read(file);
  const std::size_t end = flight.find('\n'), rates = flight.find(R"("rates":{"mesh_arm":)");
  ASSERT_LT(rates, end) << flight.substr(0, end);
  const std::size_t next = flight.find("}},", rates + 40);
  ASSERT_LT(next, end) << flight.substr(0, end);
  const std::string older = flight.substr(0, rates) + flight.substr(next + 3);
  replayed = run("--over box --replay " + write("older.jsonl", older).string());
  EXPECT_NE(replayed.out.find("NOT the bits recorded"), std::string::npos) << replayed.out << replayed.err;
  // The earlier recording may be opened beside it.
  ASSERT_EQ(run("--over box --replay " + file + " --poses " + folder_.string()).code, 0);
  const Outcome opened = run("--over box --port 0 --seconds 0.1 --open " + (folder_ / "robot.csv").string() +
                             " --of " TOUCHSTONE_ROBOTS "/mesh_arm/urdf/mesh_arm.urdf");
  EXPECT_EQ(opened.code, 0) << opened.err;
  // Covered otherwise it is another robot.
  replayed = run("--over 20% --replay " + file);
  EXPECT_NE(replayed.out.find("are others than when it was recorded"), std::string::npos) << replayed.out;
}

TEST_F(StationProgram, ARobotWhoseNameIsNoUtf8ReplaysFromItsRecordingAlone) {
  const std::filesystem::path robot = folder_ / "arm \xe9 \xff.urdf";
  std::filesystem::copy_file(TOUCHSTONE_ROBOTS "/arm.urdf", robot);
  const std::string file = (folder_ / "robot.jsonl").string();
  const Outcome flown =
      run("--port 0 --soak --seconds 0.3 --record " + file + " --robot '" + robot.string() + "'");
  ASSERT_EQ(flown.code, 0) << flown.err;
  EXPECT_NE(read(file).find("\"scene\":\"arm %e9 %ff\""), std::string::npos) << read(file).substr(0, 300);
  const Outcome replayed = run("--replay " + file);
  EXPECT_EQ(replayed.code, 0) << replayed.err << replayed.out;
  EXPECT_NE(replayed.out.find("the same bits as recorded"), std::string::npos) << replayed.out;
}

TEST_F(StationProgram, TwoScenesOfOneNameAreRefused) {
  const std::filesystem::path other = folder_ / "mesh_arm.yaml";
  std::ofstream(other) << "name: never read\n";
  expect_refusal(
      "--list --scene " + other.string() + " --robot " TOUCHSTONE_ROBOTS "/mesh_arm/urdf/mesh_arm.urdf",
      {"is a scene of the same name"});
}
#endif

TEST_F(StationProgram, AReplayRefusesWhatTheRecordingSays) {
  const std::string file = (folder_ / "flight.jsonl").string();
  ASSERT_EQ(run("--port 0 --seconds 0.1 --record " + file).code, 0);
  for (const char* option : {"--rate 100", "--methods 3", "--dynamics", "--seconds 1", "--port 0"}) {
    const Outcome outcome = run("--replay " + file + " " + option);
    EXPECT_EQ(outcome.code, 2) << option;
    EXPECT_EQ(outcome.err.rfind("touchstone_station: --", 0), 0U) << outcome.err;
  }
  const std::string bad = write("bad.jsonl", "{\"station\": \"one\"}\n").string();
  EXPECT_NE(run("--replay " + bad).err.find("bad.jsonl:1: no recording"), std::string::npos);
}

TEST_F(StationProgram, EndsAfterAFrameOfHoweverLittleTime) {
  const auto never = [](const std::string&) { return false; };
  const auto [outcome, seconds] = run_until("--port 0 --seconds 0.001", never, SIGINT);
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.out.find("frames 1,"), std::string::npos) << outcome.out;
}

TEST_F(StationProgram, AReplayWritesTheRecordAndAnimationOfItsFlight) {
  const std::string file = (folder_ / "flight.jsonl").string(), out = (folder_ / "poses").string();
  ASSERT_EQ(run("--port 0 --seconds 0.2 --scene grapple --record " + file).code, 0);
  const Outcome replayed = run("--replay " + file + " --poses " + out + " --gltf " + out);
  ASSERT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_NE(replayed.out.find("11 of 11 frames delivered"), std::string::npos) << replayed.out;
  EXPECT_NE(read(out + "/flight.csv").find("ssrms.tip_lee"), std::string::npos);
  EXPECT_NE(read(out + "/flight.gltf").find("ssrms.tip_lee"), std::string::npos);
}

/// A port on this machine that counts the datagrams that come to it.
class Receiver {
 public:
  Receiver() : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    port_ = std::to_string(ntohs(address.sin_port));
  }
  ~Receiver() { close(socket_); }
  std::string address() const { return "127.0.0.1:" + port_; }
  int count() const {
    std::array<char, 2048> bytes{};
    int datagrams = 0;
    while (recv(socket_, bytes.data(), bytes.size(), 0) > 0) ++datagrams;
    return datagrams;
  }

 private:
  int socket_;
  std::string port_;
};

TEST_F(StationProgram, ALiveFlightIsShownAsItsReplayIs) {
  const std::string file = (folder_ / "flight.jsonl").string(), live = (folder_ / "live").string(),
                    later = (folder_ / "later").string();
  const Receiver receiver;
  const Outcome flown = run("--port 0 --seconds 0.5 --soak --scene grapple --record " + file + " --poses " +
                            live + " --gltf " + live + " --cigi " + receiver.address());
  ASSERT_EQ(flown.code, 0) << flown.err;
  EXPECT_NE(flown.out.find("record: 26 of 26 frames delivered, 0 dropped\n"), std::string::npos) << flown.out;
  EXPECT_NE(flown.out.find("cigi " + receiver.address() + ": 26 of 26 frames delivered, 0 dropped\n"),
            std::string::npos)
      << flown.out;
  EXPECT_NE(flown.out.find("gltf: written\n"), std::string::npos) << flown.out;
  EXPECT_EQ(receiver.count(), 26);
  ASSERT_EQ(run("--replay " + file + " --poses " + later + " --gltf " + later).code, 0);
  const std::string record = read(live + "/flight.csv");
  EXPECT_NE(record.find("ssrms.tip_lee"), std::string::npos);
  EXPECT_EQ(record, read(later + "/flight.csv"));
  EXPECT_EQ(read(live + "/flight.gltf"), read(later + "/flight.gltf"));
}

TEST_F(StationProgram, SaysThatNobodyListensWhereItSends) {
  std::string nowhere;
  {
    const Receiver gone;
    nowhere = gone.address();
  }
  const Outcome flown = run("--port 0 --seconds 0.5 --scene grapple --cigi " + nowhere);
  ASSERT_EQ(flown.code, 0) << flown.err;
  EXPECT_NE(flown.out.find(" errors, the last: Connection refused\n"), std::string::npos) << flown.out;
}

TEST_F(StationProgram, ASignalEndsAFlightWithOutputs) {
  const std::string file = (folder_ / "flight.jsonl").string(), live = (folder_ / "live").string();
  const Receiver receiver;
  int datagrams = 0;
  const auto is_shown = [&](const std::string&) { return (datagrams += receiver.count()) > 10; };
  const auto [outcome, seconds] = run_until("--port 0 --soak --scene grapple --record " + file + " --poses " +
                                                live + " --gltf " + live + " --cigi " + receiver.address(),
                                            is_shown, SIGINT);
  EXPECT_EQ(outcome.code, 130) << outcome.err;
  expect_soon(seconds);
  EXPECT_NE(outcome.err.find("frames delivered, 0 dropped\ncigi "), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("gltf: not written"), std::string::npos) << outcome.err;
  EXPECT_GT(datagrams, 10);
  EXPECT_FALSE(std::filesystem::exists(live + "/flight.gltf"));
  // The record is whole: its end names as many frames as were delivered.
  const std::string later = (folder_ / "later").string();
  ASSERT_EQ(run("--replay " + file + " --poses " + later).code, 0);
  EXPECT_EQ(read(live + "/flight.csv"), read(later + "/flight.csv"));
}

TEST_F(StationProgram, APipeThatNobodyReadsLosesFramesAndHoldsUpNothing) {
  const std::filesystem::path live = folder_ / "live", pipe = live / "grapple.csv";
  std::filesystem::create_directory(live);
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  const auto has_flown = [](const std::string& printed) { return frame_of(printed) > 3000; };
  const auto [outcome, seconds] = run_until(
      "--port 0 --rate 1000 --methods 3 --scene grapple --poses " + live.string(), has_flown, SIGINT);
  close(reader);
  EXPECT_EQ(outcome.code, 130) << outcome.err;
  expect_soon(seconds);
  std::smatch found;
  const std::regex line("record: ([0-9]+) of ([0-9]+) frames delivered, ([0-9]+) dropped");
  ASSERT_TRUE(std::regex_search(outcome.err, found, line)) << outcome.err;
  const int offered = std::stoi(found[2]), dropped = std::stoi(found[3]);
  EXPECT_EQ(std::stoi(found[1]) + dropped, offered);
  EXPECT_GT(dropped, 0);
  EXPECT_GT(offered, 3000) << "the loop waited";
}

TEST_F(StationProgram, SaysHowLongAFlightTookStageByStage) {
  const Outcome flown = run("--port 0 --seconds 1 --soak");
  ASSERT_EQ(flown.code, 0) << flown.err;
  EXPECT_TRUE(std::regex_search(flown.out, std::regex("deadlines missed [0-9]+ of 50; a step: median")))
      << flown.out;
  std::smatch found;
  ASSERT_TRUE(
      std::regex_search(flown.out, found, std::regex("hands that were obeyed: ([0-9]+), above 150 ms")))
      << flown.out;
  EXPECT_GT(std::stoi(found[1]), 10);
  EXPECT_NE(flown.out.find("no page drew what it flew\n"), std::string::npos) << flown.out;
}

TEST_F(StationProgram, OpensOnlyRecordsOfTheSceneThatIsNamed) {
  const std::string file = (folder_ / "flight.jsonl").string(), out = (folder_ / "poses").string();
  const std::string scenes = STATION_SCENES, fly = "--port 0 --seconds 0.1 ";
  ASSERT_EQ(run(fly + "--scene grapple --record " + file).code, 0);
  ASSERT_EQ(run("--replay " + file + " --poses " + out).code, 0);
  const std::string record = fly + "--open " + out + "/flight.csv", of = " --of " + scenes;
  const Outcome opened = run(record + of + "/grapple.yaml");
  EXPECT_EQ(opened.code, 0) << opened.err;
  EXPECT_EQ(run(record).err, "touchstone_station: --open needs --of SCENE: records have no solids\n");
  EXPECT_EQ(run(fly + of + "/grapple.yaml").code, 2);
  EXPECT_EQ(run("--replay " + file + " --open " + out + "/flight.csv" + of + "/grapple.yaml").code, 2);

  expect_refusal(record + of + "/otcm.yaml", {"otcm.yaml: has no object '"});
  expect_refusal(record + of + "/nothing.yaml", {"nothing.yaml: cannot be read"});
  expect_refusal(fly + "--open nothing.csv" + of + "/grapple.yaml", {"nothing.csv"});
  expect_refusal(fly + "--open " + file + of + "/grapple.yaml", {"no record"});
  expect_refusal(fly + "--open " + out + of + "/grapple.yaml", {"cannot be opened"});
}

TEST_F(StationProgram, ASignalEndsItAndItsRecordingIsWhole) {
  const std::string file = (folder_ / "flight.jsonl").string();
  const auto flies = [](const std::string& printed) { return frame_of(printed) > 10; };
  const auto [outcome, seconds] = run_until("--port 0 --record " + file, flies, SIGINT);
  EXPECT_EQ(outcome.code, 130) << outcome.err;
  expect_soon(seconds);
  EXPECT_EQ(run("--replay " + file).code, 0);
}

TEST_F(StationProgram, OverwritesNoRecording) {
  const std::string file = write("flight.jsonl", "of another\n").string();
  expect_refusal("--port 0 --seconds 0.1 --record " + file, {"is not overwritten"});
  EXPECT_EQ(read(file), "of another\n");
}

TEST_F(StationProgram, FliesTheFileThatIsGivenNotTheBundledSceneOfItsName) {
  const std::string file = write("worksite.yaml", "name: none\n").string();
  const Outcome outcome = run("--port 0 --seconds 0.1 --scene " + file);
  EXPECT_EQ(outcome.code, 2);
  const std::string list = run("--list --scene " + std::string(STATION_SCENES) + "/worksite.yaml").out;
  EXPECT_EQ(list.find("worksite"), list.rfind("\nworksite") + 1) << list;
}

TEST_F(StationProgram, FliesAtTenAndAtAThousandFramesASecond) {
  EXPECT_NE(run("--port 0 --rate 10 --seconds 0.5").out.find("frames 5, hash "), std::string::npos);
  EXPECT_NE(run("--port 0 --rate 1000 --seconds 0.05").out.find("frames 50, hash "), std::string::npos);
  for (const char* rate : {"9", "1001", "0", "-50", "nan"}) {
    expect_refusal(std::string("--port 0 --seconds 0.1 --rate ") + rate, {"rate"});
  }
}

TEST_F(StationProgram, SaysThatAPortIsTakenAndWhatToDo) {
  const int taken = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  ASSERT_EQ(bind(taken, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(listen(taken, 1), 0);
  getsockname(taken, reinterpret_cast<sockaddr*>(&address), &size);
  const std::string port = std::to_string(ntohs(address.sin_port));
  const Outcome outcome = run("--seconds 0.1 --port " + port);
  close(taken);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(outcome.err, "touchstone_station: 127.0.0.1:" + port +
                             ": Address already in use; --port 0 takes a free one\n");
}

TEST_F(StationProgram, ABrokenSceneFileIsNamedWithItsLine) {
  const std::string file = write("own.yaml", "name: own\nscene: {file: [\n").string();
  expect_refusal("--port 0 --seconds 0.1 --scene " + file, {"touchstone_station: " + file});
}

TEST_F(StationProgram, SaysInOneLineWhatItCannotDo) {
  EXPECT_EQ(run("--scene nowhere --port 0").err,
            "touchstone_station: there is no scene 'nowhere': see --list\n");
  EXPECT_EQ(run("--port 0 --seconds 0.1 --gltf " + (folder_ / "gltf").string()).err,
            "touchstone_station: --gltf: is written from records; give --poses too\n");
  EXPECT_EQ(run("--port 0 --seconds 0.1 --poses /dev/null/x")
                .err.rfind("touchstone_station: --poses /dev/null/x: ", 0),
            0U);
  EXPECT_EQ(run("--replay nothing").code, 2);
  EXPECT_EQ(run("--bind elsewhere --port 0").code, 2);
  const std::string list = run("--list").out;
  EXPECT_EQ(list.rfind("worksite", 0), 0U) << list;
}

}  // namespace
}  // namespace touchstone
