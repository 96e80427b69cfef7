#include "touchstone/contact_core/mechanism/arms/bundled_arms.hpp"

#include <string>

#include "touchstone/contact_core/input_error.hpp"
#include "touchstone/contact_core/mechanism/arms/mobile_transporter.hpp"
#include "touchstone/contact_core/mechanism/arms/spdm.hpp"
#include "touchstone/contact_core/mechanism/arms/ssrms.hpp"

namespace touchstone {

MechanismDescription make_bundled_arm(std::string_view name) {
  if (name == "ssrms") return make_ssrms();
  if (name == "ssrms_walking") return make_walking_ssrms();
  if (name == "ssrms_on_transporter") return make_ssrms_on_transporter();
  if (name == "spdm") return make_spdm();
  if (name == "spdm_arm") return make_spdm_arm();
  throw InputError("arm '" + std::string(name) +
                   "' is not known; known: ssrms, ssrms_walking, ssrms_on_transporter, spdm, spdm_arm");
}

}  // namespace touchstone
