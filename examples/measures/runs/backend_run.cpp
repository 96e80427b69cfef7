#include "touchstone/examples/measures/runs/backend_run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/examples/measures/common/allocations.hpp"
#include "touchstone/examples/measures/common/parallel.hpp"
#include "touchstone/examples/measures/common/random.hpp"

namespace touchstone::measures {
namespace {

using Clock = std::chrono::steady_clock;

double nanoseconds(Clock::time_point begin, Clock::time_point end) {
  return std::chrono::duration<double, std::nano>(end - begin).count();
}

void make_slots(QueryAnswers& answers, QueryKind kind, std::size_t cases) {
  answers.status.assign(cases, PairStatus::unsupported);
  answers.geometry.assign(kind == QueryKind::overlap ? 0 : cases, no_geometry());
  answers.points.assign(kind == QueryKind::manifold ? cases * kMaxManifoldPoints : 0, ContactPoint{});
}

NarrowphaseOutput slots(QueryAnswers& answers, std::size_t first, std::size_t count) {
  NarrowphaseOutput output;
  output.status = std::span(answers.status).subspan(first, count);
  if (!answers.geometry.empty()) output.geometry = std::span(answers.geometry).subspan(first, count);
  if (!answers.points.empty()) {
    output.points = std::span(answers.points).subspan(first * kMaxManifoldPoints, count * kMaxManifoldPoints);
  }
  return output;
}

// ---- answers

void answer_frames(const Narrowphase& narrowphase, const PairSet& set, QueryKind kind, int threads,
                   QueryAnswers& answers) {
  make_slots(answers, kind, set.cases());
  const std::size_t pairs = set.pairs.size();
  for (std::size_t frame = 0; frame < set.frames(); ++frame) {
    parallel_chunks(pairs, 256, narrowphase.capabilities().thread_safe ? threads : 1,
                    [&](std::size_t begin, std::size_t end) {
                      const auto workspace = narrowphase.make_workspace();
                      const NarrowphaseInput input{std::span(set.pairs).subspan(begin, end - begin),
                                                   set.frame_poses(frame), query_for(kind)};
                      narrowphase.evaluate(input, slots(answers, frame * pairs + begin, end - begin),
                                           *workspace);
                    });
  }
}

// For a backend that refuses some solid: every pair on its own, so that the others get their answers.
void answer_one_by_one(Narrowphase& narrowphase, const PairSet& set, QueryKind kind, QueryAnswers& answers) {
  make_slots(answers, kind, set.cases());
  for (std::size_t p = 0; p < set.pairs.size(); ++p) {
    const SolidPair pair = set.pairs[p];
    const std::array<Hexahedron, 2> solids = {set.solids[pair.a], set.solids[pair.b]};
    try {
      narrowphase.build(solids);
    } catch (const InputError&) {
      continue;
    }
    const auto workspace = narrowphase.make_workspace();
    for (std::size_t frame = 0; frame < set.frames(); ++frame) {
      const std::array<Pose, 2> poses = {set.frame_poses(frame)[pair.a], set.frame_poses(frame)[pair.b]};
      const SolidPair both{0, 1};
      narrowphase.evaluate({{&both, 1}, poses, query_for(kind)},
                           slots(answers, frame * set.pairs.size() + p, 1), *workspace);
    }
  }
}

// True if the backend took all solids at once; only then is it timed.
bool answer_all(Narrowphase& narrowphase, const PairSet& set, const MeasureOptions& options,
                BackendAnswers& answers) {
  bool whole = true;
  try {
    narrowphase.build(set.solids);
  } catch (const InputError& error) {
    answers.failure = error.what();
    whole = false;
  }
  for (const QueryKind kind : kQueryKinds) {
    QueryAnswers& of_kind = answers.queries[index_of(kind)];
    if (whole) {
      answer_frames(narrowphase, set, kind, options.threads, of_kind);
    } else {
      answer_one_by_one(narrowphase, set, kind, of_kind);
    }
  }
  return whole;
}

// ---- timing

enum class Mode : std::uint8_t { single, batch, raw, cached };

// One row of the timing table: a backend's query in one mode.
struct Row {
  std::size_t backend;
  QueryKind kind;
  Mode mode;
  std::size_t block;   // pairs a block
  std::size_t blocks;  // blocks a repetition
  std::vector<double> averages;
};

struct Timed {
  const Narrowphase* narrowphase = nullptr;
  RawCheck* raw = nullptr;
  std::unique_ptr<Narrowphase::Workspace> workspace;
};

class BlockTimer {
 public:
  BlockTimer(const PairSet& set, std::vector<SolidPair> shuffled, std::size_t largest_block)
      : set_(set), pairs_(std::move(shuffled)) {
    make_slots(scratch_, QueryKind::manifold, largest_block);
  }

  std::size_t pairs() const { return pairs_.size(); }

  // Average [ns per pair] over `count` pairs from `first` on. A few pairs of the block before go first,
  // untimed: they bring in the backend's code, not the block's data. Cached and raw: the block itself goes
  // first. Raw is a floor, and posed objects are read by nobody else, while the poses that the interface is
  // handed stay in the cache between the rows of all backends: cold, the memory would be timed, not the call.
  double time(Timed& timed, QueryKind kind, Mode mode, std::size_t first, std::size_t count,
              std::size_t warm) {
    const auto all = std::span<const SolidPair>(pairs_);
    const std::size_t before = first >= warm ? first - warm : pairs_.size() - std::min(warm, pairs_.size());
    run(timed, kind, mode,
        mode == Mode::cached || mode == Mode::raw
            ? all.subspan(first, count)
            : all.subspan(before, std::min(warm, pairs_.size() - before)));
    const auto begin = Clock::now();
    run(timed, kind, mode, all.subspan(first, count));
    const auto end = Clock::now();
    return nanoseconds(begin, end) / static_cast<double>(count);
  }

  // One call after another, each timed on its own [ns]: all pairs once, or as often as there are calls enough
  // for a percentile, until `seconds` are over.
  std::vector<double> time_calls(Timed& timed, QueryKind kind, double seconds) {
    std::vector<double> calls;
    const NarrowphaseOutput output = output_for(kind);
    const std::size_t wanted = std::max(pairs_.size(), kLeastForP999);
    for (double left = seconds * 1e9; calls.size() < wanted && left > 0; left -= calls.back()) {
      const SolidPair& pair = pairs_[calls.size() % pairs_.size()];
      const auto begin = Clock::now();
      timed.narrowphase->evaluate({{&pair, 1}, set_.poses, query_for(kind)}, output, *timed.workspace);
      calls.push_back(nanoseconds(begin, Clock::now()));
    }
    return calls;
  }

  void run(Timed& timed, QueryKind kind, Mode mode, std::span<const SolidPair> pairs) {
    if (mode == Mode::raw) {
      contacts_ += timed.raw->run(pairs, kind);
      return;
    }
    const std::size_t step = mode == Mode::batch ? pairs.size() : 1;
    const NarrowphaseOutput output = output_for(kind);
    for (std::size_t i = 0; i < pairs.size(); i += step) {
      timed.narrowphase->evaluate({pairs.subspan(i, step), set_.poses, query_for(kind)}, output,
                                  *timed.workspace);
    }
  }

 private:
  NarrowphaseOutput output_for(QueryKind kind) {
    NarrowphaseOutput output{scratch_.status, {}, {}};
    if (kind != QueryKind::overlap) output.geometry = scratch_.geometry;
    if (kind == QueryKind::manifold) output.points = scratch_.points;
    return output;
  }

  const PairSet& set_;
  std::vector<SolidPair> pairs_;
  QueryAnswers scratch_;
  std::size_t contacts_ = 0;
};

std::size_t warm_pairs(const Row& row) { return std::min<std::size_t>(16, row.block / 4); }

// Cuts slow rows to about slow_seconds a repetition: smaller blocks, then fewer.
void size_row(Row& row, BlockTimer& timer, Timed& timed, const MeasureOptions& options) {
  const std::size_t wanted = std::min(row.mode == Mode::batch ? options.batch : options.block, timer.pairs());
  const std::size_t probe = std::min<std::size_t>(8, timer.pairs());
  timer.time(timed, row.kind, row.mode, 0, probe, probe);
  const double each = timer.time(timed, row.kind, row.mode, 0, probe, 1);
  const double affordable = options.slow_seconds * 1e9 / std::max(each, 1.0);
  row.block = std::min(wanted, std::max<std::size_t>(probe, static_cast<std::size_t>(affordable / 4)));
  const std::size_t most = timer.pairs() / row.block;
  row.blocks =
      std::clamp<std::size_t>(static_cast<std::size_t>(affordable / static_cast<double>(row.block)), 1, most);
}

double allocations_per_query(BlockTimer& timer, Timed& timed, const Row& row) {
  std::uint64_t before = 0, after = 0;
  for (int pass = 0; pass < 2; ++pass) {  // the first one warms up
    before = *thread_allocations();
    for (std::size_t i = 0; i < row.blocks; ++i) {
      timer.time(timed, row.kind, row.mode, i * row.block, row.block, 0);
    }
    after = *thread_allocations();
  }
  return static_cast<double>(after - before) / static_cast<double>(row.blocks * row.block);
}

std::optional<Timing>& slot_of(QueryAnswers& answers, Mode mode) {
  switch (mode) {
    case Mode::single:
      return answers.single;
    case Mode::batch:
      return answers.batch;
    case Mode::raw:
      return answers.raw;
    case Mode::cached:
      break;
  }
  return answers.cached;
}

// Of the set's first kConsistencyCases those that are in this part.
std::size_t consistency_cases(const MeasureOptions& options) {
  if (options.first_case >= kConsistencyCases) return 0;
  return (kConsistencyCases - options.first_case + options.case_stride - 1) / options.case_stride;
}

bool any_answer(const QueryAnswers& answers) {
  return std::any_of(answers.status.begin(), answers.status.end(),
                     [](PairStatus status) { return status != PairStatus::unsupported; });
}

// A row a backend, query and mode that has answers.
std::vector<Row> make_rows(std::span<const Timed> timed, std::span<const BackendAnswers> answers) {
  std::vector<Row> rows;
  for (std::size_t b = 0; b < timed.size(); ++b) {
    for (const QueryKind kind : kQueryKinds) {
      const bool supported =
          timed[b].narrowphase != nullptr && any_answer(answers[b].queries[index_of(kind)]);
      if (supported) rows.push_back({b, kind, Mode::single, 0, 0, {}});
      if (supported) rows.push_back({b, kind, Mode::batch, 0, 0, {}});
      if (supported) rows.push_back({b, kind, Mode::cached, 0, 0, {}});
      if (timed[b].raw != nullptr && timed[b].raw->supports(kind))
        rows.push_back({b, kind, Mode::raw, 0, 0, {}});
    }
  }
  return rows;
}

struct TimedBlock {
  std::size_t row, block;
};

// Blocks of all rows in one random order, so that what slows the machine slows all alike.
std::vector<TimedBlock> shuffled_blocks(std::span<const Row> rows, std::size_t pairs, Random& random) {
  std::vector<TimedBlock> blocks;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::size_t most = pairs / rows[r].block;
    const std::size_t first = random.below(static_cast<std::uint32_t>(most));
    for (std::size_t i = 0; i < rows[r].blocks; ++i) blocks.push_back({r, (first + i) % most});
  }
  shuffle(blocks, random);
  return blocks;
}

void time_blocks(std::span<Row> rows, BlockTimer& timer, std::span<Timed> timed, int repetitions,
                 Random& random, const Progress& progress) {
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    const std::vector<TimedBlock> blocks = shuffled_blocks(rows, timer.pairs(), random);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      Row& row = rows[blocks[i].row];
      row.averages.push_back(timer.time(timed[row.backend], row.kind, row.mode, blocks[i].block * row.block,
                                        row.block, warm_pairs(row)));
      if (progress && i % 256 == 0) {
        progress((repetition + static_cast<double>(i) / static_cast<double>(blocks.size())) / repetitions);
      }
    }
  }
}

bool is_same(double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); }

bool is_same(const Vector3& x, const Vector3& y) {
  return is_same(x[0], y[0]) && is_same(x[1], y[1]) && is_same(x[2], y[2]);
}

bool is_same(const ContactPoint& x, const ContactPoint& y) {
  return is_same(x.p_A_W, y.p_A_W) && is_same(x.p_B_W, y.p_B_W) && is_same(x.separation, y.separation);
}

// All that an answer says: the figures of its geometry, and as many points as it counts.
bool is_same_answer(const NarrowphaseOutput& x, const NarrowphaseOutput& y) {
  if (x.status[0] != y.status[0]) return false;
  if (x.geometry.empty()) return true;
  const PairGeometry &of_x = x.geometry[0], &of_y = y.geometry[0];
  if (!is_same(of_x.separation, of_y.separation) || !is_same(of_x.n_AB_W, of_y.n_AB_W) ||
      !is_same(of_x.p_A_W, of_y.p_A_W) || !is_same(of_x.p_B_W, of_y.p_B_W) ||
      of_x.point_count != of_y.point_count)
    return false;
  if (x.points.empty()) return true;
  const int count = std::clamp(of_x.point_count, 0, kMaxManifoldPoints);
  return std::equal(x.points.begin(), x.points.begin() + count, y.points.begin(),
                    [](const ContactPoint& p, const ContactPoint& q) { return is_same(p, q); });
}

// Asks all pairs once more in the workspace that was timed, after all its calls, block by block.
void ask_later(Timed& timed, const PairSet& set, QueryKind kind, std::size_t block, QueryAnswers& answers) {
  const std::size_t pairs = set.pairs.size();
  QueryAnswers again;
  make_slots(again, kind, pairs);
  const auto ask_from = [&](std::size_t first) {
    for (; first < pairs; first += block) {
      const std::size_t count = std::min(block, pairs - first);
      timed.narrowphase->evaluate({std::span(set.pairs).subspan(first, count), set.poses, query_for(kind)},
                                  slots(again, first, count), *timed.workspace);
    }
  };
  ask_from(0);
  // A workspace whose engine was given up, as timing asked again and again what ends it, fails all pairs to
  // the last one unasked: these are asked in a new one.
  const auto is_answer = [](PairStatus status) { return status != PairStatus::failed; };
  const auto last = std::find_if(again.status.rbegin(), again.status.rend(), is_answer);
  const auto given_up = static_cast<std::size_t>(again.status.rend() - last);
  if (std::any_of(answers.status.begin() + static_cast<std::ptrdiff_t>(given_up), answers.status.end(),
                  is_answer)) {
    timed.workspace = timed.narrowphase->make_workspace();
    ask_from(given_up);
  }
  // What differs is kept.
  for (std::size_t i = 0; i < pairs; ++i) {
    const NarrowphaseOutput now = slots(again, i, 1);
    if (is_same_answer(now, slots(answers, i, 1))) continue;
    answers.later.push_back({i,
                             now.status[0],
                             now.geometry.empty() ? no_geometry() : now.geometry[0],
                             {now.points.begin(), now.points.end()}});
  }
}

void time_pairs(std::span<Timed> timed, const PairSet& set, const MeasureOptions& options,
                std::span<BackendAnswers> answers, const Progress& progress) {
  Random random(mix_seed(options.seed, 0x74696d65, set.pairs.size()));
  std::vector<SolidPair> shuffled = set.pairs;
  shuffle(shuffled, random);
  BlockTimer timer(set, std::move(shuffled), std::max(options.batch, options.block));

  // Rows get their sizes before any is timed: blocks of all rows are mixed.
  std::vector<Row> rows = make_rows(timed, answers);
  for (Row& row : rows) {
    size_row(row, timer, timed[row.backend], options);
    if (row.mode == Mode::single && thread_allocations()) {
      answers[row.backend].queries[index_of(row.kind)].allocations =
          allocations_per_query(timer, timed[row.backend], row);
    }
  }
  time_blocks(rows, timer, timed, options.repetitions, random, progress);
  // Each row's quantiles, then single calls for its tail; what a backend answers after all that.
  for (Row& row : rows) {
    slot_of(answers[row.backend].queries[index_of(row.kind)], row.mode) =
        summarise_blocks(row.averages, static_cast<std::size_t>(options.repetitions));
    slot_of(answers[row.backend].queries[index_of(row.kind)], row.mode)->block = row.block;
  }
  for (const Row& row : rows) {
    if (row.mode != Mode::single) continue;
    std::vector<double> calls = timer.time_calls(timed[row.backend], row.kind, options.tail_seconds);
    add_calls(*answers[row.backend].queries[index_of(row.kind)].single, calls);
    ask_later(timed[row.backend], set, row.kind, options.block,
              answers[row.backend].queries[index_of(row.kind)]);
  }
}

// Every frame of every backend and query, shuffled; the average is over a frame, not a pair.
void time_frames(std::span<Timed> timed, const PairSet& set, const MeasureOptions& options,
                 std::span<BackendAnswers> answers) {
  // One thing to time: a frame, with one query of one backend.
  struct Item {
    std::size_t backend, frame;
    QueryKind kind;
  };
  std::vector<Item> items;
  QueryAnswers scratch;
  make_slots(scratch, QueryKind::manifold, set.pairs.size());
  const auto time_frame = [&](std::size_t backend, std::size_t frame, QueryKind kind) {
    const NarrowphaseInput input{set.pairs, set.frame_poses(frame), query_for(kind)};
    const NarrowphaseOutput output = slots(scratch, 0, set.pairs.size());
    const auto begin = Clock::now();
    timed[backend].narrowphase->evaluate(input, output, *timed[backend].workspace);
    return nanoseconds(begin, Clock::now());
  };
  // Slow rows take fewer frames, evenly spread: about slow_frame_seconds a repetition, judged by the middle
  // one.
  const auto stride_of = [&](std::size_t backend, QueryKind kind) {
    const double each = time_frame(backend, set.frames() / 2, kind);
    const double affordable = std::clamp(options.slow_frame_seconds * 1e9 / std::max(each, 1.0), 4.0, 200.0);
    return std::max<std::size_t>(1, set.frames() / static_cast<std::size_t>(affordable));
  };
  // Of the middle frame, which stride_of() ran just before.
  const auto allocations_per_frame_pair = [&](std::size_t backend, QueryKind kind) {
    const std::uint64_t before = *thread_allocations();
    time_frame(backend, set.frames() / 2, kind);
    return static_cast<double>(*thread_allocations() - before) / static_cast<double>(set.pairs.size());
  };
  // Frames of each backend and query.
  for (std::size_t b = 0; b < timed.size(); ++b) {
    for (const QueryKind kind : kQueryKinds) {
      if (timed[b].narrowphase == nullptr || !any_answer(answers[b].queries[index_of(kind)])) continue;
      const std::size_t stride = stride_of(b, kind);
      if (thread_allocations())
        answers[b].queries[index_of(kind)].allocations = allocations_per_frame_pair(b, kind);
      for (std::size_t frame = 0; frame < set.frames(); frame += stride) items.push_back({b, frame, kind});
    }
  }
  // All of them in random order, each repetition anew.
  std::vector<std::array<std::vector<double>, 3>> times(timed.size());
  Random random(mix_seed(options.seed, 0x6672616d, set.frames()));
  for (int repetition = 0; repetition < options.repetitions; ++repetition) {
    shuffle(items, random);
    for (const Item& item : items) {
      times[item.backend][index_of(item.kind)].push_back(time_frame(item.backend, item.frame, item.kind));
    }
  }
  for (std::size_t b = 0; b < timed.size(); ++b) {
    for (const QueryKind kind : kQueryKinds) {
      auto& sample = times[b][index_of(kind)];
      if (sample.empty()) continue;
      std::optional<Timing>& timing = answers[b].frame_by_query[index_of(kind)];
      timing = summarise_blocks(sample, static_cast<std::size_t>(options.repetitions));
      add_calls(*timing, sample);
    }
  }
}

}  // namespace

Query query_for(QueryKind kind) {
  Query query;
  query.kind = kind;
  if (kind != QueryKind::manifold) return query;
  query.max_separation = 0.0;
  query.max_point_separation = 1e-3;
  return query;
}

PairSet perturbed_set(const PairSet& set, const MeasureOptions& options) {
  PairSet moved = set;
  std::vector<int> uses(set.solids.size(), 0);
  for (const SolidPair& pair : set.pairs) {
    if (++uses[pair.a] > 1 || ++uses[pair.b] > 1) return set;
  }
  for (std::size_t i = 0; i < set.cases(); ++i) {
    Random random(mix_seed(options.seed, 0x6d6f7665, options.first_case + i * options.case_stride));
    const std::size_t frame = i / set.pairs.size();
    const SolidPair pair = set.pairs[i % set.pairs.size()];
    moved.poses[frame * set.solids.size() + pair.b].p +=
        random_direction(random) * (1e-9 * posed_pair(set, i).scale);
  }
  return moved;
}

std::vector<BackendAnswers> run_backends(std::span<const BackendRegistry::NarrowphaseEntry* const> backends,
                                         const PairSet& set, const MeasureOptions& options,
                                         const Progress& progress) {
  std::vector<BackendAnswers> answers(backends.size());
  std::vector<std::unique_ptr<Narrowphase>> narrowphases(backends.size());
  std::vector<std::unique_ptr<RawCheck>> raws(backends.size());
  std::vector<Timed> timed(backends.size());
  PairSet moved;
  if (options.perturb) moved = perturbed_set(set, options);
  // Every backend's answers, and its objects for timing.
  for (std::size_t b = 0; b < backends.size(); ++b) {
    narrowphases[b] = backends[b]->make();
    answers[b].name = backends[b]->name;
    answers[b].description = backends[b]->description;
    answers[b].capabilities = narrowphases[b]->capabilities();
    const bool whole = answer_all(*narrowphases[b], set, options, answers[b]);
    if (whole && options.perturb) {
      answer_frames(*narrowphases[b], moved, QueryKind::manifold, options.threads, answers[b].perturbed);
    }
    if (whole && options.check_consistency && set.frames() == 1)
      answers[b].consistency =
          check_consistency(*narrowphases[b], set, options.threads, consistency_cases(options));
    if (whole && (options.time_pairs || options.time_frames)) {
      timed[b].narrowphase = narrowphases[b].get();
      timed[b].workspace = narrowphases[b]->make_workspace();
      if (options.time_pairs && backends[b]->make_raw) {
        raws[b] = backends[b]->make_raw();
        raws[b]->build(set.solids);
        raws[b]->set_poses(set.poses);
        timed[b].raw = raws[b].get();
      }
    }
    if (progress) progress(0.5 * static_cast<double>(b + 1) / static_cast<double>(backends.size()));
  }
  // All are timed together.
  const Progress timing_progress = [&](double share) {
    if (progress) progress(0.5 + 0.5 * share);
  };
  if (options.time_pairs && set.frames() == 1 && !set.pairs.empty()) {
    time_pairs(timed, set, options, answers, timing_progress);
  }
  if (options.time_frames) time_frames(timed, set, options, answers);
  return answers;
}

}  // namespace touchstone::measures
