#include <fmt/format.h>
#include <gmock/gmock.h>

#include <limits>

#include "touchstone/examples/compare_backends/html_report.hpp"
#include "touchstone/examples/compare_backends/options.hpp"
#include "touchstone/examples/compare_backends/results_file.hpp"
#include "touchstone/examples/compare_backends/verdict.hpp"
#include "touchstone/examples/measures/random.hpp"
#include "touchstone/tests/compare_backends/page_in_browser.hpp"

namespace touchstone::comparison {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Nine backends over two sets, costs and times of all sizes, ties, a missing value and a missing time.
std::vector<SetResult> made_up_sets(Random& random) {
  std::vector<SetResult> sets(2);
  for (std::size_t s = 0; s < 2; ++s) {
    SetResult& set = sets[s];
    set.name = s == 0 ? "one" : "two & <three>";
    set.cases = 1000;
    for (int b = 0; b < 9; ++b) {
      BackendResult backend;
      backend.name = "backend_" + std::to_string(b);
      backend.judged = true;
      for (std::size_t q = 0; q < 3; ++q) {
        const double ns = random.binary_scale(3, 18);
        if (b != 7) backend.rows[q].single = Timing{ns, ns, ns, 1};
        const double cost = b == 8 ? kInfinity : b == 0 ? 0.0 : random.binary_scale(-52, 0);
        backend.judgement.worst[q] = {cost, 7, b == 1 ? "phantom contact" : cost > 0 ? "depth" : ""};
        backend.judgement.cost[q] = {cost, cost, cost, 7, 1000};
        backend.judgement.wrongness[q].cases = 1000;
        if (b == 1) backend.judgement.wrongness[q].phantom = 312;
      }
      if (b == 3) backend.rows = set.backends[2].rows;  // as fast as the one before
      set.backends.push_back(backend);
    }
  }
  return sets;
}

Report made_up_report(const std::vector<SetResult>& sets) {
  Report report;
  report.has_truth = true;
  report.sets = sets;
  for (const BackendResult& backend : sets[0].backends) report.backends.emplace_back(backend.name, "made up");
  for (const QueryKind kind : kQueryKinds) report.candidates.push_back({kind, candidates(sets, kind)});
  return report;
}

// What the page says when its budget and query are set to each of `asked`.
std::string slider_script(const nlohmann::json& asked) {
  return "const asked=" + asked.dump() + R"(;found=asked.map(([q,b])=>{
    document.getElementById('query').value=q;const budget=document.getElementById('budget');budget.value=b;
    budget.dispatchEvent(new Event('input'));
    const text=id=>{const e=document.getElementById(id);return e?e.textContent:''};
    return {sentence:text('sentence'),headline:text('headline'),
      rows:[...document.querySelectorAll('#chosen tbody tr')].map(r=>[...r.cells].map(c=>c.textContent))}});)";
}

// Query and budget, fifty times. Some budgets are exactly what a backend costs, one is 0.
nlohmann::json fifty_budgets(Random& random, const std::vector<Candidates>& candidates) {
  nlohmann::json asked = nlohmann::json::array();
  for (int i = 0; i < 50; ++i) {
    const auto& of = candidates[random.below(3)];
    const double cost =
        of.candidates[random.below(static_cast<std::uint32_t>(of.candidates.size()))].worst_cost;
    const double budget = i == 0                              ? 0.0
                          : i % 5 == 0 && std::isfinite(cost) ? cost
                                                              : random.binary_scale(-60, 1);
    asked.push_back({to_string(of.query), fmt::format("{}", budget)});
  }
  return asked;
}

TEST_F(PageInBrowser, TheSliderDecidesAsTheProgramOnFiftyBudgets) {
  Random random(20);
  const std::vector<SetResult> sets = made_up_sets(random);
  const Report report = made_up_report(sets);
  const nlohmann::json asked = fifty_budgets(random, report.candidates);
  const nlohmann::json seen = look(html_report(report), slider_script(asked));
  EXPECT_EQ(seen["faults"], nlohmann::json::array());
  ASSERT_TRUE(seen["found"].is_array()) << seen;
  ASSERT_EQ(seen["found"].size(), 50u);
  std::size_t decided = 0;
  for (std::size_t i = 0; i < 50; ++i) {
    const Verdict verdict = decide(sets, query_named(asked[i][0]), std::stod(std::string(asked[i][1])));
    const auto& page = seen["found"][i];
    EXPECT_EQ(page["sentence"], sentence(verdict)) << asked[i];
    EXPECT_EQ(page["headline"], verdict.fastest.empty() ? "" : headline(verdict)) << asked[i];
    ASSERT_EQ(page["rows"].size(), verdict.candidates.size());
    for (std::size_t c = 0; c < verdict.candidates.size(); ++c) {
      EXPECT_EQ(page["rows"][c][0], verdict.candidates[c].backend) << asked[i];
      EXPECT_EQ(page["rows"][c][1], verdict.candidates[c].inside ? "yes" : "no") << asked[i];
      EXPECT_EQ(page["rows"][c][4], reason_out(verdict, verdict.candidates[c])) << asked[i];
    }
    decided += !verdict.fastest.empty();
  }
  EXPECT_GT(decided, 10u);
}

// A real run's page against the command line on that run's results.json.
TEST_F(PageInBrowser, TheSliderOfARealRunSaysWhatTheCommandLineSays) {
  const std::string report = (folder_ / "report").string();
  const auto command = [&](const std::string& arguments) {
    const std::filesystem::path out = folder_ / "said";
    EXPECT_EQ(std::system((COMPARE_BACKENDS " " + arguments + " >" + out.string() + " 2>/dev/null").c_str()),
              0)
        << arguments;
    return read(out);
  };
  command("--quick --no-broadphase --count 60 --families random touching tapered --output " + report);
  const std::vector<Candidates> candidates =
      candidates_of(parse_results(read(report + "/results.json"), "test", "results.json"), "test");
  if (candidates.empty()) GTEST_SKIP() << "without `exact` there is no verdict";
  Random random(50);
  const nlohmann::json asked = fifty_budgets(random, candidates);
  const nlohmann::json seen = look(read(report + "/report.html"), slider_script(asked));
  EXPECT_EQ(seen["faults"], nlohmann::json::array());
  ASSERT_EQ(seen["found"].size(), 50u);
  for (std::size_t i = 0; i < 50; ++i) {
    const std::string query = asked[i][0], budget = asked[i][1];
    const std::string said =
        command("decide " + report + "/results.json --query " + query + " --max-error " + budget);
    const std::string sentence = seen["found"][i]["sentence"];
    EXPECT_EQ(said.substr(1, said.find('\n', 1) - 1), sentence) << asked[i];
    std::size_t from = 0;  // the ranking, in the same order
    for (const auto& row : seen["found"][i]["rows"]) {
      from = said.find("\n  " + row[0].get<std::string>() + " ", from + 1);
      EXPECT_NE(from, std::string::npos) << asked[i] << row << said;
    }
  }
}

TEST_F(PageInBrowser, OpensWithoutAnErrorOrARequest) {
  Random random(3);
  const nlohmann::json seen = look(html_report(made_up_report(made_up_sets(random))),
                                   "found=document.getElementById('controls').hidden");
  EXPECT_EQ(seen["faults"], nlohmann::json::array());
  EXPECT_EQ(seen["requests"], nlohmann::json::array());
  EXPECT_EQ(seen["found"], false) << "the slider should be there";
}

TEST_F(PageInBrowser, TheWatchSeesWhatItIsFor) {
  const nlohmann::json seen = look("<html><head></head><body><img src='no_such.png'></body></html>",
                                   "console.error('a fault');found=1");
  EXPECT_THAT(seen["faults"].dump(), ::testing::HasSubstr("a fault"));
  EXPECT_THAT(seen["faults"].size(), 2u) << "the picture that is missing";
  EXPECT_THAT(seen["requests"].size(), 1u);
}

}  // namespace
}  // namespace touchstone::comparison
