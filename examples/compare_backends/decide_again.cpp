#include "touchstone/examples/compare_backends/decide_again.hpp"

#include <fmt/format.h>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/compare_backends/options.hpp"
#include "touchstone/examples/compare_backends/results_file.hpp"
#include "touchstone/examples/compare_backends/terminal.hpp"
#include "touchstone/examples/program/program.hpp"

namespace touchstone::comparison {

int run_decide(int argc, const char* const* argv) {
  CLI::App app{"The verdict of a finished run for other allowed errors, as its page's slider gives it."};
  app.name("compare_backends decide");
  std::string file, query;
  std::vector<double> max_errors;
  app.add_option("RESULTS.json", file, "results.json of the run")->required();
  app.add_option("--max-error", max_errors, "Allowed errors [m]")->required();
  add_query_option(app, query);
  if (!parse_command_line(app, argc - 1, argv + 1)) return 0;
  for (const double allowed : max_errors) checked_max_error(allowed);
  const Json results = parse_results(read_file(file, "decide"), "decide", file);
  for (const Candidates& of : candidates_of(results, "decide")) {
    if (to_string(of.query) != query) continue;
    for (const double allowed : max_errors)
      fmt::print("{}", verdict_text(decide(of.candidates, of.query, allowed)));
    return 0;
  }
  throw InputError("decide: " + file +
                   " holds no candidates: it was run without 'exact', or no case was judged");
}

}  // namespace touchstone::comparison
