#include "touchstone/examples/fit/certificate.hpp"

#include <fmt/format.h>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/examples/program/files/json.hpp"
#include "touchstone/examples/program/files/sha256.hpp"

namespace touchstone::fitting {
namespace {

using program::Json;

constexpr const char* kFormat = "touchstone cover certificate 1";

Json point(const Vector3& p) { return Json::array({p.x(), p.y(), p.z()}); }

Certificate certificate_of(const Json& json) {
  if (json.at("format") != kFormat)
    throw std::runtime_error(std::string("'format' is not \"") + kFormat + "\"");
  Certificate result;
  const Json& mesh = json.at("mesh");
  result.mesh_file = mesh.at("file");
  result.mesh_sha256 = mesh.at("sha256");
  result.scale = mesh.at("metres_a_unit");
  if (mesh.contains("up_axis")) result.up = parse_up(mesh.at("up_axis"));
  result.claim.excess = json.at("excess_m");
  for (const Json& region : json.at("regions"))
    result.claim.regions.push_back({region.at("name"), program::vector3_of(region.at("low_m")),
                                    program::vector3_of(region.at("high_m")), region.at("excess_m")});
  for (const Json& hexahedron : json.at("hexahedra_m")) {
    if (!hexahedron.is_array() || hexahedron.size() != 8)
      throw std::runtime_error("a hexahedron has eight vertices");
    std::array<Vector3, 8>& vertices = result.claim.hexahedra.emplace_back();
    for (std::size_t i = 0; i < 8; ++i) vertices[i] = program::vector3_of(hexahedron[i]);
  }
  return result;
}

}  // namespace

CoverClaim claim_of(const Fit& fit, const FitOptions& options) {
  CoverClaim claim;
  claim.excess = fit.excess;
  for (const FittedHexahedron& each : fit.hexahedra) claim.hexahedra.push_back(each.vertices);
  for (std::size_t r = 0; r < options.regions.size(); ++r) {
    const FitRegion& region = options.regions[r];
    claim.regions.push_back({region.name, region.box.low, region.box.high, fit.region_excess[r]});
  }
  return claim;
}

std::string certificate_text(const Certificate& certificate) {
  // Lengths are in metres, whatever the unit of the mesh's file.
  Json regions = Json::array(), hexahedra = Json::array();
  for (const CoverClaim::Region& region : certificate.claim.regions)
    regions.push_back({{"name", region.name},
                       {"low_m", point(region.low)},
                       {"high_m", point(region.high)},
                       {"excess_m", region.excess}});
  for (const auto& vertices : certificate.claim.hexahedra) {
    Json list = Json::array();
    for (const Vector3& p : vertices) list.push_back(point(p));
    hexahedra.push_back(std::move(list));
  }
  // The hash names the mesh that the claim is about.
  Json json = {{"format", kFormat},
               {"mesh",
                {{"file", certificate.mesh_file},
                 {"sha256", certificate.mesh_sha256},
                 {"metres_a_unit", certificate.scale}}},
               {"claims",
                "the union of the hexahedra holds every triangle and the inside of every closed shell; no "
                "point of it is farther from them than excess_m, in a region than that region's"},
               {"excess_m", certificate.claim.excess},
               {"regions", std::move(regions)},
               {"hexahedra_m", std::move(hexahedra)}};
  if (certificate.up != UpAxis::as_written) json["mesh"]["up_axis"] = to_string(certificate.up);
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";  // names may be no UTF-8
}

std::string claims_text(const Certificate& certificate) {
  const auto corner = [](const Vector3& p) { return fmt::format("({}, {}, {})", p.x(), p.y(), p.z()); };
  std::string text =
      fmt::format("error at most {} m, by {} hexahedra; a unit of the file is {} m\n",
                  certificate.claim.excess, certificate.claim.hexahedra.size(), certificate.scale);
  for (const CoverClaim::Region& region : certificate.claim.regions)
    text += fmt::format("region '{}', {} to {} m: error at most {} m\n", region.name, corner(region.low),
                        corner(region.high), region.excess);
  return text;
}

Certificate read_certificate(const std::filesystem::path& path) {
  const std::string bytes = program::read_file(path.string(), "--check");
  try {
    return certificate_of(Json::parse(bytes));
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {
    reject(path.string(), std::string("no certificate: ") + error.what());
  }
}

CoverVerdict check_certificate(const Certificate& certificate, const std::filesystem::path& mesh) {
  const std::string bytes = program::read_file(mesh.string(), "--check");
  if (program::sha256(bytes) != certificate.mesh_sha256) {
    CoverVerdict verdict;
    verdict.reason = "the certificate is of another file: " + certificate.mesh_file + ", SHA-256 " +
                     certificate.mesh_sha256;
    return verdict;
  }
  return check_cover(read_mesh(mesh, {certificate.scale, certificate.up}).mesh, certificate.claim);
}

}  // namespace touchstone::fitting
