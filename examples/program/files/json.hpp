#pragma once

#include <nlohmann/json.hpp>

#include "touchstone/contact_core/geometry/pose.hpp"
#include "touchstone/examples/measures/common/quantiles.hpp"
#include "touchstone/examples/program/terminal/machine.hpp"

// Parts that every results.json shares.

namespace touchstone::program {

using Json = nlohmann::ordered_json;

Json number(double value);  ///< NaN: null; infinite: "inf" or "-inf"
/// Reads a figure that number() wrote.
double number_of(const Json& value);
Json json(const Vector3& v);  ///< [x, y, z], each as number()
/// Reads three finite coordinates. @throws std::runtime_error, or as nlohmann::json does, for anything else.
Vector3 vector3_of(const Json& value);
Json json(const Pose& X);  ///< {"p_m", "R_rows"}
Json json(const Machine& machine);
Json json(const measures::StepTimes& times);

/// In one line; bytes of names that are no UTF-8 are replaced, as by U+FFFD.
template <class Document>
std::string one_line(const Document& document) {
  return document.dump(-1, ' ', false, Document::error_handler_t::replace);
}

/// Returns the file's bytes. @param who names the reader in an error: "diff".
/// @throws InputError when there is no such file.
std::string read_file(const std::string& path, const std::string& who);

}  // namespace touchstone::program
