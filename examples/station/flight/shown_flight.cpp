#include "touchstone/examples/station/flight/shown_flight.hpp"

namespace touchstone::station {
namespace {

constexpr std::size_t kMostEvents = 1024;  // in a frame

}  // namespace

ShownFlight::ShownFlight(const Session& session, std::span<FrameOutput* const> receivers)
    : receivers_(receivers.begin(), receivers.end()), scene_(session.scene()) {
  const training::Setting& setting = session.flight().scene().setting;
  for (std::uint32_t i = 0; i < setting.object_count(); ++i) {
    poses_.push_back({{i, 0}, session.flight().ours().poses()[i]});
    for (FrameOutput* receiver : receivers_) receiver->add_object({{i, 0}, setting.object_name(i)});
  }
  events_.reserve(kMostEvents);
  for (FrameOutput* receiver : receivers_) receiver->write({session.frame(), session.time(), poses_, {}});
}

bool ShownFlight::send(const Session& session) noexcept {
  if (session.scene() != scene_) return false;
  const Flight& flight = session.flight();
  for (std::uint32_t i = 0; i < poses_.size(); ++i) poses_[i].X_WO = flight.ours().poses()[i];
  events_.clear();
  for (const ContactEvent& event : flight.events()) {
    if (events_.size() == kMostEvents) break;
    events_.push_back(event);
    const bool has_pair = event.kind != EventKind::refused && event.kind != EventKind::at_limit;
    events_.back().a = {flight.object_of(event.a), 0};
    if (has_pair) events_.back().b = {flight.object_of(event.b), 0};
  }
  for (FrameOutput* receiver : receivers_)
    receiver->write({session.frame(), session.time(), poses_, events_});
  return true;
}

}  // namespace touchstone::station
