#pragma once

#include <string_view>

#include "touchstone/contact_core/mechanism/mechanism.hpp"

namespace touchstone {

/// Returns the bundled arm of that name, as scene files and scripts have it: `ssrms` (ssrms.hpp),
/// `ssrms_on_transporter` (mobile_transporter.hpp), `spdm` and `spdm_arm` (spdm.hpp).
/// @throws InputError: another name.
MechanismDescription make_bundled_arm(std::string_view name);

}  // namespace touchstone
