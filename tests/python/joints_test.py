"""Joints and actions of scenes of dynamics made by hand: closed forms, and the same bits as from a file."""

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


def rotor(drive, duration=1.0, **joint):
    """A bar of 2 kg, 1 m long, that turns about its middle: 2 (1^2 + 0.1^2) / 12 kg m2."""
    scene = touchstone.DynamicScene("rotor", duration)
    scene.add(block("bar", (1, 0.1, 0.1)), kind="link", mass=2.0)
    scene.add_joint("hub", "axle", "bar", drive=drive, **joint)
    return scene


INERTIA = 2 * (1 + 0.01) / 12

FILE = """
name: by file
duration: 1
dynamics:
  step: 0.001
  gravity: [0, 0, -9.81]
  bodies:
    - {object: upper, mass: 2}
    - {object: lower, mass: 1}
    - {object: load, kind: dynamic, mass: 0.5}
  mechanisms:
    - name: arm
      joints:
        - {name: shoulder, kind: revolute, child: upper, position: [0, 0, 0], axis: [0, 2, 0], friction: 0.1}
        - {name: elbow, kind: revolute, parent: upper, child: lower, position: [1, 0, 0], axis: [0, 1, 0],
           limits: {position: [-1, 1], torque: 50}, drive: {brake: 4}, damping: 0.2, rotor: 0.1}
  joints:
    - {name: grip, kind: fixed, parent: lower, child: load}
  actions:
    - {time: 0.2, drive: {joint: arm.elbow, position: 0.5, stiffness: 30, damping: 3}}
    - {time: 0.5, part: grip}
units: {length: m, angle: rad}
frame_rate: 1000
contact_gap: 1.0e-9
policy: hold
objects:
  - {name: upper, pose: {position: [0.5, 0, 0]}, hexahedra: [{name: body, box: {size: [1, 0.1, 0.1]}}]}
  - {name: lower, pose: {position: [1.5, 0, 0]}, hexahedra: [{name: body, box: {size: [1, 0.1, 0.1]}}]}
  - {name: load, pose: {position: [2.2, 0, 0]}, hexahedra: [{name: body, box: {size: [0.2, 0.2, 0.2]}}]}
"""


def arm_by_hand():
    """As FILE says."""
    scene = touchstone.DynamicScene("by hand", 1.0, gravity=[0, 0, -9.81])
    scene.add(block("upper", (1, 0.1, 0.1)), at(0.5), kind="link", mass=2.0)
    scene.add(block("lower", (1, 0.1, 0.1)), at(1.5), kind="link", mass=1.0)
    scene.add(block("load", (0.2, 0.2, 0.2)), at(2.2), mass=0.5)
    scene.add_joint("arm", "shoulder", "upper", position=[0, 0, 0], axis=[0, 2, 0], friction=0.1)
    scene.add_joint("arm", "elbow", "lower", parent="upper", position=[1, 0, 0], axis=[0, 1, 0], lower=-1, upper=1, effort=50,
                    drive=JointDrive("brake", limit=4), damping=0.2, rotor=0.1)
    scene.add_body_joint("grip", "load", parent="lower")
    scene.act(0.5, "part", "grip")
    scene.act(0.2, "drive", "arm.elbow", drive=JointDrive("position", position=0.5, stiffness=30, damping=3))  # sorted by time
    return scene


class ClosedForms(unittest.TestCase):
    def test_a_torque_turns_a_bar(self):
        run = touchstone.Simulation(rotor(JointDrive("torque", torque=0.1)))
        run.advance(500)
        self.assertAlmostEqual(run.joint_rate("hub.axle"), 0.1 / INERTIA * 0.5, delta=1e-9)
        self.assertAlmostEqual(run.joint_value("hub.axle"), 0.1 / INERTIA * 0.5**2 / 2, delta=1e-3 * 0.1 / INERTIA * 0.5)
        self.assertAlmostEqual(run.joint_torque("hub.axle"), 0.1, delta=1e-12)

    def test_a_rate_is_followed_until_the_brake_closes(self):
        scene = rotor(JointDrive("rate", rate=2.0, limit=1e6), value=0.25)
        scene.act(0.5, "drive", "hub.axle", drive=JointDrive("brake", limit=1e6))
        run = touchstone.Simulation(scene)
        run.advance(500)
        # It starts and stops with the torque of the limit, as far on each time.
        ramp = INERTIA * 2.0**2 / (2 * 1e6)
        self.assertAlmostEqual(run.joint_value("hub.axle"), 0.25 + 2.0 * 0.5 - ramp, delta=1e-10)
        run.advance(500)
        self.assertAlmostEqual(run.joint_value("hub.axle"), 0.25 + 2.0 * 0.5, delta=1e-10)

    def test_a_slider_stops_at_its_limit(self):
        scene = touchstone.DynamicScene("slider", 1.0)
        scene.add(block("cart"), kind="link", mass=1.0)
        scene.add_joint("rail", "run", "cart", kind="prismatic", axis=[3, 0, 0], rate=1.0, upper=0.25)
        run = touchstone.Simulation(scene)
        run.advance(200)
        self.assertAlmostEqual(run.poses[0][0, 3], 0.2, delta=1e-12)
        run.advance(800)
        self.assertAlmostEqual(run.joint_value("rail.run"), 0.25, delta=1e-6)

    def test_what_is_joined_moves_as_one_until_it_is_parted(self):
        scene = touchstone.DynamicScene("joined", 1.0)
        scene.add(block("a"), at(0), mass=1.0, velocity=[1, 0, 0])
        scene.add(block("b"), at(2), mass=1.0, velocity=[-1, 0, 0])
        scene.add_body_joint("rod", "b", parent="a", kind="fixed")
        scene.act(0.5, "part", "rod")
        run = touchstone.Simulation(scene)
        run.advance(400)
        np.testing.assert_allclose(run.velocities[:, 0], [0, 0], atol=1e-9)
        np.testing.assert_allclose(run.linear_momentum, [0, 0, 0], atol=1e-12)

    def test_a_latched_box_goes_along_and_is_let_go(self):
        scene = touchstone.DynamicScene("latched", 1.0)
        scene.add(block("carrier"), at(0), mass=1.0, velocity=[1, 0, 0])
        scene.add(block("box"), at(3), mass=1.0)
        scene.act(0.25, "latch", "box", carrier="carrier")
        scene.act(0.75, "release", "box")
        run = touchstone.Simulation(scene)
        run.advance(200)
        np.testing.assert_allclose(run.velocities[:, 0], [1, 0], atol=1e-12)
        run.advance(300)
        np.testing.assert_allclose(run.velocities[:, 0], [0.5, 0.5], atol=1e-9)  # an inelastic capture
        run.advance(400)
        np.testing.assert_allclose(run.velocities[:, 0], [0.5, 0.5], atol=1e-9)

    def test_an_object_that_is_brought_in_falls_from_then_on(self):
        scene = touchstone.DynamicScene("late", 1.0, gravity=[0, 0, -10])
        scene.add(block("stone"), at(0, 0, 5), mass=1.0)
        scene.act(0.5, "add", "stone")
        run = touchstone.Simulation(scene)
        run.advance(900)
        self.assertAlmostEqual(run.poses[0][2, 3], 5 - 10 * 0.4**2 / 2, delta=1e-9)


class AsAFile(unittest.TestCase):
    def test_a_scene_by_hand_has_the_bits_of_the_same_one_from_a_file(self):
        if not hasattr(touchstone, "load_dynamic_scene"):
            self.skipTest("this build reads no scene files (libyaml-cpp-dev)")
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "arm.yaml"
            path.write_text(FILE)
            of_file = touchstone.load_dynamic_scene(str(path))
        by_hand = arm_by_hand()
        self.assertEqual(by_hand.joints, ["arm.shoulder", "arm.elbow", "grip"])
        self.assertEqual(by_hand.joints, of_file.joints)
        one, other = touchstone.Simulation(by_hand), touchstone.Simulation(of_file)
        for _ in range(10):
            one.advance(100), other.advance(100)
            self.assertEqual(one.poses.tobytes(), other.poses.tobytes())
        self.assertGreater(abs(one.joint_value("arm.shoulder")), 0.1)


class Errors(unittest.TestCase):
    def test_joints_that_are_none(self):
        scene = rotor(JointDrive())
        for text, call in ((r"nobody", lambda: scene.add_joint("hub", "knee", "nobody")),
                           (r"hub\.axle.*there already", lambda: scene.add_joint("hub", "axle", "bar")),
                           (r"none of fixed, revolute, prismatic$", lambda: scene.add_joint("hub", "knee", "bar", kind="ball")),
                           (r"axis.*no direction", lambda: scene.add_joint("hub", "knee", "bar", axis=[0, 0, 0])),
                           (r"none of torque, rate, brake, position", lambda: JointDrive("hover")),
                           (r"none of fixed, revolute, prismatic, ball", lambda: scene.add_body_joint("rod", "bar", kind="rope"))):
            with self.assertRaisesRegex(InputError, text):
                call()
        self.assertEqual(scene.joints, ["hub.axle"])
        scene.add_joint("hub", "again", "bar")  # moved by two joints
        with self.assertRaisesRegex(InputError, "bar"):
            touchstone.Simulation(scene)

    def test_actions_that_are_none(self):
        scene = rotor(JointDrive())
        drive = JointDrive("brake")
        for text, call in ((r"no joint", lambda: scene.act(0, "drive", "bar", drive=drive)),
                           (r"no object", lambda: scene.act(0, "add", "hub.axle")),
                           (r"none of drive, set", lambda: scene.act(0, "dance", "bar")),
                           (r"drive: is for", lambda: scene.act(0, "drive", "hub.axle")),
                           (r"drive: is for", lambda: scene.act(0, "add", "bar", drive=drive)),
                           (r"carrier: is for", lambda: scene.act(0, "latch", "bar")),
                           (r"no object", lambda: scene.act(0, "latch", "bar", carrier="nobody")),
                           (r"value: is for", lambda: scene.act(0, "set", "hub.axle")),
                           (r"value: is for", lambda: scene.act(0, "drive", "hub.axle", drive=drive, value=0.0)),
                           (r"rate: is for", lambda: scene.act(0, "part", "hub.axle", rate=1.0)),
                           (r"allowed: is for", lambda: scene.act(0, "release", "bar", allowed=[("bar", "bar")]))):
            with self.assertRaisesRegex(InputError, text):
                call()
        scene.act(0.1, "join", "hub.axle")  # of a mechanism
        with self.assertRaises(InputError):
            touchstone.Simulation(scene)

    def test_a_link_without_a_joint(self):
        scene = touchstone.DynamicScene("loose", 1.0)
        scene.add(block("bar"), kind="link", mass=1.0)
        with self.assertRaisesRegex(InputError, "bar"):
            touchstone.Simulation(scene)


if __name__ == "__main__":
    unittest.main()
