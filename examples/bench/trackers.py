#!/usr/bin/env python3
"""Bugs that engines' trackers named, asked of the versions that had them: writes trackers.md from trackers.json.

    trackers.py --environments DIR --install    # PyPI and npm packages into DIR, a folder a version (some 6 GB)
    trackers.py --environments DIR [--only BUG ...] [--keep] [--output FILE]

Of some of the bugs alone (--only, or packages that are not in DIR) the page is written where --output is given, and not to trackers.md.
With --keep the rows of the others are those of trackers.md as it stands, which so gets new bugs without the gigabytes of the old.
Needs no build: engines answer through their adapters (adapters/process_engine/example), the truth is rational arithmetic
(tests/hard_cases/exact_hull.py). A bug whose packages are not in DIR is listed as not asked."""
import argparse
import datetime
import json
import math
import os
import pathlib
import platform
import re
import struct
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ADAPTERS = HERE.parents[1] / "adapters/process_engine/example"
sys.dont_write_bytecode = True
sys.path.insert(0, str(HERE.parents[1] / "tests/hard_cases"))
import exact_hull  # noqa: E402

RED = 1e-3  # of the scale S, as in the benchmark's rules
QUERIES = ("overlap", "distance", "manifold")
STATUS = ("separated", "overlapping", "undecided", "failed", "unsupported")


def made():
    """By which version, on what, when."""
    version = re.search(r"project\(touchstone VERSION ([0-9.]+)", (HERE.parents[1] / "CMakeLists.txt").read_text()).group(1)
    python = ".".join(platform.python_version_tuple()[:2])
    return f"Touchstone {version}; {platform.system()} {platform.machine()}, Python {python}; {datetime.date.today()}."


def load_cases():
    """All cases of cases/*.json by their ids; `new` of those that corpus 1.1 does not have."""
    cases = {}
    for path in sorted((HERE / "cases").glob("*.json")):
        for case in json.loads(path.read_text()):
            cases[case["id"]] = {**case, "new": path.stem == "reported" and "corpus 1.1" not in case["why_hard"]}
    return cases


def matrix(pose):
    """Rows of R and p, of a pose as pair files have it."""
    if "matrix" in pose:
        return [row[:3] for row in pose["matrix"][:3]], [row[3] for row in pose["matrix"][:3]]
    w, x, y, z = (value / math.hypot(*pose["quaternion_wxyz"]) for value in pose["quaternion_wxyz"])
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]], pose["position"]


def corners(shape):
    if shape["type"] == "box":
        return [[s * side / 2 for s, side in zip(signs, shape["size"])] for signs in ((a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1))]
    return shape["vertices"]


def world(shape, pose):
    R, p = matrix(pose)
    return [tuple(((row[0] * x + row[1] * y) + row[2] * z) + t for row, t in zip(R, p)) for x, y, z in corners(shape)]


def truth(case):
    """(in contact, signed distance [m], normal or None, scale S [m])."""
    hulls = [world(shape, pose) for shape, pose in zip(case["shapes"], case["poses"])]
    name, distance, normal = exact_hull.signed_distance(*hulls)
    scale = max(max(math.dist(u, v) for hull in hulls for u in hull for v in hull), max(abs(x) for hull in hulls for v in hull for x in v))
    return name != "separated", float(distance), normal, scale


class Engine:
    """An adapter's process, asked without a time limit: some compile for minutes."""

    def __init__(self, command, environment):
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment["env"],
                                        cwd=environment["cwd"])
        line = self.process.stdout.readline()
        while line and not line.startswith(b"{"):
            line = self.process.stdout.readline()  # some packages greet by themselves
        if not line:
            self.process.communicate()
            raise SystemExit(f"{' '.join(command)}: ended without a greeting, code {self.process.returncode}")
        self.greeting = json.loads(line)

    def ask(self, cases):
        """A list of (query, status, separation, normal), of each case."""
        solids = [value for case in cases for shape in case["shapes"] for corner in corners(shape) for value in corner]
        self.send(struct.pack("<6I2d", 1, 2 * len(cases), 0, 0, 0, 0, 0, 0) + struct.pack(f"<{len(solids)}d", *solids))
        answers = [[] for _ in cases]
        for query, name in enumerate(QUERIES):
            if query == 0 or (query == 1 and self.greeting.get("distance")) or (query == 2 and self.greeting.get("manifold")):
                self.ask_one(query, name, cases, answers)
        return answers

    def ask_one(self, query, name, cases, answers):
        points = 8 if query == 2 else 0
        message = struct.pack("<6I2d", 2, len(cases), query, query, points, 0, 0.0 if query == 2 else math.inf, 1e-3)
        for i, case in enumerate(cases):
            message += struct.pack("<2I", 2 * i, 2 * i + 1)
            for R, p in map(matrix, case["poses"]):
                message += struct.pack("<12d", *(R[row][column] for column in range(3) for row in range(3)), *p)
        self.send(message)
        self.read(8)
        for answer in answers:
            status = STATUS[struct.unpack("<2I", self.read(8))[1]]
            geometry = struct.unpack("<10d2i", self.read(88)) if query else None
            rest = [struct.unpack("<7d2I", self.read(64)) for _ in range(points)]
            separation = min((point[6] for point in rest[:geometry[10]]), default=math.inf) if query == 2 else geometry[0] if query else math.inf
            answer.append((name, status, separation, geometry[1:4] if query else None))

    def send(self, data):
        self.process.stdin.write(data)
        self.process.stdin.flush()

    def read(self, count):
        data = self.process.stdout.read(count)
        if len(data) != count:
            raise EOFError("the engine ended")
        return data

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def faults(answer, known):
    """(kind, text, cost [m]) of what is red about the answers to one case."""
    contact, distance, normal, scale = known
    for name, status, separation, n in answer:
        if status in ("undecided", "unsupported"):
            continue
        off = abs(separation - distance) if math.isfinite(separation) else 0.0
        text = f"{name}: {status}" + (f", {separation:.3g}" if math.isfinite(separation) else "")
        if off >= RED * scale:
            yield "separation", text, off
        if status == "failed" or (status == "overlapping") != contact:
            yield "phantom" if status == "overlapping" else "missed", text, max(off, abs(distance))
        elif math.isnan(separation) or (math.isinf(separation) and (name == "distance" or (name == "manifold" and contact))):
            yield "separation", f"{name}: no figure", scale
        elif normal and n and all(map(math.isfinite, n)) and sum(a * b for a, b in zip(n, normal)) < 0.5 and name == "distance":
            yield "normal", f"{name}: normal " + " ".join(f"{x:.2g}" for x in n), scale


def environment_of(packages, folder):
    """Where packages are: a Python environment, or a folder with node_modules."""
    name = "_".join(packages).replace("==", "-").replace("/", "-")
    root = folder / name
    node = any("@" in package for package in packages)
    installed = root / "installed"  # made last: what was interrupted is not there
    return {"root": root, "installed": installed, "node": node, "packages": packages, "cwd": root if node else None,
            "env": {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
            "command": ["node"] if node else [str(root / "bin/python")], "there": installed.exists()}


def install(environment):
    root = environment["root"]
    if environment["there"]:
        return
    root.mkdir(parents=True, exist_ok=True)
    if environment["node"]:
        (root / "package.json").write_text("{}")
        subprocess.run(["npm", "install", "--silent", "--no-audit", "--no-fund", *environment["packages"]], cwd=root, check=True)
    else:
        subprocess.run([sys.executable, "-m", "venv", "--clear", root], check=True)
        subprocess.run([root / "bin/pip", "install", "--quiet", *environment["packages"]], check=True)
    environment["installed"].touch()
    environment["there"] = True


def found_by(bug, packages, folder, cases, truths):
    """(version, red faults as (case, kind, text, cost), the most costly first); None where not installed."""
    environment = environment_of(packages, folder)
    if not environment["there"]:
        return None
    print(f"{bug['bug']}: {', '.join(packages)}", file=sys.stderr, flush=True)
    engine = Engine([*environment["command"], str(ADAPTERS / bug["engine"]), *bug.get("options", [])], environment)
    chosen = [cases[name] for name in bug["cases"]]
    red = []
    try:
        for case, answer in zip(chosen, engine.ask(chosen)):
            red += [(case["id"], *fault) for fault in faults(answer, truths(case))]
    except EOFError as error:
        red.append((chosen[0]["id"], "missed", str(error), math.inf))
    engine.close()
    return engine.greeting["description"], sorted(red, key=lambda fault: -fault[3])


def row(bug, had, later, truths, cases):
    """A line of the table, whether it counts as flagged, and whether by a pair of corpus 1.1."""
    if had is None:
        return f"| {bug['bug']} | {bug['said']} | {', '.join(bug['had'])} | {bug['pairs']} | not asked: not installed | | no | |", False, False
    as_reported = lambda fault: fault[1] in bug["symptoms"] and fault[2].split(":")[0] in bug.get("queries", QUERIES)  # noqa: E731
    shown = [fault for fault in had[1] if as_reported(fault)]
    still = later and [fault for fault in later[1] if as_reported(fault)]
    after = "not asked" if later is None else f"{len({fault[0] for fault in still})} of {len(bug['cases'])}" if still else "right"
    name = bug["had"][-1] if "engine_package" not in bug else bug["engine_package"]
    if not shown:
        return f"| {bug['bug']} | {bug['said']} | {name} | {bug['pairs']}, {len(bug['cases'])} | right | | **no**: {bug.get('why_no', '')} | {after} |", False, False
    case, _, text, _ = shown[0]
    distance = truths(cases[case])[1]
    count = len({fault[0] for fault in shown})
    return (f"| {bug['bug']} | {bug['said']} | {name} | {bug['pairs']}, {count} of {len(bug['cases'])} | `{case}`: {text} | {distance:.3g} | "
            f"yes{bug.get('note', '')} | {after} |"), True, any(not cases[fault[0]]["new"] for fault in shown)


def kept_row(bug, page, cases):
    """The line of an earlier page about a bug, with its counts as row() has them, by the case that the line shows; None: there is none."""
    for line in page.splitlines():
        cells = [cell.strip() for cell in line.split("|")[1:-1]]
        if len(cells) == 8 and cells[0] == bug["bug"]:
            is_flagged, shown = cells[6].startswith("yes"), re.match("`([^`]+)`", cells[4])
            return line, is_flagged, is_flagged and not cases[shown[1]]["new"]
    return None


def page_path(given, is_partial):
    """Where the page is written; None: nowhere, as one of some bugs alone would replace that of all."""
    return given if given or is_partial else HERE / "trackers.md"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--environments", type=pathlib.Path, required=True)
    parser.add_argument("--install", action="store_true")
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--keep", action="store_true", help="of the bugs that --only does not name, the rows of trackers.md")
    parser.add_argument("--output", type=pathlib.Path, help="default: trackers.md, if all bugs were asked")
    options = parser.parse_args()
    folder, listed, cases, known = options.environments.resolve(), json.loads((HERE / "trackers.json").read_text()), load_cases(), {}

    def truths(case):
        if case["id"] not in known:
            known[case["id"]] = truth(case)
        return known[case["id"]]

    lines, flagged, is_partial, page = [], [], bool(options.only) and not options.keep, (HERE / "trackers.md").read_text()
    for bug in listed["asked"]:
        if options.only and bug["bug"] not in options.only:
            kept = kept_row(bug, page, cases) if options.keep else None
            is_partial = is_partial or kept is None
            for line, *counts in [kept] if kept else []:
                lines.append(line)
                flagged.append(counts)
            continue
        if options.install:
            for packages in (bug["had"], bug["later"]):
                install(environment_of(packages, folder))
        had, later = (found_by(bug, bug[key], folder, cases, truths) for key in ("had", "later"))
        is_partial = is_partial or had is None or later is None
        line, *counts = row(bug, had, later, truths, cases)
        print(line, flush=True)
        lines.append(line)
        flagged.append(counts)
    others = [f"| {bug['bug']} | {bug['said']} | {bug['why']} |" for bug in listed["not_asked"]]
    count, left_out = sum(each[0] for each in flagged), sum(bug.get("left_out", 0) for bug in listed["not_asked"])
    share = (f"Flagged: {count} of {len(flagged)}, {100 * count // max(1, len(flagged))} %, {sum(each[1] for each in flagged)} of them by pairs of corpus 1.1; "
             f"with the {left_out} that need a margin: {count} of {len(flagged) + left_out}, {100 * count // max(1, len(flagged) + left_out)} %.")
    print(share)
    output = page_path(options.output, is_partial)
    if output is None:
        print("Not all bugs were asked: trackers.md stays as it is; --output FILE takes this page.")
        return
    output.write_text((HERE / "trackers_head.md").read_text().replace("{made}", made()).replace("{share}", share).replace("{asked}", "\n".join(lines))
                              .replace("{others}", "\n".join(others)))


if __name__ == "__main__":
    main()
