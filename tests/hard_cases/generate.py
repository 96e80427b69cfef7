#!/usr/bin/env python3
"""Writes the hard cases beside this file, each with its exact answer: python3 tests/hard_cases/generate.py

With --check nothing is written; the exit code says whether the files are what this script makes.
"""

import json
import math
import pathlib
import sys

from exact_hull import signed_distance

HERE = pathlib.Path(__file__).parent
IDENTITY = "identity"


def box(x, y=None, z=None):
    return {"type": "box", "size": [float(x), float(x if y is None else y), float(x if z is None else z)]}


def convex(vertices, **mark):
    return {"type": "convex", "vertices": [[float(c) for c in v] for v in vertices], **mark}


def corners(place):
    """place(i, j, k) for i, j, k in -1, +1, in the order x slowest."""
    return convex([place(i, j, k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])


def at(x, y, z, wxyz=(1, 0, 0, 0)):
    return {"position": [float(x), float(y), float(z)], "quaternion_wxyz": [float(c) for c in wxyz]}


def matrix(rows, p=(0, 0, 0)):
    return {"matrix": [[float(c) for c in rows[i]] + [float(p[i])] for i in range(3)] + [[0.0, 0.0, 0.0, 1.0]]}


def rotation(pose):
    """As the project defines it: normalise, then R00 = ((w w + x x) - y y) - z z and so on, in doubles."""
    w, x, y, z = pose["quaternion_wxyz"]
    length = math.sqrt(((w * w + x * x) + y * y) + z * z)
    w, x, y, z = w / length, x / length, y / length, z / length
    return [[((w * w + x * x) - y * y) - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), ((w * w - x * x) + y * y) - z * z, 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), ((w * w - x * x) - y * y) + z * z]]


def local_vertices(shape):
    if shape["type"] == "convex":
        return shape["vertices"]
    h = [0.5 * s for s in shape["size"]]
    return [[i * h[0], j * h[1], k * h[2]] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]


def world_vertices(shape, pose):
    if pose == IDENTITY:
        R, t = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [0.0, 0.0, 0.0]
    elif "matrix" in pose:
        R, t = [row[:3] for row in pose["matrix"][:3]], [row[3] for row in pose["matrix"][:3]]
    else:
        R, t = rotation(pose), pose["position"]
    return [[((R[i][0] * v[0] + R[i][1] * v[1]) + R[i][2] * v[2]) + t[i] for i in range(3)]
            for v in local_vertices(shape)]


class Family:
    def __init__(self, name):
        self.name, self.cases = name, []

    def add(self, name, a, b, pose_b, why, pose_a=IDENTITY):
        world = world_vertices(a, pose_a), world_vertices(b, pose_b)
        pair_class, distance, normal = signed_distance(*world)
        exact = {"class": pair_class, "signed_distance": distance}
        if normal:
            exact["normal"] = normal
        self.cases.append({"id": f"{self.name}-{name}", "why_hard": why, "shapes": [a, b], "poses": [pose_a, pose_b],
                           "exact": exact})


CUBE = box(2)
EIGHTH_TURN_Z = (0.9238795325112867, 0, 0, 0.3826834323650898)
GENERAL_TURN = (0.8, 0.2, -0.4, 0.3)
# Stands on a vertex: three edges leave the origin upwards, the opposite vertex is (0, 0, 3).
RHOMBOHEDRON = corners(lambda i, j, k: ((i + 1) / 2 - (j + 1) / 2, (j + 1) / 2 - (k + 1) / 2,
                                        ((i + 1) + (j + 1) + (k + 1)) / 2))


def ridge_x(shear=0.0, length=4.0):
    """A square prism along (1, shear, 0) with edges, not faces, at its top and bottom."""
    ring = ((1, 0), (0, 1), (0, -1), (-1, 0))
    return convex([(s * length, y + s * length * shear, z) for s in (-1, 1) for y, z in ring])


def ridge_y():
    ring = ((1, 0), (0, 1), (0, -1), (-1, 0))
    return convex([(x, s * 4, z) for s in (-1, 1) for x, z in ring])


def containment():
    f = Family("containment")
    f.add("cube-in-battery", box(1.050, 0.919, 0.525), box(0.02), at(0, 0, 0),
          "no edge of one meets a face of the other; the way out is twice as long as the overlap looks")
    f.add("off-centre", CUBE, box(0.5), at(0.25, 0.125, 0.5), "the shortest way out is through one face only")
    f.add("concentric", CUBE, box(1), at(0, 0, 0), "six ways out of the same length: any face normal is right")
    f.add("flush", CUBE, box(1), at(0.5, 0, 0), "inside with a face in the plane of the outer one: still deep, not touching")
    f.add("corner", CUBE, box(1), at(0.5, 0.5, 0.5), "inside, three faces in planes of the outer one")
    f.add("tiny", CUBE, box(2.0 ** -20), at(0.3, 0, 0), "a speck inside: its own extent is lost beside the way out")
    f.add("turned", box(4), CUBE, at(0.5, 0.2, 0.1, GENERAL_TURN), "contained and turned: no candidate axis is aligned")
    f.add("beam-through", box(2, 2, 2), box(8, 0.5, 0.5), at(0, 0, 0),
          "a beam pierces the cube: the vertices of neither are in the other")
    f.add("crossed-slabs", box(4, 4, 0.25), box(0.25, 4, 4), at(0, 0, 0), "slabs through each other's middle")
    f.add("sheared-in-sheared", corners(lambda i, j, k: (2 * i + k, 2 * j, 2 * k)),
          corners(lambda i, j, k: (0.25 * i, 0.25 * j + 0.125 * i, 0.25 * k)), at(0.5, 0, 0.125),
          "contained, and no face of one is parallel to any of the other's but one")
    return f


def coplanar():
    f = Family("coplanar")
    f.add("identical-cubes", CUBE, CUBE, at(0, 0, 0), "every edge lies in two faces of the other, all axes tie")
    f.add("identical-box", box(1, 2, 3), box(1, 2, 3), at(0, 0, 0), "identical: depth is the least side, not zero")
    f.add("identical-rhombohedra", RHOMBOHEDRON, RHOMBOHEDRON, at(0, 0, 0), "identical, with no aligned face")
    f.add("identical-turned", CUBE, CUBE, at(1, 2, 3, GENERAL_TURN), "identical after rounding: the same bent faces twice",
          at(1, 2, 3, GENERAL_TURN))
    f.add("identical-slabs", box(1, 1, 2.0 ** -10), box(1, 1, 2.0 ** -10), at(0, 0, 0), "identical and thin")
    f.add("half-turn", box(1, 2, 3), box(1, 2, 3), at(0, 0, 0, (0, 1, 0, 0)), "the same solid with other vertex labels")
    f.add("shifted", CUBE, CUBE, at(0.5, 0, 0), "four pairs of faces coplanar, overlapping by three quarters")
    f.add("shifted-little", CUBE, CUBE, at(2.0 ** -40, 0, 0), "nearly identical: every coplanar pair is a near tie")
    f.add("sharing-base", CUBE, box(1, 1, 3), at(0, 0, 0.5), "bases coplanar, the rest inside or through")
    f.add("cross-in-plane", box(4, 1, 1), box(1, 4, 1), at(0, 0, 0), "two bars crossing with top and bottom coplanar")
    f.add("diagonal-apart", CUBE, CUBE, at(3, 3, 0.5), "apart along parallel edges: the nearest points are a stretch")
    f.add("corners-apart", CUBE, CUBE, at(3, 3, 3), "vertex to vertex: no face or edge pair gives the distance")
    f.add("vertex-to-edge", CUBE, RHOMBOHEDRON, at(2, 0.25, 2), "vertex to the inside of an edge, apart")
    f.add("side-by-side", CUBE, box(1, 1, 2), at(2.5, 0, 0), "coplanar tops and bottoms, apart along x")
    return f


def touching():
    f = Family("touching")
    up = 2.0
    f.add("face-full", CUBE, CUBE, at(0, 0, up), "whole faces coincide: contact with separation exactly 0")
    f.add("face-part", CUBE, CUBE, at(0.5, 0.25, up), "faces share a part")
    f.add("face-small-inside", box(4), box(1), at(0.5, -0.5, 2.5), "a small face inside a large one")
    f.add("face-edge-only", CUBE, CUBE, at(up, 0, up), "faces coplanar with only an edge in common")
    f.add("face-vertex-only", CUBE, CUBE, at(up, up, up), "one vertex in common: the normal is any of an octant")
    f.add("collinear-edges", CUBE, CUBE, at(up, up, 0.5), "parallel edges touch along a stretch")
    f.add("collinear-edges-end", CUBE, CUBE, at(up, up, up - 2.0 ** -30), "parallel edges touch along 2^-30 of their length")
    f.add("edge-crossing", ridge_x(), ridge_y(), at(0, 0, up), "two ridges touch in one point inside both edges")
    f.add("edge-on-face", CUBE, ridge_x(), at(0, 0, up), "a ridge lies on a face")
    f.add("vertex-on-face", CUBE, RHOMBOHEDRON, at(0.25, 0.125, 1), "a vertex on the inside of a face")
    f.add("vertex-on-edge", CUBE, RHOMBOHEDRON, at(1, 0.125, 1), "a vertex on the inside of an edge")
    f.add("vertex-on-vertex", CUBE, RHOMBOHEDRON, at(1, 1, 1), "a vertex on a vertex")
    f.add("tip-to-tip", RHOMBOHEDRON, RHOMBOHEDRON, at(0, 0, 3), "two acute vertices meet: a cone of normals")
    for k in (10, 30, 45, 50):
        for name, sign in (("apart", 1), ("deep", -1)):
            f.add(f"edge-crossing-{name}-2^-{k}", ridge_x(), ridge_y(), at(0, 0, up + sign * 2.0 ** -k),
                  f"crossing edges off by 2^-{k}: the sign hangs on the last bits")
            f.add(f"vertex-face-{name}-2^-{k}", CUBE, RHOMBOHEDRON, at(0.25, 0.125, 1 + sign * 2.0 ** -k),
                  f"a vertex off a face by 2^-{k}")
    return f


def near_parallel():
    f = Family("near-parallel")
    for k in (4, 10, 16, 20, 26, 30, 40, 48, 52):
        why = f"ridges cross at an angle of 2^-{k}: their cross product is nearly all cancellation"
        f.add(f"ridges-2^-{k}", ridge_x(), ridge_x(2.0 ** -k), at(0, 0, 1.9375), why + ", and the roofs compete")
        f.add(f"ridges-apart-2^-{k}", ridge_x(), ridge_x(2.0 ** -k), at(0, 0, 2.0625), why + "; apart by 1/16")
    for k in (10, 26, 40, 52):
        stack = corners(lambda i, j, k_: (i + k_ * 2.0 ** -k, j, k_))
        f.add(f"stack-2^-{k}", CUBE, stack, at(0, 0, 1.984375),
              f"nearly aligned stack, sheared by 2^-{k}: an edge pair imitates the face")
    for k in (8, 24, 50):
        f.add(f"turned-2^-{k}", CUBE, CUBE, at(1.5, 0.1, 0.2, (1, 0, 0, 2.0 ** -k)),
              f"cubes turned by 2^-{k - 1} about z: all edges nearly parallel")
    return f


def slabs_and_needles():
    f = Family("thin")
    thin = 2.0 ** -20
    f.add("slab-on-slab", box(1, 1, thin), box(1, 1, thin), at(0.25, 0.25, thin), "slabs lie on each other")
    f.add("slab-half-in-slab", box(1, 1, thin), box(1, 1, thin), at(0.25, 0.25, thin / 2),
          "depth of half a thickness of 2^-20")
    f.add("slab-apart", box(1, 1, thin), box(1, 1, thin), at(0.25, 0.25, 2 * thin), "apart by one thickness")
    f.add("crossed-needles", box(1024, thin, thin), box(thin, 1024, thin), at(0, 0, thin / 2), "aspect 2^30, crossing")
    f.add("needles-pass", box(1024, thin, thin), box(thin, 1024, thin), at(0, 0, 1.5 * thin), "aspect 2^30, half a thickness apart")
    f.add("needle-in-cube", CUBE, box(thin, thin, 4), at(0.25, 0.5, 0), "a needle through a cube")
    f.add("needle-along-edge", CUBE, box(thin, thin, 4), at(1 + thin / 2, 1 + thin / 2, 0), "a needle touches along an edge")
    f.add("needle-turned", CUBE, box(8, 1e-6, 1e-6), at(0.5, 0.25, 1.0, GENERAL_TURN), "a turned needle: the world faces of a needle bend most")
    f.add("slab-turned", box(1, 1, 1e-9), box(1, 1, 1e-9), at(5e-10, 0, 0, GENERAL_TURN),
          "turned slabs of 1e-9: rounding of the vertices is 1e-7 of the thickness", at(0, 0, 0, GENERAL_TURN))
    f.add("paper", CUBE, box(1, 1, 2.0 ** -52), at(0, 0, 1), "a sheet of 2^-52 on a cube's face: rounding moves one of its faces into the cube's")
    return f


def scale():
    f = Family("scale")
    powers = (("denormal", 2.0 ** -1070), ("least-normal", 2.0 ** -1020), ("1e-160", 2.0 ** -530), ("1e-8", 2.0 ** -27), ("1e8", 2.0 ** 27),
              ("2^511", 2.0 ** 511), ("2^1000", 2.0 ** 1000))
    for name, s in powers:
        why = f"of size {name}: squares and triple products leave the range of a double" if abs(math.log2(s)) > 300 else \
            f"of size {name}: absolute tolerances mean something else here"
        for state, d in (("touch", 4), ("deep", 3), ("apart", 6)):
            f.add(f"{name}-{state}", box(4 * s), box(4 * s), at(d * s, 2 * s, 0), "cubes " + why)
    for name, s in (("1e-8", 1e-8), ("1e8", 1e8)):
        f.add(f"turned-{name}", box(s, 2 * s, 3 * s), box(s), at(1.1 * s, 0.3 * s, 0.2 * s, GENERAL_TURN),
              f"a general pair of size {name}")
    f.add("ratio-2^27", box(2.0 ** 27), CUBE, at(0, 0, 2.0 ** 26 + 1 - 2.0 ** -10), "a cube on one 2^26 times its size, 2^-10 deep")
    f.add("ratio-2^50", box(2.0 ** 51), box(1), at(0.25, 0.5, 2.0 ** 50 + 0.25), "a unit cube on one of 2^51: 2 ulps deep")
    return f


def far_away():
    f = Family("far")
    for name, x in (("1e6", 1e6), ("2^30", 2.0 ** 30), ("1e12", 1e12), ("1e15", 1e15)):
        step = max(2.0 ** -20, 2 * math.ulp(x))
        for state, d in (("touch", 0.0), ("deep", -step), ("apart", step)):
            f.add(f"{name}-{state}", CUBE, CUBE, at(x + 2 + d, x, -x),
                  f"{name} m from the origin: the gap is a few ulps of the coordinates", at(x, x, -x))
    for name, x in (("1e6", 1e6), ("1e9", 1e9)):
        f.add(f"turned-{name}", CUBE, CUBE, at(x + 1.5, x + 0.5, x, EIGHTH_TURN_Z),
              f"turned, {name} m out: world faces are bent by rounding, the hull decides", at(x, x, x, GENERAL_TURN))
    return f


def hexahedra():
    f = Family("hexahedra")
    sheared = corners(lambda i, j, k: (i + 0.5 * k, j + 0.25 * k, k))
    tapered = corners(lambda i, j, k: (i * (1 - 0.25 * (k + 1)), j * (1 - 0.25 * (k + 1)), k))
    pyramid = convex([(-1, -1, -1), (0, 0, 1), (-1, 1, -1), (0, 0, 1), (1, -1, -1), (0, 0, 1), (1, 1, -1), (0, 0, 1)])
    wedge = corners(lambda i, j, k: (i if k < 0 else 0, j, k))
    warped = convex([(-1, -1, -1), (-1, -1, 1), (-1, 1, -1), (-1, 1, 1), (1, -1, -1), (1, -1, 1), (1, 1, -1), (1, 1, 1.5)], warped="accept")
    f.add("sheared-deep", sheared, CUBE, at(0.5, 0.25, 1.75), "faces lean: only one face pair is parallel")
    f.add("sheared-apart", sheared, sheared, at(2.75, 2.5, 0.5), "two sheared solids, nearest along parallel edges")
    f.add("sheared-turned", sheared, sheared, at(1.2, 0.8, 1.1, GENERAL_TURN), "sheared and turned: rounding bends every face")
    f.add("tapered-side", tapered, CUBE, at(1.75, 0, 0), "the side leans, so the face of the cube is not the axis")
    f.add("tapered-tops", tapered, tapered, at(0, 0, 2, (0, 1, 0, 0)), "small tops against each other")
    f.add("tapered-turned", tapered, sheared, at(0.9, 0.4, 1.6, GENERAL_TURN), "no face parallel to any other")
    f.add("pyramid-apex", pyramid, CUBE, at(0, 0, 2), "a face collapsed to a point touches: a quad without a normal")
    f.add("pyramid-deep", pyramid, CUBE, at(0.25, 0, 1.5), "the apex inside a cube")
    f.add("pyramid-side", pyramid, CUBE, at(1.5, 0, 0.5), "against a leaning triangle")
    f.add("wedge-edge", wedge, CUBE, at(0, 0, 2), "a face collapsed to an edge touches")
    f.add("wedge-crossed", wedge, wedge, matrix([(0, 1, 0), (1, 0, 0), (0, 0, -1)], (0, 0, 1.5)), "two collapsed edges cross, 0.5 deep")
    f.add("warped-collapsed-edge", convex([(-1, -1, -1), (-1, -1, 1), (-1, 1, -1), (-1, 1, 1), (1, -1, -1), (1, -1, 1), (1, 1, -1), (1, 1, -1)], warped="accept"),
          CUBE, at(1.75, 0, 0), "two vertices coincide, which leaves the top quad out of plane")
    f.add("warped-deep", warped, CUBE, at(0, 0, 2.25), "one vertex lifted: three quads are no planes, the hull has triangles")
    f.add("warped-apart", warped, CUBE, at(0.5, 0.5, 3), "warped and apart: nearest at the lifted vertex")
    f.add("warped-little", corners(lambda i, j, k: (i, j, k * (1 + (2.0 ** -30 if i * j * k == 1 else 0)))), CUBE, at(0.5, 0.5, 2),
          "warped by 2^-30: touching at one vertex becomes overlap of 2^-30")
    f.add("reversed-order", convex([(-i, -j, -k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]), CUBE, at(2, 0, 0),
          "vertices in mirrored order")
    f.add("any-order", convex([(1, 1, 1), (-1, -1, -1), (1, -1, 1), (-1, 1, -1), (1, 1, -1), (-1, -1, 1), (-1, 1, 1), (1, -1, -1)]), CUBE,
          at(1.5, 1.25, 0), "vertices in no order")
    return f


def bad_inputs():
    """Each is one case of a pair file that must come out invalid, with `expected_error` in the reason."""
    zero, one = "identity", "identity"
    unit = [[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    cases = []

    def add(name, why, expected, shape=CUBE, pose=one):
        cases.append({"id": f"bad-{name}", "why_hard": why, "shapes": [CUBE, shape], "poses": [zero, pose],
                      "expected_error": expected})

    for word in ("NaN", "Infinity", "-Infinity"):
        add(f"size-{word}", "a side is no number", f"shape 1: size: not finite: {word}", {"type": "box", "size": [word, 2, 2]})
        add(f"vertex-{word}", "a coordinate is no number", f"shape 1: vertex 7: not finite: {word}",
            {"type": "convex", "vertices": unit[:7] + [[word, 1, 1]]})
        add(f"position-{word}", "a position is no number", f"pose 1: position: not finite: {word}",
            pose={"position": [word, 0, 0], "quaternion_wxyz": [1, 0, 0, 0]})
        add(f"quaternion-{word}", "a component is no number", f"pose 1: quaternion_wxyz: not finite: {word}",
            pose={"position": [0, 0, 0], "quaternion_wxyz": [1, word, 0, 0]})
    add("quaternion-zero", "no direction to normalise", "the quaternion is zero",
        pose={"position": [0, 0, 0], "quaternion_wxyz": [0, 0, 0, 0]})
    add("size-negative", "a negative side", "size along x is -2, must be > 0", {"type": "box", "size": [-2, 2, 2]})
    add("size-zero", "a flat box has no volume", "size along z is 0, must be > 0", {"type": "box", "size": [2, 2, 0]})
    add("vertices-none", "no vertices", "has 0 vertices, a hexahedron has 8", {"type": "convex", "vertices": []})
    add("vertices-seven", "one vertex missing", "has 7 vertices, a hexahedron has 8", {"type": "convex", "vertices": unit[:7]})
    add("vertices-coplanar", "a quad is no solid", "zero volume", {"type": "convex", "vertices": [[i, j, 0] for i, j, k in unit]})
    add("vertices-collinear", "a segment is no solid", "zero volume", {"type": "convex", "vertices": [[i, 0, 0] for i in range(8)]})
    add("vertices-one-point", "a point is no solid", "zero volume", {"type": "convex", "vertices": [[1, 2, 3]] * 8})
    add("not-convex", "a vertex pushed inside the hull", "not convex: vertex 7",
        {"type": "convex", "vertices": [[2 * c - 1 for c in v] for v in unit[:7]] + [[0.25, 0.25, 0.25]]})
    add("reflection", "a mirror image is no rigid pose", "a reflection",
        pose={"matrix": [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]})
    add("scaling", "a matrix that scales", "columns are off orthonormal by 3",
        pose={"matrix": [[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]})
    add("last-row", "a projective matrix", "the last row is not 0 0 0 1",
        pose={"matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1, 1]]})
    add("type", "a shape that is none of ours", "unknown type \"sphere\"", {"type": "sphere", "radius": 1})
    add("world-overflow", "the world vertices leave the range of a double", "beyond the range of a double",
        box(2.0 ** 1000), at(1.7976931348623157e308, 0, 0))
    return cases


def text_of(cases):
    return "[\n" + ",\n".join(json.dumps(case) for case in cases) + "\n]\n"


def main():
    families = [containment(), coplanar(), touching(), near_parallel(), slabs_and_needles(), scale(), far_away(), hexahedra()]
    files = {f.name.replace("-", "_") + ".json": f.cases for f in families}
    files["bad_inputs.json"] = bad_inputs()
    different = []
    for name, cases in files.items():
        path = HERE / name
        if "--check" not in sys.argv[1:]:
            path.write_text(text_of(cases))
        elif not path.exists() or path.read_text() != text_of(cases):
            different.append(name)
    print(f"{sum(map(len, files.values()))} cases" + "".join(f"; not as generated: {name}" for name in different))
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
