#!/usr/bin/env python3
"""An engine as a process, binary protocol, with NumPy: pairs whose bounding spheres are apart are separated,
all others undecided. A start for an engine of your own: only `answer` knows about geometry."""
from engine_protocol import np, SEPARATED, UNDECIDED, serve

solids = np.empty((0, 8, 3))


def build(corners):
    global solids
    solids = corners


def world_corners(corners, poses):
    """Corners n x 8 x 3 [m] of solids at their poses."""
    return np.einsum("nvi,nij->nvj", corners, poses["R"]) + poses["p"][:, None, :]


def answer(_, pairs, slots):
    a = world_corners(solids[pairs["a"]], pairs["X_WA"])
    b = world_corners(solids[pairs["b"]], pairs["X_WB"])
    centre_a, centre_b = a.mean(axis=1), b.mean(axis=1)
    radius_a = np.linalg.norm(a - centre_a[:, None], axis=2).max(axis=1)
    radius_b = np.linalg.norm(b - centre_b[:, None], axis=2).max(axis=1)
    apart = np.linalg.norm(centre_b - centre_a, axis=1) > (radius_a + radius_b) * (1 + 1e-12)
    slots["status"] = np.where(apart, SEPARATED, UNDECIDED)


if __name__ == "__main__":
    serve(build, answer, name="spheres_py", description="NumPy " + np.__version__ + ": bounding spheres")
