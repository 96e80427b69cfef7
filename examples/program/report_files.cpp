#include "touchstone/examples/program/report_files.hpp"

#include <unistd.h>

#include <fstream>

#include "touchstone/contact_core/input_error.hpp"

namespace touchstone::comparison {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMark = "results.json";  // what tells a report from any other folder

fs::path beside(const fs::path& folder, const char* suffix) {
  return folder.parent_path() / ("." + folder.filename().string() + suffix + std::to_string(getpid()));
}

fs::path clean(const fs::path& folder) {
  fs::path path = fs::absolute(folder).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

void write_file(const fs::path& path, const std::string& content) {
  fs::create_directories(path.parent_path());
  std::ofstream stream(path, std::ios::binary);
  stream.write(content.data(), static_cast<std::streamsize>(content.size()));
  stream.close();
  if (!stream) throw InputError(path.string() + ": cannot be written");
}

// Access rights do not tell whether a folder can be made (a root may write anywhere and yet not in /proc): it
// is made, with the parents it lacks, and what was made goes away again.
void try_to_make(const fs::path& folder, const fs::path& given) {
  std::vector<fs::path> lacking;
  std::error_code error;
  for (fs::path path = folder; !fs::exists(path, error) && path.has_relative_path();
       path = path.parent_path())
    lacking.push_back(path);
  fs::create_directories(folder, error);
  const std::error_code failure = error;
  for (const fs::path& path : lacking) fs::remove(path, error);
  if (failure) throw InputError("--output " + given.string() + ": cannot be made: " + failure.message());
}

}  // namespace

void check_report_folder(const fs::path& given) {
  const fs::path folder = clean(given);
  std::error_code error;
  if (!fs::exists(folder, error)) {
    fs::path parent = folder.parent_path();
    while (!fs::exists(parent, error) && parent.has_relative_path()) parent = parent.parent_path();
    if (!fs::is_directory(parent, error) || access(parent.c_str(), W_OK) != 0) {
      throw InputError("--output " + given.string() + ": cannot be made in " + parent.string());
    }
    try_to_make(beside(folder, ".new."), given);
    return;
  }
  if (!fs::is_directory(folder, error)) throw InputError("--output " + given.string() + ": is not a folder");
  if (access(folder.parent_path().c_str(), W_OK) != 0) {
    throw InputError("--output " + given.string() + ": cannot be replaced, its parent is not writable");
  }
  if (!fs::is_empty(folder, error) && !fs::exists(folder / kMark, error)) {
    throw InputError("--output " + given.string() +
                     ": holds files but no earlier report; name another folder");
  }
  try_to_make(beside(folder, ".new."), given);
}

void write_report_folder(const fs::path& given, const std::vector<ReportFile>& files) {
  const fs::path folder = clean(given);
  check_report_folder(folder);
  const fs::path fresh = beside(folder, ".new."), old = beside(folder, ".old.");
  try {
    for (const auto& [name, content] : files) write_file(fresh / name, content);
    if (fs::exists(folder)) fs::rename(folder, old);
    fs::rename(fresh, folder);
  } catch (const std::exception& failure) {
    std::error_code error;
    fs::remove_all(fresh, error);
    if (fs::exists(old, error) && !fs::exists(folder, error)) fs::rename(old, folder, error);
    throw InputError("--output " + given.string() + ": " + failure.what());
  }
  std::error_code error;
  fs::remove_all(old, error);
}

}  // namespace touchstone::comparison
