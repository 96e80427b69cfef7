"""What Python costs over C++: the same batches through the module, and by the module's own loop without Python.

    PYTHONPATH=build/release/python /usr/bin/python3 tests/python/benchmark.py [--repetitions 41]

Overheads are of the thread's processor time. Both sides take turns, each so short (a third of a millisecond where a batch is shorter)
that on a loaded machine, too, many run in one piece, in caches that nobody else has filled: the least of the turns count, and beside their
ratio the median of the turns' ratios. Build without TOUCHSTONE_UNTIMED_EXAMPLES, which CI's build has. Threads are timed by the clock: the
best of many runs of one thread over the best of two with half each. They are there before and wait for their share, as the processes do: to start two takes some 0.1 ms, a tenth of half of
20 000 pairs, which the row of threads that are started anew shows. The same without Python, and in two processes that share nothing but
the machine, are the yardsticks: what Python adds is the share of a batch that it holds its lock, of the thread's processor time.
"""

import argparse
import multiprocessing
import os
import queue
import statistics
import threading
import time

import numpy as np
import touchstone

OVERLAP, DISTANCE, MANIFOLD = 0, 1, 2


def scene(solids, pairs, seed=1, reach=1.0):
    """Boxes around the origin's neighbourhood, a pair of neighbours each: about half of them overlap."""
    random = np.random.default_rng(seed)
    corners = np.repeat(touchstone.Hexahedron.box([1, 1, 1]).vertices[None], solids, axis=0)
    corners = corners * random.uniform(0.5, 1.5, (solids, 1, 3))
    check = touchstone.Narrowphase("native", corners)
    poses = touchstone.Poses(random.uniform(-reach, reach, (solids, 3)), random.normal(size=(solids, 4)))
    a = random.integers(0, solids, pairs)
    b = (a + random.integers(1, solids, pairs)) % solids
    return check, poses, np.stack([np.minimum(a, b), np.maximum(a, b)], axis=1).astype(np.uint32)


def seconds_of(call, repeats):
    begin = time.thread_time()
    for _ in range(repeats):
        call()
    return time.thread_time() - begin


def overhead(name, call, kind, case, repeats, repetitions):
    check, poses, pairs = case
    ratios, ours, theirs = [], [], []
    for _ in range(repetitions):
        theirs.append(check._seconds(kind, poses, pairs, repeats) / repeats)
        ours.append(seconds_of(call, repeats) / repeats)
        ratios.append(ours[-1] / theirs[-1])
    print(f"| {name} | {1e6 * min(theirs):.2f} | {1e6 * min(ours):.2f} | {100 * (min(ours) / min(theirs) - 1):+.1f} % "
          f"| {100 * (statistics.median(ratios) - 1):+.1f} % |", flush=True)


def wall_of(bodies):
    threads = [threading.Thread(target=body) for body in bodies]
    begin = time.perf_counter()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return time.perf_counter() - begin


class Process:
    """Answers parts of the batch in a process of its own."""

    def __init__(self, body):
        if threading.active_count() > 1:
            raise RuntimeError("a process with threads is not forked: their locks would stay held in the other one")
        self.here, there = multiprocessing.Pipe()
        self.process = multiprocessing.get_context("fork").Process(target=self.serve, args=(there, body), daemon=True)
        self.process.start()

    @staticmethod
    def serve(there, body):
        for parts in iter(there.recv, None):
            for part in parts:
                body(part)
            there.send(None)

    def end(self):
        self.here.send(None)
        self.process.join()


class Waiting:
    """Answers parts of the batch in a thread of its own, with the calls of a pipe's end."""

    def __init__(self, body):
        self.here, self.asked, self.done = self, queue.SimpleQueue(), queue.SimpleQueue()
        self.send, self.recv = self.asked.put, self.done.get
        self.thread = threading.Thread(target=self.serve, args=(body,), daemon=True)
        self.thread.start()

    def serve(self, body):
        for parts in iter(self.asked.get, None):
            for part in parts:
                body(part)
            self.done.put(None)

    def end(self):
        self.send(None)
        self.thread.join()


def wall_of_waiting(others, parts):
    begin = time.perf_counter()
    for other, part in zip(others, parts):
        other.here.send(part)
    for other, _ in zip(others, parts):
        other.here.recv()
    return time.perf_counter() - begin


def held_share(check, poses, half, out, repetitions):
    """The share of a batch under Python's lock, at most: of a call that is refused after all that is done under it."""
    other = check.distance(poses, half[:1].copy())

    def refused():
        try:
            check.distance(poses, half, out=other)
        except touchstone.InputError:
            pass

    held = [seconds_of(refused, 50) / 50 for _ in range(repetitions)]
    whole = [seconds_of(lambda: check.distance(poses, half, out=out), 1) for _ in range(repetitions)]
    return statistics.median(held) / statistics.median(whole)


def threads(repetitions, case):
    check, poses, pairs = case
    halves = np.array_split(pairs, 2)
    outs = [check.distance(poses, half) for half in halves]
    share = held_share(check, poses, halves[0], outs[0], repetitions // 8 + 2)
    bodies = {"from Python": lambda k: check.distance(poses, halves[k], out=outs[k]),
              "C++ alone": lambda k: check._seconds(DISTANCE, poses, halves[k], 1)}
    others = {"two processes": [Process(bodies["C++ alone"]) for _ in halves],  # before there are threads
              **{name: [Waiting(body) for _ in halves] for name, body in bodies.items()}}
    one = {name: [] for name in [*others, "from Python, started anew"]}
    two = {name: [] for name in one}
    for _ in range(repetitions):
        for name, waiting in others.items():
            one[name].append(wall_of_waiting(waiting, [(0, 1)]))
            two[name].append(wall_of_waiting(waiting, [(0,), (1,)]))
        body = bodies["from Python"]
        one["from Python, started anew"].append(wall_of([lambda: (body(0), body(1))]))
        two["from Python, started anew"].append(wall_of([lambda: body(0), lambda: body(1)]))
    for waiting in others.values():
        for other in waiting:
            other.end()
    for name in one:
        median = statistics.median(one[name]) / statistics.median(two[name])
        print(f"| {name}, {len(pairs)} pairs | {median:.2f} | {min(one[name]) / min(two[name]):.2f} |")
    print(f"\nUnder Python's lock: at most {100 * share:.2f} % of a batch of {len(halves[0])} pairs, which allows "
          f"{2 / (1 + share):.3f}.")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repetitions", type=int, default=41)
    n = parser.parse_args().repetitions
    print(f"load {os.getloadavg()[0]:.1f}, {os.cpu_count()} processors\n")
    print("| batch | C++, least [us] | Python, least [us] | overhead | median of the ratios |\n|---|---:|---:|---:|---:|")
    thousand = scene(256, 1024)
    check, poses, pairs = thousand
    out = check.distance(poses, pairs)
    overhead("distance, 1 024 pairs", lambda: check.distance(poses, pairs), DISTANCE, thousand, 4, 25 * n)
    overhead("distance, 1 024 pairs, `out`", lambda: check.distance(poses, pairs, out=out), DISTANCE, thousand, 4, 25 * n)
    matrices = poses.matrices()
    overhead("distance, 1 024 pairs, poses as arrays", lambda: check.distance(matrices, pairs), DISTANCE, thousand, 4, 25 * n)
    positions, turns = matrices[:, :3, 3].copy(), np.random.default_rng(2).normal(size=(len(matrices), 4))
    turned = touchstone.Poses(positions, turns)  # as these will be
    update = lambda: (poses.update(positions, turns), check.distance(poses, pairs))
    overhead("distance, 1 024 pairs, poses updated by quaternions", update, DISTANCE, (check, turned, pairs), 4, 25 * n)
    poses.update(matrices)
    many = scene(2000, 100_000, reach=4.0)
    check_many, poses_many, pairs_many = many
    out_many = check_many.overlap(poses_many, pairs_many)
    overhead("overlap, 100 000 pairs", lambda: check_many.overlap(poses_many, pairs_many), OVERLAP, many, 1, 5 * n)
    overhead("overlap, 100 000 pairs, `out`", lambda: check_many.overlap(poses_many, pairs_many, out=out_many), OVERLAP,
             many, 1, 5 * n)
    overhead("distance, 100 000 pairs", lambda: check_many.distance(poses_many, pairs_many), DISTANCE, many, 1, n)
    single = (check, poses, pairs[:1].copy())
    one = check.distance(poses, single[2])
    overhead("distance, a single pair", lambda: check.distance(poses, single[2]), DISTANCE, single, 400, 25 * n)
    overhead("distance, a single pair, `out`", lambda: check.distance(poses, single[2], out=one), DISTANCE, single, 400,
             25 * n)
    print("\n| two threads over one | medians | best over best |\n|---|---:|---:|")
    threads(8 * n, scene(2000, 20_000))
    threads(n, scene(2000, 100_000))


if __name__ == "__main__":
    main()
