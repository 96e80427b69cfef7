"""What a program tells a running simulation: pushes, drives, latches, bodies that come and go, and back in time."""

import pathlib
import tempfile
import unittest

import numpy as np
import touchstone
from touchstone import InputError, JointDrive

UNIT = np.array([1.0, 0, 0, 0])


def block(name, size=(1, 1, 1)):
    return touchstone.HexahedronTree([("body", touchstone.Hexahedron.box(size), None)], name)


def at(x, y=0.0, z=0.0):
    return np.array([x, y, z], float), UNIT


def two_boxes(**more):
    scene = touchstone.DynamicScene("two boxes", 2.0, **more)
    scene.add(block("a"), at(0), mass=2.0)
    scene.add(block("b"), at(3), mass=2.0)
    return scene


def arm(**joint):
    """A bar of 2 kg, 1 m long, that turns about its middle, and a box that lies 3 m away."""
    scene = touchstone.DynamicScene("arm", 2.0)
    scene.add(block("bar", (1, 0.1, 0.1)), kind="link", mass=2.0)
    scene.add(block("box"), at(3), mass=1.0)
    scene.add_joint("hub", "axle", "bar", **joint)
    scene.add_body_joint("grip", "box", kind="revolute", holds=False)
    return scene


INERTIA = 2 * (1 + 0.01) / 12


def state(run):
    return run.poses.tobytes() + run.velocities.tobytes() + run.angular_velocities.tobytes()


class Commands(unittest.TestCase):
    def test_a_push_lasts_a_step(self):
        run = touchstone.Simulation(two_boxes())
        run.push("a", force=[2, 0, 0])  # at its origin
        run.push("a", force=[0, 4, 0], at=[1, 0, 0], moment=[0, 0, 1])  # turns it, by what a lever of 1 m adds
        run.advance(10)
        np.testing.assert_allclose(run.velocities[0], [1e-3, 2e-3, 0], atol=1e-15)
        np.testing.assert_allclose(run.angular_velocities[0], [0, 0, (4 + 1) * 1e-3 / (2 / 6)], atol=1e-12)

    def test_drives_and_values_are_set_at_once(self):
        run = touchstone.Simulation(arm())
        run.set_drive("hub.axle", JointDrive("torque", torque=0.1))
        run.advance(500)
        self.assertAlmostEqual(run.joint_rate("hub.axle"), 0.1 / INERTIA * 0.5, delta=1e-9)
        run.set_joint("hub.axle", 0.5, rate=-0.2)
        run.set_drive("hub.axle", JointDrive("torque"))
        run.advance(500)
        self.assertAlmostEqual(run.joint_value("hub.axle"), 0.5 - 0.2 * 0.5, delta=1e-9)

    def test_a_ramp_begins_when_it_is_set(self):
        run = touchstone.Simulation(arm())
        run.advance(1000)
        run.set_drive("hub.axle", JointDrive("torque", ramp=1.0))
        run.advance(500)
        self.assertAlmostEqual(run.joint_rate("hub.axle"), 0.5**2 / 2 / INERTIA, delta=1e-9)

    def test_latches_close_and_open(self):
        scene = two_boxes()
        scene.add_latch_option("b", "a", allowed=[("a", "b")])
        run = touchstone.Simulation(scene)
        run.push("a", force=[2000, 0, 0])
        run.advance(1)
        run.latch("b", carrier="a")
        run.advance(10)
        np.testing.assert_allclose(run.velocities[:, 0], [0.5, 0.5], atol=1e-12)
        run.release("b")
        run.push("a", force=[-2000, 0, 0])
        run.advance(10)
        np.testing.assert_allclose(run.velocities[:, 0], [-0.5, 0.5], atol=1e-12)

    def test_joints_between_bodies_join_and_part(self):
        run = touchstone.Simulation(arm())
        run.push("box", force=[1000, 0, 0])
        run.advance(1)
        run.join("grip")  # to the ground, by a hinge at its origin
        run.advance(5)
        np.testing.assert_allclose(run.velocities[1], [0, 0, 0], atol=1e-12)
        run.part("grip")
        run.push("box", force=[0, 1000, 0])
        run.advance(5)
        np.testing.assert_allclose(run.velocities[1], [0, 1, 0], atol=1e-12)

    def test_bodies_go_and_come(self):
        run = touchstone.Simulation(two_boxes(gravity=[0, 0, -10]))
        run.remove("b")
        run.advance(100)
        self.assertFalse(run.has("b"))
        self.assertEqual(run.poses[1][2, 3], 0.0)
        run.add("b", X_WO=at(0, 9, 5), velocity=[1, 0, 0])
        run.advance(100)
        self.assertTrue(run.has("b"))
        np.testing.assert_allclose(run.poses[1][:3, 3], [0.1, 9, 5 - 10 * 0.1**2 / 2], atol=1e-9)

    def test_touches_begin_go_on_and_end(self):
        scene = two_boxes()
        run = touchstone.Simulation(scene)
        with self.assertRaisesRegex(InputError, "watch_touches"):
            run.touches
        run.watch_touches()
        run.push("a", force=[2 * 4000, 0, 0])  # 4 m/s: there after 0.5 s; both go on with 2 m/s
        rows = []

        def go(steps):
            for _ in range(steps):
                run.advance()
                rows.extend((run.steps, row) for row in run.touches)

        go(1000)
        run.push("b", force=[2 * 4000, 0, 0])  # away
        go(20)
        self.assertEqual({(int(row["solid_a"]), int(row["solid_b"])) for _, row in rows}, {(0, 1)})
        first, last = rows[0][0], rows[-1][0]
        self.assertAlmostEqual(first, 500, delta=2)
        self.assertAlmostEqual(last, 1001, delta=2)
        self.assertEqual([(step, int(row["kind"])) for step, row in rows],
                         [(first, 0)] + [(step, 1) for step in range(first + 1, last)] + [(last, 2)])
        self.assertEqual([int(row["points"]) for _, row in rows], [4] * (len(rows) - 1) + [0])
        # On b: half of a's 8 N s, once.
        np.testing.assert_allclose(rows[0][1]["impulse_W"], [4, 0, 0], atol=1e-9)
        np.testing.assert_allclose(rows[0][1]["impact_W"], [4, 0, 0], atol=1e-9)
        np.testing.assert_allclose([row["impulse_W"] for _, row in rows[1:]], 0, atol=1e-9)

    def test_what_sleeps_goes_on_touching(self):
        scene = touchstone.DynamicScene("sleeper", 2.0, gravity=[0, 0, -10])
        scene.sleep_time = 0.2
        scene.add(block("ground", (4, 4, 1)), at(0, 0, -0.5), kind="static")
        scene.add(block("box"), at(0, 0, 0.5), mass=1.0)
        run = touchstone.Simulation(scene)
        run.watch_touches()
        kinds, points = [], []
        for _ in range(1000):
            run.advance()
            self.assertEqual(len(run.touches), 1)
            kinds.append(int(run.touches["kind"][0]))
            points.append(int(run.touches["points"][0]))
        self.assertEqual(points[-1], 0)  # asleep
        self.assertEqual(kinds, [0] + [1] * (len(kinds) - 1))
        np.testing.assert_allclose(run.touches["impulse_W"], [[0, 0, 10 * scene.step]], atol=1e-9)
        run.push("box", force=[0, 0, 4000])  # 4 m/s up
        run.advance(10)
        self.assertEqual(len(run.touches), 0)

    def test_what_is_removed_beside_a_sleeper_ends_touching(self):
        scene = touchstone.DynamicScene("sleepers", 2.0, gravity=[0, 0, -10])
        scene.sleep_time = 0.2
        scene.add(block("ground", (9, 4, 1)), at(0, 0, -0.5), kind="static")
        for name, x in (("box", 0), ("other", 3)):
            scene.add(block(name), at(x, 0, 0.5), mass=1.0)
        run = touchstone.Simulation(scene)
        run.watch_touches()
        run.advance(1000)
        self.assertEqual(sorted(run.touches["kind"]), [1, 1])
        run.remove("box")
        run.advance()
        self.assertEqual(sorted(zip(run.touches["solid_b"], run.touches["kind"])), [(1, 2), (2, 1)])
        run.advance()
        self.assertEqual(list(zip(run.touches["solid_b"], run.touches["kind"])), [(2, 1)])


class AFailedAction(unittest.TestCase):
    SCENE = """name: two
units: {length: m, angle: deg}
frame_rate: 50
contact_gap: 1.0e-9
policy: cue
duration: 0.2
objects:
  - {name: a, pose: {position: [0, 0, 0]}, hexahedra: [{name: a, box: {size: [1, 1, 1]}}]}
  - {name: b, pose: {position: [3, 0, 0]}, hexahedra: [{name: b, box: {size: [1, 1, 1]}}]}
dynamics:
  step: 0.001
  bodies: [{object: a, kind: dynamic, mass: 1}, {object: b, kind: dynamic, mass: 1}]
  actions: [{time: 0.1, latch: {carrier: a, carried: b}}]
"""

    def test_the_run_goes_on_once_it_has_its_place(self):
        if not hasattr(touchstone, "load_dynamic_scene"):
            self.skipTest("built without scene files")
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "two.yaml")
            path.write_text(self.SCENE)
            run = touchstone.Simulation(touchstone.load_dynamic_scene(str(path)))
        run.latch("b", "a")
        for _ in range(2):
            with self.assertRaisesRegex(RuntimeError, "latch: object 'b'"):
                run.advance(150)
            self.assertEqual(run.steps, 100)
        run.release("b")
        self.assertEqual(run.advance(50), 50)


class BackInTime(unittest.TestCase):
    def test_restored_and_reset_runs_have_the_same_bits(self):
        for check in ("own:native", "bullet", "ode", "mujoco"):
            if check.split(":")[0] not in touchstone.engines():
                continue
            with self.subTest(check):
                scene = touchstone.DynamicScene("tower", 2.0, gravity=[0, 0, -9.81])
                scene.add(block("ground", (20, 20, 1)), at(0, 0, -0.5), kind="static")
                for i in range(3):
                    scene.add(block(f"box {i}"), at(0.1 * i, 0, 0.5 + 1.01 * i), mass=1.0 + i)
                run = touchstone.Simulation(scene, check)
                run.advance(300)
                first = state(run)
                kept = run.snapshot()
                runs = []
                for _ in range(3):  # the first is the run that went on
                    run.advance(200)
                    runs.append(state(run))
                    run.restore(kept)
                    self.assertEqual(run.steps, 300)
                self.assertEqual(state(run), first)
                self.assertIn(run.after_restore, ("same bits", "repeatable"))
                self.assertEqual(runs[1], runs[2])
                if run.after_restore == "same bits":
                    self.assertEqual(runs[0], runs[1])
                run.reset()
                run.advance(300)
                self.assertEqual(state(run), first)

    def test_a_snapshot_of_another_run_is_refused(self):
        one, other = (touchstone.Simulation(two_boxes()) for _ in range(2))
        for snapshot in (other.snapshot(), touchstone.Simulation(two_boxes()).snapshot()):
            with self.assertRaisesRegex(InputError, "of another"):
                one.restore(snapshot)


class Errors(unittest.TestCase):
    def test_what_is_refused_changes_nothing(self):
        run = touchstone.Simulation(arm(lower=-1, upper=1))
        nan = float("nan")
        for text, call in (
            ("no object", lambda: run.push("nobody", force=[1, 0, 0])),
            ("not finite", lambda: run.push("box", force=[nan, 0, 0])),
            ("not finite", lambda: run.push("box", force=[1, 0, 0], at=[nan, 0, 0])),
            ("force", lambda: run.push("box", force=[1, 0])),
            ("no joint", lambda: run.set_drive("knee", JointDrive())),
            ("drive", lambda: run.set_drive("hub.axle", JointDrive("torque", torque=nan))),
            ("limit", lambda: run.set_drive("hub.axle", JointDrive("brake", limit=-1.0))),
            ("limits", lambda: run.set_joint("hub.axle", 2.0)),
            ("limits", lambda: run.set_joint("hub.axle", nan)),
            ("limits", lambda: run.set_joint("hub.axle", 0.0, rate=nan)),
            ("joints of mechanisms", lambda: run.set_joint("grip", 0.0)),
            ("no joint between bodies", lambda: run.join("hub.axle")),
            ("not carried", lambda: run.release("box")),
            ("held by joint 'grip'", lambda: run.latch("box", carrier="bar")),
            ("only dynamic", lambda: run.latch("bar", carrier="box")),
            ("held by joint 'grip'", lambda: run.remove("box")),
            ("not dynamic", lambda: run.remove("bar")),
            ("is there already", lambda: run.add("box")),
        ):
            with self.subTest(text), self.assertRaisesRegex(InputError, text):
                call()
        run.advance(100)
        fresh = touchstone.Simulation(arm(lower=-1, upper=1))
        fresh.advance(100)
        self.assertEqual(state(run), state(fresh))

    def test_bodies_that_a_latch_holds_stay(self):
        scene = two_boxes()
        run = touchstone.Simulation(scene)
        run.latch("b", carrier="a")
        for text, call in (("is carried", lambda: run.remove("b")), ("carries another", lambda: run.remove("a")),
                           ("already carried", lambda: run.latch("b", carrier="a")), ("cycle", lambda: run.latch("a", carrier="b"))):
            with self.subTest(text), self.assertRaisesRegex(InputError, text):
                call()
        run.release("b")
        run.remove("b")
        with self.assertRaisesRegex(InputError, "not in the world"):
            run.latch("b", carrier="a")
        with self.assertRaisesRegex(InputError, "not finite"):
            run.add("b", velocity=[float("inf"), 0, 0])
        self.assertFalse(run.has("b"))

    def test_engines_name_what_they_lack(self):
        for name in touchstone.engines():
            with self.subTest(name):
                scene = touchstone.DynamicScene("hinge", 1.0)
                scene.add(block("bar"), kind="link", mass=1.0)
                scene.add_joint("hub", "axle", "bar")
                try:
                    run = touchstone.Simulation(scene, name)
                except InputError as error:  # no arms at all
                    self.assertIn("unsupported: arms", str(error))
                    continue
                drive = JointDrive("position", stiffness=10.0)
                if name == "own":
                    run.set_drive("hub.axle", drive)
                    continue
                with self.assertRaisesRegex(InputError, "unsupported: drives of a stiffness"):
                    run.set_drive("hub.axle", drive)


if __name__ == "__main__":
    unittest.main()
