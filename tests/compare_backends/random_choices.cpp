#include "touchstone/tests/compare_backends/random_choices.hpp"

#include <fmt/format.h>

#include <cmath>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/examples/compare_backends/run/sets/options.hpp"

namespace touchstone::comparison {
namespace {

// The truth of a case, the same for every backend.
struct Truth {
  double separation, size, scale;
};

CurveCase random_answer(Random& random, const Truth& truth, int backend, std::size_t index) {
  CurveCase each;
  each.contact = truth.separation <= 0;
  each.stratum = stratum_of(truth.separation, each.contact, truth.size, truth.scale);
  each.index = index;
  each.status = each.contact ? PairStatus::overlapping : PairStatus::separated;
  const double chance = random.uniform(0, 1);
  if (backend == 8 && !each.contact) each.status = PairStatus::unsupported;
  if (backend == 1 && chance < 0.01) each.status = PairStatus::failed;
  if (backend == 2 && chance < 0.002) each.status = PairStatus::separated;
  double cost = backend == 0 ? 0.0 : random.binary_scale(-50, -6 * backend);
  for (std::size_t asked = 0; asked < kAskedKinds; ++asked) {
    const bool missing = backend == 4 && asked % 2 == 1 && chance < 0.1;
    each.costs[asked] = {cost, missing ? kNoValue : cost > 0 ? "depth" : "", missing};
    cost *= 1 + random.uniform(0, 1);
  }
  each.coverage = backend == 5 ? random.uniform(0, 1) : 1.0;
  return each;
}

ChoiceSet made_up_set(Random& random, const std::string& name) {
  ChoiceSet set;
  set.name = name;
  set.cases = 1000;
  // The truth of each pair: a tenth touches.
  std::vector<Truth> truth;
  for (std::size_t i = 0; i < set.cases; ++i) {
    const double separation = random.sign() * (i % 10 == 0 ? 0.0 : random.binary_scale(-30, 6));
    truth.push_back({separation, random.uniform(0.2, 2), random.binary_scale(-1, 24)});
  }
  for (std::size_t i = 0; i < set.cases; ++i) set.ids.push_back(name + ":" + std::to_string(i));
  // Nine backends, some without times or allocations; one set lacks one of them.
  for (int b = 0; b < 9; ++b) {
    if (b == 6 && name == "one") continue;
    ChoiceSet::Backend& backend = set.backends.emplace_back();
    backend.name = "backend_" + std::to_string(b);
    for (const QueryKind kind : kQueryKinds) {
      ChoiceSet::Answers& answers = backend.queries[index_of(kind)];
      answers.nanoseconds = b == 7 ? kNaN : b == 3 ? 50.0 : random.binary_scale(3, 18);
      answers.p999_ns = b == 2 ? kNaN : random.binary_scale(5, 20);
      answers.allocations = b == 3 ? 0.25 : b == 5 ? kNaN : 0;
      CurveBuilder builder(kind);
      for (std::size_t i = 0; i < set.cases; ++i) builder.add(random_answer(random, truth[i], b, i));
      answers.curves = builder.take();
    }
  }
  return set;
}

// Mostly on the grid, sometimes beside it.
double random_limit(Random& random, std::span<const double> bins) {
  const double end = bins[random.below(static_cast<std::uint32_t>(bins.size()))];
  const std::uint32_t kind = random.below(4);
  return kind < 2 ? kInfinity : kind == 2 ? end : end * random.uniform(0.1, 3);
}

double random_budget(Random& random) {
  const std::uint32_t kind = random.below(4);
  if (kind == 0) return random.below(10) == 0 ? 0.0 : random.binary_scale(-60, 3);
  return cost_of_code(1 + random.below(kCodesADecade * 19));
}

}  // namespace

std::vector<ChoiceSet> made_up_choice_sets(Random& random) {
  std::vector<ChoiceSet> sets = {made_up_set(random, "one")};
  sets.push_back(made_up_set(random, "two & <three>"));
  return sets;
}

Choice random_choice(Random& random, const std::vector<ChoiceSet>& sets) {
  const auto one_in = [&](std::uint32_t n) { return random.below(n) == 0; };
  Choice choice;
  choice.query = kQueryKinds[random.below(3)];
  if (one_in(3)) choice.sets = {sets[random.below(static_cast<std::uint32_t>(sets.size()))].name};
  choice.apart = !one_in(3);
  choice.touching = !one_in(4);
  choice.deep = !one_in(4);
  choice.apart_up_to = random_limit(random, kApartBins);
  choice.within = random_limit(random, kWithinBins);
  choice.normals = !one_in(3);
  choice.points = !one_in(3);
  choice.max_error = random_budget(random);
  choice.share = one_in(2)   ? 0.0
                 : one_in(2) ? std::pow(10.0, -static_cast<int>(random.below(5)) - 1)
                             : random.binary_scale(-15, -1);
  if (choice.query == QueryKind::manifold && one_in(2))
    choice.min_coverage = one_in(3)
                              ? random.uniform(0, 0.999)
                              : kCoverageBins[random.below(static_cast<std::uint32_t>(kCoverageBins.size()))];
  if (one_in(4)) choice.deadline = random.binary_scale(-25, -8);
  choice.no_allocations = one_in(4);
  return choice;
}

nlohmann::json as_json(const Choice& choice) {
  const auto limit = [](double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
  };
  return {{"query", to_string(choice.query)},
          {"sets", choice.sets},
          {"apart", choice.apart},
          {"touching", choice.touching},
          {"deep", choice.deep},
          {"apart_up_to", limit(choice.apart_up_to)},
          {"within", limit(choice.within)},
          {"normals", choice.normals},
          {"points", choice.points},
          {"max_error", choice.max_error},
          {"share", choice.share},
          {"min_coverage", choice.min_coverage},
          {"deadline", limit(choice.deadline)},
          {"no_allocations", choice.no_allocations}};
}

Choice choice_from(const nlohmann::json& json) {
  const auto limit = [&](const char* key) {
    return json[key].is_null() ? kInfinity : json[key].get<double>();
  };
  Choice choice;
  choice.query = query_named(json["query"]);
  choice.sets = json["sets"].get<std::vector<std::string>>();
  choice.apart = json["apart"];
  choice.touching = json["touching"];
  choice.deep = json["deep"];
  choice.apart_up_to = limit("apart_up_to");
  choice.within = limit("within");
  choice.normals = json["normals"];
  choice.points = json["points"];
  choice.max_error = json["max_error"];
  choice.share = json["share"];
  choice.min_coverage = json["min_coverage"];
  choice.deadline = limit("deadline");
  choice.no_allocations = json["no_allocations"];
  return choice;
}

std::string as_options(const nlohmann::json& json) {
  const Choice choice = choice_from(json);
  std::string text = fmt::format(" --query {} --max-error {} --share {}", to_string(choice.query),
                                 choice.max_error, choice.share);
  for (const std::string& name : choice.sets) text += " --of '" + name + "'";
  std::string classes;
  if (choice.apart) classes += " apart";
  if (choice.touching) classes += " touching";
  if (choice.deep) classes += " deep";
  text += " --classes" + classes;
  if (std::isfinite(choice.apart_up_to)) text += fmt::format(" --apart-up-to {}", choice.apart_up_to);
  if (std::isfinite(choice.within)) text += fmt::format(" --within {}", choice.within);
  if (!choice.normals) text += " --without-normals";
  if (!choice.points) text += " --without-points";
  if (choice.min_coverage > 0) text += fmt::format(" --min-coverage {}", choice.min_coverage);
  if (std::isfinite(choice.deadline)) text += fmt::format(" --deadline {}", choice.deadline);
  if (choice.no_allocations) text += " --no-allocations";
  return text;
}

}  // namespace touchstone::comparison
