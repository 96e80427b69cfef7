#include "touchstone/adapters/ode/ode_narrowphase.hpp"

#include <array>
#include <cassert>
#include <cmath>
#include <thread>
#include <utility>
#include <vector>

#include "touchstone/adapters/ode/convex_data.hpp"
#include "touchstone/adapters/ode/ode_library.hpp"
#include "touchstone/contact_core/geometry/constants.hpp"
#include "touchstone/contact_core/narrowphase/no_geometry.hpp"
#include "touchstone/contact_core/narrowphase/points_within.hpp"
#include "touchstone/contact_core/narrowphase/validate.hpp"

namespace touchstone::ode {
namespace {

using GeomHandle = std::unique_ptr<dxGeom, GeomDeleter>;

/// The data that a geom is made from.
struct Shape {
  bool is_box;
  dVector3 side;      ///< boxes: full side lengths [m]
  ConvexData convex;  ///< boxes: about the solid's origin

  explicit Shape(const Hexahedron& solid)
      : is_box(solid.is_box()), convex(solid, is_box ? Vector3(Vector3::Zero()) : mean_vertex(solid)) {
    for (int k = 0; k < 3; ++k) side[k] = 2.0 * solid.half_extents()[k];
    side[3] = 0.0;
  }
};

/// A solid's pose as ODE wants it.
struct Placement {
  dVector3 position;
  Rotation rotation;

  Placement(const Shape& shape, const Pose& X_WS) : rotation(X_WS.R) {
    const Vector3 p_W = shape.is_box ? X_WS.p : transform(X_WS, shape.convex.centre);
    for (int k = 0; k < 3; ++k) position[k] = p_W[k];
    position[3] = 0.0;
  }
};

/// A NaN would pass for "apart": every comparison in ODE's separating-axis tests is then false.
struct Contacts {
  int count = 0;
  int box_code = 0;  ///< dBoxBox's return code; 0 when the contacts are dCollide's
  Vector3 n_AB_W;    ///< of the deepest contact
  std::array<dContactGeom, kMaxManifoldPoints> contact;
};

void box_contacts(const Shape& a, const Placement& at_a, const Shape& b, const Placement& at_b,
                  int max_points, Contacts& out) {
  dVector3 normal;
  dReal depth;
  out.count = dBoxBox(at_a.position, at_a.rotation.rows, a.side, at_b.position, at_b.rotation.rows, b.side,
                      normal, &depth, &out.box_code, max_points, out.contact.data(), sizeof(dContactGeom));
  if (out.count > 0) out.n_AB_W = Vector3(normal[0], normal[1], normal[2]);
}

bool boxes_touch(const Shape& a, const Placement& at_a, const Shape& b, const Placement& at_b) {
  return dBoxTouchesBox(at_a.position, at_a.rotation.rows, a.side, at_b.position, at_b.rotation.rows,
                        b.side) != 0;
}

int deepest(const Contacts& contacts) {
  int best = 0;
  for (int i = 1; i < contacts.count; ++i) {
    if (contacts.contact[i].depth > contacts.contact[best].depth) best = i;
  }
  return best;
}

/// How much of the depth lies between `pos` and A's surface; the rest lies between it and B's.
double share_of_a(int box_code) {
  if (box_code >= 1 && box_code <= 3) return 1.0;  // a face of A is the reference: pos is on B
  if (box_code >= 4 && box_code <= 6) return 0.0;  // a face of B is the reference: pos is on A
  return 0.5;
}

ContactPoint contact_point(const Contacts& contacts, int i) {
  const dContactGeom& contact = contacts.contact[i];
  ContactPoint point;
  point.separation = -contact.depth;
  point.p_A_W = Vector3(contact.pos[0], contact.pos[1], contact.pos[2]) +
                (share_of_a(contacts.box_code) * contact.depth) * contacts.n_AB_W;
  point.p_B_W = point.p_A_W + point.separation * contacts.n_AB_W;
  point.feature_id = 0;
  return point;
}

/// MPR at exact touch has a zero normal; overflow leaves NaN or infinities.
bool is_usable(const Contacts& contacts) {
  for (int i = 0; i < contacts.count; ++i) {
    const dContactGeom& contact = contacts.contact[i];
    if (!std::isfinite(contact.depth)) return false;
    if (!std::isfinite(contact.pos[0]) || !std::isfinite(contact.pos[1]) || !std::isfinite(contact.pos[2]))
      return false;
  }
  return std::abs(norm(contacts.n_AB_W) - 1.0) <= kRotationTolerance;
}

class OdeWorkspace final : public Narrowphase::Workspace {
 public:
  OdeWorkspace() {
    static constexpr std::array<dReal, 24> kNoPlanes = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1,
                                                        0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static constexpr std::array<dReal, 24> kNoPoints{};
    for (int i = 0; i < 2; ++i) {
      boxes_[i].reset(dCreateBox(nullptr, 1, 1, 1));
      convexes_[i].reset(dCreateConvex(nullptr, kNoPlanes.data(), 6, kNoPoints.data(), Hexahedron::kVertices,
                                       kConvexPolygons.data()));
    }
  }

  /// ODE wants its data allocated in every thread that collides.
  void enter_thread() {
    if (thread_ == std::this_thread::get_id()) return;
    dAllocateODEDataForThread(dAllocateMaskAll);
    thread_ = std::this_thread::get_id();
  }

  void collide(const Shape& a, const Placement& at_a, const Shape& b, const Placement& at_b, int max_points,
               Contacts& out) {
    const dGeomID geom_a = place(0, a, at_a);
    const dGeomID geom_b = place(1, b, at_b);
    out.count = dCollide(geom_a, geom_b, max_points, out.contact.data(), sizeof(dContactGeom));
    if (out.count == 0) return;
    const dReal* normal = out.contact[deepest(out)].normal;
    out.n_AB_W = Vector3(-normal[0], -normal[1], -normal[2]);
  }

 private:
  dGeomID place(int slot, const Shape& shape, const Placement& at) {
    const dGeomID geom = shape.is_box ? boxes_[slot].get() : convexes_[slot].get();
    if (shape.is_box) {
      dGeomBoxSetLengths(geom, shape.side[0], shape.side[1], shape.side[2]);
    } else {
      dGeomSetConvex(geom, shape.convex.planes.data(), 6, shape.convex.points.data(), Hexahedron::kVertices,
                     kConvexPolygons.data());
    }
    dGeomSetPosition(geom, at.position[0], at.position[1], at.position[2]);
    dGeomSetRotation(geom, at.rotation.rows);
    return geom;
  }

  LibraryUse library_;  // first, so that the geoms go before the library does
  std::array<GeomHandle, 2> boxes_;
  std::array<GeomHandle, 2> convexes_;
  std::thread::id thread_;
};

class OdeNarrowphase final : public Narrowphase {
 public:
  OdeNarrowphase() {
    capabilities_.penetration = true;
    capabilities_.manifold = true;
    capabilities_.overlap_complete = false;  // convexes that just touch are missed
    // A property of the method: MPR's tolerance is 1e-6 and its direction need not be that of the least depth
    // (1.0 m off on sheared hexahedra of about 1 m); dBoxBox is up to 0.056 m off. Measured in
    // tests/ode/ode_accuracy_test.cpp.
    capabilities_.resolution = {1e-6, 1.0};
  }

  std::string_view name() const noexcept override { return "ode"; }
  const Capabilities& capabilities() const noexcept override { return capabilities_; }

  void build(std::span<const Hexahedron> solids) override {
    refuse_rounded(solids, "ode");
    std::vector<Shape> shapes(solids.begin(), solids.end());
    shapes_ = std::move(shapes);
  }

  std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<OdeWorkspace>(); }

  void evaluate(const NarrowphaseInput& input, const NarrowphaseOutput& output,
                Workspace& workspace) const noexcept override {
    assert(fits(input, output, shapes_.size()));
    auto& scratch = static_cast<OdeWorkspace&>(workspace);
    scratch.enter_thread();
    for (std::size_t i = 0; i < input.pairs.size(); ++i) evaluate_pair(input, i, output, scratch);
  }

 private:
  void evaluate_pair(const NarrowphaseInput& input, std::size_t i, const NarrowphaseOutput& output,
                     OdeWorkspace& scratch) const {
    const auto [a, b] = input.pairs[i];
    const QueryKind kind = input.query.kind;
    // Poses that are not finite have no answer.
    if (!has_finite_poses(input.pairs[i], input.poses)) {
      return refuse(PairStatus::failed, kNaN, kind, i, output);
    }
    const Shape& shape_a = shapes_[a];
    const Shape& shape_b = shapes_[b];
    const Placement at_a(shape_a, input.poses[a]);
    const Placement at_b(shape_b, input.poses[b]);
    // ODE has an overlap test for boxes, which is more exact than its contacts.
    const bool boxes = shape_a.is_box && shape_b.is_box;
    if (kind == QueryKind::overlap && boxes) {
      const bool touch = boxes_touch(shape_a, at_a, shape_b, at_b);
      output.status[i] = touch ? PairStatus::overlapping : PairStatus::separated;
      return;
    }
    // All else is decided from contact points.
    Contacts contacts;
    const int max_points = kind == QueryKind::overlap ? 1 : kMaxManifoldPoints;
    if (boxes) {
      box_contacts(shape_a, at_a, shape_b, at_b, max_points, contacts);
    } else {
      scratch.collide(shape_a, at_a, shape_b, at_b, max_points, contacts);
    }
    // ODE measures no distances: pairs apart get a status alone.
    if (kind == QueryKind::overlap) {
      output.status[i] = contacts.count > 0 ? PairStatus::overlapping : PairStatus::separated;
    } else if (contacts.count == 0 && boxes && boxes_touch(shape_a, at_a, shape_b, at_b)) {
      refuse(PairStatus::failed, kNaN, kind, i,
             output);  // dBoxBox finds no points at edges and corners that just touch
    } else if (contacts.count == 0) {
      const bool nearness_asked = input.query.max_separation > 0.0;
      refuse(nearness_asked ? PairStatus::unsupported : PairStatus::separated,
             nearness_asked ? kNaN : kInfinity, kind, i, output);
    } else if (!is_usable(contacts)) {
      refuse(PairStatus::failed, kNaN, kind, i, output);
    } else {
      report(contacts, input.query, i, output);
    }
  }

  static void refuse(PairStatus status, double separation, QueryKind kind, std::size_t i,
                     const NarrowphaseOutput& output) {
    output.status[i] = status;
    if (kind != QueryKind::overlap) output.geometry[i] = no_geometry(separation);
  }

  static void report(Contacts& contacts, const Query& query, std::size_t i, const NarrowphaseOutput& output) {
    const int best = deepest(contacts);
    std::swap(contacts.contact[0], contacts.contact[best]);
    const ContactPoint witness = contact_point(contacts, 0);
    output.status[i] = PairStatus::overlapping;
    output.geometry[i] = {witness.separation, contacts.n_AB_W, witness.p_A_W, witness.p_B_W, 0};
    if (query.kind != QueryKind::manifold) return;
    const int count = contacts.count < query.max_points ? contacts.count : query.max_points;
    const auto points = output.points_of(i, query).first(static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k) points[static_cast<std::size_t>(k)] = contact_point(contacts, k);
    output.geometry[i].point_count = keep_within(points, point_limit(query, witness.separation));
  }

  LibraryUse library_;
  Capabilities capabilities_;
  std::vector<Shape> shapes_;
};

/// Pairs of boxes go to ODE's own box functions on data that lies in arrays: through dGeomGetPosition the
/// same dBoxTouchesBox costs up to four times as much, because geoms and their poses are scattered over the
/// heap.
class OdeRawCheck final : public RawCheck {
 public:
  void build(std::span<const Hexahedron> solids) override {
    refuse_rounded(solids, "ode");
    dAllocateODEDataForThread(dAllocateMaskAll);
    std::vector<Shape> shapes(solids.begin(), solids.end());
    std::vector<GeomHandle> geoms;
    geoms.reserve(shapes.size());
    for (const Shape& shape : shapes) {
      geoms.emplace_back(shape.is_box ? dCreateBox(nullptr, shape.side[0], shape.side[1], shape.side[2])
                                      : dCreateConvex(nullptr, shape.convex.planes.data(), 6,
                                                      shape.convex.points.data(), Hexahedron::kVertices,
                                                      kConvexPolygons.data()));
    }
    geoms_ = std::move(geoms);
    shapes_ = std::move(shapes);  // moving keeps the elements that the geoms point into where they are
  }

  bool supports(QueryKind kind) const noexcept override { return kind != QueryKind::distance; }

  void set_poses(std::span<const Pose> poses) override {
    boxes_.clear();
    for (std::size_t i = 0; i < geoms_.size(); ++i) {
      const Placement at(shapes_[i], poses[i]);
      dGeomSetPosition(geoms_[i].get(), at.position[0], at.position[1], at.position[2]);
      dGeomSetRotation(geoms_[i].get(), at.rotation.rows);
      boxes_.push_back(
          {at, {shapes_[i].side[0], shapes_[i].side[1], shapes_[i].side[2], 0.0}, shapes_[i].is_box});
    }
  }

  std::size_t run(std::span<const SolidPair> pairs, QueryKind kind) noexcept override {
    std::size_t in_contact = 0;
    for (const auto [a, b] : pairs) in_contact += in_touch(a, b, kind) ? 1 : 0;
    return in_contact;
  }

 private:
  struct PosedBox {
    Placement at;
    dVector3 side;
    bool is_box;
  };

  bool in_touch(SolidIndex a, SolidIndex b, QueryKind kind) noexcept {
    const PosedBox &box_a = boxes_[a], &box_b = boxes_[b];
    std::array<dContactGeom, kMaxManifoldPoints> contacts;
    if (!box_a.is_box || !box_b.is_box) {
      const int max_points = kind == QueryKind::manifold ? kMaxManifoldPoints : 1;
      return dCollide(geoms_[a].get(), geoms_[b].get(), max_points, contacts.data(), sizeof(dContactGeom)) >
             0;
    }
    if (kind == QueryKind::overlap) {
      return dBoxTouchesBox(box_a.at.position, box_a.at.rotation.rows, box_a.side, box_b.at.position,
                            box_b.at.rotation.rows, box_b.side) != 0;
    }
    dVector3 normal;
    dReal depth;
    int code;
    return dBoxBox(box_a.at.position, box_a.at.rotation.rows, box_a.side, box_b.at.position,
                   box_b.at.rotation.rows, box_b.side, normal, &depth, &code, kMaxManifoldPoints,
                   contacts.data(), sizeof(dContactGeom)) > 0;
  }

  LibraryUse library_;
  std::vector<Shape> shapes_;
  std::vector<PosedBox> boxes_;    // of every solid; only those of boxes are read further than is_box
  std::vector<GeomHandle> geoms_;  // after shapes_: destroyed before what they point into
};

}  // namespace

std::unique_ptr<Narrowphase> make_narrowphase() { return std::make_unique<OdeNarrowphase>(); }
std::unique_ptr<RawCheck> make_raw_check() { return std::make_unique<OdeRawCheck>(); }

}  // namespace touchstone::ode
