#include "touchstone/adapters/mesh_files/mesh_file.hpp"
#include "touchstone/adapters/mesh_files/soup.hpp"

namespace touchstone {
namespace mesh_files {

Soup read_dae(const std::filesystem::path&, std::string_view, bool, const ReadTask& task) {
  task.fail("DAE needs assimp, which this build has not (Debian: libassimp-dev)");
}

}  // namespace mesh_files

bool reads_dae() { return false; }

}  // namespace touchstone
