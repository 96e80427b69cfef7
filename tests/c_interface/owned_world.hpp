#pragma once

#include <cstring>
#include <memory>

#include "touchstone/adapters/c_interface/touchstone.h"
#include "touchstone/contact_core/geometry/pose.hpp"

namespace touchstone {

struct DestroyWorld {
  void operator()(touchstone_world* one) const { touchstone_destroy_world(one); }
};

/// A world of the C interface that ends with its test.
using OwnedWorld = std::unique_ptr<touchstone_world, DestroyWorld>;

/// The same pose in C: both have the same members in the same order.
inline touchstone_pose c_pose(const Pose& X) {
  touchstone_pose out;
  std::memcpy(&out, &X, sizeof out);
  return out;
}

}  // namespace touchstone
