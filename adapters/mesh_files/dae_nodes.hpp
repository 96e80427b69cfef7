#pragma once

#include <string_view>

#include "touchstone/adapters/mesh_files/soup.hpp"

// Private to this folder.

namespace touchstone::mesh_files {

/// assimp follows the nodes that a COLLADA file's nodes instance without end, and overflows the stack where
/// one instances itself, by others or at once.
/// @throws InputError naming such a node.
void require_finite_nodes(std::string_view text, const ReadTask& task);

}  // namespace touchstone::mesh_files
