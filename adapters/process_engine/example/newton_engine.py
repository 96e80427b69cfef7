#!/usr/bin/env python3
"""Newton (single precision) as an engine: pip install newton. Overlap, distances and depths by its collision pipeline, on the processor.
Shapes have no margin; contacts are found up to a gap of a tenth of the pair's extent, or as far as a distance needs it."""
from engine_protocol import DISTANCE, half_sides, need, np, put, serve

wp, newton = need("warp", "warp-lang"), need("newton")
NORMAL_SIGN = -1 if newton.__version__.startswith(("0.", "1.0.")) else 1  # until 1.0 normals are from the second shape to the first
HULL = np.array([t for a, b, c, d in ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
                 for t in (a, b, c, a, c, d)], np.int32)
solids, reach = [], []


def build(corners):
    solids[:] = corners
    reach[:] = [np.linalg.norm(each, axis=1).max() for each in corners]


def quaternion(R):
    """x, y, z, w of a rotation (Bar-Itzhack)."""
    K = np.array([[R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0], [R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
                  [R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], 0],
                  [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], np.trace(R)]])
    return np.linalg.eigh(K)[1][:, -1]


def scene(pairs, gaps):
    """A model of all pairs, shapes 2 i and 2 i + 1 the i-th, and its collision pipeline for these pairs alone."""
    builder = newton.ModelBuilder()
    for pair, gap in zip(pairs, gaps):
        for solid, pose in ((pair["a"], pair["X_WA"]), (pair["b"], pair["X_WB"])):
            body = builder.add_body(xform=wp.transform(wp.vec3(*pose["p"]), wp.quat(*quaternion(pose["R"].T))))
            config, half = builder.ShapeConfig(margin=0.0, gap=float(gap) / 2), half_sides(solids[solid])
            if half is not None:
                builder.add_shape_box(body, hx=half[0], hy=half[1], hz=half[2], cfg=config)
            else:
                mesh = newton.Mesh(np.asarray(solids[solid], np.float32), HULL, compute_inertia=False)
                builder.add_shape_convex_hull(body, mesh=mesh, cfg=config)
    model = builder.finalize(device="cpu")
    wanted = wp.array(np.arange(2 * len(pairs), dtype=np.int32).reshape(-1, 2), dtype=wp.vec2i, device="cpu")
    return model, newton.CollisionPipeline(model, broad_phase="explicit", shape_pairs_filtered=wanted)


def answer(head, pairs, slots):
    gaps = [reach[pair["a"]] + reach[pair["b"]] for pair in pairs]
    if head["query"] == DISTANCE:
        gaps = [min(float(head["max_separation"]), gap + np.linalg.norm(pair["X_WB"]["p"] - pair["X_WA"]["p"])) for gap, pair in zip(gaps, pairs)]
    else:
        gaps = [0.1 * gap for gap in gaps]
    model, pipeline = scene(pairs, gaps)
    contacts, state = pipeline.contacts(), model.state()
    pipeline.collide(state, contacts)
    count, poses = int(contacts.rigid_contact_count.numpy()[0]), state.body_q.numpy().astype(float)
    first, p0, p1, normals = (getattr(contacts, "rigid_contact_" + name).numpy()[:count].astype(float) for name in ("shape0", "point0", "point1", "normal"))
    found = [[] for _ in slots]
    for shape, a, b, n in zip(first.astype(int), p0, p1, normals):
        pair, swapped = shape // 2, shape % 2 == 1
        a, b = (moved(poses[body], point) for body, point in ((shape, a), (shape ^ 1, b)))
        n = NORMAL_SIGN * n
        found[pair].append((float(n @ (b - a)), *((b, a, -n) if swapped else (a, b, n))))
    for slot, points in zip(slots, found):
        put(slot, points, head)


def moved(pose, point):
    x, w = pose[3:6], pose[6]
    return pose[:3] + point + 2 * np.cross(x, np.cross(x, point) + w * point)


if __name__ == "__main__":
    serve(build, answer, name="newton", description=f"Newton {newton.__version__} (PyPI): CollisionPipeline", distance=True,
          penetration=True, manifold=True, scalar_bits=32, relative_resolution=1e-6, depth_resolution=None)
