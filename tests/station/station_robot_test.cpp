#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "touchstone/contact_core/fit/mesh_distance.hpp"
#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/station/exchange/recording.hpp"
#include "touchstone/examples/station/flight/session.hpp"
#include "touchstone/tests/station/station_scenes.hpp"
#include "touchstone/tests/support/program_test.hpp"

// Robots of others in the station: flown before a block, and pictured by the meshes that their files have.

namespace touchstone::station {
namespace {

constexpr const char* kRobot = TOUCHSTONE_ROBOTS "/mesh_arm/urdf/mesh_arm.urdf";

/// Each mesh in a box of its own; spheres by facets.
SceneRobots in_boxes() {
  SceneRobots robots;
  robots.choices.over = "box";
  robots.choices.sphere_facets = 8;
  return robots;
}

struct Surface {
  std::uint32_t object;
  std::vector<Vector3> corners;
};

/// As protocol.md has them.
std::vector<Surface> surfaces_of(const std::string& bytes) {
  std::size_t at = 4;
  const auto take = [&]<class T>(T value) {
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    at += sizeof(T);
    return value;
  };
  EXPECT_EQ(bytes.substr(0, 4), "TSM1");
  std::vector<Surface> out(take(std::uint32_t{}));
  for (Surface& surface : out) {
    surface.object = take(std::uint32_t{});
    surface.corners.resize(3 * std::size_t{take(std::uint32_t{})});
    for (Vector3& corner : surface.corners)
      for (int axis = 0; axis < 3; ++axis) corner[axis] = static_cast<double>(take(float{}));
  }
  EXPECT_EQ(at, bytes.size());
  return out;
}

Bounds bounds_of(const HexahedronTree& tree) {
  Bounds out;
  for (const PlacedHexahedron& part : tree.solids())
    for (const Vector3& vertex : part.solid.vertices()) out.add(transform(part.X_OS, vertex));
  return out;
}

TEST(StationRobot, IsPicturedByItsMeshesWhereItsHexahedraAre) {
  const auto scene = load_station_scene(kRobot, 50.0, in_boxes());
  EXPECT_EQ(scene->name, "mesh_arm");
  EXPECT_EQ(scene->meshes.triangles, 28U + (28U + 5U * 12U) + 12U);
  std::vector<std::string> names;
  for (const Surface& surface : surfaces_of(scene->meshes.bytes)) {
    names.push_back(scene->setting.object_name(surface.object));
    Bounds mesh;
    for (const Vector3& corner : surface.corners) mesh.add(corner);
    const HexahedronTree& tree = *scene->setting.instance().trees()[surface.object];
    // It is as large as what stands for it: each mesh has a box, and the lower boom's cuff, of which there is
    // no mesh, is shown by its five hexahedra.
    const Bounds cover = bounds_of(tree);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(mesh.low[axis], cover.low[axis] - 1e-6);
      EXPECT_LE(mesh.high[axis], cover.high[axis] + 1e-6);
      if (scene->setting.object_name(surface.object) != "mesh_arm.lower") continue;
      EXPECT_NEAR(mesh.low[axis], cover.low[axis], 0.02);
    }
    if (names.back() == "mesh_arm.upper") {
      EXPECT_NEAR(mesh.low.x(), 0.12, 1e-6);
      EXPECT_NEAR(mesh.high.x(), 0.72, 1e-6);
    }
  }
  EXPECT_THAT(names, testing::ElementsAre("mesh_arm.upper", "mesh_arm.lower", "mesh_arm.hand"));
  const nlohmann::json text = nlohmann::json::parse(scene_json(*scene));
  EXPECT_EQ(text["meshes"]["path"], scene->meshes.path);
  EXPECT_EQ(text["meshes"]["triangles"], 128);
  // Of its reach of 1.6 m or so, stretched out.
  EXPECT_GT(text["view"].get<double>(), 1.0);
  EXPECT_LT(text["view"].get<double>(), 3.6);
}

TEST(StationRobot, ABundledArmHasNoMeshes) {
  const StationScenes scenes = bundled({"grapple"});
  EXPECT_TRUE(scenes[0]->meshes.bytes.empty());
  EXPECT_EQ(scenes[0]->view, 5.0);
  EXPECT_FALSE(nlohmann::json::parse(scene_json(*scenes[0])).contains("meshes"));
}

TEST(StationRobot, MeetsTheBlockAndIsHeldThere) {
  StationScenes scenes;
  scenes.push_back(load_station_scene(kRobot, 50.0, in_boxes()));
  Session session(scenes, 0);
  // Towards the block, as the script's hand would go.
  const HandScript& hand = scenes[0]->setting.script().hands[0];
  const Vector3 way = hand.rates[0].velocity / norm(hand.rates[0].velocity);
  const Pose& X_WO = scenes[0]->setting.scene().objects[scenes[0]->hand_object()].X_WO;
  HandInput input;
  const Vector3 way_T = rotate_back(X_WO.R, way);
  for (int axis = 0; axis < 3; ++axis) input.translation[axis] = way_T[axis];
  bool blocked = false;
  for (int frame = 0; frame < 500 && !blocked; ++frame) {
    session.step(input);
    blocked = session.flight().methods().back().blocked_frames > 0;
  }
  EXPECT_TRUE(blocked);
}

TEST(StationRobot, HandsFollowItsReach) {
  StationScenes scenes = bundled({"grapple"});
  scenes.push_back(load_station_scene(kRobot, 50.0, in_boxes()));
  // Its column and booms are 2.04 m to the hand's origin, all upright; the SSRMS keeps its public figures.
  const HandScales& scales = scenes[1]->scales;
  const double reach = 8.0 * scales.coarse;
  EXPECT_GT(reach, 2.04);
  EXPECT_LT(reach, 2.4);
  EXPECT_NEAR(scales.coarse_turn, 3.14159 / 8.0, 1e-4);
  EXPECT_NEAR(scales.vernier / scales.coarse, 0.02 / 0.37, 1e-12);
  EXPECT_EQ(scenes[0]->scales.coarse, 0.37);
  EXPECT_EQ(nlohmann::json::parse(scene_json(*scenes[1]))["rates"]["coarse"]["translation"], scales.coarse);
  // It goes that fast, and no faster than its joints. Upwards nothing is in its way.
  Session session(scenes, 1);
  session.set({Control::Kind::frame_of_command, true, static_cast<std::uint32_t>(CommandFrame::base)});
  HandInput input;
  input.translation = {0.0, 0.0, 0.3};
  for (int frame = 0; frame < 50; ++frame) session.step(input);
  EXPECT_GT(session.flight().figures().path, 0.1 * scales.coarse);
  EXPECT_LE(session.flight().figures().path, 0.3 * scales.coarse * (1.0 + 1e-6));
}

TEST(StationHandScales, ReachFromATenthToThirtyMetresAndAreNeverFasterThanTheSsrmss) {
  for (const double reach : {0.1, 0.855, 2.96, 3.4, 17.6, 30.0}) {
    const HandScales scales = hand_scales_of(reach);
    EXPECT_EQ(scales.coarse, std::min(0.37, reach / 8.0)) << reach;
    EXPECT_GE(scales.coarse_turn, 0.0698) << reach;
    EXPECT_LE(scales.coarse_turn, 0.3927) << reach;
    EXPECT_LT(scales.vernier, scales.coarse);
    EXPECT_LT(scales.vernier_turn, scales.coarse_turn);
  }
  EXPECT_NEAR(hand_scales_of(0.855).coarse, 0.107, 1e-3);
  EXPECT_NEAR(hand_scales_of(17.6).coarse_turn, 0.0698, 1e-12);
}

TEST(StationHandScales, ReachIsThatOfTheLinksWhateverTheJointsDo) {
  const auto scene = load_station_scene(kRobot, 50.0, in_boxes());
  const Mechanism& arm = *scene->arm()->mechanism;
  const double reach = reach_of(arm);
  // Of drawn poses none is beyond, and some come near.
  std::mt19937_64 random(7);
  std::vector<double> q(arm.value_count());
  std::vector<Pose> X_WL(arm.links().size());
  double farthest = 0.0;
  for (int i = 0; i < 20'000; ++i) {
    for (const Mechanism::Joint& joint : arm.joints())
      if (joint.value != Mechanism::kNone)
        q[joint.value] =
            std::uniform_real_distribution(std::max(joint.lower, -3.0), std::min(joint.upper, 3.0))(random);
    arm.link_poses({}, q, X_WL);
    for (std::uint32_t solid = 0; solid < arm.solids().size(); ++solid)
      for (const Vector3& corner : arm.solids()[solid].vertices())
        farthest = std::max(
            farthest, norm(transform(X_WL[arm.link_of(solid)], transform(arm.placed(solid).X_OS, corner))));
  }
  EXPECT_LE(farthest, reach);
  EXPECT_GT(farthest, 0.9 * reach);
  // A slide adds what it moves.
  MechanismDescription longer = arm.description();
  for (JointDescription& joint : longer.joints)
    if (joint.name == "bend") joint.kind = JointKind::prismatic, joint.lower = -0.5, joint.upper = 0.25;
  EXPECT_NEAR(reach_of(Mechanism(longer)), reach + 0.5, 1e-12);
}

/// A flight upwards of 20 frames, recorded; hash of its poses behind.
std::string recorded_flight(const StationScenes& scenes) {
  Recording header;
  header.scene = scenes[0]->name;
  Recorder recorder(scenes, header);
  Session session(scenes, 0, header.methods);
  const HandInput up{{0.3, 0.0, 0.2}, {0.0, 0.4, 0.0}, 0.0, 0.0};
  recorder.offer({0, up});
  for (int frame = 0; frame < 20; ++frame) session.step(up);
  recorder.end(session.frame(), session.hash());
  return recorder.kept();
}

/// Whether it is replayed to the bits recorded.
bool replays(const std::string& recorded) {
  std::istringstream head(recorded), all(recorded);
  const Recording header = read_header(head, "flight");
  SceneRobots robots = in_boxes();
  robots.recorded = &header.rates;
  StationScenes scenes;
  scenes.push_back(load_station_scene(kRobot, 50.0, robots));
  const Recording recording = read_recording(all, "flight", scenes);
  Session session(scenes, 0, recording.methods);
  replay(recording, session);
  return session.frame() == 20 && hash_text(session.hash()) == recording.hash;
}

TEST(StationRobot, RecordingsReplayAtTheRatesThatTheyWereFlownWith) {
  StationScenes scenes;
  scenes.push_back(load_station_scene(kRobot, 50.0, in_boxes()));
  const std::string now = recorded_flight(scenes);
  EXPECT_TRUE(replays(now));
  // Without rates, as before there were others: the SSRMS's.
  const SceneScales none;
  SceneRobots before = in_boxes();
  before.recorded = &none;
  scenes[0] = load_station_scene(kRobot, 50.0, before);
  EXPECT_EQ(scenes[0]->scales, HandScales{});
  const auto without_rates = [](const std::string& flight) {
    const std::size_t end = flight.find('\n');
    nlohmann::json header = nlohmann::json::parse(flight.substr(0, end));
    header.erase("rates");
    return header.dump() + flight.substr(end);
  };
  EXPECT_TRUE(replays(without_rates(recorded_flight(scenes))));
  EXPECT_FALSE(replays(without_rates(now))) << "rates say nothing";
  // Rates that are none are refused by the header's line.
  std::istringstream bad(R"({"station": 1, "scene": "a", "rate_hz": 50, "methods": 8, "rates": {"a": {}}})");
  EXPECT_THROW(read_header(bad, "flight"), InputError);
}

TEST(StationMeshes, ThoseWithoutRoomAreNamedAndLeftToTheirHexahedra) {
  auto large = std::make_shared<TriangleMesh>();
  large->vertices = {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0)};
  large->triangles.assign(250'000, {0, 1, 2});
  auto small = std::make_shared<TriangleMesh>(*large);
  small->triangles.resize(1);
  const ObjectMeshes placed = place_meshes(
      {{7, {}, small}, {2, {}, small}, {5, {}, large}, {7, {Matrix3::Identity(), {0, 0, 3}}, small}});
  EXPECT_THAT(placed.left_out, testing::ElementsAre(5U));
  EXPECT_THAT(placed.objects, testing::ElementsAre(2U, 7U));
  EXPECT_EQ(placed.triangles, 3U);
  const std::vector<Surface> surfaces = surfaces_of(placed.bytes);
  EXPECT_EQ(surfaces[1].corners[5].z(), 3.0);
}

class StationMeshList : public FolderTest {
 protected:
  StationMeshList() {
    write("scene.yaml", R"(name: Part and block
units: {length: m, angle: deg}
frame_rate: 50
contact_gap: 1e-9
policy: slide
duration: 1
objects:
  - {name: part, pose: {position: [0, 0, 0]}, hexahedra: [{name: s, box: {size: [1, 1, 1]}}]}
  - {name: block, pose: {position: [2, 0, 0]}, hexahedra: [{name: s, box: {size: [1, 1, 1]}}]}
)");
    write("part.stl",
          "solid a\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 10 0 0\nvertex 0 20 0\nendloop\n"
          "endfacet\nendsolid a\n");
    script_ = write("flight.yaml", R"(name: Part
scene: {file: scene.yaml}
policy: slide
duration: 60
hands:
  - {object: block, rates: [{time: 0}]}
)");
  }
  std::string error_of(const std::string& list) const {
    write("flight.meshes.json", list);
    try {
      load_station_scene(script_, 50.0);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  std::filesystem::path script_;
};

TEST_F(StationMeshList, ShowsObjectsByTheirMeshes) {
  write("flight.meshes.json", R"([{"object": "part", "mesh": "part.stl", "metres_per_unit": 0.1}])");
  const auto scene = load_station_scene(script_, 50.0);
  const std::vector<Surface> surfaces = surfaces_of(scene->meshes.bytes);
  ASSERT_EQ(surfaces.size(), 1U);
  EXPECT_EQ(surfaces[0].object, 0U);
  EXPECT_EQ(surfaces[0].corners[1], Vector3(1, 0, 0));
  EXPECT_EQ(surfaces[0].corners[2], Vector3(0, 2, 0));
}

TEST_F(StationMeshList, AMeshThatIsGoneLeavesTheHexahedraAndIsNamed) {
  write("flight.meshes.json", R"([{"object": "part", "mesh": "gone.stl", "metres_per_unit": 0.1}])");
  std::string said;
  const auto scene = load_station_scene(script_, 50.0, {{}, [&](const std::string& text) { said += text; }});
  EXPECT_TRUE(scene->meshes.bytes.empty());
  EXPECT_THAT(said, testing::HasSubstr("there is no file gone.stl: the hexahedra of 'part' are shown"));
}

TEST_F(StationMeshList, NamesWhatItCannotMean) {
  EXPECT_THAT(error_of("[{"), testing::HasSubstr("flight.meshes.json: "));
  EXPECT_THAT(error_of(R"([{"object": "nobody", "mesh": "part.stl", "metres_per_unit": 1}])"),
              testing::HasSubstr("flight.meshes.json: there is no object 'nobody'"));
  EXPECT_THAT(error_of(R"([{"object": "part", "mesh": "part.stl", "metres_per_unit": 1e60}])"),
              testing::HasSubstr("further than 1e15 m"));
  EXPECT_THAT(error_of(R"([{"object": "part", "mesh": "part.stl", "upp": "z"}])"),
              testing::HasSubstr("unknown field 'upp'"));
  EXPECT_THAT(error_of(R"({"object": "part", "mesh": "part.stl"})"), testing::HasSubstr("is no list"));
  EXPECT_THAT(error_of(R"([{"object": "part", "mesh": "part.stl", "metres_per_unit": 1},
                           {"object": "part", "mesh": "part.stl", "metres_per_unit": 1}])"),
              testing::HasSubstr("'part' stands twice"));
  EXPECT_THAT(error_of(R"([{"object": "part", "mesh": "part.stl", "metres_per_unit": 1, "up": "w"}])"),
              testing::HasSubstr("'w' is none of as-written, stated, x, y, z"));
  EXPECT_THAT(error_of(R"([{"object": "part", "mesh": "part.stl"}])"), testing::HasSubstr("part.stl"));
}

TEST(StationRobot, IsAnotherWhereItIsFlownOtherwiseAlone) {
  SceneRobots fitted = in_boxes();
  fitted.choices.over = "25%";
  std::string account;
  fitted.on_account = [&](const std::string& text) { account += text; };
  const std::string files = load_station_scene(kRobot, 50.0, in_boxes())->files;
  EXPECT_NE(load_station_scene(kRobot, 50.0, fitted)->files, files);
  EXPECT_THAT(account, testing::HasSubstr("boom.stl, 28 triangles"));
  // By another path, and without meshes for a picture.
  SceneRobots unseen = in_boxes();
  unseen.shows_meshes = false;
  const auto same = load_station_scene(std::filesystem::proximate(kRobot), 50.0, unseen);
  EXPECT_EQ(same->files, files);
  EXPECT_TRUE(same->meshes.bytes.empty());
}

TEST(StationRobot, RoundedSolidsAreRefusedByName) {
  SceneRobots exact = in_boxes();
  exact.choices.sphere_facets = 0;
  try {
    load_station_scene(kRobot, 50.0, exact);
    FAIL() << "taken";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("shoulder"));
  }
}

}  // namespace
}  // namespace touchstone::station
