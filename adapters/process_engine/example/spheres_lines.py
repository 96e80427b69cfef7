#!/usr/bin/env python3
"""An engine as a process, JSON lines, without packages: bounding spheres, as spheres.py."""
import json
import math
import sys


def sphere(corners, pose):
    """Centre and radius [m] of a solid's 24 corner coordinates at a pose of 12 numbers, R by columns, then p."""
    world = [[sum(pose[3 * k + axis] * corners[v + k] for k in range(3)) + pose[9 + axis] for axis in range(3)]
             for v in range(0, 24, 3)]
    centre = [sum(v[axis] for v in world) / 8 for axis in range(3)]
    return centre, max(math.dist(v, centre) for v in world)


print(json.dumps({"touchstone": 1, "name": "spheres_lines", "format": "json"}), flush=True)
solids = []
for line in sys.stdin:
    message = json.loads(line)
    if "solids" in message:
        solids = message["solids"]
        continue
    centre_a, radius_a = sphere(solids[message["a"]], message["X_WA"])
    centre_b, radius_b = sphere(solids[message["b"]], message["X_WB"])
    apart = math.dist(centre_a, centre_b) > (radius_a + radius_b) * (1 + 1e-12)
    print(json.dumps({"pair": message["pair"], "status": "separated" if apart else "undecided"}), flush=True)
