#include "touchstone/tests/world/progress/progress_page.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "touchstone/examples/program/terminal/machine.hpp"
#include "touchstone/examples/program/terminal/text_table.hpp"

namespace touchstone {
namespace {

using program::format_count;

std::string row(const ProgressFigures& f) {
  const double frames = static_cast<double>(std::max<std::uint64_t>(f.frames, 1));
  return fmt::format(
      "| {} | {:g} | {:g} | {} | {} | {} | {} | {} | {} of {} | {:.2g} | {} | {} | {:.0f} | {:.0f} |\n",
      f.run.scene, f.run.rate, f.run.gap, f.run.seed, format_count(f.run.trials), format_count(f.frames),
      format_count(f.blocked), format_count(f.motionless), format_count(f.frozen), format_count(f.open),
      100.0 * f.frozen_share(), f.stuck, f.merged, f.sum_us / frames, f.worst_us);
}

}  // namespace

std::string progress_page(std::span<const ProgressFigures> figures, const std::string& command) {
  std::string out = program::page_head("How far motion gets", command);
  out +=
      "A blocked frame is *open* where small steps, searched by other means, come nearer to the command by "
      "a\n"
      "thousandth of what is left, and *frozen* where the world then takes less than a tenth of that; of "
      "each trial\n"
      "at most some 40 frames are searched. *Stuck*: trials at whose end small steps go on by more than a "
      "hundredth\n"
      "of their path. *Merged*: frames searched in which two solids touch, by `exact` at samples of every "
      "part.\n"
      "*Mean* and *worst* are of a frame, in thread CPU time.\n\n"
      "| scene | Hz | gap [m] | seeds from | trials | frames | blocked | motionless | frozen of open | % | "
      "stuck | "
      "merged | mean [us] | worst [us] |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const ProgressFigures& each : figures) out += row(each);
  return out;
}

}  // namespace touchstone
