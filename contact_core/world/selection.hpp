#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "touchstone/contact_core/world/handles.hpp"

/// @file
/// Changes for ContactWorld::select(), and their record. Changes are plain values that refer to objects
/// by handle or by name: they outlive their world, and replay in another one that was set up the same.

namespace touchstone {

/// The name of a group, held in place: the frame loop copies changes, and does not allocate.
class GroupName {
 public:
  static constexpr std::size_t kMostBytes = 63;

  GroupName() = default;
  /// @throws InputError: longer than kMostBytes.
  explicit GroupName(std::string_view name);
  std::string_view text() const { return {bytes_.data(), size_}; }

  friend bool operator==(const GroupName&, const GroupName&) = default;

 private:
  std::array<char, kMostBytes> bytes_ = {};
  std::uint8_t size_ = 0;
};

/// A switch for objects, pairs or groups. A pair of objects is checked while all that it belongs to is on. A
/// change that names what is gone when it would come into force, or a group that no object and no rule of the
/// world has named, is refused: see FrameReport::refused_selections.
struct SelectionChange {
  /// The members in use: none, `first`, `first` and `second`, `group`, or every link of `mechanism`.
  enum class Scope : std::uint8_t { everything, object, pair, group, mechanism };

  Scope scope = Scope::everything;
  bool on = true;
  ObjectHandle first = {}, second = {};
  MechanismHandle mechanism = {};
  GroupName group = {};

  friend bool operator==(const SelectionChange&, const SelectionChange&) = default;

  static SelectionChange of_everything(bool on);
  static SelectionChange of(ObjectHandle object, bool on);
  static SelectionChange of(ObjectHandle a, ObjectHandle b, bool on);
  /// Switches its links, each as an object.
  static SelectionChange of(MechanismHandle mechanism, bool on);
  /// @throws InputError: a name that no group can have, longer than GroupName::kMostBytes.
  static SelectionChange of_group(std::string_view name, bool on);
};

/// A change that came into force, for a replay.
struct SelectionRecord {
  std::uint64_t frame;  ///< the frame at whose start it came into force
  SelectionChange change;
};

}  // namespace touchstone
