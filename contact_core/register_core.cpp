#include "touchstone/contact_core/broadphase/register_broadphases.hpp"
#include "touchstone/contact_core/edge_face/edge_face.hpp"
#include "touchstone/contact_core/edge_face/edge_face_broadphase.hpp"
#include "touchstone/contact_core/native/native.hpp"
#include "touchstone/contact_core/registry.hpp"

namespace touchstone {

void register_core(BackendRegistry& registry) {
  register_native(registry);
  register_edge_face(registry);
  register_broadphases(registry);
  register_edge_face_broadphase(registry);
}

}  // namespace touchstone
