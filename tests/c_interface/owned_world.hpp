#pragma once

#include <memory>

#include "touchstone/adapters/c_interface/touchstone.h"

namespace touchstone {

struct DestroyWorld {
  void operator()(touchstone_world* one) const { touchstone_destroy_world(one); }
};

/// A world of the C interface that ends with its test.
using OwnedWorld = std::unique_ptr<touchstone_world, DestroyWorld>;

}  // namespace touchstone
