"""Several threads ask one narrowphase; none waits for Python's lock, and none gets another's answers."""

import signal
import threading
import time
import unittest

import numpy as np
import touchstone


class Threads(unittest.TestCase):
    def setUp(self):
        random = np.random.default_rng(5)
        self.n = 200
        self.boxes = [touchstone.Hexahedron.box(size) for size in random.uniform(0.2, 1, (self.n, 3))]
        self.poses = touchstone.Poses(random.uniform(-2, 2, (self.n, 3)), random.normal(size=(self.n, 4)))
        self.pairs = np.argwhere(np.triu(np.ones((self.n, self.n)), 1)).astype(np.uint32)

    def run_all(self, bodies):
        errors = []

        def guarded(body):
            try:
                body()
            except BaseException as error:  # noqa: BLE001
                errors.append(error)

        threads = [threading.Thread(target=guarded, args=(body,)) for body in bodies]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        if errors:
            raise errors[0]

    def test_a_shared_narrowphase_gives_every_thread_its_own_answers(self):
        # ODE's data are per thread; the others' workspaces go from thread to thread.
        for name in sorted({"native", "ode", "bullet", "exact"} & set(touchstone.backends())):
            with self.subTest(name):
                check = touchstone.Narrowphase(name, self.boxes)
                pairs = self.pairs if name != "exact" else self.pairs[::40]
                parts = np.array_split(pairs, 4)
                query = check.overlap if name == "ode" else check.distance
                expected = [query(self.poses, part).status.copy() for part in parts]
                found = [[] for _ in parts]

                def ask(k, found=found, query=query, parts=parts):
                    found[k] = [query(self.poses, parts[k]).status for _ in range(5)]

                self.run_all([lambda k=k: ask(k) for k in range(4)])
                for one, answers in zip(expected, found):
                    self.assertEqual(len(answers), 5)
                    for status in answers:
                        np.testing.assert_array_equal(status, one)

    @unittest.skipUnless("exact" in touchstone.backends(), "no exact in this build")
    def test_a_signal_ends_a_long_batch(self):
        class Stop(Exception):
            pass

        def stop(number, frame):
            raise Stop

        before = signal.signal(signal.SIGALRM, stop)
        self.addCleanup(signal.signal, signal.SIGALRM, before)
        check = touchstone.Narrowphase("exact", self.boxes)
        pairs = np.tile([[0, 1]], (200_000, 1)).astype(np.uint32)  # some 20 s of manifolds
        meeting = touchstone.Poses(np.zeros((self.n, 3)), np.tile([1.0, 0, 0, 0], (self.n, 1)))
        begin = time.thread_time()
        signal.setitimer(signal.ITIMER_REAL, 0.05)
        with self.assertRaises(Stop):
            check.manifold(meeting, pairs)
        self.assertLess(time.thread_time() - begin, 0.5)
        # What was in use is free again.
        meeting.update([[0, 0, 0]], [[1, 0, 0, 0]], first=0)
        self.assertEqual(len(check.overlap(self.poses, self.pairs[:9])), 9)

    def test_pythons_lock_is_free_during_a_batch(self):
        check = touchstone.Narrowphase("native", self.boxes)
        pairs = np.tile(self.pairs, (20, 1))  # some 100 ms
        done = threading.Event()
        counted = []

        def ask():
            check.distance(self.poses, pairs)
            done.set()

        def count():
            n = 0
            while not done.is_set():
                n += 1
            counted.append(n)

        thread = threading.Thread(target=count)
        asker = threading.Thread(target=ask)
        thread.start()
        asker.start()
        asker.join()
        thread.join()
        self.assertGreater(counted[0], 1000)

    def test_what_a_batch_reads_or_writes_is_not_changed_meanwhile(self):
        """Poses and out in use by one thread are refused to another: an exception, no torn answers."""
        check = touchstone.Narrowphase("native", self.boxes)
        pairs = np.tile(self.pairs, (4, 1))
        out = check.distance(self.poses, pairs)
        expected = out.geometry["p_A_W"].tobytes()
        matrices = self.poses.matrices()
        refused = {"poses": 0, "out": 0}
        stop = threading.Event()

        def update():
            while not stop.is_set():
                try:
                    self.poses.update(matrices)
                except RuntimeError as error:
                    refused[str(error).split(":")[0]] += 1

        def write():
            while not stop.is_set():
                try:
                    check.distance(self.poses, pairs, out=out)
                except RuntimeError as error:
                    refused[str(error).split(":")[0]] += 1

        def stop_later():
            try:
                for _ in range(3):
                    own = check.distance(self.poses, pairs)
                    self.assertEqual(own.geometry["p_A_W"].tobytes(), expected)
            finally:
                stop.set()

        self.run_all([update, write, write, stop_later])
        self.assertGreater(refused["poses"], 0)
        self.assertGreater(refused["out"], 0)
        self.assertEqual(check.distance(self.poses, pairs, out=out).geometry["p_A_W"].tobytes(), expected)


if __name__ == "__main__":
    unittest.main()
