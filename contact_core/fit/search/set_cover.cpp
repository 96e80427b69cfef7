#include "touchstone/contact_core/fit/search/set_cover.hpp"

#include <algorithm>
#include <optional>

#include "touchstone/contact_core/geometry/disjoint_sets.hpp"

namespace touchstone::fit {
namespace {

// Gao, Weise, Li, "An efficient local search heuristic with row weighting for the unicost set covering
// problem", 2015.
class LocalSearch {
 public:
  LocalSearch(std::span<const std::vector<std::uint32_t>> sets, std::size_t elements)
      : sets_(sets),
        first_(elements + 1, 0),
        weight_(elements, 1),
        count_(elements, 0),
        mixed_(elements, 0),
        place_(elements),
        score_(sets.size(), 0),
        changed_(sets.size(), 0),
        least_(least_sets(sets, elements)),
        may_enter_(sets.size(), 1) {
    // Elements' holders stand one after the other, so that a walk over them is one in memory.
    for (const std::vector<std::uint32_t>& set : sets)
      for (const std::uint32_t e : set) ++first_[e + 1];
    for (std::size_t e = 0; e < elements; ++e) first_[e + 1] += first_[e];
    holders_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t s = 0; s < sets.size(); ++s) {
      score_[s] = sets[s].size();
      for (const std::uint32_t e : sets[s]) holders_[next[e]++] = s;
    }
    for (std::uint32_t e = 0; e < elements; ++e) open(e);
  }

  std::vector<std::size_t> run(const std::vector<std::size_t>& start, std::uint64_t work) {
    for (const std::size_t s : start) put_in(s);
    work_ = 0;
    std::vector<std::size_t> best = start;
    if (best.size() <= least_) return best;
    // Where a cover is found, one set goes; then sets go and come until everything is held again.
    for (std::uint64_t i = 1; work_ < work; ++i) {
      while (open_.empty() && !chosen_.empty()) {
        best = chosen_;
        if (best.size() <= least_) return best;
        take_out(least_missed(std::nullopt), i);
      }
      if (chosen_.size() < 2) return one_of(best);
      take_out(least_missed(entered_), i);
      const std::uint32_t element = open_[random() % open_.size()];
      entered_ = most_needed(element);
      put_in(*entered_);
      changed_[*entered_] = i;
      for (const std::uint32_t e : open_) {
        ++weight_[e];
        work_ += holders_of(e).size();
        for (const std::uint32_t s : holders_of(e)) ++score_[s];
      }
    }
    return best;
  }

 private:
  // Fewer than two are one that holds everything.
  std::vector<std::size_t> one_of(const std::vector<std::size_t>& two) const {
    for (std::size_t s = 0; s < sets_.size(); ++s)
      if (sets_[s].size() == weight_.size()) return {s};
    return two;
  }

  std::span<const std::uint32_t> holders_of(std::size_t e) const {
    return std::span(holders_).subspan(first_[e], first_[e + 1] - first_[e]);
  }

  // Of a chosen set, `score_` weighs what no other one holds; of another, what is open and it would hold.
  void put_in(std::size_t set) {
    chosen_.push_back(set);
    score_[set] = 0;
    for (const std::uint32_t e : sets_[set]) {
      if (++count_[e] == 1) {
        close(e);
        score_[set] += weight_[e];
        work_ += holders_of(e).size();
        for (const std::uint32_t s : holders_of(e))
          if (s != set) score_[s] -= weight_[e], may_enter_[s] = 1;
      } else if (count_[e] == 2) {
        work_ += holders_of(e).size();
        score_[mixed_[e]] -= weight_[e];  // of the only one before
      }
      mixed_[e] ^= set;
    }
  }

  void take_out(std::size_t set, std::uint64_t when) {
    chosen_.erase(std::find(chosen_.begin(), chosen_.end(), set));
    score_[set] = 0;
    for (const std::uint32_t e : sets_[set]) {
      mixed_[e] ^= set;
      if (--count_[e] == 0) {
        open(e);
        score_[set] += weight_[e];
        work_ += holders_of(e).size();
        for (const std::uint32_t s : holders_of(e))
          if (s != set) score_[s] += weight_[e], may_enter_[s] = 1;
      } else if (count_[e] == 1) {
        work_ += holders_of(e).size();
        score_[mixed_[e]] += weight_[e];  // of the only one left
      }
    }
    may_enter_[set] = 0;
    changed_[set] = when;
  }

  // Of equal ones that which has stood longest.
  std::size_t least_missed(std::optional<std::size_t> except) {
    work_ += chosen_.size();
    std::optional<std::size_t> least;
    for (const std::size_t s : chosen_) {
      if (s == except) continue;
      if (!least || score_[s] < score_[*least] ||
          (score_[s] == score_[*least] && changed_[s] < changed_[*least]))
        least = s;
    }
    return *least;
  }

  // One that was taken out enters only when something about it has changed, unless it is the only one.
  std::size_t most_needed(std::uint32_t element) const {
    std::optional<std::size_t> most;
    const auto is_better = [&](std::size_t s) {
      if (may_enter_[s] != may_enter_[*most]) return may_enter_[s] > may_enter_[*most];
      if (score_[s] != score_[*most]) return score_[s] > score_[*most];
      return changed_[s] < changed_[*most];
    };
    for (const std::uint32_t s : holders_of(element))
      if (!most || is_better(s)) most = s;
    return *most;
  }

  void open(std::uint32_t element) {
    place_[element] = open_.size();
    open_.push_back(element);
  }

  void close(std::uint32_t element) {
    open_[place_[element]] = open_.back();
    place_[open_.back()] = place_[element];
    open_.pop_back();
  }

  std::uint64_t random() {  // Marsaglia's xorshift
    state_ ^= state_ << 13;
    state_ ^= state_ >> 7;
    state_ ^= state_ << 17;
    return state_;
  }

  std::span<const std::vector<std::uint32_t>> sets_;
  std::vector<std::size_t> first_;      ///< of an element's in `holders_`
  std::vector<std::uint32_t> holders_;  ///< the sets that hold each element
  std::vector<std::uint64_t> weight_;
  std::vector<std::uint32_t> count_;  ///< the chosen sets that hold each element
  std::vector<std::size_t> mixed_;    ///< these, by exclusive or: where there is one, that one
  std::vector<std::size_t> place_;    ///< of open elements in `open_`
  std::vector<std::uint32_t> open_;
  std::vector<std::uint64_t> score_, changed_;
  std::size_t least_;  ///< no cover has fewer
  std::vector<std::uint8_t> may_enter_;
  std::vector<std::size_t> chosen_;
  std::optional<std::size_t> entered_;
  /// Scores that are looked at or may have to change: of an element that one chosen set holds it counts all
  /// of its holders, so that a search ends where it did when they were all looked at.
  std::uint64_t work_ = 0;
  std::uint64_t state_ = 88172645463325252U;
};

// Sets and elements that no set shares with others: each part has its own fewest.
struct Part {
  std::vector<std::size_t> sets, start;  // the second by place in the first
  std::size_t elements = 0;
};

// The elements' numbers in their parts go to `own`.
std::vector<Part> parts_of(std::span<const std::vector<std::uint32_t>> sets,
                           const std::vector<std::size_t>& start, std::vector<std::uint32_t>& own) {
  // Elements of one set are joined, each part under its first.
  DisjointSets joined(own.size());
  for (const std::vector<std::uint32_t>& set : sets)
    for (const std::uint32_t e : set) joined.join(set.front(), e);
  // Elements, sets and those of the start are numbered anew, in the order in which they are.
  std::vector<std::size_t> part_of(own.size()), place(sets.size());
  std::vector<Part> parts;
  for (std::uint32_t e = 0; e < own.size(); ++e) {
    const std::uint32_t first = joined.least_of(e);
    if (first == e) {
      part_of[e] = parts.size();
      parts.emplace_back();
    }
    part_of[e] = part_of[first];
    own[e] = static_cast<std::uint32_t>(parts[part_of[e]].elements++);
  }
  for (std::size_t s = 0; s < sets.size(); ++s) {
    if (sets[s].empty()) continue;
    std::vector<std::size_t>& into = parts[part_of[sets[s].front()]].sets;
    place[s] = into.size();
    into.push_back(s);
  }
  for (const std::size_t s : start)
    if (!sets[s].empty()) parts[part_of[sets[s].front()]].start.push_back(place[s]);
  return parts;
}

}  // namespace

std::size_t least_sets(std::span<const std::vector<std::uint32_t>> sets, std::size_t elements) {
  std::vector<std::vector<std::uint32_t>> holders(elements);
  for (std::uint32_t s = 0; s < sets.size(); ++s)
    for (const std::uint32_t e : sets[s]) holders[e].push_back(s);
  std::stable_sort(holders.begin(), holders.end(),
                   [](const auto& a, const auto& b) { return a.size() < b.size(); });
  std::vector<std::uint8_t> is_needed(sets.size(), 0);
  std::size_t count = 0;
  for (const std::vector<std::uint32_t>& each : holders) {
    if (std::any_of(each.begin(), each.end(), [&](std::uint32_t s) { return is_needed[s] != 0; })) continue;
    for (const std::uint32_t s : each) is_needed[s] = 1;
    ++count;
  }
  return count;
}

std::vector<std::size_t> fewer_sets(std::span<const std::vector<std::uint32_t>> sets, std::size_t elements,
                                    const std::vector<std::size_t>& start, std::uint64_t work) {
  std::vector<std::size_t> result;
  if (start.empty()) return result;  // there is nothing to hold
  std::vector<std::uint32_t> own(elements);
  for (const Part& part : parts_of(sets, start, own)) {
    std::vector<std::vector<std::uint32_t>> own_sets;
    for (const std::size_t s : part.sets)
      for (std::vector<std::uint32_t>& set = own_sets.emplace_back(sets[s]); std::uint32_t & e : set)
        e = own[e];
    // Each may take as much as it has of the start.
    const std::uint64_t share = work / start.size() * part.start.size();
    for (const std::size_t s : LocalSearch(own_sets, part.elements).run(part.start, share))
      result.push_back(part.sets[s]);
  }
  return result;
}

}  // namespace touchstone::fit
