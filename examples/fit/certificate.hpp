#pragma once

#include <filesystem>
#include <string>

#include "touchstone/adapters/cover_proof/cover_proof.hpp"
#include "touchstone/contact_core/fit/fit.hpp"
#include "touchstone/examples/fit/mesh_input.hpp"

namespace touchstone::fitting {

/// A cover, what is claimed of it, and of which mesh.
struct Certificate {
  std::string mesh_file;    ///< name without folder
  std::string mesh_sha256;  ///< of the file's bytes
  double scale = 1.0;       ///< metres a unit of the file; DAE, which states its own: 1
  UpAxis up = UpAxis::as_written;
  CoverClaim claim;
};

/// Claims the figures of a fit.
CoverClaim claim_of(const Fit& fit, const FitOptions& options);

/// JSON; every double reads back to the same bits.
std::string certificate_text(const Certificate& certificate);

/// The claims, for people: the error, the file's unit, and each region's box and error.
std::string claims_text(const Certificate& certificate);

/// @throws InputError naming the file and the field: unreadable, malformed, another format.
Certificate read_certificate(const std::filesystem::path& path);

/// Checks a certificate against a mesh file: the hash, then the proof.
/// @throws InputError where the mesh cannot be read.
CoverVerdict check_certificate(const Certificate& certificate, const std::filesystem::path& mesh);

}  // namespace touchstone::fitting
