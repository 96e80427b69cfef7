#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

// Checks of a request, without sockets: paths, tokens, hosts.

namespace touchstone::station {

/// A request's target in parts.
struct Target {
  std::string path;   ///< as sent, without the query
  std::string token;  ///< of `?token=`; empty: none
};
Target split_target(std::string_view target);

/// The file that a path names below a folder: names of letters, digits, `.`, `-` and `_`, none of which
/// begins with a dot, at most four deep. Nothing: no such file, or one that a link leads to elsewhere.
std::optional<std::filesystem::path> file_below(const std::filesystem::path& folder, std::string_view path);

/// By the name's end; text/plain where it is not known.
std::string_view content_type(std::string_view path);

/// At most kMostFileBytes. Nothing: it cannot be read.
std::optional<std::string> read_file(const std::filesystem::path& file);
inline constexpr std::uintmax_t kMostFileBytes = std::uintmax_t{32} << 20U;

/// Of a `Cookie` header: the value of `station_token`.
std::string token_in_cookies(std::string_view cookies);

/// In a time that does not tell where they differ.
bool is_same_secret(std::string_view a, std::string_view b);

/// True for 127.0.0.1, localhost and [::1] with this port: pages of other hosts cannot name themselves so.
bool is_loopback_host(std::string_view host, std::uint16_t port);

}  // namespace touchstone::station
