#!/usr/bin/env python3
"""warp.sim of Warp (single precision; gone since 1.10) as an engine: pip install warp-lang==1.9.1. Boxes alone: overlap and distances by
collide(), on the processor."""
import sys

from engine_protocol import DISTANCE, UNSUPPORTED, half_sides, need, np, put, quaternion, serve

wp = need("warp", "warp-lang")
if not hasattr(wp, "sim"):
    try:
        import warp.sim
    except ImportError:
        sys.exit("Python package 'warp-lang' has no warp.sim since 1.10: pip install warp-lang==1.9.1")
solids, reach = [], []


def build(corners):
    solids[:] = [half_sides(each) for each in corners]
    reach[:] = [np.linalg.norm(each, axis=1).max() for each in corners]


def scene(pairs, margin):
    """A model of all pairs, shapes 2 i and 2 i + 1 the i-th and in a group of their own."""
    builder = wp.sim.ModelBuilder()
    builder.rigid_contact_margin = float(margin)
    for group, pair in enumerate(pairs):
        for solid, pose in ((pair["a"], pair["X_WA"]), (pair["b"], pair["X_WB"])):
            body, half = builder.add_body(origin=wp.transform(wp.vec3(*pose["p"]), wp.quat(*quaternion(pose["R"].T)))), solids[solid]
            builder.add_shape_box(body, hx=half[0], hy=half[1], hz=half[2], thickness=0.0, collision_group=group + 1, has_ground_collision=False)
    model = builder.finalize(device="cpu")
    model.ground = False
    return model


def answer(head, pairs, slots):
    boxes = [i for i, pair in enumerate(pairs) if solids[pair["a"]] is not None and solids[pair["b"]] is not None]
    slots["status"] = UNSUPPORTED
    if not boxes:
        return
    gaps = [reach[pairs[i]["a"]] + reach[pairs[i]["b"]] for i in boxes]
    if head["query"] == DISTANCE:
        gaps = [gap + np.linalg.norm(pairs[i]["X_WB"]["p"] - pairs[i]["X_WA"]["p"]) for gap, i in zip(gaps, boxes)]
    model = scene(pairs[boxes], max(gaps))
    state = model.state()
    wp.sim.collide(model, state)
    count, poses = int(model.rigid_contact_count.numpy()[0]), state.body_q.numpy().astype(float)
    first, p0, p1, normals = (getattr(model, "rigid_contact_" + name).numpy()[:count].astype(float) for name in ("shape0", "point0", "point1", "normal"))
    found = [[] for _ in boxes]
    for shape, a, b, n in zip(first.astype(int), p0, p1, normals):  # n from the second shape to the first
        a, b = (moved(poses[body], point) for body, point in ((shape, a), (shape ^ 1, b)))
        found[shape // 2].append((float(n @ (a - b)), *((b, a, n) if shape % 2 else (a, b, -n))))
    for i, points in zip(boxes, found):
        put(slots[i], points, head)


def moved(pose, point):
    x, w = pose[3:6], pose[6]
    return pose[:3] + point + 2 * np.cross(x, np.cross(x, point) + w * point)


if __name__ == "__main__":
    serve(build, answer, name="warp_sim", description=f"warp.sim {wp.__version__} (PyPI): collide", distance=True, penetration=True,
          scalar_bits=32, relative_resolution=1e-6, depth_resolution=None)
