#pragma once

#include <string>
#include <vector>

namespace touchstone::program {

/// The machine and the build that the figures were measured with.
struct Machine {
  std::string cpu;              ///< model
  std::string instruction_set;  ///< that native's kernels use: "generic", "avx2", "avx512"
  unsigned hardware_threads = 0;
  std::string system;  ///< kernel's name and version, architecture
  std::string compiler;
  std::string build_type;
  std::string flags;
  std::string version;                                         ///< of this project
  std::vector<std::pair<std::string, std::string>> libraries;  ///< name and version, besides the engines
};
Machine describe_machine();

/// Of a Markdown page of figures: the title, then version, machine, date, load and the command that wrote it.
std::string page_head(const std::string& title, const std::string& command);

/// Of this project, "1.2.3".
std::string touchstone_version();

}  // namespace touchstone::program
