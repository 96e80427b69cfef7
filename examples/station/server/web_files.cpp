#include "touchstone/examples/station/server/web_files.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <sstream>
#include <utility>

namespace touchstone::station {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostDepth = 4, kMostPath = 200;

bool is_name(std::string_view name) {
  const auto fits = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '_';
  };
  return !name.empty() && name.front() != '.' && std::all_of(name.begin(), name.end(), fits);
}

}  // namespace

Target split_target(std::string_view target) {
  const std::size_t mark = target.find('?');
  Target out{std::string(target.substr(0, mark)), {}};
  if (mark == std::string_view::npos) return out;
  std::string_view query = target.substr(mark + 1);
  constexpr std::string_view kName = "token=";
  while (!query.empty()) {
    const std::size_t end = query.find('&');
    const std::string_view part = query.substr(0, end);
    if (part.substr(0, kName.size()) == kName) out.token = part.substr(kName.size());
    query = end == std::string_view::npos ? std::string_view() : query.substr(end + 1);
  }
  return out;
}

std::optional<fs::path> file_below(const fs::path& folder, std::string_view path) {
  if (path.size() > kMostPath || path.empty() || path.front() != '/') return std::nullopt;
  path.remove_prefix(1);
  fs::path out = folder;
  for (std::size_t depth = 0; !path.empty(); ++depth) {
    const std::size_t end = path.find('/');
    const std::string_view name = path.substr(0, end);
    if (depth == kMostDepth || !is_name(name)) return std::nullopt;
    out /= name;
    path = end == std::string_view::npos ? std::string_view() : path.substr(end + 1);
  }
  std::error_code error;
  const fs::path real = fs::canonical(out, error);
  if (error || !fs::is_regular_file(real, error)) return std::nullopt;
  const fs::path root = fs::canonical(folder, error);
  if (error || std::mismatch(root.begin(), root.end(), real.begin(), real.end()).first != root.end())
    return std::nullopt;
  return real;
}

std::string_view content_type(std::string_view path) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 10> kTypes = {
      {{".html", "text/html; charset=utf-8"},
       {".js", "text/javascript; charset=utf-8"},
       {".mjs", "text/javascript; charset=utf-8"},
       {".css", "text/css; charset=utf-8"},
       {".json", "application/json"},
       {".jsonl", "application/jsonl"},
       {".svg", "image/svg+xml"},
       {".png", "image/png"},
       {".ico", "image/x-icon"},
       {".glb", "model/gltf-binary"}}};
  for (const auto& [end, type] : kTypes)
    if (path.size() >= end.size() && path.substr(path.size() - end.size()) == end) return type;
  return "text/plain; charset=utf-8";
}

std::optional<std::string> read_file(const fs::path& file) {
  std::error_code error;
  if (fs::file_size(file, error) > kMostFileBytes || error) return std::nullopt;
  std::ifstream in(file, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  if (!in) return std::nullopt;
  return std::move(out).str();
}

std::string token_in_cookies(std::string_view cookies) {
  constexpr std::string_view kName = "station_token=";
  const std::size_t at = cookies.find(kName);
  if (at == std::string_view::npos || (at > 0 && cookies[at - 1] != ' ' && cookies[at - 1] != ';')) return {};
  const std::string_view rest = cookies.substr(at + kName.size());
  return std::string(rest.substr(0, rest.find(';')));
}

bool is_same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned differs = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    differs |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return differs == 0;
}

bool is_loopback_host(std::string_view host, std::uint16_t port) {
  const std::string end = ":" + std::to_string(port);
  return host == "127.0.0.1" + end || host == "localhost" + end || host == "[::1]" + end;
}

}  // namespace touchstone::station
