"""Google Benchmark's JSON on stdin, a Markdown table of its counters on stdout."""

import json
import sys

runs = json.load(sys.stdin)["benchmarks"]
known = {"name", "family_index", "per_family_instance_index", "run_name", "run_type", "repetitions", "repetition_index",
         "threads", "iterations", "real_time", "cpu_time", "time_unit"}
columns = list(dict.fromkeys(key for run in runs for key in run if key not in known))
print("| " + " | ".join(["run"] + columns) + " |\n" + "|---" * (len(columns) + 1) + "|")
for run in runs:
    cells = [f"{run[column]:.4g}" if column in run else "" for column in columns]
    print("| " + " | ".join([run["name"]] + cells) + " |")
