#include "touchstone/examples/station/exchange/live_outputs.hpp"

#include <fmt/format.h>

#include <system_error>

namespace touchstone::station {
namespace {

const training::OutputOptions& prepared(const training::OutputOptions& options, const std::string& name) {
  training::prepare_outputs(options, {name});
  return options;
}

}  // namespace

LiveOutputs::LiveOutputs(const training::OutputOptions& options, const Session& session,
                         const std::string& name)
    : outputs_(prepared(options, name), session.flight().scene().setting, name, true),
      has_animation_(!options.animations.empty()) {
  if (!outputs_.receivers().empty()) shown_.emplace(session, outputs_.receivers());
}

void LiveOutputs::send(const Session& session) noexcept {
  if (shown_ && !shown_->send(session)) ++of_other_scenes_;
}

std::string LiveOutputs::lines(std::span<const training::OutputFigures> figures) const {
  std::string out;
  for (const training::OutputFigures& each : figures) {
    out += each.receiver + ":";
    if (each.status.offered > 0)
      out += fmt::format(" {} of {} frames delivered, {} dropped", each.status.delivered, each.status.offered,
                         each.status.dropped);
    if (each.status.errors > 0)
      out += fmt::format(", {} errors, the last: {}", each.status.errors,
                         std::generic_category().message(each.status.last_error));
    if (each.status.offered > 0 && of_other_scenes_ > 0)
      out += fmt::format(", {} of another scene not shown", of_other_scenes_);
    if (each.status.offered == 0 && each.error.empty()) out += " written";
    out += (each.error.empty() ? "" : " " + each.error) + "\n";
  }
  return out;
}

std::string LiveOutputs::end() { return lines(outputs_.end()); }

std::string LiveOutputs::write_animation() { return lines(outputs_.write_animation()); }

}  // namespace touchstone::station
