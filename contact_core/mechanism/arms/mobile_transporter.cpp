#include "touchstone/contact_core/mechanism/arms/mobile_transporter.hpp"

#include "touchstone/contact_core/mechanism/arms/link_parts.hpp"
#include "touchstone/contact_core/mechanism/arms/ssrms.hpp"

namespace touchstone {
namespace {

constexpr double kDeck = 2.6, kDeckHeight = 0.5, kAbove = 0.02, kStand = 0.6, kStandWidth = 0.5;  // [m]
constexpr double kMass = 885.0, kTravel = 10.0, kRate = 0.0254, kForce = 1000.0;

PlacedHexahedron box(const char* name, const Vector3& size, const Vector3& centre) {
  Pose X;
  X.p = centre;
  return {name, Hexahedron::from_size(size), X};
}

}  // namespace

MechanismDescription make_ssrms_on_transporter() {
  MechanismDescription arm = make_ssrms();
  const Vector3 deck(kDeck, kDeck, kDeckHeight), centre(0.0, 0.0, kAbove + 0.5 * kDeckHeight);
  LinkDescription transporter{"transporter", {}, solid_box_mass(kMass, centre, deck)};
  transporter.solids.push_back(box("deck", deck, centre));
  transporter.solids.push_back(
      box("stand", {kStandWidth, kStandWidth, kStand}, {0.0, 0.0, kAbove + kDeckHeight + 0.5 * kStand}));
  arm.links.insert(arm.links.begin(), {LinkDescription{"rails", {}, {}}, transporter});

  JointDescription rail{"rail", JointKind::prismatic, "rails", "transporter"};
  rail.axis_J = Vector3::UnitX();
  rail.lower = 0.0;
  rail.upper = kTravel;
  rail.rate = kRate;
  rail.effort = kForce;
  JointDescription held{"held", JointKind::fixed, "transporter", "base_lee"};
  held.X_PJ.p = {0.0, 0.0, kAbove + kDeckHeight + kStand};
  held.X_PJ.R << 0, 0, -1, 0, 1, 0, 1, 0, 0;  // the arm's x axis upwards
  arm.joints.insert(arm.joints.begin(), {rail, held});
  return arm;
}

}  // namespace touchstone
