#pragma once

#include "touchstone/contact_core/registry.hpp"

namespace touchstone {

/// The paper's first build, as a narrowphase `edge_face`: bounding spheres, then every edge of either solid
/// against every face of the other. Answers overlap only; distance and manifold queries are `unsupported`.
///
/// Blind spots, kept on purpose: no edge crosses a face when one solid contains the other; an edge parallel
/// to a plane is skipped, so coplanar faces are seen only where other edges cross; spheres that just touch
/// count as apart; a face whose first three vertices are collinear (collapsed) has no plane and is skipped;
/// coordinates beyond about 1e100 m or sizes below 1e-100 m overflow or underflow the products and count as
/// apart.
///
/// A hit is a point of an edge whose height over the other's face, and whose place within it, are 0 to
/// rounding: solids apart by less than the declared resolution may count as in contact. Of pairs whose edges
/// are nearly parallel about 1 in 20 is such a phantom, apart by up to 1e-16 of the largest coordinate
/// (edge_face_phantoms_test.cpp); faces whose corners have angles beyond 30 to 150 degrees are off by as much
/// more as their plane's normal is, bent faces by the height of the fourth corner over the plane of the other
/// three.
void register_edge_face(BackendRegistry& registry);

}  // namespace touchstone
