#include "touchstone/examples/compare_backends/cli/decide_again.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/cli/command_line.hpp"
#include "touchstone/examples/compare_backends/cli/terminal.hpp"
#include "touchstone/examples/compare_backends/results/results_file.hpp"
#include "touchstone/examples/program/terminal/program.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone::comparison {

int run_decide(int argc, const char* const* argv) {
  CLI::App app{"The verdict of a finished run for other choices, as its page gives it."};
  app.name("compare_backends decide");
  // Choices are made by the same options as in a run.
  std::string file;
  ChoiceOptions options;
  app.add_option("RESULTS.json", file, "results.json of the run")->required();
  options.add_to(app);
  app.get_option("--max-error")->required();
  if (!parse_command_line(app, argc - 1, argv + 1)) return 0;
  const std::vector<Choice> choices = options.choices();
  // The counts in the file decide, so that nothing is measured again.
  const Json results = parse_results(read_file(file, "decide"), "decide", file);
  const std::vector<ChoiceSet> sets = choice_sets_of(results, "decide: " + file);
  if (sets.empty())
    throw InputError("decide: " + file +
                     " holds nothing to decide from: it was run without 'exact', or no case was judged");
  // Sets that a choice names must be in the run.
  std::vector<std::string> names;
  for (const ChoiceSet& set : sets) names.push_back(set.name);
  check_sets(choices.front(), names);
  // Each choice gets a verdict of its own.
  std::string text = partial_note(results, file);
  for (const Choice& choice : choices) {
    const Verdict verdict = decide(sets, choice);
    if (verdict.is_empty()) throw InputError("decide: " + file + ": " + sentence(verdict));
    text += verdict_text(verdict);
  }
  print_now(wrapped(text));
  return 0;
}

}  // namespace touchstone::comparison
