#pragma once

#include <cstddef>
#include <cstdint>

#include "touchstone/contact_core/numerics/certified.hpp"

// Kernels on many pairs, or on one pair's axes, in the lanes of a vector register. Each is
// compiled once per instruction set (kernels_<isa>.cpp) and chosen when the program starts. Everything here
// is plain data, so that no inline function of a shared header is ever compiled for one instruction set and
// linked into another. Lanes never mix and nothing is contracted: the bits are the same on every instruction
// set.

namespace touchstone::native {

using numerics::Certified;

/// The pairs of a block, as indices into the arrays of poses and shapes.
struct PairIndices {
  std::uint32_t a;
  std::uint32_t b;
};

/// X_WS as twelve doubles, R by columns, then p: Pose's layout in memory.
struct PoseRecord {
  double R[9];
  double p[3];
};

struct alignas(32) BoxRecord {
  double half_extents[3];
  double reach;  ///< their sum
};

/// centre + x half_edges[0] + y half_edges[1] + z half_edges[2], x, y, z in [-1, 1], in the solid's frame.
struct alignas(64) Parallelepiped {
  double half_edges[3][3];
  double centre[3];
  double deviation;  ///< bound on the distance of a vertex from this parallelepiped's, by coordinate [m]
  double padding[3];
};

/// The vertices in the solid's frame. Not a number where the solid's magnitudes are not ordinary: nothing
/// then is certified.
struct alignas(64) VertexRecord {
  double x[8], y[8], z[8];
};

/// The same for the depth kernels and clipping: edges as unit directions and half lengths, and the vertices.
/// A record of its own, as boxes go without it, and overlap reads the two cache lines of Parallelepiped
/// alone.
struct alignas(64) ParallelepipedEdges {
  double directions[3][3];
  double half_lengths[3];
  double centre[3];
  double deviation;  ///< as Parallelepiped's, with the rounding of lengths and directions
  double x[8], y[8], z[8];
};

/// How the faces and edges of a solid's hull hang together. An edge runs along the loop of its first face.
struct HullTopology {
  std::uint8_t face_count, edge_count;
  std::uint8_t face_vertex[12];  ///< one that lies on the face
  std::uint8_t edge_faces[2][18];
  std::uint8_t edge_vertices[2][18];  ///< from, to
};

/// The faces and edges of a solid's hull; see find_features(). Where they are kRegularHull's, in its order.
struct alignas(64) HullRecord {
  /// Outward unit normals of eight faces, by coordinate for the lanes.
  struct Normals {
    double x[8], y[8], z[8];
  };

  HullTopology topology;
  alignas(64) Normals normals[2];
};

/// Hexahedron::kFaceVertices, which kernels do not see.
inline constexpr std::uint8_t kQuads[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                              {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};

consteval HullTopology regular_hull() {
  HullTopology out{6, 0, {}, {}, {}};
  const auto has = [](int face, int vertex) {
    for (const int v : kQuads[face])
      if (v == vertex) return true;
    return false;
  };
  for (int f = 0; f < 6; ++f) {
    while (!has(f, out.face_vertex[f])) ++out.face_vertex[f];
    for (int g = f + 1; g < 6; ++g) {
      for (int k = 0; k < 4; ++k) {
        const std::uint8_t from = kQuads[f][k], to = kQuads[f][(k + 1) % 4];
        if (!has(g, from) || !has(g, to)) continue;
        const int e = out.edge_count++;
        out.edge_faces[0][e] = static_cast<std::uint8_t>(f),
        out.edge_faces[1][e] = static_cast<std::uint8_t>(g);
        out.edge_vertices[0][e] = from, out.edge_vertices[1][e] = to;
      }
    }
  }
  return out;
}

/// Of most solids: six faces in the order of kQuads, twelve edges.
inline constexpr HullTopology kRegularHull = regular_hull();
inline constexpr int kRegularFaces = 6, kRegularEdges = 12;
static_assert(kRegularHull.edge_count == kRegularEdges);

/// The faces of a solid of six plane quadrangles, in the order of kQuads.
struct alignas(64) PlainHull {
  double normals[3][6];  ///< outward, unit, in the solid's frame: x, y, z
  double padding[2];     ///< lanes load it, too
  bool is_plain;         ///< whether the solid is one: else the rest is nothing
  bool is_regular;       ///< whether its HullRecord has kRegularHull and these normals
};

/// The faces of a solid of six quadrangles, plane or bent, in the order of kQuads, each as its loop there.
struct alignas(64) QuadFaces {
  /// Of a bent face's triangles; of a plane face its own, twice.
  struct alignas(64) Planes {
    double normals[2][4];  ///< outward, unit, in the solid's frame: x, y, z, nothing
  };

  double normals[3][8];  ///< of the faces, likewise: x of six, y, z
  Planes planes[6];
  std::uint8_t anchor[6];  ///< a vertex that is on all of a face's planes
  std::uint8_t bent;       ///< a bit a face
  bool are_quads;          ///< whether the solid is such a one: else the rest is nothing
};

/// A posed solid for clip_hull_pair.
struct QuadView {
  const QuadFaces* faces;
  const double* vertices;  ///< as HullView's
  const double* R;
};

/// A posed solid for compute_hull_depth.
struct HullView {
  const HullRecord* hull;
  const double* vertices;  ///< x of eight, y of eight, z of eight, about the pair's common origin
  const double* R;         ///< R_WS by columns
};

/// What a single pair of boxes is asked for.
enum class PairNeed : std::uint8_t {
  distance,
  manifold,  ///< and the distance of pairs apart: most asked are in contact
  contacts,  ///< of pairs that are certified as separated nothing else is set
};

/// How much of a DepthRecord holds.
enum class DepthKnown : std::uint8_t {
  nothing,
  axis,     ///< separation and n
  witness,  ///< p_A too
};

/// The depth of an overlapping pair, certified here or elsewhere; see depth_kernels.hpp.
struct alignas(64) DepthRecord {
  double separation;
  double n[3];
  double p_A[3];  ///< in the world
  Certified certified;
  DepthKnown known;
  /// Of boxes and parallelepipeds certified as separated: where they are furthest apart, of the axes whose
  /// edges meet at a sine above 2^-10. If none of these separates them it may be any, a thinner one too; and
  /// it tells nothing where contacts alone were asked for. 0-2: along A's face normals, 3-5: B's, 6 + 3 i +
  /// j: across edge i of A and j of B.
  std::uint8_t axis;
  bool is_of_hulls;  ///< what the kernels of hulls found, be it nothing: they need not be asked again
};

/// How much of a DistanceRecord holds.
enum class DistanceState : std::uint8_t {
  undecided,     ///< nothing; a more accurate kernel, or one on a scaled copy, may find more
  exhausted,     ///< nothing, and no kernel can do better: magnitudes did not hinder the most accurate one
  if_separated,  ///< all of it if the pair is separated, which no kernel certifies
  found,         ///< all of it: the pair is certainly separated
};

/// Of what is further from its own origin than from the world's, the roundings of a vertex: see
/// find_hull_depth().
inline constexpr double kFarRoundoffs = 4.0;

/// Both solids' vertices as compute_hull_depths places them, about A's first: x of eight, y, z.
struct alignas(64) PlacedHulls {
  double a[24], b[24];
  double origin[3];  ///< in the world
  double padding;    ///< lanes write it, too
};

/// A pair for compute_hull_depths, in the order of comes_first().
struct HullTask {
  PairIndices pair;
  const PlainHull *a, *b;  ///< nothing is computed unless both are regular
  DepthRecord* depth;      ///< p_A about the origin
  PlacedHulls* placed;     ///< holds where the depth is known
};

/// The distance of a separated pair; see distance_kernels.hpp.
struct DistanceRecord {
  double separation;
  double n[3];       ///< unit, A to B
  double from_A[3];  ///< from A's origin to its witness point, in world axes
  DistanceState state;
};

/// Edges of two faces count as one edge if their directions agree to this angle and their distance is at most
/// this part of the shorter one; see manifold.hpp.
inline constexpr double kFlushEdges = 0x1p-26;

/// ContactPoint's layout in memory.
struct PointRecord {
  double p_A[3], p_B[3], separation;
  std::uint32_t feature_id, padding;
};

/// A pair whose faces are to be clipped against each other along a known normal.
struct ClipTask {
  double n_separation[4];  ///< n, A to B, unit; separation along it
  PairIndices pair;        ///< in the order of comes_first()
  bool swapped;            ///< points are written for (b, a)
  PointRecord* points;     ///< room for eight
};

/// The clip of one pair; see manifold.hpp.
struct ClipRecord {
  int count;    ///< points written
  int deepest;  ///< the first as deep as the pair, or -1
  bool fits;    ///< the rest holds
};

/// A pair of solids with PlainHulls whose faces are to be clipped, in the order of comes_first().
struct HullClipTask {
  double n_separation[4];  ///< as ClipTask's
  PairIndices pair;
  const PlainHull *a, *b;
};

/// Of HullClipRecord::bits.
struct HullClipBits {
  static constexpr int kLeft = 0;     ///< eight: an edge of the common region (0-3: A's, 4-7: B's)
  static constexpr int kNear = 8;     ///< eight: and its corner is within the limit
  static constexpr int kBehind = 16;  ///< 4 j + i: A's edge i turns past B's edge j
  static constexpr int kFaceA = 32, kFaceB = 36;  ///< four each: number in Hexahedron::kFaceVertices
  static constexpr int kFits = 40;                ///< the rest holds
};

/// The clip of a HullClipTask, as Clip<4> (polygon_clip.hpp), about A's first vertex.
struct alignas(64) HullClipRecord {
  double p_x[8], p_y[8], p_z[8], separation[8];  ///< by edge
  double origin[3];                              ///< in the world
  double tie;                                    ///< points this close to the deepest are as deep
  std::uint64_t bits;                            ///< see HullClipBits
  std::uint64_t flush;                           ///< 4 j + i: A's edge i and B's edge j are flush
};

/// Rules of manifold.hpp that the kernel shares with scalar code.
namespace hull_clip {

/// Leans closer than this are equal.
inline constexpr double kSameLean = 0x1p-51;
/// Cosine between a face's normal (either one, of a bent face) and n below which the face counts as its edge
/// furthest along n.
inline constexpr double kSteep = 0x1p-3;
/// Sine of a corner's angle below which it is sharp.
inline constexpr double kSharp = 0x1p-2;
/// Corners this share of the extent apart are one.
inline constexpr double kShortest = 0x1p-44;
/// Parallel edges no further apart than this many u * extent coincide.
inline constexpr double kCoincide = 16;
/// Edges are parallel to rounding when moving one across by the tolerance moves their crossing by more than
/// this part of the other.
inline constexpr double kParallel = 0x1p-20;
/// The exact test runs from this part on, which includes all flush edges, as 16 u * 8 / kFlushEdges / 12 >
/// 2^-24.
inline constexpr double kNearlyParallel = 0x1p-24;
/// Points this close to the deepest count as deep, in u * extent.
inline constexpr double kAsDeep = 64;

}  // namespace hull_clip

/// A plane through p_W: unit vectors that span it, and its normal.
struct PlaneFrame {
  double x[3], y[3], n[3];
  double p_W[3];
};

/// From A to B, any length.
struct PairAxis {
  double x, y, z, padding;
};

struct Kernels {
  const char* isa;
  int lanes;  ///< pairs at a time

  /// Overlap of boxes by their half-extents: the coarse pass of certify_boxes (box_box_overlap.hpp), in two
  /// lanes both.
  Certified (*certify_box_pair)(const PoseRecord& X_WA, const BoxRecord& a, const PoseRecord& X_WB,
                                const BoxRecord& b);
  /// Both passes, the second for lanes that the first leaves open: it leaves only pairs that touch to
  /// rounding, or nearly touch along edges at a small angle.
  void (*certify_boxes)(const PoseRecord* poses, const BoxRecord* shapes, const PairIndices* pairs,
                        std::size_t count, Certified* out);
  /// Of pairs that these leave open, most that touch across an axis of the world or at edges. Left are those
  /// that touch along another face, in a vertex or within 1/64 of an edge's end, very thin ones, and some
  /// with several axes open; see touching_boxes.hpp.
  void (*certify_touching_boxes)(const PoseRecord* poses, const BoxRecord* shapes, const PairIndices* pairs,
                                 std::size_t count, Certified* out);
  /// `separated` where a face's normal, or an axis across two edges, shows that the boxes are further apart
  /// than `reach` [m] by 2^-15 of their size and more, else unknown: then they may be so in a vertex, too.
  void (*find_boxes_beyond)(const PoseRecord* poses, const BoxRecord* shapes, const PairIndices* pairs,
                            std::size_t count, double reach, Certified* out);
  /// Two solids' world vertices in a plane's frame, their heights in twice the precision; see
  /// flush_hulls.cpp. @returns the largest |p - p_W|_1.
  double (*put_into_frame)(const VertexRecord& a_W, const VertexRecord& b_W, const PlaneFrame& plane,
                           VertexRecord& a, VertexRecord& b);
  /// As certify_parallelepipeds (parallelepiped_overlap.hpp).
  void (*certify_parallelepipeds)(const PoseRecord* poses, const Parallelepiped* shapes,
                                  const PairIndices* pairs, std::size_t count, Certified* out);
  /// As certify_aligned (aligned_hulls.hpp). Unknown where a solid's vertices are not numbers.
  void (*certify_aligned)(const PoseRecord* poses, const VertexRecord* shapes, const PairIndices* pairs,
                          std::size_t count, Certified* out);
  /// As certify_by_mpr (mpr.hpp), of any two solids; gives up after `max_steps`.
  /// @param axes null, or one a pair: set where the pair is found separated.
  void (*certify_by_mpr)(const PoseRecord* poses, const VertexRecord* shapes, const PairIndices* pairs,
                         std::size_t count, int max_steps, Certified* out, PairAxis* axes);
  /// Separated where B certainly lies beyond A along its axis, else unknown. Any axes, numbers or not.
  void (*certify_by_axis)(const PoseRecord* poses, const VertexRecord* shapes, const PairIndices* pairs,
                          std::size_t count, const PairAxis* axes, Certified* out);

  /// Depth, normal and witness of overlapping pairs; DepthRecord::known tells how much is set. Pairs go in
  /// the order of comes_first(). A single pair has the same bits. Of several, none with a pose that is not
  /// finite is certified.
  void (*compute_box_depths)(const PoseRecord* poses, const BoxRecord* shapes, const PairIndices* pairs,
                             std::size_t count, DepthRecord* out);
  void (*compute_parallelepiped_depths)(const PoseRecord* poses, const ParallelepipedEdges* shapes,
                                        const PairIndices* pairs, std::size_t count, DepthRecord* out);
  /// place() of solids of ordinary magnitudes, from their own frames into the world and about A's first
  /// vertex.
  /// @returns HullPair::extent
  double (*place_hulls)(const PoseRecord& X_WA, const VertexRecord& a_S, const PoseRecord& X_WB,
                        const VertexRecord& b_S, VertexRecord& a_W, VertexRecord& b_W, VertexRecord& a,
                        VertexRecord& b);
  /// One pair, as the first.
  void (*compute_box_pair_depth)(const PoseRecord* poses, const BoxRecord* shapes, PairIndices pair,
                                 PairNeed need, DepthRecord* out);
  /// The same of two solids of any kind; p_A about the common origin. @param extent see HullPair. @param
  /// position at least every |world coordinate|. Certifies separated pairs too, without measuring them.
  void (*compute_hull_depth)(const HullView& a, const HullView& b, double extent, double position,
                             DepthRecord* out);
  /// The same bits for pairs of ordinary magnitudes and finite poses with regular hulls; those of others
  /// stay.
  /// @param fetched tasks that are there, `count` or more: those beyond are fetched for later calls
  void (*compute_hull_depths)(const PoseRecord* poses, const VertexRecord* shapes, const HullTask* tasks,
                              std::size_t count, std::size_t fetched);

  /// Distance of pairs separated by more than rounding; others, and pairs that the kernel does not settle,
  /// are not `found`. The bits do not depend on the batch.
  /// @param axes DepthRecord::axis of each pair, or null: then each is searched for.
  void (*compute_box_distances)(const PoseRecord* poses, const BoxRecord* shapes, const PairIndices* pairs,
                                const std::uint8_t* axes, std::size_t count, DistanceRecord* out);
  void (*compute_parallelepiped_distances)(const PoseRecord* poses, const Parallelepiped* shapes,
                                           const PairIndices* pairs, const std::uint8_t* axes,
                                           std::size_t count, DistanceRecord* out);
  /// The same with exact products, for edges at small angles: slower. For pairs at any distance.
  void (*compute_box_distances_accurately)(const PoseRecord* poses, const BoxRecord* shapes,
                                           const PairIndices* pairs, std::size_t count, DistanceRecord* out);
  void (*compute_parallelepiped_distances_accurately)(const PoseRecord* poses, const Parallelepiped* shapes,
                                                      const PairIndices* pairs, std::size_t count,
                                                      DistanceRecord* out);
  /// As the first two, for any two solids of ordinary magnitudes; see hull_distance_kernels.hpp.
  void (*compute_hull_distances)(const PoseRecord* poses, const VertexRecord* shapes,
                                 const PairIndices* pairs, std::size_t count, DistanceRecord* out);

  /// Clips the contact faces of two solids; records of pairs that the kernel does not settle do not `fit`.
  /// The bits do not depend on the batch.
  void (*clip_boxes)(const PoseRecord* poses, const BoxRecord* shapes, const ClipTask* tasks,
                     std::size_t count, double max_point_separation, ClipRecord* out);
  void (*clip_parallelepipeds)(const PoseRecord* poses, const ParallelepipedEdges* shapes,
                               const ClipTask* tasks, std::size_t count, double max_point_separation,
                               ClipRecord* out);
  /// The same for general hexahedra; pairs that do not fit are left to make_manifold().
  void (*clip_hulls)(const PoseRecord* poses, const VertexRecord* shapes, const HullClipTask* tasks,
                     std::size_t count, double max_point_separation, HullClipRecord* out);
  /// The same of one pair, faces bent or plane; sets no `origin`. @param n_separation as HullClipTask's.
  /// @param extent see HullPair
  void (*clip_hull_pair)(const QuadView& a, const QuadView& b, const double (&n_separation)[4], double extent,
                         double max_point_separation, HullClipRecord* out);
};

/// The instruction sets that this machine runs, the narrowest first.
struct KernelList {
  const Kernels* of[3];
  int count;
};
const KernelList& available_kernels();

/// The widest that this machine runs, or the one that the environment variable TOUCHSTONE_ISA names (generic,
/// avx2, avx512; one that the machine lacks falls back to the widest that it has). Chosen once.
/// @throws InputError for a name that is none of these.
const Kernels& kernels();

}  // namespace touchstone::native
