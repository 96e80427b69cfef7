"""examples/bench/trackers.py without engines: what is red, and that every case of trackers.json is there."""
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

BENCH = pathlib.Path(__file__).resolve().parents[2] / "examples/bench"
sys.path.insert(0, str(BENCH))
import trackers  # noqa: E402

NAN3 = (math.nan,) * 3


def kinds(answer, known):
    return {kind for kind, _, _ in trackers.faults(answer, known)}


class Faults(unittest.TestCase):
    contact = (True, -0.1, [0.0, 0.0, 1.0], 2.0)
    apart = (False, 0.5, [0.0, 0.0, 1.0], 2.0)

    def test_a_right_answer_is_none(self):
        self.assertEqual(kinds([("overlap", "overlapping", math.inf, None), ("distance", "overlapping", -0.1, (0, 0, 1))], self.contact), set())
        self.assertEqual(kinds([("overlap", "separated", math.inf, None), ("manifold", "separated", math.inf, NAN3)], self.apart), set())

    def test_a_wrong_class_is_red_however_near(self):
        self.assertEqual(kinds([("overlap", "separated", math.inf, None)], (True, -1e-9, None, 2.0)), {"missed"})
        self.assertEqual(kinds([("overlap", "overlapping", math.inf, None)], (False, 1e-9, None, 2.0)), {"phantom"})

    def test_half_a_depth_and_a_huge_distance_are_red(self):
        self.assertEqual(kinds([("manifold", "overlapping", -0.05, (0, 0, 1))], self.contact), {"separation"})
        self.assertEqual(kinds([("distance", "overlapping", -1.79e308, NAN3)], self.apart), {"separation", "phantom"})

    def test_below_a_thousandth_of_the_scale_is_not(self):
        self.assertEqual(kinds([("distance", "overlapping", -0.1 + 1.9e-3, (0, 0, 1))], self.contact), set())
        self.assertEqual(kinds([("distance", "overlapping", -0.1 + 2.1e-3, (0, 0, 1))], self.contact), {"separation"})

    def test_no_figure_and_another_normal_are_red(self):
        self.assertEqual(kinds([("distance", "overlapping", math.nan, NAN3)], self.contact), {"separation"})
        self.assertEqual(kinds([("distance", "overlapping", -0.1, (0, 1, 0))], self.contact), {"normal"})

    def test_what_is_not_answered_is_none(self):
        self.assertEqual(kinds([("distance", "undecided", -0.1, NAN3), ("manifold", "unsupported", math.nan, NAN3)], self.contact), set())


class Listed(unittest.TestCase):
    def test_every_case_is_there_and_as_published(self):
        cases, listed = trackers.load_cases(), json.loads((BENCH / "trackers.json").read_text())
        for bug in listed["asked"]:
            self.assertLessEqual(set(bug["symptoms"]), {"missed", "phantom", "separation", "normal"}, bug["bug"])
            self.assertTrue((trackers.ADAPTERS / bug["engine"]).exists(), bug["engine"])
            for name in bug["cases"]:
                self.assertIn(name, cases)
        for name, distance in (("mujoco-2710", 0.1), ("mujoco_warp-1635", -0.01), ("newton-2622-like-1", 0.00142)):
            contact, exact, _, _ = trackers.truth(cases[name])
            self.assertEqual(contact, distance < 0)
            self.assertAlmostEqual(exact, distance, places=12)


class Environments(unittest.TestCase):
    def test_what_was_interrupted_is_installed_again(self):
        for packages in (["numpy==1"], ["engine@1"]):
            with tempfile.TemporaryDirectory() as folder:
                def here():
                    return trackers.environment_of(packages, pathlib.Path(folder))

                def stopped(command, **_):
                    (here()["root"] / "bin").mkdir(exist_ok=True)
                    (here()["root"] / "bin/python").touch()
                    (here()["root"] / "node_modules").mkdir(exist_ok=True)
                    if "venv" not in command:
                        raise subprocess.CalledProcessError(1, command)

                with unittest.mock.patch("subprocess.run", stopped), self.assertRaises(subprocess.CalledProcessError):
                    trackers.install(here())
                self.assertFalse(here()["there"])
                with unittest.mock.patch("subprocess.run") as run:
                    trackers.install(here())
                    self.assertTrue(run.called)
                    self.assertTrue(here()["there"])
                    run.reset_mock()
                    trackers.install(here())
                    self.assertFalse(run.called)

    def test_an_engine_without_a_greeting_is_named(self):
        with self.assertRaisesRegex(SystemExit, "-c pass: ended without a greeting, code 0"):
            trackers.Engine([sys.executable, "-c", "pass"], {"env": None, "cwd": None})


class Page(unittest.TestCase):
    def test_rows_of_bugs_that_are_not_asked_again_are_kept(self):
        cases, page = trackers.load_cases(), (BENCH / "trackers.md").read_text()
        listed = json.loads((BENCH / "trackers.json").read_text())["asked"]
        kept = [trackers.kept_row(bug, page, cases) for bug in listed]
        self.assertNotIn(None, kept, "a bug of trackers.json has no row: trackers.py --keep --only it")
        share = f"Flagged: {sum(each[1] for each in kept)} of {len(kept)}, "
        self.assertIn(share, page)
        self.assertIn(f", {sum(each[2] for each in kept)} of them by pairs of corpus 1.1", page)
        self.assertIsNone(trackers.kept_row({"bug": "mujoco#1"}, page, cases))

    def test_the_page_of_all_is_not_replaced_by_one_of_some(self):
        self.assertEqual(trackers.page_path(None, False), BENCH / "trackers.md")
        self.assertIsNone(trackers.page_path(None, True))
        self.assertEqual(trackers.page_path(pathlib.Path("some.md"), True), pathlib.Path("some.md"))
        before = (BENCH / "trackers.md").read_text()
        with tempfile.TemporaryDirectory() as folder, unittest.mock.patch("builtins.print"):
            with unittest.mock.patch("sys.argv", ["trackers.py", "--environments", folder]):
                trackers.main()  # nothing is installed
        self.assertEqual((BENCH / "trackers.md").read_text(), before)


if __name__ == "__main__":
    unittest.main()
