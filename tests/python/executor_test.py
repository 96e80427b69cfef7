"""Frames on threads of Python's own executors: the same bits, and no frame that waits for an executor."""

import concurrent.futures
import gc
import signal
import sys
import threading
import time
import unittest
import weakref

import touchstone
import numpy as np
from hands_test import Heap, at, block
from touchstone import InputError


class Unraisable:
    """What went to sys.unraisablehook meanwhile."""

    def __enter__(self):
        self.seen, self.before = [], sys.unraisablehook
        sys.unraisablehook = lambda of: self.seen.append(str(of.exc_value))
        return self.seen

    def __exit__(self, *_):
        sys.unraisablehook = self.before


class Crowd:
    """Three hundred boxes that go among each other."""

    def __init__(self):
        self.random = np.random.default_rng(11)
        self.world = touchstone.World()
        self.movers = [self.world.add(block(f"mover {i}", (0.5, 0.4, 0.3)), at(i % 20, i // 20)) for i in range(300)]

    def fly(self, frames=20):
        for _ in range(frames):
            moves = {m: (self.random.uniform(-0.4, 0.4, 3), self.random.uniform(-0.3, 0.3, 3)) for m in self.movers}
            self.world.frame(moves=moves)

    def poses(self):
        return b"".join(self.world.pose(m).tobytes() for m in self.movers)


class TimedLender:
    """Calls each function on a thread of its own and waits for it; `seconds` of the processor that they took there."""

    def __init__(self):
        self.functions, self.seconds = [], 0.0

    def time(self, function):
        start = time.thread_time()
        function()
        self.seconds += time.thread_time() - start

    def __call__(self, function):
        self.functions.append(function)
        thread = threading.Thread(target=self.time, args=(function,))
        thread.start()
        thread.join()


class Executors(unittest.TestCase):
    def setUp(self):
        self.expected = Heap().fly()

    def fly(self, executor, threads):
        heap = Heap()
        heap.world.set_executor(executor, threads)
        return heap.fly()

    def test_frames_have_the_same_bits_on_a_thread_pool_executor(self):
        with concurrent.futures.ThreadPoolExecutor(3) as executor:
            for threads in (1, 2, 4):
                self.assertEqual(self.fly(executor, threads), self.expected, threads)

    def test_a_callable_lends_threads_that_do_work(self):
        lent = []

        def lend(function):
            def body():
                function()
                lent.append(threading.get_ident())

            threading.Thread(target=body).start()

        self.assertEqual(self.fly(lend, 3), self.expected)
        self.assertGreater(len(set(lent) - {threading.get_ident()}), 0)

    def test_tasks_run_on_the_executors_threads_beside_the_callers(self):
        """A thread that is lent takes tasks while the caller is held up: both are in the same frame."""
        inside, both = set(), threading.Event()

        def lend(function):
            def body():
                inside.add(threading.get_ident())
                function()
                both.set()

            thread = threading.Thread(target=body)
            thread.start()
            while not inside:  # the caller waits here until the thread has begun
                time.sleep(0)

        self.assertEqual(self.fly(lend, 2), self.expected)
        self.assertTrue(both.wait(10))

    def test_lent_threads_do_the_work(self):
        """One that has ended before the caller takes part has done all tasks of its call."""
        alone, crowd, lender = Crowd(), Crowd(), TimedLender()
        start = time.thread_time()
        alone.fly()
        all_alone = time.thread_time() - start
        crowd.world.set_executor(lender, 2)
        crowd.fly()
        lent = lender.seconds
        self.assertEqual(crowd.poses(), alone.poses())
        self.assertGreater(lent, 0.3 * all_alone)
        for late in lender.functions:  # again: nothing is left to do
            lender.time(late)
        self.assertLess(lender.seconds - lent, 0.1 * lent)

    def test_what_interrupts_is_raised_where_the_frame_ends(self):
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)
        for interrupt, raised in ((lambda: signal.raise_signal(signal.SIGINT), KeyboardInterrupt), (sys.exit, SystemExit)):
            calls, crowd, undisturbed = [], Crowd(), Crowd()

            def lend(function, calls=calls, interrupt=interrupt):
                calls.append(function)
                if len(calls) == 1:
                    interrupt()

            crowd.world.set_executor(lend, 2)
            with Unraisable() as seen, self.assertRaises(raised):
                crowd.fly(1)
            self.assertEqual((seen, len(calls)), ([], 1))
            # The frame was flown to its end, and the world goes on.
            undisturbed.fly(1)
            self.assertEqual(crowd.poses(), undisturbed.poses())
            crowd.fly(2)
            undisturbed.fly(2)
            self.assertEqual(crowd.poses(), undisturbed.poses())
            self.assertGreater(len(calls), 1)

    def test_a_signal_that_comes_while_the_executor_is_called_is_raised(self):
        before = signal.signal(signal.SIGALRM, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGALRM, before)

        def lend(function):
            signal.setitimer(signal.ITIMER_REAL, 1e-3)
            end = time.monotonic() + 10
            while time.monotonic() < end:
                pass

        heap = Heap()
        heap.world.set_executor(lend, 2)
        with Unraisable() as seen, self.assertRaises(KeyboardInterrupt):
            heap.fly()
        self.assertEqual(seen, [])

    def test_a_world_and_the_executor_that_holds_it_are_collected(self):
        class Owner:
            def __init__(self):
                self.heap = Heap()
                self.heap.world.set_executor(self, 2)

            def __call__(self, function):
                function()

        class Kind(touchstone.World):
            pass

        owner = Owner()
        gc.collect()
        self.assertEqual(owner.heap.fly(), self.expected)  # what is held is left alone
        kept = weakref.ref(owner)
        del owner
        gc.collect()
        self.assertIsNone(kept())
        # The same of a derived class, while the collector runs as often as it can.
        before = gc.get_threshold()
        self.addCleanup(gc.set_threshold, *before)
        gc.set_threshold(1, 1, 1)
        for _ in range(50):
            world = Kind()
            world.lend = lambda function, of=world: function()
            world.set_executor(world.lend, 2)
            kept = weakref.ref(world)
            del world
            gc.collect()
            self.assertIsNone(kept())

    def test_a_callable_may_call_at_once(self):
        self.assertEqual(self.fly(lambda function: function(), 4), self.expected)

    def test_no_frame_waits_for_an_executor_that_does_nothing(self):
        kept = []
        self.assertEqual(self.fly(kept.append, 3), self.expected)
        self.assertGreater(len(kept), 0)
        for late in kept:  # frames and world are gone
            late()
            late()

    def test_a_frame_within_the_only_thread_of_its_executor_goes_on(self):
        with concurrent.futures.ThreadPoolExecutor(1) as executor:
            self.assertEqual(executor.submit(self.fly, executor, 2).result(timeout=60), self.expected)

    def test_worlds_of_several_threads_share_an_executor(self):
        with concurrent.futures.ThreadPoolExecutor(2) as executor, concurrent.futures.ThreadPoolExecutor(4) as flying:
            flights = [flying.submit(self.fly, executor, 3) for _ in range(4)]
            self.assertEqual([flight.result(timeout=120) for flight in flights], [self.expected] * 4)

    def test_what_an_executor_raises_is_seen_and_costs_no_frame(self):
        def fail(function):
            raise OSError("no more threads")

        shut = concurrent.futures.ThreadPoolExecutor(1)
        shut.shutdown()
        for executor, text in ((fail, "no more threads"), (shut, "shutdown")):
            with Unraisable() as seen:
                self.assertEqual(self.fly(executor, 2), self.expected)
            self.assertGreater(len(seen), 0)
            self.assertIn(text, seen[0])

    def test_a_frame_within_a_frame_is_refused(self):
        heap = Heap()

        def reenter(function):
            heap.world.frame()

        heap.world.set_executor(reenter, 2)
        with Unraisable() as seen:
            self.assertEqual(heap.fly(), self.expected)
        self.assertIn("in use", seen[0])

    def test_an_executor_lives_as_long_as_a_world_borrows_it(self):
        class Lender:
            def __call__(self, function):
                function()

        heap, lender = Heap(), Lender()
        kept = weakref.ref(lender)
        heap.world.set_executor(lender, 2)
        del lender
        gc.collect()
        self.assertIsNotNone(kept())
        self.assertEqual(heap.fly(), self.expected)
        heap.world.set_threads(1)
        gc.collect()
        self.assertIsNone(kept())

    def test_executors_that_are_none(self):
        world = touchstone.World()
        for executor in (3, None, object()):
            with self.assertRaisesRegex(TypeError, "no submit"):
                world.set_executor(executor, 2)
        for threads in (0, 65):
            with self.assertRaisesRegex(InputError, "threads"):
                world.set_executor(print, threads)
        with concurrent.futures.ProcessPoolExecutor(1) as processes, self.assertRaisesRegex(TypeError, "ProcessPoolExecutor"):
            world.set_executor(processes, 2)


if __name__ == "__main__":
    unittest.main()
