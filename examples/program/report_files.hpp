#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace touchstone::comparison {

/// Relative path and content.
using ReportFile = std::pair<std::string, std::string>;

/// @throws InputError unless `folder` can become a report: it does not exist, is empty, or holds an earlier
/// report.
void check_report_folder(const std::filesystem::path& folder);

/// Writes into a folder beside it, then swaps: there is the old report or the new one, never half of one.
/// @throws InputError when a file cannot be written; nothing has changed then.
void write_report_folder(const std::filesystem::path& folder, const std::vector<ReportFile>& files);

}  // namespace touchstone::comparison
