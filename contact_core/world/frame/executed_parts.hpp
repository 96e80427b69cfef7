#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "touchstone/contact_core/memory/reserve_more.hpp"
#include "touchstone/contact_core/motion/path.hpp"
#include "touchstone/contact_core/world/handles.hpp"

namespace touchstone {

/// A mover's motion in one part of a frame: the commanded path is part 0, each sub-step of slides another.
struct ExecutedPart {
  std::uint32_t root;
  std::uint32_t part;
  CarriedPath path;
  double stop;
  std::uint32_t joints;  ///< an arm's joint values at both ends: index of the first
  ObjectHandle object;   ///< the root's: the next object in its slot did none of this
  /// The link that took the root along: the arm's first link as `lead`, and the link's number; else none.
  ObjectHandle lead = {};
  std::uint32_t link = 0;
  Pose X_LR = {};  ///< of the root in that link
};

/// A frame's parts: see ContactWorld::executed_parts().
class ExecutedParts {
 public:
  /// How one mover stands at s of a part.
  struct At {
    const ExecutedPart* part;  ///< null: it stood still
    double s;                  ///< within it
  };

  void reserve(std::size_t parts, std::size_t joints) {
    reserve_more(parts_, parts);
    joints_.reserve(joints);
  }
  void clear() { parts_.clear(), joints_.clear(); }
  /// @param from, to an arm's joint values; else empty. @pre parts come in order.
  void add(ObjectHandle object, std::uint32_t part, const CarriedPath& path, double stop,
           std::span<const double> from = {}, std::span<const double> to = {}) {
    parts_.push_back({object.slot, part, path, stop, static_cast<std::uint32_t>(joints_.size()), object});
    joints_.insert(joints_.end(), from.begin(), from.end());
    joints_.insert(joints_.end(), to.begin(), to.end());
  }
  /// Adds a root that a link takes along, before or after the link's arm. @param path at rest.
  void add_ride(ObjectHandle object, std::uint32_t part, const CarriedPath& path, double stop,
                ObjectHandle lead, std::uint32_t link, const Pose& X_LR) {
    parts_.push_back({object.slot, part, path, stop, 0, object, lead, link, X_LR});
  }
  /// The number of parts of the frame.
  void set_count(std::uint32_t count) { count_ = count; }
  std::uint32_t count() const { return count_; }

  At find(ObjectHandle root, std::size_t part, double s) const {
    const ExecutedPart* last = nullptr;
    for (const ExecutedPart& entry : parts_) {
      if (entry.object != root) continue;
      if (entry.part > part) break;
      last = &entry;
    }
    if (last == nullptr) return {nullptr, s};
    return {last, last->part == part ? std::min(s, last->stop) : last->stop};
  }
  /// @param values of the arm. @pre at.part is not null.
  double joint_value(const At& at, std::uint32_t value, std::size_t values) const {
    const double* q = &joints_[at.part->joints + value];
    const double from = q[0], to = q[values], s = at.s;
    return s <= 0.0 ? from : s >= 1.0 ? to : from + s * (to - from);
  }

 private:
  std::vector<ExecutedPart> parts_;
  std::vector<double> joints_;
  std::uint32_t count_ = 0;
};

}  // namespace touchstone
