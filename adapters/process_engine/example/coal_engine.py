#!/usr/bin/env python3
"""Coal (double precision) as an engine: pip install coal, or hpp-fcl, its name before. Boxes are its boxes, others its convexes.
Default requests; with --tolerance T gjk_tolerance is T."""
import importlib.util
import sys

from engine_protocol import OVERLAP, OVERLAPPING, SEPARATED, half_sides, need, serve

if importlib.util.find_spec("coal") is None and importlib.util.find_spec("hppfcl") is not None:
    coal = need("hppfcl")
    coal.Transform3s, coal.StdVec_Vec3s = coal.Transform3f, coal.StdVec_Vec3f
else:
    coal = need("coal")
TOLERANCE = float(sys.argv[sys.argv.index("--tolerance") + 1]) if "--tolerance" in sys.argv else None
# The twelve triangles of a hexahedron, outwards; corner i is (i>>2 & 1, i>>1 & 1, i & 1).
FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
shapes = []


def shape_of(corners):
    half = half_sides(corners)
    if half is not None:
        return coal.Box(*(2 * half))
    points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    points.extend(list(corners))
    for a, b, c, d in FACES:
        triangles.extend([coal.Triangle(a, b, c), coal.Triangle(a, c, d)])
    return coal.Convex(points, triangles)


def build(corners):
    shapes[:] = [shape_of(each) for each in corners]


def placed(pose):
    return coal.Transform3s(pose["R"].T.copy(), pose["p"].copy())


def request(made):
    if TOLERANCE is not None:
        made.gjk_tolerance = TOLERANCE
    return made


def answer(head, pairs, slots):
    for pair, slot in zip(pairs, slots):
        question = (shapes[pair["a"]], placed(pair["X_WA"]), shapes[pair["b"]], placed(pair["X_WB"]))
        if head["query"] == OVERLAP:
            result = coal.CollisionResult()
            slot["status"] = OVERLAPPING if coal.collide(*question, request(coal.CollisionRequest()), result) else SEPARATED
            continue
        result = coal.DistanceResult()
        distance = coal.distance(*question, request(coal.DistanceRequest()), result)
        slot["status"] = SEPARATED if distance > 0 else OVERLAPPING
        if distance <= head["max_separation"]:
            slot["separation"], slot["n_AB_W"] = distance, result.normal
            slot["p_A_W"], slot["p_B_W"] = result.getNearestPoint1(), result.getNearestPoint2()


if __name__ == "__main__":
    serve(build, answer, name="coal", description=f"Coal {coal.__version__} (PyPI): collide, distance", distance=True,
          penetration=True, relative_resolution=1e-5, depth_resolution=None)
