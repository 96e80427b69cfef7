"""Tables in Markdown, on stdout, from what programs print or write:

as_table.py [benchmark]               Google Benchmark's JSON on stdin: its counters
as_table.py printed HEAD ...          the first table that a program prints on stdin, below a line that begins with a HEAD
as_table.py tests                     what tests print on stdin, a row a test
as_table.py engines                   of engine_suite_test on stdin: errors, a row a figure, a column an engine and check
as_table.py dynamics RESULTS.json     of dynamics_run: times of steps, a row a scene, a column a backend
as_table.py flights RESULTS.csv       of training_run: sums over its scripts, a row a method and backend
as_table.py stops RESULTS.csv         of training_run: first stops, a row a script and method
as_table.py station SCENE ...         of touchstone_station --soak, then --replay, of each scene, on stdin
as_table.py served PAGE ...           pages of touchstone_fit --serves --uniform: a row a mesh, and which have ten times fewer
"""

import csv
import json
import re
import sys


def row(cells):
    print("| " + " | ".join(cells) + " |")


def table(head, rows):
    if not rows:
        sys.exit("as_table: no row below " + " | ".join(head))
    row(head)
    print("|---" * len(head) + "|")
    for cells in rows:
        row(cells)


def benchmark():
    runs = json.load(sys.stdin)["benchmarks"]
    known = {"name", "family_index", "per_family_instance_index", "run_name", "run_type", "repetitions",
             "repetition_index", "threads", "iterations", "real_time", "cpu_time", "time_unit"}
    columns = list(dict.fromkeys(key for run in runs for key in run if key not in known))
    table(["run"] + columns,
          [[run["name"]] + [f"{run[column]:.4g}" if column in run else "" for column in columns] for run in runs])


def printed(*heads):
    """Columns are two blanks apart; a table ends where a line has another number of them."""
    lines = [line.strip() for line in sys.stdin]
    for at, line in enumerate(lines):
        if not line.startswith(heads) or "  " not in line:
            continue
        head = re.split("  +", line)
        rows = []
        for below in lines[at + 1:]:
            cells = re.split("  +", below)
            if len(cells) != len(head):
                break
            if not set(below) <= set("- "):
                rows.append(cells)
        table(head, rows)
        print()
        return
    sys.exit("as_table: no line begins with " + " or ".join(heads))


def of_tests():
    """Each test's name, and the lines that it printed."""
    name, lines = None, []
    for line in sys.stdin:
        line = line.rstrip("\n")
        if line.startswith("[ RUN"):
            name, lines = line[12:].strip(), []
        elif line.startswith("[       OK"):
            yield name, lines
            name = None
        elif line.startswith("[  FAILED") and name:
            sys.exit("failed: " + name)
        elif name and line.strip():
            lines.append(line.strip())


def tests():
    table(["test", "prints"], [[f"`{name}`", "; ".join(lines)] for name, lines in of_tests() if lines])


def engines():
    pattern = re.compile(r"(\S+)\s+(.+?)\s+off by (\S+) \(may be (\S+)\)")
    figures, columns = {}, []
    for name, lines in of_tests():
        test = name.split("/")[-2].split(".")[-1]
        for engine, what, error, _ in (pattern.match(line).groups() for line in lines if pattern.match(line)):
            if engine not in columns:
                columns.append(engine)
            figures.setdefault((test, what), {})[engine] = error
    table(["test", "off by"] + columns,
          [[f"`{test}`", what] + [errors.get(engine, "-") for engine in columns]
           for (test, what), errors in figures.items()])


def dynamics(file):
    """A backend that is outside a scene's limits has its first miss instead of times."""
    with open(file) as text:
        results = json.load(text)
    columns = list(dict.fromkeys(run["backend"] for scene in results["scenes"] for run in scene["runs"]
                                 if "not_run" not in run))
    rows = []
    for scene in results["scenes"]:
        cells = {}
        for run in scene["runs"]:
            if "not_run" in run:
                continue
            times = run["step_us"]
            cells[run["backend"]] = f"({run['misses'][0]})" if run["misses"] else \
                f"{times['median']:.1f}, {times['p99_9']:.1f}"
        build_on = scene["build_on"] or ("-" if scene["touches"] else "-: nothing touches")
        rows.append([f"`{scene['scene']}`", build_on] + [cells.get(column, "-") for column in columns])
    table(["scene", "build on"] + columns, rows)
    print(f"\nOver all scenes: {results['build_on'] or 'none'}; {results['reason']}.")


def flown(file):
    with open(file) as text:
        return [line for line in csv.DictReader(text) if not line["not_flown"]]


def flights(file):
    sums = {}
    for line in flown(file):
        of = f"{line['method']}, {line['backend']}" + (", sampled" if line["check"] == "sampled" else "")
        sums.setdefault(of, []).append(line)
    keys = ["frames"] + [key + "_frames" for key in ("merged", "passed_through", "missed", "phantom")]

    def total(lines, key):
        return sum(int(line[key]) for line in lines)

    table(["method, backend", "scripts", "frames", "merged", "passed through", "missed", "phantom", "false stops",
           "worst frame [us]", "allocations"],
          [[of, str(len(lines))] + [str(total(lines, key)) for key in keys] +
           [f"{total(lines, 'false_stop_frames')} of {total(lines, 'blocked_frames')}",
            f"{max(float(line['worst_cpu_us']) for line in lines):.0f}", str(total(lines, "allocations"))]
           for of, lines in sums.items()])


def stops(file):
    rows = []
    for line in flown(file):
        if line["method"] == "contact world" and line["backend"] != "native":
            continue
        stop = [f"{float(line[key]):.4g}" if line[key] else "-" for key in ("first_stop_s", "first_clearance_m")]
        deep = [f"{1e3 * float(line[key]):.3g}" for key in ("deepest_shown_m", "deepest_between_m")]
        rows.append([f"`{line['script']}`", line["method"], line["stops"]] + stop + deep +
                    [line[key] for key in ("merged_frames", "missed_frames", "phantom_frames", "false_stop_frames")])
    table(["script", "method", "stops", "first [s]", "clear [m]", "deep [mm]", "between [mm]", "merged", "missed",
           "phantom", "false stops"], rows)


def depth(metres):
    return f"{metres:.3g} m" if round(1e3 * metres) >= 1000 else f"{1e3 * metres:.3g} mm"


def station(*scenes):
    text = sys.stdin.read()
    flights = re.findall(r"deadlines missed (\d+) of (\d+)", text)
    decided = re.findall(r"received to decided\s+median\s+([\d.]+) ms, 99.9 %\s+([\d.]+) ms, worst\s+([\d.]+)", text)
    steps = re.findall(r"by the thread's clock: median (\d+) us, 99.9 % (\d+) us, worst (\d+)", text)
    merged = re.findall(r"(no check|figure 1|figure 2|ours)\s+merged\s+(\d+) of\s+(\d+) frames, worst\s+(\S+) m", text)
    if not len(flights) == len(decided) == len(steps) == len(scenes) or len(merged) != 4 * len(scenes):
        sys.exit("station: a flight or a replay lacks figures:\n" + text)
    rows = []
    for s, scene in enumerate(scenes):
        of = [f"{int(count)}" + (f", {depth(float(deep))}" if int(count) else "")
              for _, count, _, deep in merged[4 * s:4 * s + 4]]
        rows.append([f"`{scene}`", merged[4 * s][2]] + of + [", ".join(steps[s]), " of ".join(flights[s]),
                                                             ", ".join(decided[s])])
    table(["scene", "frames", "merged: no check", "Figure 1", "Figure 2", "ours", "step [us]: median, 99.9 %, worst",
           "deadlines missed", "received to decided [ms]: median, 99.9 %, worst"], rows)


def served(*pages):
    """Covers fitted to tasks beside those of one error everywhere."""
    rows, few, out_of_reach, neither, slower = [], [], [], [], []
    for page in pages:
        with open(page) as file:
            text = file.read()
        # The two covers' rows in the page's last table, and what is said below it.
        both = re.findall(r"^ +(.+?) {2,}(?:uniform error|fitted to the task) {2,}(\d+) .* {2,}(\S+) {2,}(\S+) {2,}\S+$", text,
                          re.MULTILINE)
        off = re.search(r"what it stops is at most (\S+) mm off", text)
        tolerance = re.search(r"--tolerance (\S+)mm", text)
        times = re.search(r"(\S+) times fewer hexahedra(?: \(at most (\S+) times)?.*, (\S+) times as short", text)
        if len(both) != 2 or not off or not tolerance or not times:
            sys.exit(page + ": no cover that serves beside one of the same error everywhere")
        (mesh, uniform, uniform_pairs, uniform_us), (_, fitted, fitted_pairs, fitted_us) = both
        fewer, most, shorter = times.groups()
        rows.append([mesh, tolerance[1], off[1], uniform, fitted, fewer, most or "?",
                     f"{uniform_pairs}, {fitted_pairs}", f"{uniform_us}, {fitted_us}"])
        is_few = int(uniform) >= 10 * int(fitted)
        (few if is_few else out_of_reach if most and float(most) < 10 else neither).append(mesh)
        if float(shorter) < 0.95:
            slower.append(mesh)
    table(["mesh", "tolerance [mm]", "stops off [mm]", "uniform", "fitted", "times fewer", "at most", "pairs a frame",
           "frame [us]"], sorted(rows))
    for what, meshes in (("Ten times fewer, or more", few), ("Out of reach of any cover that is right in the same zones",
                         out_of_reach), ("Neither", neither), ("Frames longer by more than a twentieth", slower)):
        print(f"\n{what}: {len(meshes)}" + (f" ({', '.join(sorted(meshes))})." if meshes else "."))


modes = {"benchmark": benchmark, "printed": printed, "tests": tests, "engines": engines, "dynamics": dynamics,
         "flights": flights, "stops": stops, "station": station, "served": served}
mode = sys.argv[1] if len(sys.argv) > 1 else "benchmark"
if mode not in modes:
    sys.exit(__doc__)
modes[mode](*sys.argv[2:])
