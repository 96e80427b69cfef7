#pragma once

// The comparison and the bench call what the measures and the programs share by bare names.

namespace touchstone::measures {
struct SolidPaths;
}
namespace touchstone::program {}

namespace touchstone::comparison {

using namespace measures;
using namespace program;
using measures::SolidPaths;  // not a broadphase's

}  // namespace touchstone::comparison
