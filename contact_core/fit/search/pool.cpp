#include "touchstone/contact_core/fit/search/pool.hpp"

#include <bit>
#include <utility>

namespace touchstone::fit {
namespace {

// Without a call, which the compiler makes of std::popcount where no instruction is sure to be there.
std::size_t count_bits(std::uint64_t bits) {
  bits -= bits >> 1 & 0x5555555555555555U;
  bits = (bits & 0x3333333333333333U) + (bits >> 2 & 0x3333333333333333U);
  bits = (bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0fU;
  return bits * 0x0101010101010101U >> 56;
}

std::uint64_t hash_of(std::span<const HeldWord> held) {
  std::uint64_t hash = 0;
  for (const HeldWord& word : held)
    hash = (hash ^ (word.index * 0x9e3779b97f4a7c15U) ^ word.bits) * 0xff51afd7ed558ccdU + (hash >> 29);
  return hash;
}

}  // namespace

Candidate::Candidate(const SixPlanes& hexahedron, std::span<const std::uint32_t> cells)
    : solid(hexahedron), count(cells.size()) {
  for (const std::uint32_t i : cells) {
    if (held.empty() || held.back().index != i / 64) held.push_back({i / 64, 0});
    held.back().bits |= std::uint64_t{1} << (i % 64);
  }
}

void CandidatePool::add(Candidate candidate) {
  const std::uint64_t hash = hash_of(candidate.held);
  const auto [first, last] = by_held_.equal_range(hash);
  for (auto known = first; known != last; ++known)
    if (candidates_[known->second].held == candidate.held) return;
  by_held_.emplace(hash, candidates_.size());
  for (const HeldWord& word : candidate.held)
    holders_[word.index].push_back({static_cast<std::uint32_t>(candidates_.size()), word.bits});
  candidates_.push_back(std::move(candidate));
}

void CandidatePool::forget(std::size_t i) {
  for (const HeldWord& word : candidates_[i].held)
    std::erase_if(holders_[word.index], [&](const Holder& holder) { return holder.candidate == i; });
  candidates_[i].held.clear();
  candidates_[i].count = 0;
}

OpenCells::OpenCells(const CandidatePool& pool, CellBits open)
    : pool_(pool), open_(std::move(open)), gains_(pool.size(), 0) {
  for (std::size_t word = 0; word < open_.size(); ++word) {
    if (open_[word] == 0) continue;
    count_ += count_bits(open_[word]);
    for (const CandidatePool::Holder& holder : pool.holders(word))
      if (const std::uint64_t bits = holder.bits & open_[word]; bits != 0)
        gains_[holder.candidate] += static_cast<std::uint32_t>(count_bits(bits));
  }
}

std::size_t OpenCells::next_from(std::size_t start, std::size_t cells) const {
  if (count_ == 0) return cells;
  std::size_t word = start / 64;
  std::uint64_t bits = open_[word] & ~std::uint64_t{0} << (start % 64);
  while (bits == 0) {
    word = word + 1 == open_.size() ? 0 : word + 1;
    bits = open_[word];
  }
  return word * 64 + static_cast<std::size_t>(std::countr_zero(bits));
}

std::size_t OpenCells::held_by(const Candidate& candidate) const {
  std::size_t count = 0;
  for (const HeldWord& word : candidate.held)
    if (const std::uint64_t bits = word.bits & open_[word.index]; bits != 0) count += count_bits(bits);
  return count;
}

void OpenCells::look_at_new() {
  while (gains_.size() < pool_.size())
    gains_.push_back(static_cast<std::uint32_t>(held_by(pool_[gains_.size()])));
}

OpenCells::Best OpenCells::best() {
  look_at_new();
  Best best{0, 0};
  for (std::size_t i = 0; i < gains_.size(); ++i)
    if (gains_[i] > best.gain) best = {i, gains_[i]};
  return best;
}

OpenCells::Best OpenCells::best_at(std::size_t cell) {
  look_at_new();
  Best best{0, 0};
  for (const CandidatePool::Holder& holder : pool_.holders(cell / 64))
    if ((holder.bits >> (cell % 64) & 1) != 0 && gains_[holder.candidate] > best.gain)
      best = {holder.candidate, gains_[holder.candidate]};
  return best;
}

void OpenCells::cover(const Candidate& candidate) {
  for (const HeldWord& word : candidate.held) {
    const std::uint64_t now = word.bits & open_[word.index];
    if (now == 0) continue;
    open_[word.index] ^= now;
    count_ -= count_bits(now);
    for (const CandidatePool::Holder& holder : pool_.holders(word.index))
      if (const std::uint64_t bits = holder.bits & now; bits != 0 && holder.candidate < gains_.size())
        gains_[holder.candidate] -= static_cast<std::uint32_t>(count_bits(bits));
  }
}

}  // namespace touchstone::fit
