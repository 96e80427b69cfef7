"""What compare_backends wrote, as tables and as data frames where pandas is there."""

import importlib.util
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import touchstone
from touchstone import results

PROGRAM = os.environ.get("TOUCHSTONE_COMPARE_BACKENDS", "")
CASES = pathlib.Path(os.environ["TOUCHSTONE_SOURCE"]) / "tests" / "hard_cases" / "touching.json"


class Written(unittest.TestCase):
    """Files as the program has them, with what is rare in them."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def write(self, root):
        path = pathlib.Path(self.folder.name) / "results.json"
        path.write_text(root if isinstance(root, str) else json.dumps(root))
        return path

    def test_figures_that_are_infinite_or_were_not_measured(self):
        wrong = [{"cost_m": "inf", "case": "c1", "reason": "missed"}]
        overlap = {"single": {"median_ns": 5.0}, "batch": None, "worst": wrong[0], "wrong_cases": wrong}
        backend = {"backend": "b", "queries": {"overlap": overlap},
                   "errors": {"distance": {"over_S": {"median": 0.0, "worst": "inf"}, "over_size": None}}}
        root = {"schema": "touchstone.compare_backends/2", "backends": [{"name": "b", "description": "d"}],
                "pair_sets": [{"name": "s", "backends": [backend]}]}
        self.write(root)
        read = results.read_results(self.folder.name)
        self.assertEqual(read.backends(), [{"name": "b", "description": "d"}])
        head = {"set": "s", "backend": "b"}
        self.assertEqual(read.queries(), [{**head, "query": "overlap", "single_median_ns": 5.0, "worst_cost_m": math.inf,
                                           "worst_case": "c1", "worst_reason": "missed"}])
        self.assertEqual(read.errors(), [{**head, "measure": "distance", "over_S_median": 0.0, "over_S_worst": math.inf}])
        self.assertEqual(read.wrong_cases()[0]["cost_m"], math.inf)

    def test_what_is_no_such_file_is_named(self):
        for content, text in (("{", "no JSON"), ("[]", "schema is None"), ('{"schema": "other/1"}', "other/1")):
            path = self.write(content)
            with self.assertRaisesRegex(touchstone.InputError, f"results.json: .*{text}"):
                results.read_results(path)
        with self.assertRaisesRegex(touchstone.InputError, "nowhere"):
            results.read_answers("nowhere.json")

    def test_without_pandas_the_package_is_named(self):
        (pathlib.Path(self.folder.name) / "pandas.py").write_text("raise ImportError('hidden')")
        paths = os.pathsep.join([self.folder.name, os.environ["PYTHONPATH"]])
        run = subprocess.run([sys.executable, "-c", "from touchstone import results; results.frame([{'a': 1}])"],
                             capture_output=True, text=True, env={**os.environ, "PYTHONPATH": paths})
        self.assertNotEqual(run.returncode, 0)
        self.assertIn("python3-pandas", run.stderr)

    @unittest.skipUnless(importlib.util.find_spec("pandas"), "no pandas")
    def test_frames_have_a_column_a_figure(self):
        made = results.frame([{"a": 1, "b": math.inf}, {"a": 2}])
        self.assertEqual(list(made.columns), ["a", "b"])
        self.assertTrue(math.isnan(made["b"][1]))


@unittest.skipUnless(PROGRAM and pathlib.Path(PROGRAM).exists(), "compare_backends was not built")
class Measured(unittest.TestCase):
    def test_a_report_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            run = subprocess.run([PROGRAM, "--pairs", str(CASES), "--backend", "native", "exact", "--quick",
                                  "--repetitions", "1", "--output", folder], capture_output=True, text=True)
            self.assertEqual(run.returncode, 0, run.stderr)
            read = results.read_results(folder)
            answers = results.read_answers(f"{folder}/answers.json").answers()
        self.assertLessEqual({"native", "exact"}, {row["name"] for row in read.backends()})
        native = [row for row in read.queries() if row["backend"] == "native"]
        self.assertEqual({row["query"] for row in native}, {"overlap", "distance", "manifold"})
        self.assertTrue(all(row["wrong_missed"] == 0 and row["single_median_ns"] > 0 for row in native))
        cases = json.loads(CASES.read_text())
        self.assertEqual(len([row for row in answers if row["backend"] == "native"]), len(cases))
        self.assertTrue(all(row["status"] == "overlapping" for row in answers if row.get("exact_class") == "touching"))
        self.assertTrue(any(row["measure"] for row in read.errors()))


if __name__ == "__main__":
    unittest.main()
