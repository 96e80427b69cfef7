#pragma once

#include <filesystem>

namespace touchstone::program {

/// The folder of the running program's file.
std::filesystem::path program_folder();

/// A folder of files that come with the programs, by its path below examples/ ("dynamics_run/scenes"): that
/// of the installation the program runs from (PREFIX/share/touchstone/examples beside PREFIX/bin), else the
/// checkout's.
/// @param checkout examples/ of the checkout that the program was built from.
std::filesystem::path bundled_folder(const std::filesystem::path& checkout,
                                     const std::filesystem::path& folder);

}  // namespace touchstone::program
