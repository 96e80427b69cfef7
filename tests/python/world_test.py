"""Objects, mechanisms, rules, frames and events."""

import threading
import unittest

import numpy as np
import touchstone
from touchstone import EventKind, InputError

UNIT = np.array([1.0, 0, 0, 0])


def block(name, size=(1, 1, 1)):
    return touchstone.HexahedronTree([("body", touchstone.Hexahedron.box(size), None)], name)


def at(x, y=0.0, z=0.0):
    return np.array([x, y, z], float), UNIT


def two_links():
    """A metre each; the elbow turns about z at x = 1."""
    bar = touchstone.Hexahedron.box([1, 0.1, 0.1])
    links = [touchstone.Link("base"), touchstone.Link("upper", [("bar", bar, at(0.5))], mass=2.0),
             touchstone.Link("lower", [("bar", bar, at(0.6))])]
    joints = [touchstone.Joint("shoulder", "revolute", "base", "upper", lower=-3, upper=3),
              touchstone.Joint("elbow", "revolute", "upper", "lower", X_PJ=at(1.0), axis=[0, 0, 1])]
    return touchstone.Mechanism("arm", links, joints)


class Frames(unittest.TestCase):
    def setUp(self):
        self.world = touchstone.World(gap=1e-6)
        self.box = self.world.add(block("box"))
        self.wall = self.world.add(block("wall", (1, 4, 4)), at(3.0), is_static=True)

    def gap(self):
        check = touchstone.Narrowphase("native", [touchstone.Hexahedron.box([1, 1, 1]), touchstone.Hexahedron.box([1, 4, 4])])
        poses = np.stack([self.world.pose(self.box), self.world.pose(self.wall)])
        return check.distance(poses, [[0, 1]]).geometry["separation"][0]

    def test_a_free_way_is_gone(self):
        report = self.world.frame({self.box: at(1.5, 0.25)})
        np.testing.assert_array_equal(self.world.pose(self.box)[:3, 3], [1.5, 0.25, 0])
        self.assertEqual((report.blocked_movers, len(report.events), report.is_proven), (0, 0, True))

    def test_advance_stops_at_the_gap_and_says_so(self):
        self.world.set_default_rule(policy="advance")
        report = self.world.frame({self.box: at(10.0)})  # through the wall and beyond
        self.assertEqual(report.blocked_movers, 1)
        self.assertTrue(0.5e-6 <= self.gap() <= 1e-6, self.gap())
        kinds = [EventKind(kind) for kind in report.events["kind"]]
        self.assertIn(EventKind.BEGAN, kinds)
        self.assertIn(EventKind.BLOCKED, kinds)
        began = report.events[kinds.index(EventKind.BEGAN)]
        self.assertEqual({int(began["a"]), int(began["b"])}, {int(self.box), int(self.wall)})
        self.assertEqual(touchstone.Object(int(began["a"])), self.box)
        np.testing.assert_allclose(np.abs(began["n_AB_W"]), [1, 0, 0], atol=1e-12)
        self.assertAlmostEqual(began["s"], 0.2, delta=1e-6)
        np.testing.assert_array_equal(self.world.commanded_pose(self.box)[:3, 3], [10, 0, 0])

    def test_hold_does_not_begin_a_step_that_would_meet(self):
        self.world.set_default_rule(policy="hold")
        self.world.frame({self.box: at(10.0)})
        np.testing.assert_array_equal(self.world.pose(self.box), np.eye(4))

    def test_slide_goes_along_the_wall(self):
        self.world.set_pair_rule(self.box, self.wall, policy="slide")
        self.world.frame({self.box: at(2.5, 1.0)})
        x, y, _ = self.world.pose(self.box)[:3, 3]
        self.assertAlmostEqual(x, 2.0, delta=2e-6)
        self.assertAlmostEqual(y, 1.0, delta=1e-3)

    def test_cue_lets_through_and_tells(self):
        self.world.set_default_rule(policy="cue", warn_distance=0.25)
        self.assertEqual(self.world.rule_of(self.box, self.wall),
                         {"policy": "cue", "warn_distance": 0.25, "translation_only": False, "passive": "stays"})
        near = self.world.frame({self.box: at(1.9)})
        self.assertEqual([EventKind(k) for k in near.events["kind"]], [EventKind.NEAR])
        self.assertAlmostEqual(near.events["separation"][0], 0.1, delta=1e-9)
        inside = self.world.frame({self.box: at(2.5)})
        self.assertIn(EventKind.BEGAN, [EventKind(k) for k in inside.events["kind"]])
        self.assertAlmostEqual(self.world.pose(self.box)[0, 3], 2.5)
        out = self.world.frame({self.box: at(0.0)})
        self.assertIn(EventKind.ENDED, [EventKind(k) for k in out.events["kind"]])

    def test_a_move_turns_by_axis_times_angle(self):
        self.world.frame(moves={self.box: ([0.5, 0, 0], [0, 0, np.pi / 2])})
        X = self.world.pose(self.box)
        np.testing.assert_allclose(X[:3, :3], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-12)
        np.testing.assert_allclose(X[:3, 3], [0.5, 0, 0], atol=1e-15)

    def test_what_is_off_is_not_checked(self):
        self.world.select(False, self.box, self.wall)
        self.world.frame({self.box: at(10.0)})
        self.assertEqual(self.world.pose(self.box)[0, 3], 10.0)
        self.world.reset()
        self.world.exempt(self.box, self.wall)
        self.world.frame({self.box: at(10.0)})
        self.assertEqual(self.world.pose(self.box)[0, 3], 10.0)
        self.world.unexempt(self.box, self.wall)
        self.world.set_default_rule(policy="advance")
        self.world.frame({self.box: at(0.0)})
        self.assertGreater(self.world.pose(self.box)[0, 3], 4.0)

    def test_a_load_goes_along_and_stops_its_carrier(self):
        self.world.set_default_rule(policy="advance")
        load = self.world.add(block("load", (0.5, 0.5, 0.5)), at(0.75))
        self.world.latch(self.box, load)
        self.world.frame({self.box: at(10.0)})
        self.assertAlmostEqual(self.world.pose(self.box)[0, 3], 1.5, delta=1e-5)
        self.assertAlmostEqual(self.world.pose(load)[0, 3], 2.25, delta=1e-5)
        self.world.unlatch(load)

    def test_reports_outlive_their_frame(self):
        self.world.set_default_rule(policy="advance")
        events = self.world.frame({self.box: at(10.0)}).events
        expected = events.tobytes()
        self.world.frame({self.box: at(0.0)})
        self.assertEqual(events.tobytes(), expected)

    def test_two_runs_have_the_same_bits(self):
        def run():
            world = touchstone.World()
            random = np.random.default_rng(8)
            boxes = [world.add(block(f"b{i}"), at(1.5 * i)) for i in range(6)]
            world.set_default_rule(policy="slide")
            events = b""
            for _ in range(10):
                moves = {b: (random.uniform(-1, 1, 3), random.uniform(-1, 1, 3)) for b in boxes}
                events += world.frame(moves=moves).events.tobytes()
            return events + b"".join(world.pose(b).tobytes() for b in boxes)

        self.assertEqual(run(), run())


class Mechanisms(unittest.TestCase):
    def test_links_are_where_joints_have_them(self):
        arm = two_links()
        self.assertEqual((arm.links, arm.joints), (["base", "upper", "lower"], ["shoulder", "elbow"]))
        poses = arm.link_poses([np.pi / 2, -np.pi / 2])
        np.testing.assert_allclose(poses[2], [[1, 0, 0, 0], [0, 1, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1]], atol=1e-12)
        with self.assertRaisesRegex(InputError, "2 joint values"):
            arm.link_poses([0.0])

    def test_an_arm_stops_at_a_wall_as_one(self):
        world = touchstone.World()
        arm = world.add_mechanism(two_links())
        world.add(block("wall", (4, 1, 1)), at(1.0, 1.5), is_static=True)
        world.set_default_rule(policy="advance")
        report = world.frame(joints={arm: [np.pi / 2, 0.0]})
        q = world.joint_values(arm)
        self.assertEqual(report.blocked_movers, 1)
        self.assertEqual(q[1], 0.0)
        reach = np.array([2.1, 0.05])  # the tip's upper corner touches y = 1
        self.assertAlmostEqual(reach @ [np.sin(q[0]), np.cos(q[0])], 1.0, delta=1e-5)
        np.testing.assert_array_equal(world.commanded_joints(arm), [np.pi / 2, 0])
        np.testing.assert_array_equal(world.link_poses(arm), two_links().link_poses(q))
        self.assertEqual(world.name_of(world.link(arm, "upper")), "arm.upper")

    def test_limits_are_told(self):
        world = touchstone.World()
        arm = world.add_mechanism(two_links())
        report = world.frame(joints={arm: [5.0, 0.0]})
        self.assertIn(EventKind.AT_LIMIT, [EventKind(k) for k in report.events["kind"]])
        self.assertAlmostEqual(world.joint_values(arm)[0], 3.0)

    def test_mechanisms_that_are_none(self):
        with self.assertRaisesRegex(InputError, "elbow"):
            touchstone.Mechanism("m", [touchstone.Link("a")], [touchstone.Joint("elbow", "revolute", "a", "b")])
        with self.assertRaisesRegex(InputError, "none of fixed, revolute, prismatic"):
            touchstone.Joint("j", "ball", "a", "b")


class Errors(unittest.TestCase):
    def setUp(self):
        self.world = touchstone.World()
        self.box = self.world.add(block("box"))

    def test_names_and_handles(self):
        with self.assertRaisesRegex(InputError, "box"):
            self.world.add(block("box"))
        with self.assertRaises(InputError):
            self.world.find("nobody")
        self.assertEqual(self.world.find("box"), self.box)
        self.world.remove(self.box)
        self.assertFalse(self.world.is_alive(self.box))
        with self.assertRaises(InputError):
            self.world.pose(self.box)
        with self.assertRaises(InputError):
            self.world.frame({self.box: at(1.0)})

    def test_rules_and_worlds(self):
        with self.assertRaisesRegex(InputError, "'push' is none of cue, hold, advance, slide"):
            self.world.set_default_rule(policy="push")
        with self.assertRaises(InputError):
            self.world.set_default_rule(warn_distance=-1.0)
        with self.assertRaises(InputError):
            touchstone.World(gap=0.0)
        with self.assertRaises(InputError):
            touchstone.World(narrowphase="nobody's")
        with self.assertRaises(TypeError):
            self.world.select(True, 1, 2, 3)

    def test_bad_poses_move_nothing(self):
        for bad in (np.full((4, 4), np.nan), 2 * np.eye(4), ([0, 0, np.inf], UNIT)):
            with self.assertRaises(InputError):
                self.world.frame({self.box: bad})
        np.testing.assert_array_equal(self.world.pose(self.box), np.eye(4))
        report = self.world.frame(moves={self.box: ([np.nan, 0, 0], [0, 0, 0])})
        self.assertEqual([EventKind(k) for k in report.events["kind"]], [EventKind.REFUSED])

    def test_executed_poses_are_of_the_last_frame(self):
        self.world.frame({self.box: at(1.0)})
        self.assertEqual(self.world.executed_parts(), 1)
        np.testing.assert_allclose(self.world.executed_pose(self.box, 0, 0.5)[:3, 3], [0.5, 0, 0])
        for part, s in ((1, 0.5), (0, 1.5), (0, np.nan)):
            with self.assertRaises(InputError):
                self.world.executed_pose(self.box, part, s)

    def test_a_second_thread_is_refused_and_may_select(self):
        for i in range(40):
            self.world.add(block(f"b{i}"), at(0, 1.01 * i + 1.01))
        self.world.set_default_rule(policy="slide")
        refused, stop = [], threading.Event()

        def look():
            while not stop.is_set():
                self.world.select(True)
                try:
                    self.world.pose(self.box)
                except RuntimeError as error:
                    refused.append(str(error))

        thread = threading.Thread(target=look)
        thread.start()
        try:
            for i in range(200):
                try:
                    self.world.frame(moves={self.box: ([0.01, 0.1, 0], [0, 0, 0.01])})
                except RuntimeError:
                    self.fail("only one thread is in frames")
                if refused:
                    break
        finally:
            stop.set()
            thread.join()
        for text in refused:
            self.assertIn("in use by another thread", text)


if __name__ == "__main__":
    unittest.main()
