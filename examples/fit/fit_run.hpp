#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "touchstone/contact_core/fit/levels.hpp"
#include "touchstone/examples/fit/certificate.hpp"
#include "touchstone/examples/program/files/report_files.hpp"
#include "touchstone/examples/program/options/length.hpp"
#include "touchstone/examples/program/terminal/progress.hpp"

namespace touchstone::fitting {

using program::Length;
using program::parse_length;
using program::parse_unit;

/// --region NAME=LENGTH:x,y,z:x,y,z
struct RegionRequest {
  std::string name;
  Length over;
  Vector3 low, high;  ///< in the file's units, DAE: in metres; axes as they are read
};

/// @throws InputError for invalid ones.
RegionRequest parse_region(const std::string& text);

/// The fit that each mesh gets.
struct FitRequest {
  Length over;
  std::optional<std::size_t> count;
  std::vector<RegionRequest> regions;
  std::optional<Length> keep_open;  ///< largest error in bores that are found
  std::vector<Length> levels;       ///< errors of coarser levels, ascending
  MeshInput input;
  bool page = false;                   ///< a page and a glTF model, too
  bool training = false;               ///< a scene and a script to fly, too
  std::filesystem::path output = ".";  ///< the folder of what is written, from where scenes name the mesh
  int repairs = FitOptions().repairs;
  int tries = 3;
  std::size_t samples = 0;
  /// Called often while a mesh is fitted; may throw, which ends the fit. May be empty.
  std::function<void()> on_progress;
};

/// One mesh's cover, and its proof.
struct FitRun {
  std::string name;  ///< cover_name()
  std::size_t triangles = 0, shells = 0, closed_shells = 0, open_edges = 0;
  double diagonal = 0.0;  ///< [m]
  double over = 0.0;      ///< asked [m]
  TriangleMesh mesh;      ///< as it was read [m]
  std::string note;       ///< what a user should know of the mesh; may be empty
  Fit fit;
  double fit_seconds = 0.0, proof_seconds = 0.0;  ///< of the processor
  CoverVerdict verdict;
  std::size_t samples = 0, uncovered = 0;
  Certificate certificate;
  std::vector<CoarserLevel> levels;
  std::vector<Certificate> level_certificates;  ///< one a level: proven too, where the verdict is so
  std::vector<program::ReportFile> more;        ///< pictures and scenes where they are asked for
};

/// The name of a mesh's cover: the file's without extension; what is no UTF-8 is replaced.
std::string cover_name(const std::filesystem::path& mesh);

/// @throws InputError naming two meshes whose covers would have one name.
void check_names(const std::vector<std::filesystem::path>& meshes);

/// @throws InputError: the file, or a request that it cannot meet.
FitRun run_fit(const std::filesystem::path& mesh, const FitRequest& request, program::ProgressLine& progress);

/// The extensions of what is written of each mesh.
std::vector<std::string> cover_extensions(const FitRequest& request);

/// NAME.yaml, a scene file with the cover, NAME.certificate.json, and what else was asked for.
std::vector<program::ReportFile> cover_files(const FitRun& run);

/// A line a mesh.
std::string table_text(const std::vector<FitRun>& runs);
std::string table_csv(const std::vector<FitRun>& runs);

}  // namespace touchstone::fitting
