#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/memory/growing_list.hpp"
#include "touchstone/contact_core/memory/reserve_more.hpp"
#include "touchstone/contact_core/motion/impact.hpp"
#include "touchstone/contact_core/motion/separation_memo.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"

namespace touchstone {

/// True where find_impact() can use the narrowphase's own separations.
inline bool gives_signed_distance(const Narrowphase& narrowphase) {
  const Capabilities& can = narrowphase.capabilities();
  return can.distance && can.penetration && std::isfinite(can.resolution.of_depth);
}

/// Asks a narrowphase that was built over many solids about trial poses: only the pair's own poses are set,
/// and none is kept. One a thread.
class NarrowphaseQuery final : public SeparationQuery {
 public:
  /// Keeps a reference. @param solids as many as `narrowphase` was built with.
  NarrowphaseQuery(const Narrowphase& narrowphase, std::size_t solids)
      : NarrowphaseQuery(narrowphase, narrowphase, solids) {}

  /// @param planner native, over the same solids: gives separations where `narrowphase` has none and only
  /// judges poses, and contact points for plans of motion, which are no more than proposals: an engine's
  /// single point, or its share of noise, would have a body turn on it and stick.
  NarrowphaseQuery(const Narrowphase& narrowphase, const Narrowphase& planner, std::size_t solids)
      : judges_poses_(!gives_signed_distance(narrowphase)),
        own_{&narrowphase, narrowphase.make_workspace()},
        planner_{&planner, planner.make_workspace()} {
    resize_more(poses_, solids);
  }

  /// The pair that the next calls ask about, a < b.
  void set_pair(const SolidPair& pair) { pair_ = pair; }

  /// From now on separations are remembered (separation_memo.hpp): no narrowphase may be built anew without
  /// take_up().
  void remember() {
    memo_.emplace(kRememberedSets);
    known_ = &*memo_;
  }

  /// Reads the memory of `other` and remembers nothing itself. While both ask, `other` must not note
  /// anything. Keeps a reference. @pre other.remember().
  void look_up_in(const NarrowphaseQuery& other) { known_ = other.known_; }

  /// Remembers nothing more until it is called with false.
  void pause_notes(bool pause) { is_paused_ = pause; }

  /// Forgets all answers, since the narrowphases took up other solids. @param solids their number now.
  void take_up(std::size_t solids) {
    resize_more(poses_, solids);
    if (memo_) memo_->forget();
  }

  PairStatus separation(const Pose& X_WA, const Pose& X_WB, PairGeometry& out) noexcept override {
    const SeparationMemo::Answer* known = find(X_WA, X_WB);
    if (known != nullptr) {
      out = known->geometry;
      return last_status_ = known->status;
    }
    last_status_ = ask(separations(), X_WA, X_WB, distance_query(), out, {});
    if (memo_ && !is_paused_) memo_->put(pair_, X_WA, X_WB, last_status_, out);
    return last_status_;
  }
  /// The status that the last separation() got.
  PairStatus last_status() const { return last_status_; }

  /// Supplies the answer for a pair at these poses, used until expect_nothing(). Keeps references.
  void expect(const SolidPair& pair, const Pose& X_WA, const Pose& X_WB,
              const SeparationMemo::Answer& answer) {
    expected_ = {pair, &X_WA, &X_WB, &answer};
  }
  void expect_nothing() { expected_ = {}; }

  /// Asks about many pairs in one call and remembers nothing.
  /// @param poses X_WS of every solid. @param out as many as pairs.
  void separations_at(std::span<const SolidPair> pairs, std::span<const Pose> poses,
                      std::span<SeparationMemo::Answer> out) noexcept {
    std::array<std::size_t, kBatch> place;
    std::array<SolidPair, kBatch> wanted;
    std::size_t count = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const SolidPair& pair = pairs[i];
      const SeparationMemo::Answer* known =
          known_ != nullptr ? known_->find(pair, poses[pair.a], poses[pair.b]) : nullptr;
      if (known != nullptr)
        out[i] = *known;
      else
        place[count] = i, wanted[count++] = pair;
      if (count < kBatch && (i + 1 < pairs.size() || count == 0)) continue;
      std::array<PairStatus, kBatch> status;
      std::array<PairGeometry, kBatch> geometry;
      evaluate(std::span(wanted).first(count), poses, status, geometry);
      for (std::size_t k = 0; k < count; ++k) out[place[k]] = {status[k], geometry[k]};
      count = 0;
    }
  }

  /// Asks once for pairs in full batches, so that later calls do not allocate.
  void warm_up() noexcept {
    if (poses_.size() < 2) return;
    std::array<SolidPair, kBatch> pairs;
    pairs.fill({0, 1});
    std::array<PairStatus, kBatch> status;
    std::array<PairGeometry, kBatch> geometry;
    evaluate(pairs, poses_, status, geometry);
    if (judges_poses_) verdict(poses_[0], poses_[1]);
    PairGeometry unused{};
    std::array<ContactPoint, kMaxManifoldPoints> points;
    set_pair({0, 1});
    manifold(poses_[0], poses_[1], kInfinity, unused, points);
  }

  /// Remembers an answer, unless it is known. @pre remember().
  void note(const SolidPair& pair, const Pose& X_WA, const Pose& X_WB, const SeparationMemo::Answer& answer) {
    if (memo_->find(pair, X_WA, X_WB) == nullptr)
      memo_->put(pair, X_WA, X_WB, answer.status, answer.geometry);
  }

  /// Asks about many pairs in one call, which costs less than one by one, and remembers the answers.
  /// @param poses X_WS of every solid. @pre remember().
  void look_ahead(std::span<const SolidPair> pairs, std::span<const Pose> poses) noexcept {
    std::array<SolidPair, kBatch> wanted;
    std::size_t count = 0;
    for (const SolidPair& pair : pairs) {
      if (memo_->find(pair, poses[pair.a], poses[pair.b]) == nullptr) wanted[count++] = pair;
      if (count == kBatch) look_at(std::span(wanted).first(count), poses), count = 0;
    }
    if (count > 0) look_at(std::span(wanted).first(count), poses);
  }

  bool judges_poses() const noexcept override { return judges_poses_; }

  PairStatus verdict(const Pose& X_WA, const Pose& X_WB) noexcept override {
    PairGeometry unused{};
    return ask(own_, X_WA, X_WB, Query{}, unused, {});
  }

  /// The pair's contact points too, the planner's, where it has them; else the witness points as one.
  /// @param max_separation pairs further apart get a separation of +inf and no points; nor are points that
  /// are further apart among them [m].
  PairStatus manifold(const Pose& X_WA, const Pose& X_WB, double max_separation, PairGeometry& out,
                      std::span<ContactPoint, kMaxManifoldPoints> points) noexcept {
    const bool has_points = planner_.narrowphase->capabilities().manifold;
    Query query;
    query.kind = has_points ? QueryKind::manifold : QueryKind::distance;
    query.max_separation = query.max_point_separation = max_separation;
    const PairStatus status = ask(planner_, X_WA, X_WB, query, out, points);
    if (!has_points) {
      out.point_count = out.separation <= max_separation ? 1 : 0;
      points[0] = {out.p_A_W, out.p_B_W, out.separation, 0};
    }
    return status;
  }

  static constexpr std::size_t kRememberedSets = 256;  ///< of two answers each
  static constexpr std::size_t kBatch = 32;            ///< asked about in one call at most

  /// Pairs that both narrowphases were asked about.
  std::uint64_t calls() const { return calls_; }

 private:
  struct Backend {
    const Narrowphase* narrowphase = nullptr;
    std::unique_ptr<Narrowphase::Workspace> workspace;
  };

  struct Expected {
    SolidPair pair{0, 0};
    const Pose* X_WA = nullptr;
    const Pose* X_WB = nullptr;
    const SeparationMemo::Answer* answer = nullptr;
  };

  static Query distance_query() {
    Query query;
    query.kind = QueryKind::distance;
    return query;
  }

  /// The backend that gives separations.
  Backend& separations() { return judges_poses_ ? planner_ : own_; }

  /// @pre at most kBatch pairs.
  void evaluate(std::span<const SolidPair> pairs, std::span<const Pose> poses, std::span<PairStatus> status,
                std::span<PairGeometry> geometry) noexcept {
    std::fill(geometry.begin(), geometry.end(), no_geometry());  // of pairs without an answer
    Backend& backend = separations();
    backend.narrowphase->evaluate({pairs, poses, distance_query()},
                                  {status.first(pairs.size()), geometry.first(pairs.size())},
                                  *backend.workspace);
    calls_ += pairs.size();
  }

  const SeparationMemo::Answer* find(const Pose& X_WA, const Pose& X_WB) const noexcept {
    if (expected_.answer != nullptr && expected_.pair == pair_ && has_same_bits(*expected_.X_WA, X_WA) &&
        has_same_bits(*expected_.X_WB, X_WB))
      return expected_.answer;
    return known_ != nullptr ? known_->find(pair_, X_WA, X_WB) : nullptr;
  }

  void look_at(std::span<const SolidPair> pairs, std::span<const Pose> poses) noexcept {
    std::array<PairStatus, kBatch> status;
    std::array<PairGeometry, kBatch> geometry;
    evaluate(pairs, poses, status, geometry);
    for (std::size_t i = 0; i < pairs.size(); ++i)
      memo_->put(pairs[i], poses[pairs[i].a], poses[pairs[i].b], status[i], geometry[i]);
  }

  PairStatus ask(Backend& backend, const Pose& X_WA, const Pose& X_WB, const Query& query, PairGeometry& out,
                 std::span<ContactPoint> points) noexcept {
    poses_[pair_.a] = X_WA;
    poses_[pair_.b] = X_WB;
    PairStatus status = PairStatus::failed;
    backend.narrowphase->evaluate({{&pair_, 1}, poses_, query}, {{&status, 1}, {&out, 1}, points},
                                  *backend.workspace);
    ++calls_;
    return status;
  }

  bool judges_poses_;
  Backend own_, planner_;
  std::optional<SeparationMemo> memo_;
  const SeparationMemo* known_ = nullptr;  // where answers are looked up
  bool is_paused_ = false;
  Expected expected_;
  PairStatus last_status_ = PairStatus::failed;
  GrowingList<Pose> poses_;
  SolidPair pair_{0, 1};
  std::uint64_t calls_ = 0;
};

}  // namespace touchstone
