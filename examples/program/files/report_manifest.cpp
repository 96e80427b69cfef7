#include "touchstone/examples/program/files/report_manifest.hpp"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/files/sha256.hpp"

namespace touchstone::program {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kSchema = "touchstone.report_files/1";

std::string read_whole(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

Manifest manifest_from(const Json& json) {
  if (json.at("schema") != kSchema) throw InputError("is of another schema");
  Manifest manifest;
  manifest.program = json.at("program").get<std::string>();
  manifest.complete = json.at("complete").get<bool>();
  for (const Json& file : json.at("files")) {
    manifest.files.push_back({file.at("name").get<std::string>(), file.at("bytes").get<std::uintmax_t>(),
                              file.at("sha256").get<std::string>()});
    if (!stays_inside(manifest.files.back().name)) throw InputError("names a file outside its folder");
  }
  return manifest;
}

}  // namespace

bool stays_inside(const std::string& name) {
  const fs::path path(name);
  if (name.empty() || path.is_absolute() || !path.has_filename()) return false;
  if (name.find('\0') != std::string::npos) return false;  // the system would take what is before it
  return std::none_of(path.begin(), path.end(), [](const fs::path& part) { return part == ".."; });
}

ManifestEntry manifest_entry(const std::string& name, std::string_view content) {
  return {name, content.size(), sha256(content)};
}

std::optional<Manifest> read_manifest(const fs::path& folder, const char* name) {
  const fs::path path = folder / name;
  std::error_code error;
  const fs::file_status status = fs::symlink_status(path, error);
  if (status.type() == fs::file_type::not_found) return std::nullopt;
  const auto refuse = [&](const std::string& why) {
    return InputError(path.string() + ": " + why + "; move it away or name another folder");
  };
  if (!fs::is_regular_file(status)) throw refuse("is no file");
  try {
    return manifest_from(Json::parse(read_whole(path)));
  } catch (const InputError& reason) {
    throw refuse(reason.what());
  } catch (const nlohmann::json::exception&) {
    throw refuse("is no manifest of a report");
  }
}

std::string manifest_text(const Manifest& manifest) {
  Json json = {{"schema", kSchema},
               {"what",
                "the files that Touchstone wrote here: a later run replaces these, unless they have "
                "changed, and no others"},
               {"program", manifest.program},
               {"complete", manifest.complete}};
  json["files"] = Json::array();
  for (const ManifestEntry& file : manifest.files)
    json["files"].push_back({{"name", file.name}, {"bytes", file.bytes}, {"sha256", file.sha256}});
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";  // paths and names may be no UTF-8
}

FileOwner owner_of(const fs::path& folder, const std::optional<Manifest>& manifest, const std::string& name) {
  const fs::path path = folder / name;
  std::error_code error;
  const fs::file_type type = fs::symlink_status(path, error).type();
  if (type == fs::file_type::not_found) return FileOwner::free;
  if (!manifest) return FileOwner::foreign;
  bool is_listed = false;
  for (const ManifestEntry& file : manifest->files) {
    if (file.name != name) continue;
    is_listed = true;
    if (type == fs::file_type::regular && fs::file_size(path, error) == file.bytes &&
        sha256(read_whole(path)) == file.sha256)
      return FileOwner::ours;
  }
  return is_listed ? FileOwner::changed : FileOwner::foreign;
}

}  // namespace touchstone::program
