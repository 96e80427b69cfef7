#pragma once

#include "touchstone/contact_core/mechanism/mechanism.hpp"

namespace touchstone {

/// The arm of make_ssrms() on a carriage that rolls along a truss, as on the Mobile Transporter: 8 values,
/// the first the prismatic joint `rail` along +x of the base's frame, 0 to 10 m. The base, `rails`, is a
/// frame without solids in the middle of the truss's upper face, z upwards; `transporter` is the carriage;
/// the arm stands on it by `base_lee`, its x axis upwards.
///
/// Assumed, as no figure of it was at hand: a deck of 2.6 x 2.6 x 0.5 m that floats 20 mm above the face,
/// 885 kg, 25.4 mm/s, 1 kN; a stand of 0.6 m for the grapple fixture that holds the arm, which is not
/// modelled. Rails, wheels, utility cables and the latches that hold the carriage at a worksite are left out:
/// it holds wherever it is.
MechanismDescription make_ssrms_on_transporter();

}  // namespace touchstone
