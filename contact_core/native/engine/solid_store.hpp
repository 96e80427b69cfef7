#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <shared_mutex>
#include <string_view>
#include <vector>

#include "touchstone/contact_core/narrowphase/narrowphase.hpp"
#include "touchstone/contact_core/native/solids/solid_set.hpp"

// The native check, or another narrowphase, for engines: solids come and go while the engine runs, and pairs
// are asked one at a time.

namespace touchstone::native {

/// An engine's shape, by the engine's own numbers.
struct SolidContent {
  bool is_box = false;
  /// A box: {its full side lengths [m]}, the rest zero. Else its eight vertices, in any order that
  /// Hexahedron::from_vertices takes.
  std::array<std::array<double, 3>, 8> points{};

  friend bool operator==(const SolidContent&, const SolidContent&) = default;
  friend auto operator<=>(const SolidContent&, const SolidContent&) = default;
};

/// A user's hold on a content: `content` stays where it is until the release.
struct SolidHandle {
  std::uint32_t key;
  const SolidContent* content;
};

/// Where the check reads the poses of a pair.
struct PairPlaces {
  Pose* X_WA;
  Pose* X_WB;
};

struct PairAnswer {
  PairStatus status;
  PairGeometry geometry;
  std::array<ContactPoint, kMaxManifoldPoints> points;
};

/// Solids by content: a thousand equal boxes are one entry. Entries are counted, and used again when their
/// last user has gone. Members may be called from any threads at once; compute_manifold() of the native check
/// waits for nobody. Allocates only where a content is new, and on a thread's first pair after that.
class SolidStore {
 public:
  SolidStore();
  /// Pairs are asked of this narrowphase, not of the native check. Its solids are set anew where a content is
  /// new or an old one's place is used again (Narrowphase::set_solids(), build() where it has none), and
  /// pairs wait for each other where it is not thread safe.
  /// @throws InputError: none given, or one without manifolds.
  explicit SolidStore(std::unique_ptr<Narrowphase> narrowphase);
  ~SolidStore();
  SolidStore(const SolidStore&) = delete;
  SolidStore& operator=(const SolidStore&) = delete;

  bool is_native() const { return other_ == nullptr; }
  std::string_view name() const;  ///< of the narrowphase: "native"

  /// Adds a user of this content. Empty where it is no convex hexahedron (warped ones are accepted), or the
  /// narrowphase refuses it.
  std::optional<SolidHandle> acquire(const SolidContent& content);
  /// @pre acquired once more often than released.
  void release(const SolidHandle& solid);
  std::size_t size() const;  ///< contents in use

  /// A manifold query for a pair, as make_native() answers it, whatever query.kind. A rotation that is off by
  /// more than kRotationTolerance is made orthonormal first (Gram-Schmidt from its first column); a pose that
  /// is not finite, or no rotation at all, comes out as `failed`, without points. Of another narrowphase what
  /// is `unsupported` comes out as `failed`, too, and what is `undecided` as `overlapping`: nearer to
  /// touching than it tells.
  /// @pre the handles are not released; query.max_points is 1 to kMaxManifoldPoints.
  void compute_manifold(const SolidHandle& a, const Pose& X_WA, const SolidHandle& b, const Pose& X_WB,
                        const Query& query, PairAnswer& answer) const noexcept {
    const PairPlaces places = places_of(a, b);
    *places.X_WA = X_WA, *places.X_WB = X_WB;
    compute_manifold(a, b, query, answer);
  }
  /// The same of the poses that the caller has written into places_of() the pair, on this thread, after any
  /// other pair was asked for.
  void compute_manifold(const SolidHandle& a, const SolidHandle& b, const Query& query,
                        PairAnswer& answer) const noexcept;
  /// Saves an engine's plug-in from copying poses that it has just made. They stay where they are until this
  /// thread's next call.
  PairPlaces places_of(const SolidHandle& a, const SolidHandle& b) const noexcept;

  /// A copy: for those who write the solid down.
  Hexahedron solid(const SolidHandle& solid) const;

 private:
  using Key = std::uint32_t;
  struct Entry {
    Key key;
    std::uint32_t users;
  };
  using Entries = std::map<SolidContent, Entry>;

  struct Other;

  void ask_other(const SolidHandle& a, const SolidHandle& b, const Query& query,
                 PairAnswer& answer) const noexcept;
  SolidSet& set_with_place(Key key);

  // A query names a solid and its pose by one index. Each content is there twice, as A at 2 key and as B at
  // 2 key + 1, so that a pair of equal solids is a pair.
  //
  // Queries read the set without a lock: a solid is put into places that no user's handle names, and where
  // these run out a set twice as large takes the old one's place, which stays for those who still read it.
  std::vector<std::unique_ptr<SolidSet>> sets_;
  std::atomic<const SolidSet*> set_;  ///< the last of these
  Entries entries_;
  /// A heap, the least first: after all are released the same contents in the same order get the same keys
  /// again, on which the order depends in which another narrowphase is asked.
  std::vector<Key> unused_;
  mutable std::shared_mutex mutex_;
  const Kernels& kernels_;
  std::unique_ptr<Other> other_;  // null: native
};

}  // namespace touchstone::native
