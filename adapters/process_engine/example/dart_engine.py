#!/usr/bin/env python3
"""DART (double precision) as an engine: pip install dartpy. Boxes alone (it has no hulls), by the collision detector of its worlds;
depths are those of its contacts, distances those of that detector."""
from engine_protocol import DISTANCE, OVERLAP, OVERLAPPING, SEPARATED, UNSUPPORTED, half_sides, need, np, put, serve

dart = need("dartpy")
detector = dart.simulation.World().getConstraintSolver().getCollisionDetector()
frames = []


def frame_of(index, corners):
    """Where a solid is; None: no box."""
    half = half_sides(corners)
    if half is None:
        return None
    frame = dart.dynamics.SimpleFrame(dart.dynamics.Frame.World(), str(index))
    frame.setShape(dart.dynamics.BoxShape(2 * half))
    frame.createCollisionAspect()
    return frame


def build(corners):
    frames[:] = [frame_of(*each) for each in enumerate(corners)]


def contacts(group, a):
    """Points as put() takes them: a contact is in the middle between the surfaces, its normal from the second object to the first."""
    result = dart.collision.CollisionResult()
    group.collide(dart.collision.CollisionOption(), result)
    for found in result.getContacts():
        n = -found.normal if found.collisionObject1.getShapeFrame().getName() == a.getName() else found.normal
        yield -found.penetrationDepth, found.point + found.penetrationDepth / 2 * n, found.point - found.penetrationDepth / 2 * n, n


def nearest(group, a):
    """The nearest points of solids that are apart."""
    result = dart.collision.DistanceResult()
    group.distance(dart.collision.DistanceOption(True), result)
    points = result.nearestPoint1, result.nearestPoint2
    p_A, p_B = points if result.shapeFrame1.getName() == a.getName() else points[::-1]
    away = p_B - p_A
    yield result.minDistance, p_A, p_B, away / np.linalg.norm(away)


def answer(head, pairs, slots):
    for pair, slot in zip(pairs, slots):
        both = [frames[pair["a"]], frames[pair["b"]]]
        if None in both:
            slot["status"] = UNSUPPORTED
            continue
        group = detector.createCollisionGroup()
        for frame, pose in zip(both, (pair["X_WA"], pair["X_WB"])):
            frame.setTransform(dart.math.Isometry3(pose["R"].T, pose["p"]))
            group.addShapeFrame(frame)
        if head["query"] == OVERLAP:
            slot["status"] = OVERLAPPING if group.collide() else SEPARATED
            continue
        points = list(contacts(group, both[0]))
        put(slot, points or (list(nearest(group, both[0])) if head["query"] == DISTANCE else []), head)


if __name__ == "__main__":
    serve(build, answer, name="dart", description=f"DART {dart.__version__} (PyPI): collide, distance of boxes", distance=True,
          penetration=True, manifold=True, depth_resolution=None)
