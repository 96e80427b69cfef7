"""What first_table is built from: no world, motion or mechanism, no page, and less than half of what the comparison is.
usage: needs_test.py NINJA BUILD_FOLDER"""
import re
import subprocess
import sys


def objects(target):
    run = subprocess.run([sys.argv[1], "-C", sys.argv[2], "-t", "inputs", target], capture_output=True, text=True, check=True)
    return [line for line in run.stdout.splitlines() if line.endswith(".o")]


first, all_of_it = objects("first_table"), objects("compare_backends")
# A folder's files, or one source of all of them.
for part in (*(f"/{folder}/|contact_core_{folder}_" for folder in ("world", "motion", "mechanism")), "compare_backends", "scene_files"):
    assert any(re.search(part, each) for each in all_of_it), part
    assert not any(re.search(part, each) for each in first), (part, first)
assert 2 * len(first) < len(all_of_it), (len(first), len(all_of_it))
shared = set(first) & set(all_of_it)
assert len(first) - len(shared) == 3, set(first) - shared  # its main; a text table and a list of backends of its own
