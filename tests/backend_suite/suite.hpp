#pragma once

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "touchstone/contact_core/registry.hpp"
#include "touchstone/tests/support/ask.hpp"

// The shared backend suite: the same tests for every registered backend. A program is the suite's library
// (component backend_suite of the installed package, with its main) and two definitions:
// register_suite_backends() below, and accuracy_table() of accuracy_table.hpp. One process holds one
// precision of Bullet, so there are two programs here.

namespace touchstone::suite {

/// Defined by the program: registers every backend that it tests.
void register_suite_backends(BackendRegistry& registry);

/// Filled once, before the tests are listed.
const BackendRegistry& backends();

std::vector<std::string> narrowphase_names();
std::vector<std::string> broadphase_names();

struct Body {
  Hexahedron solid;
  Pose X_WS;
};

/// One pair through a fresh build of `narrowphase`, `a` before `b`.
Answer ask(Narrowphase& narrowphase, const Body& a, const Body& b, const Query& query);

Body box(const Vector3& size, const Pose& X_WS);
Body box_at(const Vector3& size, const Vector3& p);
/// A cube of edge 2 sheared along x by `shear` per metre of z, through the general hexahedron path.
Body sheared_cube(double shear, const Pose& X_WS);
/// The same solid and place, made from eight vertices: engines see a hull instead of a box.
Body as_hexahedron(const Body& body);
Body moved(const Body& body, const Pose& X_VW);
/// max(size of the pair, largest |world coordinate|), the S of the error measures.
double scale_of(const Body& a, const Body& b);

/// Do nothing; naming them links the tests.
void link_narrowphase_suite();
void link_bad_pose_suite();
void link_manifold_suite();
void link_broadphase_suite();
void link_accuracy_suite();  ///< in installations with the component exact

/// Can this backend be expected to give geometry for a pair of that class?
bool gives_distance(const Capabilities& capabilities, double exact_separation);

}  // namespace touchstone::suite
