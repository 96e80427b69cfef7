#include <fmt/format.h>
#include <gmock/gmock.h>

#include <limits>

#include "touchstone/examples/compare_backends/judge/verdict.hpp"
#include "touchstone/examples/compare_backends/page/embedded_text.hpp"
#include "touchstone/examples/compare_backends/page/html_report.hpp"
#include "touchstone/examples/compare_backends/results/json_writer.hpp"
#include "touchstone/examples/compare_backends/results/results_file.hpp"
#include "touchstone/examples/measures/common/random.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"
#include "touchstone/tests/compare_backends/random_choices.hpp"
#include "touchstone/tests/support/page_in_browser.hpp"

namespace touchstone::comparison {
namespace {

class PageScript : public ProgramTest {
 protected:
  PageScript() : ProgramTest(NODE) {}

  // Runs decide.js on each of `asked`, given results.json's `choices`.
  nlohmann::json in_node(const std::string& choices, const nlohmann::json& asked) {
    const std::string script = R"(
      const decider=touchstoneDecider(data);
      console.log(JSON.stringify(asked.map(c=>{
        for(const id of ['apart_up_to','within','deadline'])if(c[id]===null)c[id]=Infinity;
        const v=decider.decide(c);
        return {sentence:decider.sentence(v),headline:decider.headline(v),
                rows:v.candidates.map(e=>[e.backend,...decider.cells(v,e)])}})));)";
    const std::string file =
        write("page.js", std::string(embedded_text("decide.js")) + "\nconst data=" + choices +
                             ",asked=" + asked.dump() + ";" + script)
            .string();
    const Outcome outcome = run(file);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.code == 0 ? nlohmann::json::parse(outcome.out) : nlohmann::json();
  }
};

Report made_up_report(const std::vector<ChoiceSet>& sets) {
  Report report;
  report.has_truth = true;
  report.choices = sets;
  for (const ChoiceSet::Backend& backend : sets[0].backends)
    report.backends.emplace_back(backend.name, "made up");
  return report;
}

// Some choices err: nothing is in them.
nlohmann::json random_choices(Random& random, const std::vector<ChoiceSet>& sets, int count) {
  nlohmann::json asked = nlohmann::json::array();
  for (int i = 0; i < count; ++i) asked.push_back(as_json(random_choice(random, sets)));
  return asked;
}

void expect_said(const nlohmann::json& page, const Verdict& verdict, const nlohmann::json& asked) {
  EXPECT_EQ(page["sentence"], sentence(verdict)) << asked;
  EXPECT_EQ(page["headline"], headline(verdict)) << asked;
  ASSERT_EQ(page["rows"].size(), verdict.candidates.size()) << asked;
  for (std::size_t c = 0; c < verdict.candidates.size(); ++c) {
    const Candidate& each = verdict.candidates[c];
    EXPECT_EQ(page["rows"][c],
              nlohmann::json({each.backend, each.inside ? "yes" : "no", speed_text(each),
                              format_ns(each.p999_ns), format_allocations(each.allocations),
                              beyond_text(each), format_error(each.worst_cost), reason_out(verdict, each)}))
        << asked;
  }
}

struct VerdictCounts {
  std::size_t decided = 0, empty = 0;
};
// The page's answers to all that was asked, against decide()'s.
VerdictCounts expect_all_said(const nlohmann::json& page, const std::vector<ChoiceSet>& sets,
                              const nlohmann::json& asked) {
  VerdictCounts counted;
  EXPECT_EQ(page.size(), asked.size());
  for (std::size_t i = 0; i < asked.size() && i < page.size(); ++i) {
    const Verdict verdict = decide(sets, choice_from(asked[i]));
    expect_said(page[i], verdict, asked[i]);
    counted.decided += !verdict.fastest.empty();
    counted.empty += verdict.is_empty();
  }
  return counted;
}

// The page's menus have the ends of the bins alone.
Choice on_the_grid(Choice choice) {
  choice.apart_up_to = upper_end(choice.apart_up_to, kApartBins);
  choice.within = upper_end(choice.within, kWithinBins);
  return choice;
}

// Sets the page's controls to each of `asked` and reads its answers.
std::string controls_script(const nlohmann::json& asked) {
  return "const asked=" + asked.dump() + R"(;const by=id=>document.getElementById(id);found=asked.map(c=>{
    by('query').value=c.query;by('budget').value=c.max_error;by('share').value=c.share;
    for(const id of ['apart','touching','deep','normals','points','no_allocations'])by(id).checked=c[id];
    by('deadline').value=c.deadline===null?'':c.deadline;
    for(const id of ['apart_up_to','within'])
      by(id).value=c[id]===null?'':[...by(id).options].find(o=>o.value!==''&&Number(o.value)===c[id]).value;
    by('coverage').value=c.min_coverage;
    for(const box of document.querySelectorAll('#sets input'))
      box.checked=c.sets.length===0||c.sets.includes(box.value);
    by('query').dispatchEvent(new Event('change',{bubbles:true}));
    const said=e=>e.textContent.replace(/\u00a0/g,' '), text=id=>by(id)?said(by(id)):'';
    return {sentence:text('sentence'),headline:text('headline'),
      rows:[...document.querySelectorAll('#chosen tbody tr')].map(r=>[...r.cells].map(said))}});)";
}

TEST_F(PageInBrowser, DecidesAsTheProgramOnFiveHundredChoices) {
  Random random(20);
  const std::vector<ChoiceSet> sets = made_up_choice_sets(random);
  nlohmann::json asked = random_choices(random, sets, 500);
  for (nlohmann::json& each : asked) each = as_json(on_the_grid(choice_from(each)));
  const nlohmann::json seen = look(html_report(made_up_report(sets)), controls_script(asked));
  EXPECT_EQ(seen["faults"], nlohmann::json::array());
  ASSERT_TRUE(seen["found"].is_array()) << seen;
  const VerdictCounts counted = expect_all_said(seen["found"], sets, asked);
  EXPECT_GT(counted.decided, 100u);
  EXPECT_GT(counted.empty, 5u);
}

// Contacts only, and 0.1 mm with one in a thousand beyond.
TEST_F(PageInBrowser, TwoClicksAskForContactsWithinATenthOfAMillimetre) {
  Random random(21);
  const std::vector<ChoiceSet> sets = made_up_choice_sets(random);
  const nlohmann::json seen =
      look(html_report(made_up_report(sets)),
           "document.getElementById('contacts_only').click();"
           "document.getElementById('one_in_a_thousand').click();"
           "found=document.getElementById('sentence').textContent.replace(/\\u00a0/g,' ')");
  EXPECT_EQ(seen["faults"], nlohmann::json::array());
  Choice choice;
  choice.apart = false;
  choice.max_error = 1e-4;
  choice.share = 1e-3;
  EXPECT_EQ(seen["found"], sentence(decide(sets, choice)));
}

// The script without a page, where there is node: the same answers as in a browser.
TEST_F(PageScript, DecidesAsTheProgramOnFiveHundredChoices) {
  if (std::string_view(NODE).empty()) {
    ASSERT_FALSE(std::string_view(CHROMIUM).empty())
        << "the page's script is tested by node (package nodejs) or Chromium; neither is on this machine";
    GTEST_SKIP() << "no node; Chromium runs the script";
  }
  Random random(20);
  const std::vector<ChoiceSet> sets = made_up_choice_sets(random);
  const nlohmann::json asked = random_choices(random, sets, 500);
  const VerdictCounts counted =
      expect_all_said(in_node(choices_json(made_up_report(sets)), asked), sets, asked);
  EXPECT_GT(counted.decided, 100u);
  EXPECT_GT(counted.empty, 5u);
}

// A real run's page against the command line on that run's results.json.
TEST_F(PageScript, OfARealRunSaysWhatTheCommandLineSays) {
  if (std::string_view(NODE).empty()) GTEST_SKIP() << "no node";
  // A run, and what the page's script says of random choices.
  const std::string report = (folder_ / "report").string();
  const auto command = [&](const std::string& arguments) {
    const std::filesystem::path out = folder_ / "said";
    EXPECT_EQ(std::system((COMPARE_BACKENDS " " + arguments + " >" + out.string() + " 2>/dev/null").c_str()),
              0)
        << arguments;
    return read(out);
  };
  command("--quick --no-broadphase --count 60 --families random touching tapered --output " + report);
  const Json results = parse_results(read(report + "/results.json"), "test", "results.json");
  const std::vector<ChoiceSet> sets = choice_sets_of(results, "test");
  if (sets.empty()) GTEST_SKIP() << "without `exact` there is no verdict";
  Random random(50);
  const nlohmann::json asked = random_choices(random, sets, 60);
  const nlohmann::json seen = in_node(results.at("choices").dump(), asked);
  expect_all_said(seen, sets, asked);
  EXPECT_THAT(read(report + "/report.html"), ::testing::HasSubstr(std::string(embedded_text("decide.js"))));
  // The command says the same of the first twelve.
  int counted = 0;
  for (std::size_t i = 0; i < asked.size() && counted < 12; ++i) {
    if (decide(sets, choice_from(asked[i])).is_empty()) continue;
    const std::string said = command("decide " + report + "/results.json" + as_options(asked[i]));
    const std::string shown = said.substr(1, said.find("\n  backend ") - 1);
    EXPECT_EQ(shown, wrapped(seen[i]["sentence"].get<std::string>())) << asked[i];
    ++counted;
  }
  EXPECT_EQ(counted, 12);
}

TEST_F(PageInBrowser, OpensWithoutAnErrorOrARequest) {
  Random random(3);
  const nlohmann::json seen = look(html_report(made_up_report(made_up_choice_sets(random))),
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
