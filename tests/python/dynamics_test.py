"""Scenes, steps and states, held against closed forms."""

import os
import pathlib
import unittest

import numpy as np
import touchstone
from touchstone import InputError

UNIT = np.array([1.0, 0, 0, 0])
SCENES = pathlib.Path(os.environ["TOUCHSTONE_SOURCE"]) / "examples" / "dynamics_run" / "scenes"


def block(name, size=(1, 1, 1)):
    return touchstone.HexahedronTree([("body", touchstone.Hexahedron.box(size), None)], name)


def at(x, y=0.0, z=0.0):
    return np.array([x, y, z], float), UNIT


def on_the_ground(duration=1.0, velocity=None, friction=0.5):
    scene = touchstone.DynamicScene("on the ground", duration, step=1e-3, gravity=[0, 0, -9.81])
    scene.add(block("ground", (20, 20, 1)), at(0, 0, -0.5), kind="static", friction=friction)
    scene.add(block("box"), at(0, 0, 0.5), mass=2.0, velocity=velocity, friction=friction)
    return scene


class ClosedForms(unittest.TestCase):
    def test_free_fall_is_a_parabola(self):
        scene = touchstone.DynamicScene("fall", 1.0, gravity=[0, 0, -9.81])
        scene.add(block("stone"), mass=1.0, velocity=[1, 0, 5])
        run = touchstone.Simulation(scene)
        self.assertEqual(run.advance(250), 250)
        self.assertAlmostEqual(run.time, 0.25)
        np.testing.assert_allclose(run.poses[0][:3, 3], [0.25, 0, 5 * 0.25 - 9.81 / 2 * 0.25**2], atol=1e-12)
        np.testing.assert_allclose(run.velocities[0], [1, 0, 5 - 9.81 * 0.25], atol=1e-12)

    def test_a_box_at_rest_presses_with_its_weight(self):
        run = touchstone.Simulation(on_the_ground())
        run.advance(100)
        contacts = run.contacts
        self.assertEqual(len(contacts), 4)
        np.testing.assert_allclose(np.abs(contacts["force_W"].sum(axis=0)), [0, 0, 2 * 9.81], atol=1e-9)
        self.assertTrue(np.isnan(run.velocities[0]).all())  # the ground has none
        self.assertEqual(run.last_step["contacts"], 4)

    def test_a_sliding_box_stops_where_friction_says(self):
        run = touchstone.Simulation(on_the_ground(velocity=[2, 0, 0]))
        run.advance(1000)
        self.assertTrue(run.is_over)
        self.assertAlmostEqual(run.poses[1][0, 3], 2.0**2 / (2 * 0.5 * 9.81), delta=1e-6)
        self.assertEqual(run.advance(5), 0)

    def test_a_bump_keeps_momentum(self):
        scene = touchstone.DynamicScene("bump", 1.0)
        scene.add(block("a"), at(0), mass=1.0, velocity=[2, 0, 0], restitution=1.0)
        scene.add(block("b"), at(1.5), mass=1.0, restitution=1.0)
        run = touchstone.Simulation(scene)
        run.advance(500)
        np.testing.assert_allclose(run.velocities, [[0, 0, 0], [2, 0, 0]], atol=1e-9)
        np.testing.assert_allclose(run.linear_momentum, [2, 0, 0], atol=1e-12)
        self.assertAlmostEqual(run.energy, 2.0, delta=1e-9)
        self.assertLess(run.worst_depth, 1e-6)

    def test_one_step_at_a_time_has_the_bits_of_many(self):
        one, many = (touchstone.Simulation(on_the_ground(velocity=[2, 1, 0])) for _ in range(2))
        for _ in range(300):
            one.advance()
        many.advance(300)
        self.assertEqual(one.poses.tobytes(), many.poses.tobytes())


class Engines(unittest.TestCase):
    def test_each_engine_lets_a_box_rest(self):
        for name, (description, checks) in touchstone.engines().items():
            for check in checks[:2]:
                with self.subTest(engine=name, check=check):
                    choice = name if check == "own" else f"{name}:{check}"
                    run = touchstone.Simulation(on_the_ground(), choice)
                    run.advance(200)
                    self.assertTrue(description)
                    self.assertAlmostEqual(run.poses[1][2, 3], 0.5, delta=2e-3)

    def test_files_have_names_joints_and_state(self):
        if not hasattr(touchstone, "load_dynamic_scene"):
            self.skipTest("this build reads no scene files (libyaml-cpp-dev)")
        scene = touchstone.load_dynamic_scene(str(SCENES / "09_elbow_saturates.yaml"))
        self.assertTrue(scene.joints)
        run = touchstone.Simulation(scene)
        before = [run.joint_value(name) for name in scene.joints]
        run.advance(50)
        self.assertNotEqual(before, [run.joint_value(name) for name in scene.joints])
        self.assertEqual(run.poses.shape, (len(scene.objects), 4, 4))
        with self.assertRaisesRegex(InputError, "no joint"):
            run.joint_rate("knee")
        with self.assertRaisesRegex(InputError, "nowhere.yaml"):
            touchstone.load_dynamic_scene("nowhere.yaml")


class Errors(unittest.TestCase):
    def test_bodies_that_are_none(self):
        scene = touchstone.DynamicScene("errors", 1.0)
        for named, text in (({}, "no mass"), ({"mass": -1.0}, "mass"), ({"mass": 1.0, "density": 1.0}, "density"),
                            ({"mass": 1.0, "kind": "ghost"}, "none of static, dynamic")):
            with self.assertRaisesRegex(InputError, text):
                scene.add(block("box"), **named)
        self.assertEqual(scene.objects, [])
        scene.add(block("box"), mass=1.0)
        with self.assertRaisesRegex(InputError, "box"):
            scene.add(block("box"), mass=1.0)

    def test_scenes_and_engines(self):
        scene = touchstone.DynamicScene("errors", 1.0)
        with self.assertRaises(InputError):
            touchstone.Simulation(scene)  # nothing in it
        scene.add(block("box"), mass=1.0)
        with self.assertRaisesRegex(InputError, "own"):
            touchstone.Simulation(scene, "nobody's")
        with self.assertRaises(InputError):
            touchstone.Simulation(scene, "own:nobody's")
        scene.contact_margin = float("nan")
        with self.assertRaises(InputError):
            touchstone.Simulation(scene)

    def test_a_run_keeps_the_scene_that_it_was_made_with(self):
        scene = on_the_ground()
        run = touchstone.Simulation(scene)
        scene.add(block("late"), at(5, 0, 5), mass=1.0)
        run.advance(10)
        self.assertEqual(len(run.poses), 2)


if __name__ == "__main__":
    unittest.main()
