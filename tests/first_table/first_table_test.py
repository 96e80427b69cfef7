"""Runs first_table as a user does. usage: first_table_test.py PROGRAM"""
import subprocess
import sys


def rows(family):
    """By backend: (ns, wrong, open) of overlap, distance and manifold."""
    run = subprocess.run([sys.argv[1], family], capture_output=True, text=True, check=True)
    found = {}
    for line in run.stdout.splitlines():
        cells = line.split("  ")
        cells = [cell.strip() for cell in cells if cell.strip()]
        if len(cells) == 12 and cells[0] != "ns a pair":
            found[cells[0]] = [tuple(cells[i:i + 3]) for i in (1, 4, 7)]
    assert f"\n{family}: " in run.stdout and "500 pairs" in run.stdout, run.stdout
    return found


contained = rows("containment")
assert {"native", "edge_face", "exact"} <= contained.keys(), contained
for name in ("native", "exact"):
    for ns, wrong, left_open in contained[name]:
        assert (wrong, left_open) == ("0", "0") and float(ns.replace(" ", "")) > 0, contained
# The paper's check does not see a solid within another, and has neither distances nor manifolds.
assert int(contained["edge_face"][0][1]) > 0, contained
assert [row[0] for row in contained["edge_face"][1:]] == ["-", "-"], contained
assert [row[1:] for row in contained["edge_face"][1:]] == [("0", "500")] * 2, contained

version = subprocess.run([sys.argv[1], "--version"], capture_output=True, text=True, check=True)
assert version.stdout.startswith("first_table 0."), version
with open("/dev/full", "w") as full:
    lost = subprocess.run([sys.argv[1], "--version"], stdout=full, stderr=subprocess.PIPE, text=True)
assert lost.returncode == 2 and lost.stderr.count("\n") == 1, lost

unknown = subprocess.run([sys.argv[1], "nothing"], capture_output=True, text=True)
assert unknown.returncode == 2 and unknown.stdout == "", unknown
assert unknown.stderr.startswith("first_table: unknown pair family 'nothing'"), unknown
assert unknown.stderr.count("\n") == 1, unknown
