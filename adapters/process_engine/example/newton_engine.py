#!/usr/bin/env python3
"""Newton (single precision) as an engine: pip install newton. Overlap, distances and depths by its collision pipeline, on the processor.
Contacts are found up to a gap of a tenth of the pair's extent, or as far as a distance needs it. One model holds all solids; each
question gives it pairs, gaps and poses."""
from engine_protocol import AT_ONCE, DISTANCE, FAILED, half_sides, need, np, put, quaternion, serve

wp, newton = need("warp", "warp-lang"), need("newton")
NORMAL_SIGN = -1 if newton.__version__.startswith(("0.", "1.0.")) else 1  # until 1.0 normals are from the second shape to the first
HULL = np.array([t for a, b, c, d in ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
                 for t in (a, b, c, a, c, d)], np.int32)
UNIT = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
solids, holds, reach, scene = [], [], [], []  # holds: whether single precision does, without which Newton makes no model


def build(corners):
    holds[:] = np.isfinite(4 * corners.astype(np.float32)).all(axis=(1, 2))
    solids[:] = [each if held else UNIT for each, held in zip(corners, holds)]
    reach[:] = [np.linalg.norm(each, axis=1).max() for each in corners]
    scene.clear()


def make_scene():
    """A model that has every solid twice, as body and shape 2 i and 2 i + 1, and its collision pipeline for AT_ONCE pairs."""
    builder = newton.ModelBuilder()
    for corners in solids:
        half, config = half_sides(corners), builder.ShapeConfig(density=0.0, margin=0.0, gap=0.0)
        if half is None:
            mesh = newton.Mesh(np.asarray(corners, np.float32), HULL, compute_inertia=False)
        for body in builder.add_body(), builder.add_body():
            if half is None:
                builder.add_shape_convex_hull(body, mesh=mesh, cfg=config)
            else:
                builder.add_shape_box(body, hx=half[0], hy=half[1], hz=half[2], cfg=config)
    model, wanted = builder.finalize(device="cpu"), wp.zeros(AT_ONCE, dtype=wp.vec2i, device="cpu")
    pipeline = newton.CollisionPipeline(model, broad_phase="explicit", shape_pairs_filtered=wanted)
    return model, wanted, pipeline, pipeline.contacts(), model.state()


def answer(head, pairs, slots):
    scene[:] = scene or make_scene()
    slots["status"] = FAILED
    left = np.flatnonzero([holds[pair["a"]] and holds[pair["b"]] for pair in pairs])
    while len(left):  # those in which each solid is once
        now = left[np.intersect1d(*(np.unique(pairs[side][left], return_index=True)[1] for side in "ab"))]
        ask(head, pairs[now], [slots[i] for i in now])
        left = np.setdiff1d(left, now)


def ask(head, pairs, slots):
    model, wanted, pipeline, contacts, state = scene
    shapes = np.column_stack((2 * pairs["a"], 2 * pairs["b"] + 1)).astype(np.int32)
    wanted.numpy()[:] = np.pad(shapes, ((0, AT_ONCE - len(pairs)), (0, 0)))  # a shape and itself: no pair
    gaps, poses = model.shape_gap.numpy(), state.body_q.numpy()
    for pair, both in zip(pairs, shapes):
        extent, apart = reach[pair["a"]] + reach[pair["b"]], np.linalg.norm(pair["X_WB"]["p"] - pair["X_WA"]["p"])
        gaps[both] = (min(float(head["max_separation"]), extent + apart) if head["query"] == DISTANCE else 0.1 * extent) / 2
        for body, pose in zip(both, (pair["X_WA"], pair["X_WB"])):
            poses[body] = *pose["p"], *quaternion(pose["R"].T)
    pipeline.collide(state, contacts)
    count, poses = int(contacts.rigid_contact_count.numpy()[0]), poses.astype(float)
    first, second, p0, p1, normals = (getattr(contacts, "rigid_contact_" + name).numpy()[:count]
                                      for name in ("shape0", "shape1", "point0", "point1", "normal"))
    found = {shape: [] for shape in shapes[:, 0]}
    for shape, other, a, b, n in zip(first, second, *(each.astype(float) for each in (p0, p1, normals))):
        a, b, n = moved(poses[shape], a), moved(poses[other], b), NORMAL_SIGN * n
        key = shape if shape % 2 == 0 else other
        found[key].append((float(n @ (b - a)), *((a, b, n) if key == shape else (b, a, -n))))
    for slot, points in zip(slots, found.values()):
        put(slot, points, head)


def moved(pose, point):
    x, w = pose[3:6], pose[6]
    return pose[:3] + point + 2 * np.cross(x, np.cross(x, point) + w * point)


if __name__ == "__main__":
    serve(build, answer, name="newton", description=f"Newton {newton.__version__} (PyPI): CollisionPipeline", distance=True,
          penetration=True, manifold=True, scalar_bits=32, relative_resolution=1e-6, depth_resolution=None)
