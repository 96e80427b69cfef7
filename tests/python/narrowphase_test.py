"""Batches from NumPy to any backend and back."""

import gc
import os
import pathlib
import sys
import unittest

import numpy as np
import touchstone

UNIT = [1.0, 0.0, 0.0, 0.0]
OF_THE_BUILD = touchstone.backends()  # before a test adds to them


def row_of_boxes(count, step):
    """Unit boxes `step` apart along x, and the pairs of neighbours."""
    boxes = [touchstone.Hexahedron.box([1, 1, 1])] * count
    positions = np.zeros((count, 3))
    positions[:, 0] = step * np.arange(count)
    pairs = np.stack([np.arange(count - 1), np.arange(1, count)], axis=1).astype(np.uint32)
    return boxes, positions, pairs


def fields_bytes(rows):
    """Without the bytes between fields, which hold anything."""
    return [np.ascontiguousarray(rows[name]).tobytes() for name in rows.dtype.names]


def unaligned(array):
    """The same, a byte after where its elements may begin for C++."""
    return np.frombuffer(b"x" + array.tobytes(), array.dtype, offset=1).reshape(array.shape)


def random_rotations(random, count):
    q = random.normal(size=(count, 4))
    w, x, y, z = (q / np.linalg.norm(q, axis=1)[:, None]).T
    rows = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    return q, np.moveaxis(np.array(rows), 2, 0)


class Answers(unittest.TestCase):
    def setUp(self):
        boxes, self.positions, self.pairs = row_of_boxes(5, 1.25)
        self.check = touchstone.Narrowphase("native", boxes)
        self.poses = touchstone.Poses(self.positions, [UNIT] * 5)

    def test_distance_has_separation_normal_and_witness_points(self):
        answers = self.check.distance(self.poses, self.pairs)
        self.assertEqual(len(answers), 4)
        np.testing.assert_array_equal(answers.status, [touchstone.Status.SEPARATED] * 4)
        geometry = answers.geometry
        np.testing.assert_array_equal(geometry["separation"], [0.25] * 4)
        np.testing.assert_array_equal(geometry["n_AB_W"], [[1, 0, 0]] * 4)
        np.testing.assert_allclose(geometry["p_A_W"] + 0.25 * geometry["n_AB_W"], geometry["p_B_W"], atol=1e-15)
        self.assertIsNone(answers.points)

    def test_overlap_has_the_status_alone(self):
        answers = self.check.overlap(self.poses, self.pairs)
        self.assertEqual(answers.status.dtype, np.uint8)
        self.assertIsNone(answers.geometry)

    def test_a_manifold_has_the_corners_and_nan_behind_them(self):
        self.poses.update(0.8 * self.positions, [UNIT] * 5)
        answers = self.check.manifold(self.poses, self.pairs, max_points=6)
        self.assertEqual(answers.points.shape, (4, 6))
        np.testing.assert_array_equal(answers.status, [touchstone.Status.OVERLAPPING] * 4)
        np.testing.assert_array_equal(answers.geometry["point_count"], [4] * 4)
        self.assertEqual(len(np.unique(answers.points["p_A_W"][0, :4], axis=0)), 4)
        self.assertTrue(np.isnan(answers.points["separation"][:, 4:]).all())
        self.assertTrue((answers.points["feature_id"][:, 4:] == 0).all())

    def test_beyond_max_separation_the_separation_is_infinite(self):
        answers = self.check.distance(self.poses, [[0, 1], [0, 4]], max_separation=1.0)
        np.testing.assert_array_equal(answers.geometry["separation"], [0.25, np.inf])

    def test_no_pairs_have_no_answers(self):
        for none in ([], np.zeros((0, 2), np.uint32), np.zeros((0, 2))):
            answers = self.check.distance(self.poses, none)
            self.assertEqual((len(answers), answers.geometry.shape), (0, (0,)))

    def test_answers_of_an_earlier_call_are_written_again(self):
        answers = self.check.distance(self.poses, self.pairs)
        separation = answers.geometry["separation"]
        self.poses.update(2 * self.positions, [UNIT] * 5)
        self.assertIs(self.check.distance(self.poses, self.pairs, out=answers), answers)
        np.testing.assert_array_equal(separation, [1.5] * 4)  # a view, not a copy
        other = self.check.distance(self.poses, self.pairs)
        np.testing.assert_array_equal(other.geometry["separation"], separation)
        self.assertFalse(np.shares_memory(other.geometry, answers.geometry))

    def test_arrays_outlive_what_they_came_from(self):
        geometry = self.check.distance(self.poses, self.pairs).geometry
        del self.check, self.poses
        gc.collect()
        filler = [np.full(geometry.nbytes // 8, 7.0) for _ in range(100)]
        np.testing.assert_array_equal(geometry["separation"], [0.25] * 4)
        self.assertEqual(len(filler), 100)

    def test_memory_of_answers_that_are_gone_serves_later_ones_alone(self):
        def place(array):
            return array.__array_interface__["data"][0]

        pairs = np.tile(self.pairs, (500, 1))
        first = self.check.overlap(self.poses, pairs)
        status, was = first.status, place(first.status)
        expected = status.copy()
        del first  # the view holds it
        others = [self.check.overlap(self.poses, pairs) for _ in range(6)]
        self.assertEqual(len({was, *(place(each.status) for each in others)}), 7)
        np.testing.assert_array_equal(status, expected)
        del status
        self.assertEqual(place(self.check.overlap(self.poses, pairs).status), was)
        few = self.check.overlap(self.poses, self.pairs)  # a hundred times as much is not spent on it
        self.assertNotIn(place(few.status), {was, *(place(each.status) for each in others)})
        np.testing.assert_array_equal(few.status, expected[:len(self.pairs)])

    def test_views_cannot_be_resized_under_us(self):
        answers = self.check.distance(self.poses, self.pairs)
        for array in (answers.status, answers.geometry):
            with self.assertRaises(ValueError):
                array.resize(10000, refcheck=False)


class Conversions(unittest.TestCase):
    """Any layout gives the answers of doubles without gaps, bit by bit."""

    def setUp(self):
        random = np.random.default_rng(21)
        self.n = 40
        corners = touchstone.Hexahedron.box([1, 0.5, 0.25]).vertices
        self.corners = np.repeat(corners[None], self.n, axis=0) * random.uniform(0.5, 2, (self.n, 1, 3))
        self.check = touchstone.Narrowphase("native", self.corners)
        self.q, R = random_rotations(random, self.n)
        self.matrices = np.tile(np.eye(4), (self.n, 1, 1))
        self.matrices[:, :3, :3] = R
        self.matrices[:, :3, 3] = random.uniform(-1, 1, (self.n, 3))
        self.pairs = random.choice([(a, b) for a in range(self.n) for b in range(a)], 200, replace=False)[:, ::-1]
        self.expected = self.geometry(touchstone.Poses(self.matrices), self.pairs.astype(np.uint32).copy())

    def geometry(self, poses, pairs):
        return fields_bytes(self.check.distance(poses, pairs).geometry)

    def test_matrices_in_any_layout(self):
        wide = np.zeros((2 * self.n, 4, 8))
        wide[::2, :, ::2] = self.matrices
        for layout in (self.matrices, np.asfortranarray(self.matrices), wide[::2, :, ::2],
                       self.matrices.astype(">f8"), self.matrices.astype(np.longdouble), self.matrices.tolist(),
                       unaligned(self.matrices)):
            self.assertEqual(self.geometry(layout, self.pairs), self.expected)
            self.assertEqual(self.geometry(touchstone.Poses(layout), self.pairs), self.expected)

    def test_poses_come_back_as_they_went_in(self):
        poses = touchstone.Poses(self.matrices)
        np.testing.assert_array_equal(poses.matrices(), self.matrices)
        np.testing.assert_array_equal(poses[7], self.matrices[7])

    def test_quaternions_are_the_rotations_that_they_stand_for(self):
        positions, quaternions = self.matrices[:, :3, 3].copy(), 3.0 * self.q
        poses = touchstone.Poses(positions, quaternions)
        np.testing.assert_allclose(poses.matrices(), self.matrices, atol=1e-15)
        other = touchstone.Poses(unaligned(positions), unaligned(quaternions))
        self.assertEqual(other.matrices().tobytes(), poses.matrices().tobytes())

    def test_quaternions_of_many_have_the_bits_of_one(self):
        """Many are converted side by side, those that are odd one by one."""
        random = np.random.default_rng(7)
        q = random.normal(size=(23, 4)) * 2.0 ** random.integers(-60, 60, (23, 1))
        q[5] = [0.0, -0.0, 1e-200, 0.0]
        q[10] *= 1e150
        q[16] = [1e300, 1e300, -1e300, 1e300]
        p = random.normal(size=(23, 3))
        one_by_one = np.concatenate([touchstone.Poses(p[i:i + 1], q[i:i + 1]).matrices() for i in range(23)])
        self.assertEqual(touchstone.Poses(p, q).matrices().tobytes(), one_by_one.tobytes())

    def test_what_is_a_rotation_is_decided_alike_of_many_and_of_one(self):
        random = np.random.default_rng(8)
        tree = touchstone.HexahedronTree([("body", touchstone.Hexahedron.box([1, 1, 1]), None)])
        matrices = np.repeat(np.eye(4)[None], 600, axis=0)
        matrices[:, :3, :3] = random_rotations(random, 600)[1]
        matrices[:, :3, :3] += 1e-6 * random.uniform(-0.6, 0.6, (600, 3, 3))
        matrices[::50, 0] *= -1.0  # reflections

        def takes(call, pose):
            try:
                call(pose)
                return True
            except touchstone.InputError:
                return False

        one = [takes(tree.world_poses, matrix) for matrix in matrices]
        many = [takes(touchstone.Poses, np.stack([np.eye(4), matrix])) for matrix in matrices]
        self.assertEqual(many, one)
        self.assertTrue(100 < sum(one) < 500, sum(one))

    def test_pairs_in_any_layout(self):
        wide = np.zeros((200, 5), np.int32)
        wide[:, ::3] = self.pairs
        for layout in (self.pairs.astype(np.int64), self.pairs.astype(np.uint8), self.pairs.astype(">u4"),
                       np.asfortranarray(self.pairs), wide[:, ::3], self.pairs.tolist(),
                       unaligned(self.pairs.astype(np.uint32))):
            self.assertEqual(self.geometry(self.matrices, layout), self.expected)

    def test_a_part_of_the_poses_is_updated(self):
        poses = touchstone.Poses(self.matrices)
        moved = self.matrices.copy()
        moved[3:6, 0, 3] += 0.125
        poses.update(moved[3:6], first=3)
        np.testing.assert_array_equal(poses.matrices(), moved)

    def test_swapped_pairs_have_negated_normals(self):
        one = self.check.distance(self.matrices, self.pairs).geometry
        other = self.check.distance(self.matrices, self.pairs[:, ::-1]).geometry
        np.testing.assert_array_equal(one["separation"], other["separation"])
        np.testing.assert_array_equal(one["n_AB_W"], -other["n_AB_W"])

    def test_halves_of_a_batch_have_the_answers_of_the_whole(self):
        halves = [self.check.distance(self.matrices, half).geometry for half in np.split(self.pairs, 2)]
        self.assertEqual(fields_bytes(np.concatenate(halves)), self.expected)

    def test_separations_are_those_of_an_independent_bound(self):
        """Along the returned normal the solids are as far apart as said; along no other axis tried are they further."""
        geometry = self.check.distance(self.matrices, self.pairs).geometry
        world = np.einsum("nij,nkj->nki", self.matrices[:, :3, :3], self.corners) + self.matrices[:, None, :3, 3]
        axes = np.random.default_rng(3).normal(size=(500, 3))
        axes /= np.linalg.norm(axes, axis=1)[:, None]
        for (a, b), row in zip(self.pairs, geometry):
            gap = (world[b] @ row["n_AB_W"]).min() - (world[a] @ row["n_AB_W"]).max()
            self.assertAlmostEqual(gap, row["separation"], delta=1e-13)
            best = max((world[b] @ axes.T).min(axis=0) - (world[a] @ axes.T).max(axis=0))
            self.assertLessEqual(best, row["separation"] + 1e-13)


class Backends(unittest.TestCase):
    def test_every_backend_answers_two_boxes_or_says_that_it_cannot(self):
        boxes, positions, pairs = row_of_boxes(2, 1.0)
        for name, description in OF_THE_BUILD.items():
            with self.subTest(name):
                self.assertTrue(description)
                check = touchstone.Narrowphase(name, boxes)
                self.assertEqual((check.name, len(check)), (name, 2))
                for step, expected in ((0.75, touchstone.Status.OVERLAPPING), (1.5, touchstone.Status.SEPARATED)):
                    poses = touchstone.Poses(step * positions, [UNIT] * 2)
                    self.assertEqual(check.overlap(poses, pairs).status[0], expected)
                    answer = check.distance(poses, pairs)
                    if answer.status[0] == touchstone.Status.UNSUPPORTED:
                        able = check.capabilities["penetration" if step < 1 else "distance"]
                        self.assertFalse(able)
                        self.assertTrue(np.isnan(answer.geometry["separation"][0]))
                    elif step > 1:  # depths of engines are off by percents
                        self.assertAlmostEqual(answer.geometry["separation"][0], 0.5, delta=1e-4)

    @unittest.skipUnless(hasattr(touchstone, "start_engine"), "this build has no process engines")
    def test_a_program_is_a_backend_like_any_other(self):
        spheres = pathlib.Path(os.environ["TOUCHSTONE_SOURCE"]) / "adapters" / "process_engine" / "example" / "spheres.py"
        name = touchstone.start_engine([sys.executable, str(spheres)])
        self.assertIn(name, touchstone.backends())
        boxes, positions, pairs = row_of_boxes(3, 4.0)
        check = touchstone.Narrowphase(name, boxes)
        answers = check.overlap(touchstone.Poses(positions, [UNIT] * 3), pairs)
        np.testing.assert_array_equal(answers.status, [touchstone.Status.SEPARATED] * 2)
        with self.assertRaisesRegex(touchstone.InputError, "no_such_engine"):
            touchstone.start_engine(["/no_such_engine"])

    def test_a_library_that_is_no_plugin_is_named(self):
        if not hasattr(touchstone, "load_plugin"):
            self.skipTest("this build loads no plug-ins")
        with self.assertRaisesRegex(touchstone.InputError, "no_such_library"):
            touchstone.load_plugin("/no_such_library.so")


if __name__ == "__main__":
    unittest.main()
