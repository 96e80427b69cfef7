#include <algorithm>
#include <array>
#include <limits>

#include "touchstone/contact_core/world/world_state.hpp"

// What a frame reports.

namespace touchstone {

std::string_view to_string(EventKind kind) {
  constexpr std::array<std::string_view, 8> kNames{
      "near", "began", "persists", "ended", "penetrating_at_start", "blocked", "refused", "at_limit"};
  return kNames[static_cast<std::size_t>(kind)];
}

ContactEvent command_event(EventKind kind, ObjectHandle object) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  ContactEvent event{kind, object, {}, {0, 0}, 0.0, {}};
  event.geometry.separation = kNaN;
  event.geometry.n_AB_W = event.geometry.p_A_W = event.geometry.p_B_W = Vector3::Constant(kNaN);
  return event;
}

ContactEvent ContactWorld::State::pair_event(EventKind kind, const SolidPair& pair, double s,
                                             const PairGeometry& geometry) const {
  const auto within = [&](SolidIndex solid) { return solid - layout.first_solid_of(solid); };
  return {kind,    layout.handle_of(pair.a), layout.handle_of(pair.b), {within(pair.a), within(pair.b)}, s,
          geometry};
}

void ContactWorld::State::add_event(EventKind kind, const SolidPair& pair, double s,
                                    const PairGeometry& geometry) {
  events.push_back(pair_event(kind, pair, s, geometry));
}

/// Set-up gives solids new numbers, in the same order; contacts stay what they are.
void ContactWorld::State::keep_contacts(const Layout& next) {
  std::erase_if(contacts, [&](ContactState& contact) {
    const auto a = next.find(layout, contact.solids.a), b = next.find(layout, contact.solids.b);
    if (a && b) {
      contact.solids = {*a, *b};
      return false;
    }
    left_contacts.push_back(pair_event(EventKind::ended, contact.solids, 0.0, contact.geometry));
    return true;
  });
}

bool ContactWorld::State::is_in_contact(const FramePair& pair, double separation, bool was_in_contact) {
  const bool is_close = separation <= (was_in_contact ? 2.0 * pair.gap : pair.gap);
  if (!query->judges_poses()) return is_close;
  // The backend says what is contact, the gap only how long one lasts: what it does not see is none.
  if (query->verdict(from[pair.solids.a], from[pair.solids.b]) != PairStatus::separated) return true;
  return is_close && separation >= 0.0 && (was_in_contact || pair.has_blocked);
}

void ContactWorld::State::report_pair(const FramePair& pair, bool was_in_contact) {
  PairGeometry geometry = pair.impact.geometry;
  query->set_pair(pair.solids);
  query->separation(from[pair.solids.a], from[pair.solids.b], geometry);
  const bool in_contact = is_in_contact(pair, geometry.separation, was_in_contact);
  const bool at_start = !was_in_contact && pair.impact.starts_overlapping;
  if (at_start) add_event(EventKind::penetrating_at_start, pair.solids, 0.0, geometry);
  if (pair.has_blocked) add_event(EventKind::blocked, pair.solids, pair.blocked_at, geometry);
  if (in_contact) {
    const double s = pair.has_blocked ? pair.blocked_at : pair.impact.lo;
    add_event(was_in_contact ? EventKind::persists : EventKind::began, pair.solids, was_in_contact ? 1.0 : s,
              geometry);
    contacts.push_back({pair.solids, geometry});
  } else if (was_in_contact) {
    add_event(EventKind::ended, pair.solids, 1.0, geometry);
  } else if (geometry.separation >= 0.0 && geometry.separation <= pair.rule.warn_distance) {
    add_event(EventKind::near, pair.solids, 1.0, geometry);
  }
}

void ContactWorld::State::report_pairs() {
  events.insert(events.end(), left_contacts.begin(), left_contacts.end());
  left_contacts.clear();
  contacts_before.swap(contacts);
  contacts.clear();
  ahead.clear();
  for (const FramePair& pair : pairs)
    if (!pair.impact.is_far || pair.has_blocked) ahead.push_back(pair.solids);
  query->look_ahead(ahead, from);
  auto before = contacts_before.begin();
  const auto end_those_before = [&](const SolidPair& limit) {
    for (; before != contacts_before.end() && before->solids < limit; ++before)
      add_event(EventKind::ended, before->solids, 1.0, before->geometry);
  };
  for (const FramePair& pair : pairs) {
    end_those_before(pair.solids);
    const bool was_in_contact = before != contacts_before.end() && before->solids == pair.solids;
    if (was_in_contact) ++before;
    if (!pair.impact.is_far || was_in_contact || pair.has_blocked) report_pair(pair, was_in_contact);
  }
  end_those_before({std::numeric_limits<SolidIndex>::max(), 0});
}

}  // namespace touchstone
