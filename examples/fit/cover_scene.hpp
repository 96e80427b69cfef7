#pragma once

#include <span>
#include <string>

#include "touchstone/contact_core/fit/fit.hpp"
#include "touchstone/contact_core/fit/levels.hpp"

namespace touchstone::fitting {

/// A scene file with the cover as one static object of that name, in metres; vertices with all their bits.
/// Further objects may be appended. @param duration [s]
std::string scene_text(const Fit& fit, const std::string& name, const std::string& description,
                       double duration = 1.0, std::span<const CoarserLevel> levels = {});

}  // namespace touchstone::fitting
