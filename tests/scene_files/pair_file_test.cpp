#include "touchstone/adapters/scene_files/pair_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone {
namespace {

const std::string kBox = R"({"type": "box", "size": [2, 2, 2]})";

std::filesystem::path temporary() {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  return std::filesystem::path(::testing::TempDir()) / (std::string("pairs_") + test->name() + ".json");
}

std::vector<PairCase> loaded(const std::string& text) {
  std::ofstream(temporary()) << text;
  return load_pairs(temporary());
}

std::string file_error(const std::string& text) {
  try {
    loaded(text);
  } catch (const InputError& error) {
    return std::string(error.what()).substr(temporary().string().size());
  }
  return "accepted";
}

// The reason why a case of `shape` and `pose` beside a good box is invalid.
std::string reason(const std::string& shape, const std::string& pose = "\"identity\"") {
  const std::vector<PairCase> cases = loaded(
      "[{\"id\": \"bad\", \"shapes\": [" + kBox + ", " + shape + "], \"poses\": [\"identity\", " + pose +
      "]}, {\"id\": \"good\", \"shapes\": [" + kBox + ", " + kBox + "], \"poses\": \"identity\"}]");
  EXPECT_EQ(cases.size(), 2u);
  EXPECT_TRUE(cases[1].pair.has_value()) << cases[1].invalid_reason;
  EXPECT_EQ(cases[0].pair.has_value(), cases[0].invalid_reason.empty());
  return cases[0].invalid_reason;
}

TEST(PairFile, ReadsBoxesHexahedraAndPoses) {
  const std::vector<PairCase> cases = loaded(
      R"({"cases": [{"id": 7, "shapes": [{"type": "box", "size": [1, 2, 3]},
        {"type": "convex", "vertices": [[0,0,0],[0,0,1],[0,1,0],[0,1,1],[1,0,0],[1,0,1],[1,1,0],[1,1,1]]}],
        "poses": [{"position": [1, 2, 3], "quaternion_wxyz": [2, 0, 0, 0]},
                  {"matrix": [[0,-1,0,4],[1,0,0,5],[0,0,1,6],[0,0,0,1]]}]}]})");
  ASSERT_EQ(cases.size(), 1u);
  EXPECT_EQ(cases[0].id, "7");
  ASSERT_TRUE(cases[0].pair) << cases[0].invalid_reason;
  EXPECT_EQ(cases[0].pair->solids[0].half_extents(), Vector3(0.5, 1, 1.5));
  EXPECT_EQ(cases[0].pair->X_WS[0].R, Matrix3::Identity());
  EXPECT_EQ(cases[0].pair->X_WS[1].p, Vector3(4, 5, 6));
  EXPECT_EQ(cases[0].pair->X_WS[1].R(0, 1), -1.0);
}

std::string one_case(const std::string& shape, const std::string& more = "") {
  return R"([{"id": "k", "shapes": [)" + kBox + ", " + shape + R"(], "poses": "identity")" + more + "}]";
}

TEST(PairFile, AFieldThatNobodyReadsIsRefusedWithFileAndElement) {
  EXPECT_EQ(file_error(one_case(kBox, R"(, "pose": "identity")")),
            ": case 'k': unknown field 'pose'; known: id, shapes, poses, exact, captured, why_hard, "
            "expected_error");
  EXPECT_EQ(file_error(one_case(R"({"type": "box", "size": [1, 1, 1], "margin": 0.1})")),
            ": case 'k': shape 1: unknown field 'margin'; known: type, size");
  EXPECT_EQ(file_error(R"({"cases": [], "unit": "mm"})"), ": unknown field 'unit'; known: units, cases");
  EXPECT_EQ(
      file_error(
          R"([{"id": "k", "shapes": [)" + kBox + ", " + kBox +
          R"(], "poses": ["identity", {"position": [0, 0, 0], "quaternion_wxyz": [1, 0, 0, 0], "rpy": 0}]}])"),
      ": case 'k': pose 1: unknown field 'rpy'; known: position, quaternion_wxyz");
  EXPECT_EQ(file_error(
                one_case(kBox, R"(, "exact": {"class": "touching", "signed_distance": "0", "distance": 0})")),
            ": case 'k': exact: unknown field 'distance'; known: class, signed_distance, normal");
  EXPECT_EQ(file_error(one_case(kBox, R"(, "captured": {"by": "x", "status": "separated", "depth": 0})")),
            ": case 'k': captured: unknown field 'depth'; known: by, status, separation, normal, points");
}

TEST(PairFile, UnitsAreHonouredOrRefused) {
  const std::string in_mm = R"({"units": {"length": "mm"}, "cases": [{"id": "k",
    "shapes": [{"type": "box", "size": [1000, 2000, 3000]},
      {"type": "convex", "vertices": [[0,0,0],[0,0,100],[0,100,0],[0,100,100],[100,0,0],[100,0,100],[100,100,0],[100,100,100]]}],
    "poses": [{"position": [1, 2, 3], "quaternion_wxyz": [1, 0, 0, 0]},
              {"matrix": [[1,0,0,4],[0,1,0,5],[0,0,1,6],[0,0,0,1]]}]}]})";
  const std::vector<PairCase> cases = loaded(in_mm);
  ASSERT_TRUE(cases[0].pair) << cases[0].invalid_reason;
  EXPECT_EQ(cases[0].pair->solids[0].half_extents(), Vector3(0.5, 1, 1.5));
  EXPECT_EQ(cases[0].pair->solids[1].vertices()[7], Vector3(0.1, 0.1, 0.1));
  EXPECT_EQ(cases[0].pair->X_WS[0].p, Vector3(0.001, 0.002, 0.003));
  EXPECT_EQ(cases[0].pair->X_WS[1].p, Vector3(0.004, 0.005, 0.006));
  EXPECT_EQ(cases[0].pair->X_WS[1].R, Matrix3::Identity());
  EXPECT_EQ(file_error(R"({"units": {"length": "ft"}, "cases": []})"),
            ": units: length: unknown unit \"ft\"; known: m, mm");
  EXPECT_EQ(file_error(R"({"units": {"angle": "deg"}, "cases": []})"),
            ": units: unknown field 'angle'; known: length");
  EXPECT_EQ(file_error(R"({"units": "mm", "cases": []})"),
            ": units: expected an object with 'length', got \"mm\"");
  EXPECT_EQ(file_error(R"({"units": {"length": "mm"}, "cases": )" +
                       one_case(kBox, R"(, "exact": {"class": "touching", "signed_distance": "0"})") + "}"),
            ": case 'k': 'exact' is in metres, so that its file's length must be m");
}

// As in scene files: `warped`, and the same default.
TEST(PairFile, BentSolidsAreMarkedAsInSceneFiles) {
  const auto bent = [](const std::string& by, const std::string& mark) {
    return R"({"type": "convex", "vertices": [[0,0,0],[0,0,1],[0,1,0],[0,1,1],[1,0,0],[1,0,1],[1,1,0],[1,1,)" +
           by + "]]" + mark + "}";
  };
  EXPECT_EQ(reason(bent("1.001", "")), "");
  EXPECT_NE(reason(bent("1.001", R"(, "warped": "refuse")")), "");
  EXPECT_NE(reason(bent("1.2", "")), "");
  EXPECT_EQ(reason(bent("1.2", R"(, "warped": "accept")")), "");
  EXPECT_EQ(reason(bent("1.2", R"(, "warped": true)")),
            "shape 1: warped: unknown true; known: refuse, within_tolerance, accept");
}

TEST(PairFile, ABadCaseIsInvalidAndTheRestGoesOn) {
  // Shapes have finite positive sizes or eight vertices.
  EXPECT_EQ(reason(R"({"type": "box", "size": ["NaN", 1, 1]})"), "shape 1: size: not finite: NaN");
  EXPECT_EQ(reason(R"({"type": "box", "size": ["-Infinity", 1, 1]})"),
            "shape 1: size: not finite: -Infinity");
  EXPECT_EQ(reason(R"({"type": "box", "size": ["1", 1, 1]})"), "shape 1: size: expected a number, got \"1\"");
  EXPECT_EQ(reason(R"({"type": "box", "size": [1e400, 1, 1]})"),
            "shape 1: size: beyond the range of a double: 1e400");
  EXPECT_EQ(reason(R"({"type": "box", "size": [-1, 1, 1]})"), "shape 1: size along x is -1, must be > 0");
  EXPECT_EQ(reason(R"({"type": "box", "size": [1, 1]})"), "shape 1: size: expected 3 numbers, got [1,1]");
  EXPECT_EQ(reason(R"({"type": "sphere"})"), "shape 1: unknown type \"sphere\"; known: box, convex");
  EXPECT_EQ(reason(R"({"type": "convex", "vertices": []})"), "shape 1: has 0 vertices, a hexahedron has 8");
  // Poses are rotations and places.
  EXPECT_EQ(reason(kBox, R"({"position": [0, 0, 0]})"), "pose 1: missing 'quaternion_wxyz'");
  EXPECT_EQ(reason(kBox, R"({"position": [0, 0, 0], "quaternion_wxyz": [0, 0, 0, 0]})"),
            "pose 1: the quaternion is zero");
  EXPECT_EQ(reason(kBox, R"({"position": [0, "NaN", 0], "quaternion_wxyz": [1, 0, 0, 0]})"),
            "pose 1: position: not finite: NaN");
  EXPECT_EQ(reason(kBox, R"({"matrix": [[-1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]})"),
            "pose 1: not a rotation: a reflection, determinant -1");
  EXPECT_EQ(reason(kBox, R"({"matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,2]]})"),
            "pose 1: the last row is not 0 0 0 1");
  EXPECT_EQ(reason(kBox, R"({"matrix": [[1,0,0,0],[0,1,0,0]]})"),
            "pose 1: expected 4 rows of 4 numbers, got [[1,0,0,0],[0,1,0,0]]");
  EXPECT_EQ(reason(R"({"type": "box", "size": [1e308, 1, 1]})",
                   R"({"position": [1.7e308, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]})"),
            "pose 1: a world vertex is beyond the range of a double");
}

TEST(PairFile, ACaseWithoutIdOrThatIsNoObjectIsInvalid) {
  const std::vector<PairCase> cases = loaded("[3, {\"shapes\": []}]");
  ASSERT_EQ(cases.size(), 2u);
  EXPECT_EQ(cases[0].invalid_reason, "expected an object, got 3");
  EXPECT_EQ(cases[1].id, "#1");
  EXPECT_EQ(cases[1].invalid_reason, "missing 'id' (text or a whole number)");
}

TEST(PairFile, WarpedIsAcceptedAndFlagged) {
  const std::vector<PairCase> cases = loaded(
      "[{\"id\": \"w\", \"poses\": \"identity\", \"shapes\": [" + kBox +
      R"(, {"type": "convex", "vertices": [[-1,-1,-1],[-1,-1,1],[-1,1,-1],[-1,1,1],[1,-1,-1],[1,-1,1],[1,1,-1],[1,1,1.5]],
        "warped": "accept"}]}])");
  ASSERT_TRUE(cases[0].pair) << cases[0].invalid_reason;
  EXPECT_TRUE(cases[0].pair->solids[1].is_warped());
}

TEST(PairFile, CornersRoundedToThreeDecimalsLoadInAnyOrder) {
  // A cube of edge 2, turned by 30 degrees about z, its corners shuffled.
  const std::vector<PairCase> cases = loaded(
      "[{\"id\": \"w\", \"poses\": \"identity\", \"shapes\": [" + kBox +
      R"(, {"type": "convex", "vertices": [[0.366,1.366,1],[-0.366,-1.366,-1],[1.366,-0.366,1],[-1.366,0.366,-1],
        [0.366,1.366,-1],[-0.366,-1.366,1.001],[1.366,-0.366,-1],[-1.366,0.366,1]]}]}])");
  ASSERT_TRUE(cases[0].pair) << cases[0].invalid_reason;
  EXPECT_TRUE(cases[0].pair->solids[1].is_warped());
  EXPECT_NEAR(cases[0].pair->solids[1].out_of_plane(), 0.25e-3, 1e-5);
}

TEST(PairFile, OnlyTheWholeFileThrows) {
  EXPECT_EQ(file_error("[\n  {\"id\": }\n]").substr(0, 31), ":2:10: malformed JSON: syntax e");
  EXPECT_EQ(file_error("{}"), ": expected a list of cases, or an object with 'cases'");
  EXPECT_EQ(file_error(R"([{"id": "a"}, {"id": "b"}, {"id": "a"}])"),
            ": cases 0 and 2 (counted from 0) have the same id 'a'");
  EXPECT_EQ(file_error("[{\"id\": 1e400, \"x\": }]").substr(0, 20), ":1: malformed JSON: ");
  EXPECT_THROW(load_pairs("/nonexistent/pairs.json"), InputError);
}

TEST(PairFile, RoundTripsBitForBit) {
  // Figures that short texts would round.
  PairCase one;
  one.id = "one \"quoted\"";
  Pose X;
  X.R = rotation_from_quaternion(0.1, 0.7, -0.3, 0.2);
  X.p = {1.0 / 3.0, 1e-300, -2.0e15};
  const std::array<Vector3, 8> wedge = {
      {{0, 0, 0}, {0.1, 0, 1}, {0, 1, 0}, {0.1, 1, 1}, {1, 0, 0}, {0.7, 0, 1}, {1, 1, 0}, {0.7, 1, 1}}};
  one.pair =
      PosedPair{{Hexahedron::from_size({0.1, 1e-9, 3e7}), Hexahedron::from_vertices(wedge)}, {Pose{}, X}};
  one.exact =
      ExactAnswer{PairClass::separated, "1.000000000000000000000000000000001e-3", Vector3(0.6, 0.8, 0)};
  one.why_hard = "made up";
  save_pairs(temporary(), std::array{one});
  // Every bit comes back.
  const std::vector<PairCase> back = load_pairs(temporary());
  ASSERT_EQ(back.size(), 1u);
  ASSERT_TRUE(back[0].pair) << back[0].invalid_reason;
  EXPECT_EQ(back[0].id, one.id);
  EXPECT_EQ(back[0].why_hard, one.why_hard);
  for (int s = 0; s < 2; ++s) {
    EXPECT_EQ(back[0].pair->solids[s].vertices(), one.pair->solids[s].vertices());
    EXPECT_EQ(back[0].pair->X_WS[s].R, one.pair->X_WS[s].R);
    EXPECT_EQ(back[0].pair->X_WS[s].p, one.pair->X_WS[s].p);
  }
  EXPECT_EQ(back[0].exact->pair_class, PairClass::separated);
  EXPECT_EQ(back[0].exact->signed_distance, one.exact->signed_distance);
  EXPECT_EQ(*back[0].exact->normal, *one.exact->normal);
}

TEST(PairFile, SavesNothingWhenACaseIsInvalid) {
  std::filesystem::remove(temporary());
  EXPECT_THROW(save_pairs(temporary(), std::array{PairCase{}}), InputError);
  EXPECT_FALSE(std::filesystem::exists(temporary()));
}

// Replaced, both would be one and the file could not be read again.
TEST(PairFile, IdsThatAreNoTextAreNotSaved) {
  std::vector<PairCase> cases =
      loaded("[{\"id\": \"a\", \"shapes\": [" + kBox + ", " + kBox + "], \"poses\": \"identity\"}]");
  cases.push_back(cases[0]);
  cases[1].id = "\xff";
  try {
    pairs_text(cases);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "case #1: its id is no UTF-8 and cannot be saved");
  }
  cases[1].id = "\u00e9";
  cases[0].why_hard = "\xff";
  save_pairs(temporary(), cases);
  EXPECT_EQ(load_pairs(temporary())[1].id, "\u00e9");
}

}  // namespace
}  // namespace touchstone
