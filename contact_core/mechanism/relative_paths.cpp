#include "touchstone/contact_core/mechanism/relative_paths.hpp"

namespace touchstone {
namespace {

/// Links and joints alone: paths ask for no hexahedra, whose trees would be made anew for each view.
MechanismDescription frames_of(const Mechanism& mechanism) {
  MechanismDescription out;
  out.name = mechanism.name();
  for (const Mechanism::Link& link : mechanism.links()) out.links.push_back({link.name});
  out.joints = mechanism.description().joints;
  out.reference = mechanism.description().reference;
  return out;
}

}  // namespace

RelativePaths::RelativePaths(const Mechanism& mechanism) : seen_(mechanism.links().size()) {
  MechanismDescription frames = frames_of(mechanism);
  for (std::uint32_t link = 0; link < seen_.size(); ++link) {
    if (link == mechanism.base()) continue;
    frames.base = mechanism.links()[link].name;
    seen_[link].mechanism = std::make_unique<const Mechanism>(frames);
    seen_[link].path = std::make_unique<MechanismPath>(*seen_[link].mechanism);
  }
}

void RelativePaths::forget() noexcept {
  for (Seen& seen : seen_) seen.is_set = false;
}

const MechanismPath& RelativePaths::seen_from(std::uint32_t link, const MechanismPath& whole) noexcept {
  Seen& seen = seen_[link];
  if (!seen.mechanism) return whole;
  if (!seen.is_set) seen.path->lay(whole.at(link, 0.0).X_WO, whole.from(), whole.to());
  seen.is_set = true;
  return *seen.path;
}

}  // namespace touchstone
