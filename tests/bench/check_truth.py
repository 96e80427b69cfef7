#!/usr/bin/env python3
"""Holds a corpus's truth against rational arithmetic that shares nothing with the C++ code (tests/hard_cases/exact_hull.py).

    check_truth.py CORPUS [--every 10] [--jobs 2]       # every tenth case and path; 1: all (0.2 s a case)
"""

import argparse
import concurrent.futures
import json
import math
import pathlib
import sys
from fractions import Fraction

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "hard_cases"))
import exact_hull  # noqa: E402


def corners(shape):
    if shape["type"] == "box":
        x, y, z = (side / 2 for side in shape["size"])
        return [(a * x, b * y, c * z) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]
    return shape["vertices"]


def world(shape, pose):
    """((R0 x + R1 y) + R2 z) + t in doubles: what the corpus's solids are."""
    rows = pose["matrix"]
    return [tuple(((row[0] * x + row[1] * y) + row[2] * z) + row[3] for row in rows[:3]) for x, y, z in corners(shape)]


def fault(job):
    """Why the truth of a case is not what this says; None: it is."""
    case, (name, pair_class, distance) = job
    if case["id"] != name:
        return f"{case['id']}: the truth at its place is {name}'s"
    hulls = [world(shape, pose) for shape, pose in zip(case["shapes"], case["poses"])]
    known_class, known, _ = exact_hull.signed_distance(*hulls)
    if known_class != pair_class:
        return f"{name}: {pair_class} in the corpus, {known_class}"
    if abs(Fraction(known) - Fraction(distance)) > abs(Fraction(known)) * Fraction(1, 2**52):
        return f"{name}: {distance} in the corpus, {known}"
    return None


# ---- paths

NEAR = 1e-3  # of S: nearer than this a path is looked at from step to step, not proven
STEP = 1 / 64
ROUNDING = 1e-12  # of S: poses here are rounded otherwise than the corpus's
TIGHT = 1e-11  # of S: how near the two are at lo
BRACKET = 1e-6  # of s: a wider one may hold a contact that was looked past


def turn_between(R, Q):
    """Axis and angle, in the world, of the shorter turn from R to Q (lists of rows)."""
    M = [[sum(Q[i][k] * R[j][k] for k in range(3)) for j in range(3)] for i in range(3)]
    v = [M[2][1] - M[1][2], M[0][2] - M[2][0], M[1][0] - M[0][1]]
    sine, cosine = math.sqrt(sum(x * x for x in v)) / 2, (M[0][0] + M[1][1] + M[2][2] - 1) / 2
    angle = math.atan2(sine, cosine)
    if sine > 1e-3 or cosine > 0:
        return ([x / (2 * sine) for x in v] if sine > 0 else [0, 0, 1]), angle
    # Nearly half a turn: the axis from the symmetric part, its sign from what is left of the other.
    k = max(range(3), key=lambda i: M[i][i])
    axis = [(M[i][k] + M[k][i]) / 2 - (cosine if i == k else 0) for i in range(3)]
    length = math.sqrt(sum(x * x for x in axis)) * (1 if sum(x * y for x, y in zip(axis, v)) >= 0 else -1)
    return [x / length for x in axis], angle


def pose_at(ends, s):
    """Origin straight, turned about a fixed axis at a constant rate."""
    first, last = ([row[:3] for row in end[:3]] for end in ends)
    p = [a[3] + s * (b[3] - a[3]) for a, b in zip(ends[0][:3], ends[1][:3])]
    axis, angle = turn_between(first, last)
    c, n = math.cos(s * angle), math.sin(s * angle)
    x, y, z = axis
    T = [[c + x * x * (1 - c), x * y * (1 - c) - z * n, x * z * (1 - c) + y * n],
         [y * x * (1 - c) + z * n, c + y * y * (1 - c), y * z * (1 - c) - x * n],
         [z * x * (1 - c) - y * n, z * y * (1 - c) + x * n, c + z * z * (1 - c)]]
    return [[*(sum(T[i][k] * first[k][j] for k in range(3)) for j in range(3)), p[i]] for i in range(3)] + [[0, 0, 0, 1]]


class Path:
    """Two solids on their ways, by the first and the last of their poses."""

    def __init__(self, cases):
        self.shapes = cases[0]["shapes"]
        self.ends = [[cases[end]["poses"][i]["matrix"] for end in (0, -1)] for i in (0, 1)]
        self.reach = [max(math.dist((0, 0, 0), corner) for corner in corners(shape)) for shape in self.shapes]
        sizes = [2 * reach for reach in self.reach]
        self.scale = max(sizes + [abs(row[3]) for ends in self.ends for end in ends for row in end[:3]])
        a, b = ([q[3] - p[3] for p, q in zip(*(end[:3] for end in ends))] for ends in self.ends)
        turns = [turn_between(*([row[:3] for row in end[:3]] for end in ends))[1] for ends in self.ends]
        self.speed = math.dist(a, b) + sum(turn * reach for turn, reach in zip(turns, self.reach))

    def at(self, s):
        return [pose_at(ends, s) for ends in self.ends]

    def distance(self, s):
        return float(exact_hull.signed_distance(*(world(shape, {"matrix": pose}) for shape, pose in zip(self.shapes, self.at(s))))[1])


def path_fault(job):
    """Why the time of impact of a path is not what this says; None: it is."""
    cases, (name, path_class, lo, hi) = job
    path = Path(cases)
    for k, case in enumerate(cases):
        if case["id"] != f"{name}@{k}":
            return f"{name}: its pose {k} is {case['id']}"
        for ours, theirs in zip(path.at(k / (len(cases) - 1)), case["poses"]):
            if any(abs(x - y) > ROUNDING * max(1, path.scale) for row, other in zip(ours, theirs["matrix"]) for x, y in zip(row, other)):
                return f"{name}: pose {k} is not on its path"
    # Apart up to lo: as far as a speed allows each time, and near each other in small steps.
    s = 0.0
    while s < lo:
        distance = path.distance(s)
        if distance < -ROUNDING * path.scale:
            return f"{name}: {distance} at {s}, apart up to {lo} in the corpus"
        s += max(distance / path.speed, STEP if distance < NEAR * path.scale else 0)
    if path_class == "clear":
        return None if path.distance(1) > -ROUNDING * path.scale else f"{name}: clear in the corpus, in contact at the end"
    if path_class != "meets":
        return None  # nobody is judged by it
    if not -ROUNDING * path.scale < path.distance(lo) < TIGHT * path.scale:
        return f"{name}: {path.distance(lo)} at lo {lo}"
    return None if path.distance(hi) < ROUNDING * path.scale else f"{name}: {path.distance(hi)} at hi {hi}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("corpus", type=pathlib.Path)
    parser.add_argument("--every", type=int, default=1, help="look at every N-th case of a set")
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    jobs, paths, loose = [], [], []
    for each in json.loads((options.corpus / "corpus.json").read_text())["sets"]:
        cases = json.loads((options.corpus / each["pairs"]).read_text())
        truth = json.loads((options.corpus / each["truth"]).read_text())
        if len(cases) != len(truth):
            sys.exit(f"{each['name']}: {len(cases)} pairs, {len(truth)} truths")
        jobs += list(zip(cases, truth))[::options.every]
        if "impacts" in each:
            impacts, poses = json.loads((options.corpus / each["impacts"]).read_text()), each["poses"]
            if len(impacts) * poses != len(cases):
                sys.exit(f"{each['name']}: {len(cases)} poses, {len(impacts)} paths")
            loose += [f"{name}: the bracket {lo}, {hi} is not one of a time" for name, path_class, lo, hi in impacts
                      if path_class == "meets" and not 0 <= hi - lo < BRACKET]
            paths += [(cases[i * poses:(i + 1) * poses], impact) for i, impact in enumerate(impacts)][::options.every]
    with concurrent.futures.ProcessPoolExecutor(options.jobs) as pool:
        faults = loose + [each for each in pool.map(fault, jobs, chunksize=16) if each]
        faults += [each for each in pool.map(path_fault, paths) if each]
    print("\n".join(faults))
    print(f"{len(jobs)} cases, {len(paths)} paths, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
