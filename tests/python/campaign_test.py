"""Shards of a campaign: any number, any order, some lost, some twice, one killed; the merged bytes are the same."""

import importlib.util
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

import touchstone

FOLDER = pathlib.Path(os.environ["TOUCHSTONE_SOURCE"]) / "examples" / "python"
PAIRS = 3300  # no multiple of a block


@unittest.skipUnless("exact" in touchstone.backends(), "this build has no exact")
class Campaign(unittest.TestCase):
    def setUp(self):
        made = tempfile.TemporaryDirectory()
        self.addCleanup(made.cleanup)
        self.folder = pathlib.Path(made.name)

    def call(self, *arguments, **named):
        command = [sys.executable, "-B", FOLDER / "campaign.py", *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, cwd=self.folder, **named)

    def shard(self, k, n, folder="shards", pairs=PAIRS, kind="pairs"):
        run = self.call("run", f"--{kind}", pairs, "--shard", f"{k}/{n}", "--out", folder)
        self.assertEqual(run.returncode, 0, run.stderr)
        return self.folder / folder / f"shard_{k}_of_{n}.json"

    def merged(self, files, expected=0):
        run = self.call("merge", *files, "--out", "campaign.json")
        self.assertEqual(run.returncode, expected, run.stderr)
        return (self.folder / "campaign.json").read_bytes()

    def test_any_number_and_order_of_shards_merges_to_the_same_bytes(self):
        whole = self.merged([self.shard(1, 1)])
        self.assertIn(b'"pairs": 3300', whole)
        self.assertIn(b'"faults": []', whole)
        three = [self.shard(k, 3) for k in (1, 2, 3)]
        self.assertEqual(self.merged(three), whole)
        self.assertEqual(self.merged([three[2], three[0], three[1], three[0]]), whole)  # one twice
        run = self.call("merge", three[0], three[2])
        self.assertEqual((run.returncode, run.stderr), (1, "lost: 2/3\n"))

    def test_flights_and_dynamics_are_cut_as_pairs_are(self):
        for kind, count, runs, steps, each in (("flights", 6, "flights", "frames", 25), ("dynamics", 7, "runs", "steps", 500)):
            with self.subTest(kind):
                whole = self.merged([self.shard(1, 1, kind, count, kind)])
                three = [self.shard(k, 3, kind, count, kind) for k in (1, 2, 3)]
                self.assertEqual(self.merged([three[1], three[2], three[0], three[1]]), whole)
                root = json.loads(whole)
                self.assertEqual((root["settings"][kind], root["faults"]), (count, []))
                tallies = root["families"].values()
                self.assertEqual(sum(tally[runs] for tally in tallies), count)
                self.assertEqual(sum(tally[steps] for tally in tallies), count * each)
                self.assertGreater(sum(tally.get("blocked", 0) + tally.get("contacts", 0) for tally in tallies), 20)
        flight, run = self.shard(1, 2, kind="flights", pairs=1), self.shard(2, 2, kind="dynamics", pairs=1)
        self.assertIn("different campaigns", self.call("merge", flight, run).stderr)
        self.assertIn("not allowed with", self.call("run", "--pairs", 1, "--flights", 1).stderr)

    def test_a_killed_shard_leaves_nothing_and_is_run_again(self):
        other = self.shard(2, 2)
        far_too_many = 10**9  # it cannot end before it is killed, on any machine
        command = [sys.executable, "-B", FOLDER / "campaign.py", "run", "--pairs", far_too_many, "--shard", "1/2", "--out", "shards"]
        worker = subprocess.Popen(list(map(str, command)), cwd=self.folder, env={**os.environ, "PYTHONUNBUFFERED": "1"}, stderr=subprocess.PIPE, text=True)
        with worker:
            self.assertIn("shard 1/2: 20 of", worker.stderr.readline())
            worker.send_signal(signal.SIGKILL)
        self.assertEqual(worker.returncode, -signal.SIGKILL)
        self.assertFalse((self.folder / "shards" / "shard_1_of_2.json").exists())
        again = self.shard(1, 2)
        self.merged([again, other])

    @unittest.skipUnless(importlib.util.find_spec("distributed"), "not installed: distributed (Debian: python3-distributed)")
    def test_dask_loses_nothing_where_a_worker_is_killed(self):
        whole = self.merged([self.shard(1, 1)])
        command = [sys.executable, "-B", FOLDER / "campaign.py", "dask", "--pairs", PAIRS, "--shards", 7, "--workers", 2, "--out", "dask.json"]
        run = subprocess.Popen(list(map(str, command)), cwd=self.folder, stderr=subprocess.PIPE, text=True)
        for line in run.stderr:
            if line.startswith("1 of 7"):
                break
        children = [each for task in pathlib.Path(f"/proc/{run.pid}/task").iterdir() for each in (task / "children").read_text().split()]
        workers = [each for each in children if "spawn_main" in pathlib.Path(f"/proc/{each}/cmdline").read_text()]
        os.kill(int(workers[0]), signal.SIGKILL)
        self.assertIn("7 of 7 shards", run.stderr.read())
        self.assertEqual(run.wait(), 0)
        self.assertEqual((self.folder / "dask.json").read_bytes(), whole)

    def test_what_does_not_fit_together_is_refused(self):
        one, other = self.shard(1, 2, pairs=600), self.shard(2, 2, "others", pairs=601)
        run = self.call("merge", one, other)
        self.assertIn("different campaigns", run.stderr)
        twin = self.folder / "twin.json"
        twin.write_text(one.read_text().replace('"touching": ', '"touching": 1'))
        self.assertIn("twice, and the two differ", self.call("merge", one, twin).stderr)
        twin.write_text("{")
        self.assertIn("twin.json: no shard's file", self.call("merge", twin).stderr)
        for bad in ("0/3", "4/3", "3", "a/b"):
            self.assertIn("is no shard", self.call("run", "--shard", bad).stderr)


if __name__ == "__main__":
    unittest.main()
