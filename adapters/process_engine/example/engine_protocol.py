"""An engine as a process in Python, binary protocol, with NumPy: `serve` reads solids and pairs and writes what it is told."""
import json
import os
import sys

# stdout is the answers': what a package prints, and it may be anything, goes to stderr.
ANSWERS = os.fdopen(os.dup(1), "wb")
os.dup2(2, 1)


def need(module, package=None):
    """The module; ends the program where its package (by default of the same name) is not installed."""
    package = package or module
    try:
        return __import__(module)
    except ImportError:
        sys.exit(f"Python package '{package}' is not installed: pip install {package}")


np = need("numpy")
HEAD = np.dtype([("kind", "<u4"), ("count", "<u4"), ("batch", "<u4"), ("query", "<u4"), ("max_points", "<u4"),
                 ("reserved", "<u4"), ("max_separation", "<f8"), ("max_point_separation", "<f8")])
POSE = np.dtype([("R", "<f8", (3, 3)), ("p", "<f8", 3)])  # R[0] is the solid's x axis in the world
PAIR = np.dtype([("a", "<u4"), ("b", "<u4"), ("X_WA", POSE), ("X_WB", POSE)])
GEOMETRY = [("separation", "<f8"), ("n_AB_W", "<f8", 3), ("p_A_W", "<f8", 3), ("p_B_W", "<f8", 3), ("point_count", "<i4"), ("word", "<u4")]
POINT = np.dtype([("p_A_W", "<f8", 3), ("p_B_W", "<f8", 3), ("separation", "<f8"), ("feature_id", "<u4"), ("word", "<u4")])
SEPARATED, OVERLAPPING, UNDECIDED, FAILED, UNSUPPORTED = range(5)
OVERLAP, DISTANCE, MANIFOLD = range(3)
AT_ONCE = 64  # pairs a write: bytes that come early show that the engine lives


def half_sides(corners):
    """Half sides [m] of corners 8 x 3 that are a box about their origin, else None."""
    return corners[7] if (np.abs(corners) == corners[7]).all() else None


def quaternion(R):
    """x, y, z, w of a rotation (Bar-Itzhack)."""
    K = np.array([[R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0], [R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
                  [R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], 0],
                  [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], np.trace(R)]])
    return np.linalg.eigh(K)[1][:, -1]


def answers_for(head, count):
    """Slots of `count` answers to a question; geometry is that of pairs beyond its limit."""
    fields = [("pair", "<u4"), ("status", "<u4")]
    if head["query"] != OVERLAP:
        fields += GEOMETRY
    if head["query"] == MANIFOLD:
        fields += [("points", POINT, int(head["max_points"]))]
    slots = np.zeros(count, fields)
    if head["query"] != OVERLAP:
        slots["separation"] = np.inf
        for name in ("n_AB_W", "p_A_W", "p_B_W"):
            slots[name] = np.nan
    return slots


def put(slot, points, head):
    """An answer from contact points (separation, p_A_W, p_B_W, n_AB_W), of which the deepest is the pair's; none: nothing is near."""
    points = sorted(points, key=lambda point: point[0])
    slot["status"] = OVERLAPPING if points and not points[0][0] > 0 else SEPARATED
    if "separation" not in slot.dtype.names or not points or points[0][0] > head["max_separation"]:
        return
    slot["separation"], slot["p_A_W"], slot["p_B_W"], slot["n_AB_W"] = points[0]
    if head["query"] == MANIFOLD:
        points = [point for point in points if point[0] <= head["max_point_separation"]][:len(slot["points"])]
        slot["point_count"] = len(points)
        for kept, (separation, a, b, _) in zip(slot["points"], points):
            kept["separation"], kept["p_A_W"], kept["p_B_W"] = separation, a, b


def read(stream, dtype, count):
    data = stream.read(dtype.itemsize * count)
    return np.frombuffer(data, dtype) if len(data) == dtype.itemsize * count else None


NO_PAIR = "its first pair is none as compare_backends writes them: boxes or vertices, poses as matrices [m]"


def first_pair(path):
    """Name, corners and poses of the first pair of a file, as compare_backends writes them."""
    try:
        case, pair = json.load(open(path, encoding="utf-8"))[0], np.zeros(1, PAIR)
        pair["b"] = 1
        corners = []
        for shape, pose, name in zip(case["shapes"], case["poses"], ("X_WA", "X_WB")):
            signs = [[i >> 2 & 1, i >> 1 & 1, i & 1] for i in range(8)]
            corners.append((np.array(signs) - 0.5) * shape["size"] if shape["type"] == "box" else shape["vertices"])
            matrix = np.array(pose["matrix"], float)
            pair[name]["R"], pair[name]["p"] = matrix[:3, :3].T, matrix[:3, 3]
        return case["id"], np.array(corners, float), pair
    except (OSError, LookupError, TypeError, ValueError) as error:
        sys.exit(f"{path}: {NO_PAIR} ({type(error).__name__}: {error})")


def ask_alone(path, build, answer, with_manifold):
    """What the engine says about the first pair of a pair file, without anything of touchstone's."""
    case, corners, pair = first_pair(path)
    build(corners)
    for query, name in enumerate(("overlap", "distance", "manifold") if with_manifold else ("overlap", "distance")):
        head = np.array([(2, 1, 0, query, 8 if query == MANIFOLD else 0, 0, 0.0 if query == MANIFOLD else np.inf, 1e-3)], HEAD)[0]
        slots = answers_for(head, 1)
        answer(head, pair, slots)
        print(case, name, {field: slots[field][0].tolist() for field in slots.dtype.names if field not in ("pair", "word", "points")})
        for point in slots["points"][0][:slots["point_count"][0]] if query == MANIFOLD else ():
            print("   ", point["p_A_W"].tolist(), point["p_B_W"].tolist(), float(point["separation"]))


def serve(build, answer, **greeting):
    """build(corners: solids x 8 x 3 [m]); answer(head, pairs, slots) writes the answers to some pairs into their slots.
    With --pair FILE: prints its answers to one pair instead."""
    if "--pair" in sys.argv:
        os.dup2(ANSWERS.fileno(), 1)
        print(greeting["description"])
        ask_alone(sys.argv[sys.argv.index("--pair") + 1], build, answer, greeting.get("manifold", False))
        return
    stdin, stdout = sys.stdin.buffer, ANSWERS
    stdout.write(json.dumps({"touchstone": 1, "format": "binary", **greeting}).encode() + b"\n")
    stdout.flush()
    while (heads := read(stdin, HEAD, 1)) is not None:
        head, count = heads[0], int(heads["count"][0])
        if head["kind"] == 1:
            build(read(stdin, np.dtype(("<f8", (8, 3))), count))
            continue
        pairs, slots = read(stdin, PAIR, count), answers_for(head, count)
        slots["pair"] = np.arange(count)
        stdout.write(np.array([head["batch"], count], "<u4").tobytes())
        for first in range(0, count, AT_ONCE):
            answer(head, pairs[first:first + AT_ONCE], slots[first:first + AT_ONCE])
            stdout.write(slots[first:first + AT_ONCE].tobytes())
            stdout.flush()
