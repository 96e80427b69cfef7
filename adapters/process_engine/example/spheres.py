#!/usr/bin/env python3
"""An engine as a process, binary protocol, with NumPy: pairs whose bounding spheres are apart are separated,
all others undecided. A start for an engine of your own: only `answer` knows about geometry."""
import json
import sys

import numpy as np

HEAD = np.dtype([("kind", "<u4"), ("count", "<u4"), ("batch", "<u4"), ("query", "<u4"), ("max_points", "<u4"),
                 ("reserved", "<u4"), ("max_separation", "<f8"), ("max_point_separation", "<f8")])
POSE = np.dtype([("R", "<f8", (3, 3)), ("p", "<f8", 3)])  # R[0] is the solid's x axis in the world
PAIR = np.dtype([("a", "<u4"), ("b", "<u4"), ("X_WA", POSE), ("X_WB", POSE)])
ANSWER = np.dtype([("pair", "<u4"), ("status", "<u4")])  # of an overlap query
SEPARATED, OVERLAPPING, UNDECIDED, FAILED, UNSUPPORTED = range(5)


def world_corners(corners, poses):
    """Corners n x 8 x 3 [m] of solids at their poses."""
    return np.einsum("nvi,nij->nvj", corners, poses["R"]) + poses["p"][:, None, :]


def answer(corners, pairs):
    """The status of each pair; corners: solids x 8 x 3 [m]."""
    a = world_corners(corners[pairs["a"]], pairs["X_WA"])
    b = world_corners(corners[pairs["b"]], pairs["X_WB"])
    centre_a, centre_b = a.mean(axis=1), b.mean(axis=1)
    radius_a = np.linalg.norm(a - centre_a[:, None], axis=2).max(axis=1)
    radius_b = np.linalg.norm(b - centre_b[:, None], axis=2).max(axis=1)
    apart = np.linalg.norm(centre_b - centre_a, axis=1) > (radius_a + radius_b) * (1 + 1e-12)
    return np.where(apart, SEPARATED, UNDECIDED)


def read(stream, dtype, count):
    data = stream.read(dtype.itemsize * count)
    return np.frombuffer(data, dtype) if len(data) == dtype.itemsize * count else None


def main():
    stdin, stdout = sys.stdin.buffer, sys.stdout.buffer
    greeting = {"touchstone": 1, "name": "spheres_py", "format": "binary",
                "description": "NumPy " + np.__version__ + ": bounding spheres"}
    stdout.write(json.dumps(greeting).encode() + b"\n")
    stdout.flush()
    corners = np.empty((0, 8, 3))
    while (head := read(stdin, HEAD, 1)) is not None:
        count = int(head["count"][0])
        if head["kind"][0] == 1:
            corners = read(stdin, np.dtype(("<f8", (8, 3))), count)
            continue
        pairs = read(stdin, PAIR, count)
        answers = np.empty(count, ANSWER)
        answers["pair"] = np.arange(count)
        answers["status"] = answer(corners, pairs)
        stdout.write(np.array([head["batch"][0], count], "<u4").tobytes() + answers.tobytes())
        stdout.flush()


if __name__ == "__main__":
    main()
