"""Compares native with engines and plug-ins that misbehave, one way at a time, and prints what the comparison made of each.

    /usr/bin/python3 tests/process_engine/bad_modes.py [--build build/release] [MODE ...]

Every run must end by itself, with a report or a refusal in words, and leave no process behind; what does not is named, and the
exit code is 1. By hand: it takes a quarter of an hour. The cheap ones are tests (process_engine_test.cpp, plugin_test.cpp).
"""

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile
import time

IN_BINARY = ["", "short", "count", "nan", "infinity", "negative_zero", "denormal", "huge", "order", "batch", "status", "flood", "close",
             "closed_input", "hang", "deaf", "stop", "sleep", "slow", "orphan", "orphan_of_its_own", "stderr", "print", "early", "twice",
             "changes", "exit", "crash", "leak", "utf16", "bom", "crlf", "dribble", "silent", "chatter", "version", "resolution", "sips", "nap", "tires"]
IN_JSON = ["short", "order", "extra", "fraction", "feature", "long", "deep", "comma", "literal", "beyond", "text", "crlf", "bom", "utf16"]
OF_PLUGINS = ["", "throw", "throw_number", "throw_at_create", "throw_at_build", "throw_at_destroy", "throw_at_load", "end_thread",
              "rounding", "rounding_at_load", "flush", "trap", "precision", "chdir", "locale", "signals", "umask", "descriptors", "print",
              "print_endlessly", "exit", "exit_at_once", "exit_at_load", "abort", "stack", "stop", "hang", "spin", "nap", "child",
              "threads", "leak", "changes", "negative_zero", "denormal", "huge", "infinity", "nan_normal", "other_pair", "contradiction",
              "null", "crash_at_destroy", "crash_at_load", "crash_at_unload", "hang_at_destroy", "hang_at_unload", "overrun", "fork"]
LIMIT = 150  # [s] that a run may take


def processes(mark):
    """Those whose environment has the mark: what a run started, and what that started."""
    found = set()
    for path in pathlib.Path("/proc").glob("[0-9]*/environ"):
        try:
            if mark.encode() in path.read_bytes():  # nothing is read of one that has ended and is not waited for
                found.add(int(path.parent.name))
        except OSError:
            continue
    return found


def run(build, name, backend, arguments, environment):
    """Returns what is wrong with the run, "" where nothing is."""
    mark = f"{os.getpid()}.{time.monotonic_ns()}"
    environment = environment | {"BAD_MODES_RUN": mark}
    with tempfile.TemporaryDirectory() as folder:
        command = [build / "examples/compare_backends/compare_backends", *arguments, "--backend", "native", backend, "--families", "random",
                   "touching", "--count", "60", "--quick", "--no-broadphase", "--output", f"{folder}/report"]
        begin = time.monotonic()
        with open(f"{folder}/out", "wb") as out, open(f"{folder}/err", "wb") as err:
            process = subprocess.Popen(command, stdout=out, stderr=err, env=os.environ | environment, start_new_session=True)
            try:
                code = process.wait(LIMIT)
            except subprocess.TimeoutExpired:
                process.terminate()
                process.wait()
                code = f"longer than {LIMIT} s"
        seconds = time.monotonic() - begin
        text = pathlib.Path(f"{folder}/out").read_text(errors="replace")
        errors = pathlib.Path(f"{folder}/err").read_text(errors="replace")[-4000:]
        page = pathlib.Path(f"{folder}/report/report.html")
        held = page.read_text(errors="replace") if page.exists() else ""
        left = processes(f"BAD_MODES_RUN={mark}")
    rows = [line.strip() for line in text.splitlines() if line.strip().startswith(backend)]
    said = next((line for line in errors.splitlines() if "failed" in line or "cannot" in line or "refus" in line or "plug-in" in line
                 or "engine" in line), "")
    wrong = ""
    if code == 0 and not held:
        wrong = "no report"
    elif code not in (0, 1, 2):
        wrong = f"exit code {code}"
    elif code != 0 and not errors.strip():
        wrong = "not a word"
    elif "4.9e-324" in text + held or "e-323" in text:
        wrong = "prints the least double"
    elif left and name != "binary orphan_of_its_own":
        wrong = f"left {len(left)} processes"
    print(f"{name:28} {code!s:>4} {seconds:6.1f} s  {wrong or 'judged':22} {rows[len(rows) // 2] if rows else '-'}  | {said}"[:230], flush=True)
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build/release"))
    parser.add_argument("modes", nargs="*", help="'binary nan', 'json order', 'plugin throw'; all where none is given")
    options = parser.parse_args()
    build = options.build.resolve()
    engine, plugin = build / "tests/process_engine/bad_engine", build / "tests/plugin/librude_plugin.so"
    modes = options.modes or [f"binary {how}" for how in IN_BINARY] + [f"json {how}" for how in IN_JSON] + [
        f"plugin {how}" for how in OF_PLUGINS]
    wrong = []
    for name in modes:
        kind, how = name.split(" ", 1)
        if kind == "plugin":
            found = run(build, name, "rude", ["--plugin", str(plugin), "--engine-limit", "1"], {"RUDE": how})
        else:
            command = f"{engine} {how or 'good'}" + (" json" if kind == "json" else "")
            limit = "0.2" if how == "nap" else "0.5"  # [s]: it is given up after 300 of them
            found = run(build, name, "bad", ["--engine", command, "--engine-limit", limit], {})
        if found:
            wrong.append(f"{name}: {found}")
    print(f"\n{len(modes)} modes, {len(wrong)} not judged" + "".join(f"\n  {each}" for each in wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
