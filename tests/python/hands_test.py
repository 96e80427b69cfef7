"""Hands of worlds, what they feel, budgets of slides, and threads that worlds share."""

import threading
import unittest

import numpy as np
import touchstone
from touchstone import ArmHandStiffness, HandStiffness, InputError

UNIT = np.array([1.0, 0, 0, 0])


def block(name, size):
    return touchstone.HexahedronTree([("body", touchstone.Hexahedron.box(size), None)], name)


def at(x, y=0.0, z=0.0):
    return np.array([x, y, z], float), UNIT


def about_y(angle, p=(0, 0, 0)):
    X = np.eye(4)
    X[0, 0] = X[2, 2] = np.cos(angle)
    X[0, 2] = np.sin(angle)
    X[2, 0] = -X[0, 2]
    X[:3, 3] = p
    return X


def sliding_world():
    world = touchstone.World(gap=1e-9)
    world.set_default_rule(policy="slide")
    return world


def add_slope(world):
    """30 degrees about y, through the origin. Returns the pose on it of a cube of 0.2 m, 1 um above."""
    X = about_y(np.pi / 6)
    n = X[:3, 2]
    world.add(block("slope", (6, 6, 1)), about_y(np.pi / 6, -0.5 * n), is_static=True)
    return about_y(np.pi / 6, (0.1 + 1e-6) * n)


class Hands(unittest.TestCase):
    def test_a_floor_is_felt_as_the_spring_holds(self):
        world = sliding_world()
        world.add(block("floor", (6, 6, 1)), at(0, 0, -0.5), is_static=True)
        box = world.add(block("box", (0.6, 0.5, 0.4)), at(0, 0, 0.2 + 1e-3))
        world.set_hand(box, HandStiffness())
        felt = world.frame({box: at(0.1, 0, 0.2 - 1e-3)}).felt  # 1 mm into the floor, at 500 N/m
        self.assertEqual((felt.shape, int(felt["object"][0])), ((1,), int(box)))
        np.testing.assert_allclose(felt["lag_W"][0], [0, 0, -1e-3], atol=1e-8)
        np.testing.assert_allclose(felt["force_W"][0], [0, 0, 0.5], atol=1e-5)
        np.testing.assert_allclose(felt["p_W"][0], world.pose(box)[:3, 3], atol=1e-12)
        kept = felt.tobytes()
        self.assertEqual(len(world.frame({box: at(0.1, 0, 0.5)}).felt), 0)  # away from it nothing is felt
        self.assertEqual(felt.tobytes(), kept)

    def test_a_tool_at_the_end_of_a_lever_feels_its_moment(self):
        world = sliding_world()
        world.add(block("block", (0.02, 1, 1)), at(1.0, 0, -0.5), is_static=True)
        bar = world.add(block("bar", (2, 0.1, 0.1)), at(0, 0, 0.05 + 1e-4))
        world.set_hand(bar, HandStiffness([1000] * 3, [200] * 3, at(-1)))
        for _ in range(10):
            report = world.frame({bar: at(0, 0, 0.05 - 1e-3)})
        # Two springs in a row at the end of a lever r: the end is held up by h, f (1 / k + r^2 / c) = h.
        r, h = 1.99, 1e-3
        f = h / (1 / 1000 + r * r / 200)
        felt = report.felt[0]
        self.assertAlmostEqual(felt["force_W"][2], f, delta=0.01 * f)
        self.assertAlmostEqual(felt["moment_W"][1], -r * f, delta=0.01 * r * f)
        self.assertAlmostEqual(felt["turn_lag_W"][1], r * f / 200, delta=0.01 * r * f / 200)

    def test_a_stiffer_axis_of_the_tool_frame_gives_less(self):
        world = sliding_world()
        start = add_slope(world)
        n = start[:3, 2]
        box = world.add(block("box", (0.2, 0.2, 0.2)), start)
        world.set_hand(box, HandStiffness(translation=[400, 400, 100], X_OT=about_y(-np.pi / 6)))  # along W
        g, K = np.array([0, 0, -0.01]), np.array([400, 400, 100])
        goal = start.copy()
        goal[:3, 3] += g
        for _ in range(5):
            world.frame({box: goal})
        moved = world.pose(box)[:3, 3] - start[:3, 3]
        np.testing.assert_allclose(moved, g - (n @ g) / (n @ (n / K)) * (n / K), atol=5e-6)
        self.assertGreater(np.linalg.norm(moved - (g - (n @ g) * n)), 1e-3)  # an even hand goes elsewhere

    def test_none_is_the_object_s_mass_and_the_default_is_of_all_others(self):
        def tip(set_up):
            """Turns of a bar that is pressed on a block under its end."""
            world = sliding_world()
            world.add(block("block", (0.02, 1, 1)), at(1.0, 0, -0.5), is_static=True)
            bar = world.add(block("bar", (2, 0.1, 0.1)), at(0, 0, 0.05 + 1e-4))
            set_up(world, bar)
            for _ in range(10):
                world.frame({bar: at(0, 0, -0.1)})
            return np.arccos(np.clip(world.pose(bar)[0, 0], -1, 1))

        untouched = tip(lambda world, bar: None)
        stiff = HandStiffness(turning=[5e5] * 3)
        self.assertLess(tip(lambda world, bar: world.set_hand(bar, stiff)), 1e-3)
        self.assertEqual(tip(lambda world, bar: world.set_default_hand(HandStiffness())), untouched)
        by_default = tip(lambda world, bar: world.set_default_hand(stiff))
        self.assertLess(by_default, 1e-3)
        by_mass = tip(lambda world, bar: world.set_hand(bar, None))
        self.assertEqual(by_mass, tip(lambda world, bar: world.set_default_hand(None)))
        self.assertGreater(by_mass, 0.05)
        self.assertNotEqual(by_mass, untouched)

    def test_values_are_as_given_and_cannot_be_written(self):
        hand = HandStiffness([1, 2, 3], [4, 5, 6], at(7))
        np.testing.assert_array_equal(hand.translation, [1, 2, 3])
        np.testing.assert_array_equal(hand.turning, [4, 5, 6])
        np.testing.assert_array_equal(hand.X_OT[:3, 3], [7, 0, 0])
        self.assertIsNone(HandStiffness().X_OT)
        arm = ArmHandStiffness("tool", at(1), [1, 2, 3], joints=[8, 9])
        np.testing.assert_array_equal(arm.turning, [500] * 3)
        np.testing.assert_array_equal(arm.joints, [8, 9])
        for values in (hand.translation, hand.turning, hand.X_OT, arm.X_LT, arm.joints):
            with self.assertRaises(ValueError):
                values[0] = 1

    def test_what_is_no_hand_is_refused_and_changes_nothing(self):
        world = sliding_world()
        box = world.add(block("box", (1, 1, 1)))
        world.set_hand(box, HandStiffness([400, 400, 100]))
        for bad, text in ((HandStiffness([500, 0, 500]), "'box', hand"), (HandStiffness([1e-3, 1, 1e5]), "not within"),
                          (HandStiffness(turning=[np.nan] * 3), "not within"), (HandStiffness(X_OT=at(1e9)), "tool frame")):
            with self.assertRaisesRegex(InputError, text):
                world.set_hand(box, bad)
        with self.assertRaisesRegex(InputError, "tool frame is of one object"):
            world.set_default_hand(HandStiffness(X_OT=at(0.1)))
        with self.assertRaisesRegex(InputError, r"translation: shape is \(2,\), must be \(3,\)"):
            HandStiffness([1, 2])
        with self.assertRaisesRegex(TypeError, "turning"):
            HandStiffness(turning="stiff")
        with self.assertRaises(TypeError):
            world.set_hand(box, ArmHandStiffness("link"))
        world.remove(box)
        with self.assertRaises(InputError):
            world.set_hand(box, HandStiffness())


def gantry(X_box):
    """Slides along x, y and z one on the other, the last with a box of 0.2 m."""
    links = [touchstone.Link("base"), touchstone.Link("x"), touchstone.Link("y"),
             touchstone.Link("z", [("box", touchstone.Hexahedron.box([0.2] * 3), X_box)])]
    joints = [touchstone.Joint(name, "prismatic", parent, name, axis=np.eye(3)[k], lower=-5, upper=5)
              for k, (parent, name) in enumerate([("base", "x"), ("x", "y"), ("y", "z")])]
    return touchstone.Mechanism("gantry", links, joints)


class ArmHands(unittest.TestCase):
    def test_tool_and_joints_are_springs_in_a_row(self):
        world = sliding_world()
        start = add_slope(world)
        n = start[:3, 2]
        arm = world.add_mechanism(gantry(start))
        world.set_hand(arm, ArmHandStiffness("z", at(0.3, 0.2, 0.4), [400, 400, 100], joints=[20, 30, 50]))
        g, K = np.array([0, 0, -0.01]), np.array([420, 430, 150])
        for _ in range(5):
            report = world.frame(joints={arm: g})
        force = -(n @ g) / (n @ (n / K))
        np.testing.assert_allclose(world.joint_values(arm), g + force * n / K, atol=5e-6)
        (felt,) = report.felt
        self.assertEqual(int(felt["object"]), int(world.link(arm, "z")))
        np.testing.assert_allclose(felt["force_W"], force * n, atol=1e-3 * force)
        world.set_hand(arm, None)
        self.assertEqual(len(world.frame(joints={arm: 2 * g}).felt), 0)

    def test_what_is_no_hand_of_an_arm(self):
        world = sliding_world()
        arm = world.add_mechanism(gantry(None))
        for bad, text in ((ArmHandStiffness("nobody"), "nobody"), (ArmHandStiffness("base"), "no joint moves link 'base'"),
                          (ArmHandStiffness("z", joints=[1, 2]), "2 stiffnesses for 3 joints"),
                          (ArmHandStiffness("z", translation=[-1, 1, 1]), "'gantry', hand")):
            with self.assertRaisesRegex(InputError, text):
                world.set_hand(arm, bad)
        with self.assertRaisesRegex(InputError, "mechanism's link"):
            world.set_hand(world.link(arm, "z"), HandStiffness())


class Heap:
    """Three boxes that are commanded to go through a heap of sixty others."""

    def __init__(self):
        random = np.random.default_rng(7)
        self.world = sliding_world()
        self.movers = [self.world.add(block(f"mover {i}", (0.3, 0.25, 0.2)), at(-2.2, 0.6 * (i - 1), 0.1 * i)) for i in range(3)]
        for k in range(60):
            place = 1.2 * (k % 5), 1.2 * (k // 5 % 5 - 2), 1.2 * (k // 25 - 1)
            self.world.add(block(f"block {k}", random.uniform(0.5, 1, 3)), (place, random.normal(size=4)), is_static=True)

    def fly(self, frames=12):
        """Every bit of what the frames say, the most pairs a frame, and how often a mover was cut off."""
        bits, most, cut = b"", 0, 0
        for k in range(frames):
            moves = {m: ([0.4, 0.1 * np.sin(k + i), -0.05], [0.1, 0.2, 0.1]) for i, m in enumerate(self.movers)}
            report = self.world.frame(moves=moves)
            bits += report.events.tobytes() + report.felt.tobytes() + report.cut_off_movers.tobytes()
            most, cut = max(most, report.slide_pairs), cut + report.cut_off
            assert report.cut_off == len(report.cut_off_movers)
            assert set(report.cut_off_movers) <= {int(m) for m in self.movers}
        return bits + b"".join(self.world.pose(m).tobytes() for m in self.movers), most, cut


class Budgets(unittest.TestCase):
    def test_pairs_of_slides_are_cut_and_movers_named(self):
        _, free, cut = Heap().fly()
        self.assertEqual(cut, 0)
        self.assertGreater(free, 20)
        heap = Heap()
        heap.world.set_slide_budget(pairs=10)
        self.assertEqual(heap.world.slide_budget, {"pairs": 10, "seconds": None, "mover_work": 16384})
        _, most, cut = heap.fly()
        self.assertGreater(cut, 0)
        self.assertLess(most, free)
        heap.world.set_slide_budget()
        self.assertEqual(heap.world.slide_budget, {"pairs": None, "seconds": None, "mover_work": 16384})

    def test_work_of_a_mover_is_cut_or_not(self):
        free, _, cut = Heap().fly()
        self.assertEqual(cut, 0)
        heap = Heap()
        heap.world.set_slide_budget(mover_work=None)
        self.assertEqual(heap.world.slide_budget, {"pairs": None, "seconds": None, "mover_work": None})
        self.assertEqual(heap.fly()[0], free)
        heap.world.set_slide_budget(mover_work=1)
        self.assertGreater(heap.fly()[2], 0)

    def test_no_time_is_no_slide(self):
        heap = Heap()
        heap.world.set_slide_budget(seconds=0.0)
        _, _, cut = heap.fly()
        self.assertGreater(cut, 0)

    def test_budgets_that_are_none(self):
        world = touchstone.World()
        for seconds in (-1.0, np.nan):
            with self.assertRaisesRegex(InputError, "slide budget"):
                world.set_slide_budget(seconds=seconds)
        for pairs in (-1, 1.5, "many"):
            with self.assertRaises(TypeError):
                world.set_slide_budget(pairs=pairs)
        self.assertEqual(world.slide_budget, {"pairs": None, "seconds": None, "mover_work": 16384})


class Pools(unittest.TestCase):
    def test_frames_have_the_same_bits_on_any_threads(self):
        expected = Heap().fly()
        for threads in (1, 2, 5):
            heap = Heap()
            heap.world.set_thread_pool(touchstone.ThreadPool(threads))  # the world keeps it
            self.assertEqual(heap.fly(), expected, threads)
            heap.world.set_thread_pool(None)
            heap.world.set_threads(2)
            heap.fly(1)

    def test_worlds_of_several_threads_share_one_pool(self):
        expected = Heap().fly()
        pool = touchstone.ThreadPool(2)
        self.assertEqual(pool.threads, 2)
        found = {}

        def fly(name):
            heap = Heap()
            heap.world.set_thread_pool(pool)
            found[name] = heap.fly()

        threads = [threading.Thread(target=fly, args=(i,)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(found, {i: expected for i in range(4)})

    def test_pools_that_are_none(self):
        for threads in (0, 65):
            with self.assertRaisesRegex(InputError, f"threads: are {threads}, must be 1 to 64"):
                touchstone.ThreadPool(threads)
        with self.assertRaises(TypeError):
            touchstone.World().set_thread_pool(3)


if __name__ == "__main__":
    unittest.main()
