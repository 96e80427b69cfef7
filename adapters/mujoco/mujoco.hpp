#pragma once

#include "touchstone/contact_core/registry.hpp"

/// @file
/// MuJoCo's own check, double precision, as narrowphase `mujoco`: what its table mjCOLLISIONFUNC holds for
/// boxes and meshes, called for one pair at margin 0, with MuJoCo's default options. The errors stated here
/// were measured with Debian's MuJoCo 2.2.2; compiled with the headers of a later version (tried: 3.3.7,
/// 3.10, 3.17, 4.0) it answers as that one does.
///
/// Solids are static geoms of one model that MuJoCo compiles in build(): boxes are box geoms, other hexahedra
/// mesh geoms. Of these MuJoCo keeps single-precision vertices, about the mesh's centre of mass and along its
/// principal axes, and what qhull finds to be their hull. How far that has moved the vertices is measured in
/// build() and declared (Resolution::absolute: twice that, and MPR's tolerance of 1e-6 m); with boxes alone
/// it is 0. A solid whose mesh the compiler refuses (qhull finds it flat: thinner than about 1e-15 of its
/// size, or flat once its vertices are floats; or too large for a float) is `unsupported` in every pair, the
/// others are answered; qhull prints its reasons on stderr.
///
///  * overlap: contact where MuJoCo lists one of dist <= 0. Two boxes meet in its own separating-axis test,
///    pairs with a mesh in libccd's MPR. Blind spots: two boxes with nearly parallel edges may be listed
///    without a contact (of 4 000 pairs up to 7.4e-4 S deep); MPR misses what is less than its tolerance
///    deep.
///  * No distances: `unsupported` for a pair that is apart, unless max_separation <= 0, where "apart" is all
///    that was asked. With a margin MuJoCo lists contacts of pairs apart, but their `dist` is no distance:
///    half of it where a box's corner is nearest to a face, with meshes too little, as MPR sees the shapes
///    grown by the margin. At a margin of ten times the distance it was -7.0 to 1.7 times the distance (pair
///    families). In 4.0 `dist` of two boxes apart is up to 1.5e-3 of their size too large.
///  * Of depths nothing is claimed (Resolution::of_depth is infinite). Where faces of boxes meet, 2.2.2 gives
///    half the depth; of edges, now and then a contact as deep as the boxes are large. MPR takes the depth
///    where a ray from the centre of mass leaves, which need not be near the minimum.
///  * manifold: MuJoCo's contacts (it writes up to mjMAXCONPAIR, 50), deepest first, as many as are asked
///    for; with a mesh one. `pos` is taken to be half-way between the surfaces; feature_id is 0.
///  * Closer to touching than the resolution, the pair is `undecided` where geometry is asked. Contacts that
///    are not finite or have no normal are `failed`; so are coordinates beyond 1e75.
///
/// The functions are those that the table held when this backend, or the plugin (MujocoOverride), was first
/// used in the process: our own check, put there by the plugin, is never asked. Another's, put there before,
/// is.
///
/// Memory: a workspace holds an mjData of its own; nothing is allocated after its first call since build().
/// Threads: any, each with its own workspace. MuJoCo's errors while it compiles are InputErrors with its
/// words; what it takes for fatal (out of memory) goes to mju_user_error, which is left to the program.

namespace touchstone {

/// Adds narrowphase `mujoco`.
/// @throws InputError when the name is taken, or when the library loaded is not of the version that this was
/// compiled for.
void register_mujoco(BackendRegistry& registry);

}  // namespace touchstone
