#include "touchstone/contact_core/world/frame/contact_log.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "touchstone/contact_core/memory/reserve_more.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"

namespace touchstone {

std::string_view to_string(EventKind kind) {
  constexpr std::array<std::string_view, 8> kNames{
      "near", "began", "persists", "ended", "penetrating_at_start", "blocked", "refused", "at_limit"};
  return kNames[static_cast<std::size_t>(kind)];
}

namespace {

ContactEvent pair_event(const Layout& layout, EventKind kind, const SolidPair& pair, const Moment& at,
                        const PairGeometry& at_end) {
  const auto within = [&](SolidIndex solid) { return solid - layout.first_solid_of(solid); };
  return {kind,
          layout.handle_of(pair.a),
          layout.handle_of(pair.b),
          {within(pair.a), within(pair.b)},
          at.s,
          at.geometry,
          at.part,
          at_end};
}

/// With an object that is gone, or with the check of the pair.
ContactEvent ended_event(const Layout& layout, const ContactState& contact, const PairGeometry& at_end) {
  return pair_event(layout, EventKind::ended, contact.solids, {0, 0.0, contact.geometry}, at_end);
}

PairGeometry geometry_now(const WorldModel& model, NarrowphaseQuery& query, const SolidPair& pair) {
  PairGeometry geometry = no_geometry();
  query.set_pair(pair);
  query.separation(model.from[pair.a], model.from[pair.b], geometry);
  return geometry;
}

bool is_in_contact(const WorldModel& model, NarrowphaseQuery& query, const FramePair& pair, double separation,
                   bool has_been) {
  // The gap grows with the distance from the origin.
  const double gap = std::max(pair.gap, model.gap_of(pair.solids));
  // A narrowphase without an answer ends nothing.
  const bool is_close = has_been ? !(separation > 2.0 * gap) : separation <= gap;
  if (!query.judges_poses()) return is_close;
  // The backend decides what is contact: the gap only says how long one lasts.
  query.set_pair(pair.solids);
  if (query.verdict(model.from[pair.solids.a], model.from[pair.solids.b]) != PairStatus::separated)
    return true;
  return is_close && separation >= 0.0 && (has_been || pair.stop != kNoMoment);
}

/// Appends the events of one pair. @param end where the frame left the two.
/// @returns whether they are in contact there.
bool report_pair(const WorldModel& model, NarrowphaseQuery& query, const FramePair& pair, bool was_in_contact,
                 const MomentLog& moments, const Moment& end, std::vector<ContactEvent>& events) {
  const double separation = end.geometry.separation;
  const bool touched = !was_in_contact && pair.touch != kNoMoment;
  const Moment& first = touched ? moments[pair.touch] : end;
  const bool in_contact = is_in_contact(model, query, pair, separation, was_in_contact || touched);
  const auto add = [&](EventKind kind, const Moment& at) {
    events.push_back(pair_event(model.layout, kind, pair.solids, at, end.geometry));
  };
  if (touched && pair.impact.starts_overlapping) add(EventKind::penetrating_at_start, first);
  if (pair.stop != kNoMoment) add(EventKind::blocked, moments[pair.stop]);
  if (!was_in_contact && (touched || in_contact)) add(EventKind::began, first);
  if (was_in_contact && in_contact) add(EventKind::persists, end);
  if (!in_contact && (was_in_contact || touched))
    add(EventKind::ended, end);
  else if (!in_contact && separation >= 0.0 && separation <= pair.rule.warn_distance)
    add(EventKind::near, end);
  return in_contact;
}

bool is_asked_ahead(const FramePair& pair) { return !pair.impact.is_far || pair.has_moment(); }

}  // namespace

bool touches(const WorldModel& model, NarrowphaseQuery& query, const FramePair& pair) {
  return is_in_contact(model, query, pair, geometry_now(model, query, pair.solids).separation, false);
}

void ContactLog::take_room(std::size_t solids) {
  reserve_more(contacts_, 64 + 16 * solids), reserve_more(contacts_before_, 64 + 16 * solids);
  reserve_more(ahead_, 64 + 16 * solids), reserve_more(answers_, 64 + 16 * solids);
}

void ContactLog::renumber(const Layout& before, const Layout& next) {
  reserve_more(left_, left_.size() + contacts_.size());  // nothing is lost where memory ends
  std::erase_if(contacts_, [&](ContactState& contact) {
    const auto a = next.find(before, contact.solids.a), b = next.find(before, contact.solids.b);
    if (a && b) {
      contact.solids = {*a, *b};
      return false;
    }
    left_.push_back(ended_event(before, contact, no_geometry()));
    return true;
  });
}

void ContactLog::end_of(const Layout& layout, std::span<const std::uint32_t> slots) {
  reserve_more(left_, left_.size() + contacts_.size());  // nothing is lost where memory ends
  std::erase_if(contacts_, [&](const ContactState& contact) {
    const auto is_there = [&](SolidIndex solid) {
      return std::binary_search(slots.begin(), slots.end(), layout.slot_of[solid]);
    };
    if (!is_there(contact.solids.a) && !is_there(contact.solids.b)) return false;
    left_.push_back(ended_event(layout, contact, no_geometry()));
    return true;
  });
}

void ContactLog::report(const WorldModel& model, FrameLanes& lanes, std::span<const FramePair> pairs,
                        const MomentLog& moments, std::uint32_t last_part,
                        std::vector<ContactEvent>& events) {
  // Events that came up between frames are reported first.
  events.insert(events.end(), left_.begin(), left_.end());
  left_.clear();
  contacts_before_.swap(contacts_);
  contacts_.clear();
  // One batch asks for the pairs that need their geometry at the end.
  ahead_.clear();
  for (const FramePair& pair : pairs)
    if (is_asked_ahead(pair)) ahead_.push_back(pair.solids);
  answers_.resize(std::max(answers_.size(), ahead_.size()));
  lanes.ask(ahead_, model.from, answers_);
  NarrowphaseQuery& query = lanes.first();
  std::size_t answered = 0;
  // Pairs and the contacts before are both sorted by solids and walked side by side.
  auto before = contacts_before_.begin();
  // Pairs that are no longer checked end: those switched off, exempt or latched to one another.
  const auto end_those_before = [&](const SolidPair& limit) {
    for (; before != contacts_before_.end() && before->solids < limit; ++before)
      events.push_back(ended_event(model.layout, *before, geometry_now(model, query, before->solids)));
  };
  // Each pair is compared with its contact of the frame before.
  for (const FramePair& pair : pairs) {
    end_those_before(pair.solids);
    const bool was = before != contacts_before_.end() && before->solids == pair.solids;
    if (was) ++before;
    if (!is_asked_ahead(pair) && !was) continue;
    const Moment end{
        last_part, 1.0,
        is_asked_ahead(pair) ? answers_[answered++].geometry : geometry_now(model, query, pair.solids)};
    if (report_pair(model, query, pair, was, moments, end, events))
      contacts_.push_back({pair.solids, end.geometry});
  }
  end_those_before({std::numeric_limits<SolidIndex>::max(), 0});
}

}  // namespace touchstone
