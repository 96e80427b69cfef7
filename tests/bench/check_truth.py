#!/usr/bin/env python3
"""Holds a corpus's truth against rational arithmetic that shares nothing with the C++ code (tests/hard_cases/exact_hull.py).

    check_truth.py CORPUS [--every 10] [--jobs 2]       # every tenth case; 1: all (0.2 s a case)
"""

import argparse
import concurrent.futures
import json
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


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("corpus", type=pathlib.Path)
    parser.add_argument("--every", type=int, default=1, help="look at every N-th case of a set")
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    jobs = []
    for each in json.loads((options.corpus / "corpus.json").read_text())["sets"]:
        cases = json.loads((options.corpus / each["pairs"]).read_text())
        truth = json.loads((options.corpus / each["truth"]).read_text())
        if len(cases) != len(truth):
            sys.exit(f"{each['name']}: {len(cases)} pairs, {len(truth)} truths")
        jobs += list(zip(cases, truth))[::options.every]
    with concurrent.futures.ProcessPoolExecutor(options.jobs) as pool:
        faults = [each for each in pool.map(fault, jobs, chunksize=16) if each]
    print("\n".join(faults))
    print(f"{len(jobs)} cases, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
