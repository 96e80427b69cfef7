"""The named hard cases (tests/hard_cases) through Python, against their exact answers."""

import json
import os
import pathlib
import unittest

import numpy as np
import touchstone

FOLDER = pathlib.Path(os.environ["TOUCHSTONE_SOURCE"]) / "tests" / "hard_cases"
FILES = ("containment", "coplanar", "far", "hexahedra", "near_parallel", "scale", "thin", "touching")


def load(name):
    return json.loads((FOLDER / f"{name}.json").read_text())


def solid(shape):
    if shape["type"] == "box":
        return touchstone.Hexahedron.box(np.array(shape["size"], float))
    if shape["type"] != "convex":
        raise touchstone.InputError(f'unknown type "{shape["type"]}"')
    warp = "accept" if shape.get("warped") else "within_tolerance"
    return touchstone.Hexahedron(np.array(shape["vertices"], float).reshape(-1, 3), warp=warp)


def poses_of(case):
    """Each as its file gives it: matrices keep their bits, quaternions are turned into matrices by the module."""
    made = []
    for given in case["poses"]:
        if given == "identity":
            made.append(touchstone.Poses(np.eye(4)[None]).matrices()[0])
        elif "matrix" in given:
            made.append(touchstone.Poses(np.array(given["matrix"], float)[None]).matrices()[0])
        else:
            position, q = (np.array(given[key], float)[None] for key in ("position", "quaternion_wxyz"))
            made.append(touchstone.Poses(position, q).matrices()[0])
    return np.array(made)


def scale_of(solids, poses):
    world = [X[:3, :3] @ s.vertices.T + X[:3, 3:] for s, X in zip(solids, poses)]
    return max(max(s.size for s in solids), max(abs(w).max() for w in world))


class HardCases(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cases = [case for name in FILES for case in load(name)]
        cls.solids = [[solid(shape) for shape in case["shapes"]] for case in cls.cases]
        cls.poses = [poses_of(case) for case in cls.cases]

    def each(self):
        for case, solids, poses in zip(self.cases, self.solids, self.poses):
            with self.subTest(case["id"]):
                contact = case["exact"]["class"] != "separated"
                expected = touchstone.Status.OVERLAPPING if contact else touchstone.Status.SEPARATED
                yield solids, poses, expected, float(case["exact"]["signed_distance"])

    def test_exact_is_right_to_the_last_bit(self):
        if "exact" not in touchstone.backends():
            self.skipTest("this build has no exact (libgmp-dev)")
        for solids, poses, expected, distance in self.each():
            answer = touchstone.Narrowphase("exact", solids).distance(poses, [[0, 1]])
            self.assertEqual(answer.status[0], expected)
            self.assertEqual(answer.geometry["separation"][0], distance)

    def test_native_has_the_class_and_the_distance(self):
        for solids, poses, expected, distance in self.each():
            check = touchstone.Narrowphase("native", solids)
            self.assertEqual(check.overlap(poses, [[0, 1]]).status[0], expected)
            for answer in (check.distance(poses, [[0, 1]]), check.manifold(poses, [[0, 1]])):
                self.assertEqual(answer.status[0], expected)
                off = abs(answer.geometry["separation"][0] - distance)
                self.assertLessEqual(off, 1e-12 * scale_of(solids, poses))

    def test_one_batch_has_the_answers_of_single_pairs(self):
        """All cases as one scene of solids: the batch's lanes do not mix them."""
        check = touchstone.Narrowphase("native", [s for pair in self.solids for s in pair])
        poses = touchstone.Poses(np.concatenate(self.poses))
        pairs = np.arange(2 * len(self.cases), dtype=np.uint32).reshape(-1, 2)
        batch = check.distance(poses, pairs)
        for i, (solids, X) in enumerate(zip(self.solids, self.poses)):
            single = touchstone.Narrowphase("native", solids).distance(X, [[0, 1]])
            self.assertEqual(single.geometry[0].tobytes()[:80], batch.geometry[i].tobytes()[:80])
            self.assertEqual(single.status[0], batch.status[i])


class BadInputs(unittest.TestCase):
    def test_each_is_refused_with_its_reason(self):
        """Where the file's reader finds it first its words differ: 'not finite: NaN' is 'not finite' here."""
        seen = 0
        for case in load("bad_inputs"):
            with self.subTest(case["id"]):
                if case["id"] == "bad-world-overflow":
                    continue  # of the file's reader: poses and solids are sound each by itself
                with self.assertRaises(touchstone.InputError) as caught:
                    solids = [solid(shape) for shape in case["shapes"]]
                    touchstone.Narrowphase("native", solids).distance(poses_of(case), [[0, 1]])
                wanted = "not finite" if "not finite" in case["expected_error"] else case["expected_error"]
                text = str(caught.exception)
                if wanted == "not finite":
                    self.assertRegex(text, "finite|nan|inf")
                else:
                    self.assertIn(wanted, text)
                seen += 1
        self.assertGreater(seen, 20)


if __name__ == "__main__":
    unittest.main()
