#include <gmock/gmock.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/run/shards/shard_file.hpp"
#include "touchstone/examples/measures/pairs/pair_families.hpp"
#include "touchstone/examples/program/files/sha256.hpp"
#include "touchstone/tests/support/program_test.hpp"

// Runs whose pairs are cut into shards: together they are the run that is not cut, but for times.

namespace {

namespace fs = std::filesystem;
namespace comparison = touchstone::comparison;
using ::testing::HasSubstr;
using Json = nlohmann::ordered_json;
using touchstone::measures::PairSet;

constexpr const char* kPairs = R"([
  {"id": "apart", "shapes": [{"type": "box", "size": [1, 1, 1]}, {"type": "box", "size": [1, 1, 1]}],
   "poses": ["identity", {"position": [1.5, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]}]},
  {"id": "no pair", "shapes": [{"type": "box", "size": [1, 1, 0]}, {"type": "box", "size": [1, 1, 1]}],
   "poses": ["identity", "identity"]},
  {"id": "flush", "shapes": [{"type": "box", "size": [1, 1, 1]}, {"type": "box", "size": [2, 1, 1]}],
   "poses": ["identity", {"position": [1.5, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]}]},
  {"id": "deep", "shapes": [{"type": "box", "size": [1, 1, 1]}, {"type": "box", "size": [2, 1, 1]}],
   "poses": ["identity", {"position": [0.25, 0, 0], "quaternion_wxyz": [0.8, 0.6, 0, 0]}]}])";

/// Takes times and the day out, and what is decided by them.
void drop_times(Json& json) {
  for (const char* timed : {"single", "batch", "raw", "cached", "frame", "ns", "p999_ns", "mean_ns",
                            "pareto_front", "thread_runs", "fitted_slopes", "date"})
    if (json.is_object() && json.contains(timed)) json.erase(timed);
  if (json.is_object() && json.contains("standings"))
    std::sort(json["standings"].begin(), json["standings"].end());
  for (Json& each : json)
    if (each.is_structured()) drop_times(each);
}

class Shards : public touchstone::ProgramTest {
 protected:
  Shards() : ProgramTest(COMPARE_BACKENDS) { write("pairs.json", kPairs); }

  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  /// More than kConsistencyCases pairs of a family, so that the cut goes through those, too.
  std::string asked() const {
    return "--families random touching --count 2100 --repetitions 1 --no-broadphase --backend native "
           "edge_face --pairs " +
           at("pairs.json");
  }
  std::string small() const {
    return "--families touching --count 30 --repetitions 1 --no-broadphase --backend native";
  }
  std::string shard(const std::string& what, const std::string& shard, const std::string& folder) const {
    const Outcome done = run(what + " --shard " + shard + " --output " + at(folder));
    EXPECT_EQ(done.code, 0) << done.err;
    std::string path = done.out.substr(done.out.rfind('\n', done.out.size() - 2) + 1);
    path.pop_back();
    EXPECT_TRUE(fs::exists(path)) << done.out;
    return path;
  }
  Outcome merge(const std::string& files, const std::string& folder = "merged") const {
    return run("merge " + files + " --output " + at(folder));
  }
  Json results(const std::string& folder) const {
    Json json = Json::parse(read(folder_ / folder / "results.json"));
    drop_times(json);
    return json;
  }
  /// A shard's file with another head.
  std::string with_head(const std::string& file, const std::function<void(Json&)>& change) const {
    const std::string bytes = read(file);
    const std::size_t end = bytes.find('\n');
    Json head = Json::parse(bytes.substr(0, end));
    change(head);
    return write("forged.bin", head.dump() + bytes.substr(end)).string();
  }
  /// A shard's file with another first and only set, under the hash that it then has.
  std::string with_set(const std::string& file,
                       const std::function<void(comparison::SetAnswers&)>& change) const {
    const std::string bytes = read(file);
    const std::size_t end = bytes.find('\n');
    comparison::SetAnswers set = comparison::decode_set(bytes.substr(end + 1));
    change(set);
    return with_bytes(bytes.substr(0, end), comparison::encode_set(set));
  }
  std::string with_bytes(const std::string& head_line, const std::string& set) const {
    Json head = Json::parse(head_line);
    head["sets"][0]["bytes"] = set.size();
    head["sets"][0]["sha256"] = touchstone::program::sha256(set);
    return write("forged.bin", head.dump() + "\n" + set).string();
  }
  void expect_refused(const std::string& files, const std::string& text) const {
    const Outcome merged = merge(files, "refused");
    EXPECT_EQ(merged.code, 2) << merged.out;
    EXPECT_THAT(merged.err, HasSubstr(text));
    EXPECT_FALSE(fs::exists(folder_ / "refused"));
  }
};

TEST_F(Shards, MergeInAnyOrderToTheBytesOfTheWholeRunButForTimes) {
  const Outcome whole = run(asked() + " --output " + at("merged"));
  ASSERT_EQ(whole.code, 0) << whole.err;
  const Json expected = results("merged");
  ASSERT_EQ(expected.at("pair_sets").size(), 3u);
  EXPECT_GT(expected.dump().size(), 20000u);
  const std::string answers = read(folder_ / "merged/answers.json"),
                    csv = read(folder_ / "merged/answers.csv");
  EXPECT_THAT(answers, HasSubstr("no pair"));

  const std::string first = shard(asked(), "1/3", "a"), second = shard(asked(), "2/3", "b"),
                    third = shard(asked(), "3/3", "a");
  fs::copy_file(first, at("copy"));
  const Outcome merged = merge(third + " " + first + " " + second + " " + at("copy"));
  ASSERT_EQ(merged.code, 0) << merged.err;
  EXPECT_EQ(results("merged").dump(1), expected.dump(1));
  EXPECT_EQ(read(folder_ / "merged/answers.json"), answers);
  EXPECT_EQ(read(folder_ / "merged/answers.csv"), csv);
  EXPECT_THAT(Json::parse(read(folder_ / "merged/results.json")).at("pair_sets")[0]["backends"][0].dump(),
              HasSubstr("median_ns"));
}

void expect_the_shards_pairs(const PairSet& part, const PairSet& whole, comparison::Shard shard) {
  EXPECT_EQ(part.name, whole.name);
  EXPECT_EQ(part.description, whole.description);
  EXPECT_EQ(part.poses.size(), part.solids.size());
  ASSERT_EQ(part.pairs.size(), shard.cases_of(whole.pairs.size()));
  ASSERT_EQ(part.ids.size(), part.pairs.size());
  for (std::size_t i = 0; i < part.pairs.size(); ++i) {
    const std::size_t at = shard.k - 1 + i * shard.n;
    EXPECT_EQ(part.ids[i], case_id(whole, at));
    const touchstone::measures::PosedPair mine = posed_pair(part, i), theirs = posed_pair(whole, at);
    for (int v = 0; v < 8; ++v) {
      EXPECT_EQ(mine.a.vertex(v), theirs.a.vertex(v));
      EXPECT_EQ(mine.b.vertex(v), theirs.b.vertex(v));
    }
  }
}

double furthest(const PairSet& set) {
  double out = 0.0;
  for (const touchstone::Pose& pose : set.poses) out = std::max(out, touchstone::norm(pose.p));
  return out;
}

TEST(ShardsPart, OfAFamilyHasTheSolidsOfItsPairsAndTheFurthestAlone) {
  const PairSet family = touchstone::measures::make_pair_family("tapered", 7, 20);
  for (const comparison::Shard shard : {comparison::Shard{1, 1}, {2, 3}, {20, 20}, {21, 30}}) {
    const PairSet part = comparison::part_of_family("tapered", 7, 20, shard);
    expect_the_shards_pairs(part, family, shard);
    EXPECT_EQ(part.solids.size(), 2 * part.pairs.size() + 1);
    EXPECT_EQ(furthest(part), furthest(family));
  }
}

TEST_F(Shards, MoreShardsThanPairsAreAsGood) {
  const std::string what = "--pairs " + at("pairs.json") + " --repetitions 1 --backend native edge_face";
  ASSERT_EQ(run(what + " --output " + at("merged")).code, 0);
  const Json expected = results("merged");
  std::string files;
  for (int k = 1; k <= 5; ++k) files += " " + shard(what, std::to_string(k) + "/5", "shards");
  const Outcome merged = merge(files);
  ASSERT_EQ(merged.code, 0) << merged.err;
  EXPECT_EQ(results("merged").dump(1), expected.dump(1));
}

TEST_F(Shards, WhatDoesNotBelongTogetherIsNamed) {
  const std::string first = shard(small(), "1/2", "a"), second = shard(small(), "2/2", "a");
  const std::string third = shard(small(), "3/4", "a");
  expect_refused(first, "merge: lost: 2/2");
  expect_refused(first + " " + second + " " + third,
                 third + ": is shard 3/4 and overlaps " + first + ", which is shard 1/2");
  const std::string again = shard(small(), "2/2", "again");
  expect_refused(first + " " + second + " " + again, again + ": is shard 2/2, which " + second + " is too");
  const std::string seeded = shard(small() + " --seed 2", "2/2", "seeded");
  expect_refused(first + " " + seeded, seeded + ": is of another run than " + first + ": its arguments");
  expect_refused(first + " " + at("nothing.bin"), "nothing.bin: there is no such file");
  expect_refused(first + " " + write("some.json", "{}").string(), "some.json: is no shard of a run");
  EXPECT_EQ(merge("").code, 2);
}

TEST_F(Shards, AChangedOrCutFileIsNamed) {
  const std::string first = shard(small(), "1/2", "a"), second = shard(small(), "2/2", "a");
  const std::string bytes = read(second);
  std::string changed = bytes;
  changed[changed.size() - 9] ^= 1;
  write("changed.bin", changed);
  expect_refused(first + " " + at("changed.bin"), "changed.bin: is cut off or changed: the set 'touching'");
  write("cut.bin", bytes.substr(0, bytes.size() - 100));
  expect_refused(first + " " + at("cut.bin"), "cut.bin: is cut off or changed");
  write("long.bin", bytes + "more");
  expect_refused(first + " " + at("long.bin"), "long.bin: has more than its head says");
  write("head.bin", bytes.substr(0, 60) + "\n");
  expect_refused(first + " " + at("head.bin"), "head.bin: its head is no JSON");
}

TEST_F(Shards, AHeadThatIsWrongIsNamed) {
  const std::string first = shard(small(), "1/2", "a"), second = shard(small(), "2/2", "a");
  const auto expect = [&](const std::function<void(Json&)>& change, const std::string& text) {
    expect_refused(first + " " + with_head(second, change), "forged.bin: " + text);
  };
  const std::string cut_off = "is cut off or changed";
  expect([](Json& head) { head["sets"][0]["bytes"] = std::numeric_limits<std::uint64_t>::max(); }, cut_off);
  expect([](Json& head) { head["sets"][0]["bytes"] = std::uint64_t{1} << 40; }, cut_off);
  const std::string kind = "its head holds a value of another kind";
  expect([](Json& head) { head["sets"][0]["bytes"] = -1; }, kind);
  expect([](Json& head) { head["sets"] = 3; }, kind);
  expect([](Json& head) { head["arguments"] = {1, 2}; }, kind);
  expect([](Json& head) { head["exact"] = "yes"; }, kind);
  for (const char* key : {"version", "layout", "shard", "arguments", "inputs", "backends", "exact", "sets"})
    expect([&](Json& head) { head.erase(key); }, std::string("its head has no '") + key + "'");
  expect([](Json& head) { head["layout"] = "4"; }, "is of layout 4, this is ");
  expect([](Json& head) { head["version"] = "0.0.1"; }, "is of version 0.0.1, this is ");
  expect([](Json& head) { head["machine"]["build_type"] = "Slow"; }, "is of build type Slow, this is ");
  expect([](Json& head) { head["machine"]["flags"] = "-O0"; }, "is of flags -O0, this is ");
  expect([](Json& head) { head["machine"].erase("cpu"); }, "its head has no 'cpu'");
  expect([](Json& head) { head["sets"][0]["cases"] = 90; }, "its set 'touching' has ");
  expect([](Json& head) { head["backends"].push_back("more"), head["backends"].push_back("and more"); },
         "its set 'touching' has answers of other backends");
}

TEST_F(Shards, OtherMachinesAreNamed) {
  const std::string first = shard(small(), "1/2", "a"), second = shard(small(), "2/2", "a");
  const Outcome merged =
      merge(first + " " + with_head(second, [](Json& head) { head["machine"]["cpu"] = "abacus <2>"; }));
  ASSERT_EQ(merged.code, 0) << merged.err;
  const Json json = Json::parse(read(folder_ / "merged/results.json"));
  const Json& elsewhere = json.at("shards_elsewhere");
  ASSERT_EQ(elsewhere.size(), 1u);
  EXPECT_EQ(elsewhere[0].at("k"), 2);
  EXPECT_EQ(elsewhere[0].at("n"), 2);
  EXPECT_EQ(elsewhere[0].at("cpu"), "abacus <2>");
  const std::string page = read(folder_ / "merged/report.html");
  EXPECT_THAT(page,
              HasSubstr("1 of the 2 shards of the pairs was measured on another machine: abacus &lt;2&gt;,"));
  EXPECT_THAT(page, HasSubstr("1 of 2 shards on other machines"));
}

TEST_F(Shards, ASetThatIsNotItsShardsIsNamed) {
  const std::string first = shard(small(), "1/2", "a"), second = shard(small(), "2/2", "a");
  // Lists of a set that are longer or shorter than its pairs.
  const auto expect = [&](const std::function<void(comparison::SetAnswers&)>& change) {
    expect_refused(first + " " + with_set(second, change), "forged.bin: its set 'touching' has ");
  };
  expect([](auto& set) { set.answers[0].queries[0].status.emplace_back(); });
  expect([](auto& set) { set.answers[0].queries[0].status.pop_back(); });
  expect([](auto& set) { set.answers[0].queries[1].geometry.emplace_back(); });
  expect([](auto& set) { set.answers[0].queries[1].geometry.clear(); });
  expect([](auto& set) { set.answers[0].queries[2].points.resize(8); });
  expect([](auto& set) { set.answers[0].queries[1].single.emplace().repetitions = 33; });
  expect([](auto& set) { set.answers.clear(); });
  expect([](auto& set) { set.truth.emplace_back(); });
  expect([](auto& set) { set.errors.emplace_back(); });

  // Bytes that end too early or too late.
  const std::string bytes = read(second);
  const std::string head = bytes.substr(0, bytes.find('\n')), set = bytes.substr(head.size() + 1);
  expect_refused(first + " " + with_bytes(head, std::string(8, '\xff')), "its set 'touching' is truncated");
  expect_refused(first + " " + with_bytes(head, set + "more"),
                 "its set 'touching' has more than its lists say");

  // Points that are missing, though answers have them.
  const std::string what = "--pairs " + at("pairs.json") + " --repetitions 1 --backend native";
  const auto without_points = [](auto& pairs) { pairs.answers[0].queries[2].points.clear(); };
  const Outcome merged = merge(with_set(shard(what, "1/1", "pairs"), without_points));
  EXPECT_EQ(merged.code, 2);
  EXPECT_THAT(merged.err, HasSubstr("forged.bin: has no contact points of 'pairs'"));
}

TEST_F(Shards, CasesThatHaveChangedSinceAreNamed) {
  const std::string what = "--pairs " + at("pairs.json") + " --repetitions 1 --backend native";
  const std::string only = shard(what, "1/1", "a");
  std::string pairs = kPairs;
  pairs.replace(pairs.find("1.5"), 3, "1.6");
  write("pairs.json", pairs);
  expect_refused(only, only + ": its inputs are not those of here");
}

TEST_F(Shards, NothingOfSomebodyElseIsWrittenOver) {
  fs::create_directory(at("a"));
  write("a/shard_1_of_2.bin", "mine");
  expect_refusal(small() + " --shard 1/2 --output " + at("a"),
                 {"shard_1_of_2.bin: is there, and no shard of a run"});
  EXPECT_EQ(read(folder_ / "a/shard_1_of_2.bin"), "mine");
  shard(small(), "2/2", "a");
  shard(small(), "2/2", "a");  // run again
  EXPECT_EQ(std::distance(fs::directory_iterator(at("a")), {}), 2);
}

TEST_F(Shards, AFolderThatCannotBeIsNamedBeforeAnythingIsMeasured) {
  write("file", "mine");
  for (const char* folder : {"file", "file/below"}) {
    EXPECT_THROW(comparison::ShardWriter(at(folder), {1, 2}, {}), touchstone::InputError);
    expect_refusal(small() + " --shard 1/2 --output " + at(folder), {"shard_1_of_2.bin: cannot be written"});
  }
  EXPECT_EQ(read(at("file")), "mine");
  comparison::ShardWriter(at("made"), {1, 2}, {});
  EXPECT_TRUE(fs::is_empty(at("made")));
}

TEST_F(Shards, WhatIsPutThereMeanwhileStays) {
  comparison::ShardWriter writer(at("a"), {1, 2}, {});
  write("a/shard_1_of_2.bin", "mine");
  EXPECT_THROW(writer.finish({}), std::runtime_error);
  EXPECT_EQ(read(at("a/shard_1_of_2.bin")), "mine");
  EXPECT_EQ(std::distance(fs::directory_iterator(at("a")), {}), 2);  // the shard's, under another name
  fs::remove(at("a/shard_1_of_2.bin"));
  EXPECT_EQ(writer.finish({}), at("a/shard_1_of_2.bin"));
  EXPECT_EQ(std::distance(fs::directory_iterator(at("a")), {}), 1);
}

TEST_F(Shards, WhatIsNoShardIsRefused) {
  for (const char* text : {"0/2", "3/2", "2", "a/b", "1/2/3", "-1/2", "1/200000", "1/", "''"}) {
    expect_refusal(small() + " --shard " + text + " --output " + at("a"),
                   {"is no shard, 3/8 is the third of 8"});
  }
  EXPECT_THAT(run("--families none --shard 1/2 --output " + at("a")).err, HasSubstr("no pairs to cut"));
  EXPECT_THAT(run("--case random:1 --shard 1/2 --output " + at("a")).err, HasSubstr("--case"));
  EXPECT_FALSE(fs::exists(folder_ / "a"));
}

}  // namespace
