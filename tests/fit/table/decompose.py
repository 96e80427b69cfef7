"""Decomposes a mesh into convex hulls by CoACD or V-HACD, for fit_table.

decompose.py has METHOD: its version on stdout; exit code 3 where the package is not installed, 1 where it does not
give a cube back as one hull.
decompose.py METHOD MESH RESULT [THRESHOLD]: MESH and RESULT are text files. MESH: counts of vertices and triangles,
then one a line. RESULT: seconds of the processor, hulls, then each as MESH.
"""

import sys
import time
from importlib.metadata import version

PACKAGES = {"coacd": "coacd", "vhacd": "vhacdx"}


def read_mesh(path):
    import numpy

    words = open(path).read().split()
    vertices, triangles = int(words[0]), int(words[1])
    numbers = words[2:]
    points = numpy.array(numbers[: 3 * vertices], dtype=numpy.float64).reshape(-1, 3)
    faces = numpy.array(numbers[3 * vertices :], dtype=numpy.uint32).reshape(triangles, 3)
    return points, faces


def decompose(method, points, faces, threshold):
    if method == "vhacd":
        import numpy
        import vhacdx

        # Faces as counts and corners; triples are taken without a word, and give hulls of something else.
        counted = numpy.column_stack((numpy.full(len(faces), 3, numpy.uint32), faces)).ravel()
        return vhacdx.compute_vhacd(points, counted, asyncACD=False)
    import coacd

    coacd.set_log_level("error")
    return coacd.run_coacd(coacd.Mesh(points, faces), threshold=threshold)


def has(method):
    try:
        __import__(PACKAGES[method])
        import numpy
    except ImportError:
        sys.exit(3)
    corners = numpy.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], numpy.float64)
    sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    faces = numpy.array([[s[0], s[i], s[i + 1]] for s in sides for i in (1, 2)], numpy.uint32)
    hulls = decompose(method, corners, faces, 0.05)
    extent = numpy.ptp(numpy.asarray(hulls[0][0]), axis=0)
    if len(hulls) != 1 or numpy.abs(extent - 1.0).max() > 0.05:
        sys.exit(f"{PACKAGES[method]} {version(PACKAGES[method])} gives a cube back as {len(hulls)} hulls, {extent} large")
    print(version(PACKAGES[method]))


def main(arguments):
    if arguments[0] == "has":
        has(arguments[1])
        return
    points, faces = read_mesh(arguments[1])
    start = time.process_time()
    hulls = decompose(arguments[0], points, faces, float(arguments[3]) if len(arguments) > 3 else 0.05)
    seconds = time.process_time() - start
    with open(arguments[2], "w") as out:
        out.write(f"{seconds} {len(hulls)}\n")
        for vertices, triangles in hulls:
            out.write(f"{len(vertices)} {len(triangles)}\n")
            for v in vertices:
                out.write(" ".join(repr(float(x)) for x in v) + "\n")
            for t in triangles:
                out.write(" ".join(str(int(i)) for i in t) + "\n")


main(sys.argv[1:])
