#pragma once

#include <string>
#include <string_view>

namespace touchstone::program {

/// Returns the digest of FIPS 180-4 as 64 lower-case hexadecimal digits, as `sha256sum` prints it.
std::string sha256(std::string_view bytes);

}  // namespace touchstone::program
