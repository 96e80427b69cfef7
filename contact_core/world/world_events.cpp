#include <algorithm>
#include <array>
#include <atomic>
#include <limits>

#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
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
  query->set_pair(pair.solids);
  if (query->verdict(from[pair.solids.a], from[pair.solids.b]) != PairStatus::separated) return true;
  return is_close && separation >= 0.0 && (has_been || pair.stop != kNoMoment);
}

SeparationMemo::Answer ContactWorld::State::answer_now(const SolidPair& pair) {
  SeparationMemo::Answer answer{PairStatus::failed, no_geometry()};
  query->set_pair(pair);
  answer.status = query->separation(from[pair.a], from[pair.b], answer.geometry);
  return answer;
}

/// @param at_end where the frame left the two.
void ContactWorld::State::report_pair(const FramePair& pair, bool was_in_contact,
                                      const PairGeometry& at_end) {
  const Moment end{parts.count() - 1, 1.0, at_end};
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

/// Takes up what was left out as its path leads far away, where that path was not gone to its end, and what
/// was in contact before: it may be near yet.
void ContactWorld::State::add_left_out_pairs() {
  const std::size_t known = pairs.size();
  add_left_out();
  for (const ContactState& contact : contacts)
    if (is_checked(contact.solids) &&
        !is_among(std::span<const FramePair>(pairs).first(known), contact.solids))
      pairs.push_back(frame_pair(contact.solids));
  merge_by_solids(pairs, known);
}

/// The watched pairs of movers that were stopped, if not known to be apart. Of two such it is the lower
/// one's.
void ContactWorld::State::add_left_out() {
  constexpr std::size_t kRootsAtOnce = 16, kPairsAtOnce = 64;
  const std::size_t known = pairs.size();
  std::atomic<std::size_t> count{0};
  const auto take = [&](std::uint32_t index, SolidIndex solid) {
    const WatchedPair& watch = watched[index];
    const SolidPair pair{watch.a, watch.b};
    if (is_clear(watch) || (solid != pair.a && is_short[root_of(pair.a)])) return;
    if (is_among(std::span<const FramePair>(pairs).first(known), pair) || !is_checked(pair) ||
        is_among(contacts, pair))
      return;
    gathered[count.fetch_add(1, std::memory_order_relaxed)] = {pair, index};
  };
  gathered.resize(std::max(gathered.size(), 4 * std::size_t{watched.size()}));
  lanes.for_each(movers.size(), kRootsAtOnce, [&](NarrowphaseQuery&, std::size_t i) {
    if (!is_short[movers[i]] || mechanism_of(movers[i]) != nullptr) return;
    for_each_solid(movers[i], [&](SolidIndex solid) {
      watched.for_each_of(solid, [&](std::uint32_t index) { take(index, solid); });
    });
  });
  // Of an arm's many pairs those that are not lively are clear.
  for (const std::uint32_t root : movers) {
    if (!is_short[root] || mechanism_of(root) == nullptr) continue;
    if (needs_lively) choose_lively();
    for (const std::uint32_t index : lively) {
      const auto [a, b] = watched.solids(index);
      if (root_of(a) == root || root_of(b) == root) take(index, root_of(a) == root ? a : b);
    }
  }
  sort_gathered(count);
  close.clear();
  for (std::size_t k = 0; k < count; ++k) close.push_back(gathered[k].watch);
  place_vertices(*this, lanes, watched, close);
  pairs.resize(known + count);
  examined.resize(std::max(examined.size(), pairs.size()));
  lanes.for_each(count, kPairsAtOnce, [&](NarrowphaseQuery&, std::size_t i) {
    WatchedPair& watch = watched[close[i]];
    FramePair& entry = pairs[known + i] = frame_pair({watch.a, watch.b});
    const bool is_apart =
        is_apart_by_axis(*this, watch, entry, travelled(entry.solids, watch.own) * kDown, 0.0);
    examined[known + i].stage = is_apart ? PairStage::apart : PairStage::open;
  });
  std::size_t kept = known;
  for (std::size_t k = known; k < pairs.size(); ++k) {
    if (examined[k].stage == PairStage::apart) continue;
    if (kept != k) pairs[kept] = pairs[k];
    ++kept;
  }
  pairs.resize(kept);
}

/// Removed, switched off, exempt, latched to one another.
void ContactWorld::State::end_unchecked(const ContactState& contact) {
  events.push_back(pair_event(EventKind::ended, contact.solids, {0, 0.0, contact.geometry},
                              answer_now(contact.solids).geometry));
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
  answers.resize(std::max(answers.size(), ahead.size()));
  lanes.ask(ahead, from, answers);
  std::size_t answered = 0;
  auto before = contacts_before.begin();
  const auto end_those_before = [&](const SolidPair& limit) {
    for (; before != contacts_before.end() && before->solids < limit; ++before) end_unchecked(*before);
  };
  for (const FramePair& pair : pairs) {
    end_those_before(pair.solids);
    const bool was = before != contacts_before.end() && before->solids == pair.solids;
    if (was) ++before;
    if (!pair.impact.is_far || pair.has_moment())
      report_pair(pair, was, answers[answered++].geometry);
    else if (was)
      report_pair(pair, was, answer_now(pair.solids).geometry);
  }
  end_those_before({std::numeric_limits<SolidIndex>::max(), 0});
}

}  // namespace touchstone
