#include <algorithm>
#include <array>
#include <limits>

#include "touchstone/contact_core/world/world_state.hpp"

// What a frame reports: of each pair that matters, how it stands at the frame's end, and the moments that its
// parts noted.

namespace touchstone {

std::string_view to_string(EventKind kind) {
  constexpr std::array<std::string_view, 8> kNames{
      "near", "began", "persists", "ended", "penetrating_at_start", "blocked", "refused", "at_limit"};
  return kNames[static_cast<std::size_t>(kind)];
}

namespace {

/// Rounds sums of travels down.
constexpr double kDown = 1.0 - 0x1p-50;

PairGeometry no_geometry() {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const Vector3 nowhere = Vector3::Constant(kNaN);
  return {kNaN, nowhere, nowhere, nowhere, 0};
}

}  // namespace

ContactEvent command_event(EventKind kind, ObjectHandle object) {
  return {kind, object, {}, {0, 0}, 0.0, no_geometry(), 0, no_geometry()};
}

ContactEvent ContactWorld::State::pair_event(EventKind kind, const SolidPair& pair, const Moment& at,
                                             const PairGeometry& at_end) const {
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

ContactEvent ContactWorld::State::removed_event(const ContactState& contact) const {
  return pair_event(EventKind::ended, contact.solids, {0, 0.0, contact.geometry}, no_geometry());
}

/// Set-up gives solids new numbers, in the same order; contacts stay what they are.
void ContactWorld::State::keep_contacts(const Layout& next) {
  std::erase_if(contacts, [&](ContactState& contact) {
    const auto a = next.find(layout, contact.solids.a), b = next.find(layout, contact.solids.b);
    if (a && b) {
      contact.solids = {*a, *b};
      return false;
    }
    left_contacts.push_back(removed_event(contact));
    return true;
  });
}

/// Those of objects that are gone, or replaced. @param slots sorted.
void ContactWorld::State::end_contacts_of(std::span<const std::uint32_t> slots) {
  std::erase_if(contacts, [&](const ContactState& contact) {
    const auto is_there = [&](SolidIndex solid) {
      return std::binary_search(slots.begin(), slots.end(), layout.slot_of[solid]);
    };
    if (!is_there(contact.solids.a) && !is_there(contact.solids.b)) return false;
    left_contacts.push_back(removed_event(contact));
    return true;
  });
}

bool ContactWorld::State::is_in_contact(const FramePair& pair, double separation, bool has_been) {
  // The gap grows with the distance from the origin.
  const double own_gap = std::max(pair.gap, gap_of(pair.solids));
  // A narrowphase without an answer ends nothing.
  const bool is_close = has_been ? !(separation > 2.0 * own_gap) : separation <= own_gap;
  if (!query->judges_poses()) return is_close;
  // The backend says what is contact, the gap only how long one lasts: what it does not see is none.
  if (query->verdict(from[pair.solids.a], from[pair.solids.b]) != PairStatus::separated) return true;
  return is_close && separation >= 0.0 && (has_been || pair.stop != kNoMoment);
}

PairGeometry ContactWorld::State::geometry_now(const SolidPair& pair) {
  PairGeometry geometry = no_geometry();
  query->set_pair(pair);
  query->separation(from[pair.a], from[pair.b], geometry);
  return geometry;
}

void ContactWorld::State::report_pair(const FramePair& pair, bool was_in_contact) {
  const Moment end{slides.part_count - 1, 1.0, geometry_now(pair.solids)};
  const double separation = end.geometry.separation;
  const bool touched = !was_in_contact && pair.touch != kNoMoment;
  const Moment& first = touched ? moments[pair.touch] : end;
  const bool in_contact = is_in_contact(pair, separation, was_in_contact || touched);
  const auto add = [&](EventKind kind, const Moment& at) {
    events.push_back(pair_event(kind, pair.solids, at, end.geometry));
  };
  if (touched && pair.impact.starts_overlapping) add(EventKind::penetrating_at_start, first);
  if (pair.stop != kNoMoment) add(EventKind::blocked, moments[pair.stop]);
  if (!was_in_contact && (touched || in_contact)) add(EventKind::began, first);
  if (was_in_contact && in_contact) add(EventKind::persists, end);
  if (in_contact) contacts.push_back({pair.solids, end.geometry});
  if (!in_contact && (was_in_contact || touched))
    add(EventKind::ended, end);
  else if (!in_contact && separation >= 0.0 && separation <= pair.rule.warn_distance)
    add(EventKind::near, end);
}

bool ContactWorld::State::is_among(const SolidPair& pair, std::size_t known) const {
  const auto end = pairs.begin() + static_cast<std::ptrdiff_t>(known);
  const auto place = std::lower_bound(pairs.begin(), end, pair,
                                      [](const FramePair& x, const SolidPair& y) { return x.solids < y; });
  return place != end && place->solids == pair;
}

/// Takes up what was left out as its path leads far away, where that path was not gone to its end, and what
/// was in contact before: it may be near yet.
void ContactWorld::State::add_left_out_pairs() {
  const std::size_t known = pairs.size();
  for (const ContactState& contact : contacts)
    if (is_checked(contact.solids) && !is_among(contact.solids, known))
      pairs.push_back(frame_pair(contact.solids));
  for (const std::uint32_t root : movers)
    if (is_short[root])
      for_each_member(root, [&](std::uint32_t slot) {
        for (SolidIndex solid = layout.first_solid[slot]; solid < layout.first_solid[slot + 1]; ++solid)
          watched.for_each_of(solid, [&](std::uint32_t index) { add_left_out(index, solid, known); });
      });
  if (pairs.size() == known) return;
  std::sort(pairs.begin(), pairs.end(),
            [](const FramePair& a, const FramePair& b) { return a.solids < b.solids; });
}

/// @param solid of a mover that was stopped; of two such it is taken up with the lower one.
void ContactWorld::State::add_left_out(std::uint32_t index, SolidIndex solid, std::size_t known) {
  WatchedPair& watch = watched[index];
  const SolidPair pair{watch.a, watch.b};
  if (solid != pair.a && is_short[root_of(pair.a)]) return;
  if (is_clear(watch) || !is_checked(pair) || is_among(pair, known) || was_in_contact(pair)) return;
  const FramePair entry = frame_pair(pair);
  if (!is_apart_by_axis(watch, entry, travelled(pair, watch.own) * kDown, 0.0)) pairs.push_back(entry);
}

/// Removed, switched off, exempt, latched to one another.
void ContactWorld::State::end_unchecked(const ContactState& contact) {
  events.push_back(
      pair_event(EventKind::ended, contact.solids, {0, 0.0, contact.geometry}, geometry_now(contact.solids)));
}

void ContactWorld::State::report_pairs() {
  events.insert(events.end(), left_contacts.begin(), left_contacts.end());
  left_contacts.clear();
  add_left_out_pairs();
  contacts_before.swap(contacts);
  contacts.clear();
  ahead.clear();
  for (const FramePair& pair : pairs)
    if (!pair.impact.is_far || pair.has_moment()) ahead.push_back(pair.solids);
  query->look_ahead(ahead, from);
  auto before = contacts_before.begin();
  const auto end_those_before = [&](const SolidPair& limit) {
    for (; before != contacts_before.end() && before->solids < limit; ++before) end_unchecked(*before);
  };
  for (const FramePair& pair : pairs) {
    end_those_before(pair.solids);
    const bool was = before != contacts_before.end() && before->solids == pair.solids;
    if (was) ++before;
    if (!pair.impact.is_far || was || pair.has_moment()) report_pair(pair, was);
  }
  end_those_before({std::numeric_limits<SolidIndex>::max(), 0});
}

}  // namespace touchstone
