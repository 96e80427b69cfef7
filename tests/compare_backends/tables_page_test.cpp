#include "touchstone/examples/compare_backends/results/tables_page.hpp"

#include <gtest/gtest.h>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::comparison {
namespace {

Json query(double single, std::size_t missed, std::size_t undecided, std::size_t unsupported) {
  return {{"single", {{"median_ns", single}}},
          {"batch", nullptr},
          {"raw", nullptr},
          {"wrong",
           {{"cases", 10},
            {"missed", missed},
            {"phantom", 1},
            {"undecided", undecided},
            {"failed", 0},
            {"unsupported", unsupported},
            {"missing_value", 0}}}};
}

Json backend(const std::string& name, const Json& of_query) {
  Json errors;
  for (const char* measure : {"distance", "depth", "deepest"})
    errors[measure] = {{"over_S", {{"worst", measure == std::string("depth") ? 2e-3 : 1e-9}}}};
  return {{"backend", name},
          {"queries", {{"overlap", of_query}, {"distance", of_query}, {"manifold", of_query}}},
          {"errors", errors}};
}

Json results() {
  // A run of two backends, of which one has unsupported pairs and a gap among broadphases.
  return {
      {"version", "1.2.3"},
      {"date", "2026-11-27"},
      {"command", "compare_backends --count 10"},
      {"partial", false},
      {"machine",
       {{"cpu", "A CPU"},
        {"instruction_set", "avx2"},
        {"hardware_threads", 2},
        {"system", "Linux"},
        {"compiler", "g++"},
        {"build_type", "Release"}}},
      {"backends",
       {{{"name", "one"}, {"description", "the first"}}, {{"name", "two"}, {"description", "the second"}}}},
      {"gaps", Json::array()},
      {"measured_against_exact", true},
      {"pair_sets",
       {{{"name", "random"},
         {"backends", {backend("one", query(41.25, 2, 3, 0)), backend("two", query(1234, 0, 0, 10))}}}}},
      {"broadphases",
       {{{"broadphase", "one"},
         {"objects", 1000},
         {"hexahedra_each", 4},
         {"frame_ms", {{"median", 0.5}}},
         {"with_overlap_ms", nullptr},
         {"missed", 7}},
        {{"broadphase", "two"}, {"objects", 1000}, {"hexahedra_each", 4}, {"gap", "too slow"}}}}};
}

bool holds(const std::string& page, const std::string& line) { return page.find(line) != std::string::npos; }

TEST(TablesPage, ShowsTimesWrongAnswersAndErrors) {
  const std::string page = tables_page(results());
  EXPECT_TRUE(holds(page, "| pairs | one | two |\n|---|---:|---:|\n| random | 41.2 | 1 234 |\n")) << page;
  EXPECT_TRUE(holds(page, "| random | 3 (+3) |\n")) << page;  // two missed, one phantom; three undecided
  EXPECT_TRUE(holds(page, "| random | 2.0e-03 | 2.0e-03 |\n")) << page;
}

TEST(TablesPage, SumsUpEveryBackendOverAllSets) {
  Json two_sets = results();
  Json second = two_sets["pair_sets"][0];
  second["name"] = "near";
  second["backends"][0] = backend("one", query(20.75, 0, 1, 0));
  two_sets["pair_sets"].push_back(second);
  const std::string page = tables_page(two_sets);
  EXPECT_TRUE(holds(page, "| `one` | 31.0 | - | 4 (+4) | 31.0 | - | 4 (+4) | 31.0 | - | 4 (+4) |\n")) << page;
  EXPECT_TRUE(holds(page, "| `two` | 1 234 | - | - | 1 234 |")) << page;
}

TEST(TablesPage, LeavesOutWhatNobodyMeasuredAndWhoAnswersNothing) {
  const std::string page = tables_page(results());
  EXPECT_FALSE(holds(page, "In batches")) << page;
  EXPECT_FALSE(holds(page, "| random | 3 (+3) | ")) << "what a backend does not support is not wrong\n"
                                                    << page;
}

TEST(TablesPage, ShowsBroadphasesWithWhatTheyMissedAndWhatWasNotRun) {
  const std::string page = tables_page(results());
  EXPECT_TRUE(holds(page, "pairs missed: 7")) << page;
  EXPECT_TRUE(holds(page, "| 1 000 | 4 | 0.5 | not run |\n")) << page;
  EXPECT_TRUE(holds(page, "| 1 000 | 4 | - | not run |\n")) << page;
}

TEST(TablesPage, SaysWhereItIsFromAndThatARunEndedEarly) {
  Json partial = results();
  partial["partial"] = true;
  EXPECT_TRUE(holds(tables_page(partial), "This run ended early"));
  EXPECT_FALSE(holds(tables_page(results()), "This run ended early"));
  EXPECT_TRUE(holds(tables_page(results()), "Touchstone 1.2.3; A CPU (avx2)"));
  EXPECT_TRUE(holds(tables_page(results()), "g++, Release; 2026-11-27.\n"));
  EXPECT_TRUE(holds(tables_page(results()), "`compare_backends --count 10`"));
}

TEST(TablesPage, TakesResultsOfBeforeThereWasADate) {
  Json older = results();
  older.erase("date");
  EXPECT_TRUE(holds(tables_page(older), "g++, Release.\n"));
}

TEST(TablesPage, RefusesResultsThatLackAFigure) {
  Json lacking = results();
  lacking["pair_sets"][0]["backends"][0]["queries"]["overlap"].erase("batch");
  EXPECT_THROW(tables_page(lacking), InputError);
}

}  // namespace
}  // namespace touchstone::comparison
