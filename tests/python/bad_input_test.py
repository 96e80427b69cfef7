"""What is wrong is an exception with the project's text; nothing has changed then, and nothing ends the process."""

import inspect
import unittest

import numpy as np
import touchstone
from touchstone import InputError

UNIT = [1.0, 0.0, 0.0, 0.0]


class BadInput(unittest.TestCase):
    def setUp(self):
        self.box = touchstone.Hexahedron.box([1, 1, 1])
        self.check = touchstone.Narrowphase("native", [self.box] * 3)
        self.matrices = np.tile(np.eye(4), (3, 1, 1))
        self.matrices[:, 0, 3] = [0, 2, 4]
        self.poses = touchstone.Poses(self.matrices)

    def refused(self, error, text, call, *arguments, **named):
        with self.assertRaises(error) as caught:
            call(*arguments, **named)
        self.assertIn(text, str(caught.exception))

    def test_writes_that_would_be_lost_are_refused(self):
        mesh = touchstone.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        for copy in (self.box.vertices, self.box.half_extents, self.box.face_planes, self.poses[0], mesh.vertices,
                     mesh.triangles, touchstone.Hexahedron.FACE_VERTICES, touchstone.Hexahedron.EDGE_VERTICES):
            with self.assertRaises(ValueError):
                copy[0] = 5

    def test_indices_are_python_s(self):
        np.testing.assert_array_equal(self.poses[-1], self.matrices[2])
        for index in (3, -4):
            self.refused(IndexError, f"poses: {index} of 3", self.poses.__getitem__, index)
        self.refused(InputError, f"pair 0: {2**63} is no index", self.check.overlap, self.poses,
                     np.array([[2**63, 0]], dtype=np.uint64))

    def test_a_folder_is_no_mesh(self):
        self.refused(InputError, "is a folder", touchstone.read_stl, ".", 1.0)

    def test_objects_whose_init_was_not_called_are_refused(self):
        core = touchstone._core
        looked_at = 0
        for name, of in inspect.getmembers(core, inspect.isclass):
            if issubclass(of, Exception):
                continue
            hollow = of.__new__(of)
            for member, kept in vars(of).items():
                with self.subTest(f"{name}.{member}"):
                    if isinstance(kept, property):
                        self.refused(TypeError, "__init__() of this object was not called", getattr, hollow, member)
                        looked_at += 1
        self.assertGreater(looked_at, 50)

        class Early(touchstone.World):
            def __init__(self):
                self.frame()

        self.refused(TypeError, "__init__() of this object was not called", Early)
        self.refused(TypeError, "__init__() of this object was not called", self.check.overlap, touchstone.Poses.__new__(touchstone.Poses), [[0, 1]])

    def test_an_input_error_is_a_value_error(self):
        self.assertTrue(issubclass(InputError, ValueError))

    def test_shapes_of_poses(self):
        for bad in (np.eye(4), np.zeros((3, 3, 4)), np.zeros((3, 16)), np.zeros((3, 4, 4, 1)), 5.0):
            self.refused(InputError, "must be (n, 4, 4)", touchstone.Poses, bad)
        self.refused(InputError, "positions: shape is (3, 2), must be (n, 3)", touchstone.Poses, np.zeros((3, 2)), [UNIT])
        self.refused(InputError, "quaternions: are 1, positions 2", touchstone.Poses, np.zeros((2, 3)), [UNIT])

    def test_types_of_poses(self):
        for bad in (self.matrices.astype(complex), self.matrices > 0, self.matrices.astype(str),
                    self.matrices.astype(object), "poses", None, {}, self.matrices.astype("datetime64[s]")):
            with self.assertRaises((TypeError, InputError)):
                touchstone.Poses(bad)
        self.refused(TypeError, "must be floats or integers", touchstone.Poses, self.matrices.astype(complex))

    @unittest.skipUnless(np.finfo(np.longdouble).max > np.finfo(float).max, "long doubles are doubles")
    def test_what_numpy_refuses_to_narrow_is_named(self):
        wide = self.matrices.astype(np.longdouble)
        wide[1, 0, 3] = np.longdouble("1e400")
        with np.errstate(over="raise"):
            self.refused(InputError, "poses: cannot be converted to doubles", touchstone.Poses, wide)
        with np.errstate(over="ignore"):
            self.refused(InputError, "pose 1: ", touchstone.Poses, wide)

    def test_what_is_no_rigid_transform_is_named(self):
        for change, text in (((0, 0, np.nan), "pose 1"), ((0, 3, np.inf), "pose 1"), ((3, 3, 2.0), "last row"),
                             ((3, 0, np.nan), "pose 1"), ((0, 0, -1.0), "reflection"), ((0, 0, 2.0), "orthonormal")):
            bad = self.matrices.copy()
            bad[1][change[:2]] = change[2]
            self.refused(InputError, text, touchstone.Poses, bad)
            self.refused(InputError, "pose 1", self.check.distance, bad, [[0, 1]])
        for q in ([0, 0, 0, 0], [np.nan, 0, 0, 1], [np.inf, 0, 0, 1]):
            self.refused(InputError, "pose 1", touchstone.Poses, np.zeros((2, 3)), [UNIT, q])
        self.refused(InputError, "pose 0: position", touchstone.Poses, [[np.nan, 0, 0]], [UNIT])

    def test_a_refused_update_changes_nothing(self):
        bad = self.matrices.copy()
        bad[:, 1, 3] = 9
        bad[2, 0, 0] = np.nan
        self.refused(InputError, "pose 2", self.poses.update, bad)
        self.refused(InputError, "do not fit", self.poses.update, self.matrices, first=1)
        self.refused(InputError, "do not fit", self.poses.update, self.matrices[:1], first=2**63)
        np.testing.assert_array_equal(self.poses.matrices(), self.matrices)

    def test_numbers_of_poses(self):
        for count in (0, 2, 4):
            few = np.tile(np.eye(4), (count, 1, 1))
            self.refused(InputError, f"poses: are {count}, must be 3", self.check.overlap, few, [[0, 1]])

    def test_pairs_that_are_none(self):
        for bad in ([[0, 3]], [[1, 1]], [[0, 1], [2**32 - 1, 0]], [[0, 2**31]]):
            self.refused(InputError, "is not two of the 3 solids", self.check.overlap, self.poses, bad)
        self.refused(InputError, "pair 1", self.check.overlap, self.poses, np.array([[0, 1], [0, 3]], np.uint32))
        for bad in ([[-1, 0]], [[0, 2**32]], np.array([[0, 2**63]], np.uint64)):
            self.refused(InputError, "is no index", self.check.overlap, self.poses, bad)

    def test_shapes_and_types_of_pairs(self):
        for bad in (np.zeros((3, 3), np.uint32), np.zeros(4, np.uint32), np.zeros((1, 2, 1), np.uint32), [0, 1], 7):
            self.refused(InputError, "must be (m, 2)", self.check.overlap, self.poses, bad)
        for bad in (np.zeros((3, 2)), np.zeros((3, 2), bool), np.zeros((3, 2), object), [["0", "1"]], None):
            with self.assertRaises(TypeError):
                self.check.overlap(self.poses, bad)

    def test_queries_out_of_range(self):
        for max_points in (0, 9, -1):
            self.refused(InputError, "must be 1 to 8", self.check.manifold, self.poses, [[0, 1]], max_points=max_points)
        for limit in (-1.0, np.nan):
            self.refused(InputError, "max_separation", self.check.distance, self.poses, [[0, 1]], max_separation=limit)
        self.refused(InputError, "max_point_separation", self.check.manifold, self.poses, [[0, 1]],
                     max_point_separation=np.nan)

    def test_answers_of_another_query_do_not_serve_as_out(self):
        one = self.check.distance(self.poses, [[0, 1]])
        for call, pairs in ((self.check.overlap, [[0, 1]]), (self.check.manifold, [[0, 1]]),
                            (self.check.distance, [[0, 1], [1, 2]])):
            self.refused(InputError, "out: was made for another", call, self.poses, pairs, out=one)
        with self.assertRaises(Exception):
            self.check.distance(self.poses, [[0, 1]], out=np.zeros(3))

    def test_backends_and_solids(self):
        self.refused(InputError, "native", touchstone.Narrowphase, "nonesuch", [self.box])
        self.refused(InputError, "must be (n, 8, 3)", touchstone.Narrowphase, "native", np.zeros((2, 7, 3)))
        self.refused(InputError, "1", touchstone.Narrowphase, "native", np.stack([self.box.vertices, np.zeros((8, 3))]))
        self.refused(TypeError, "Hexahedron", touchstone.Narrowphase, "native", [1, 2])
        self.refused(InputError, "solids: are 0", touchstone.Narrowphase, "native", [])

    def test_hexahedra_that_are_none(self):
        self.refused(InputError, "size along x", touchstone.Hexahedron.box, [-1, 1, 1])
        self.refused(InputError, "must be (3,)", touchstone.Hexahedron.box, [1, 1])
        self.refused(InputError, "zero volume", touchstone.Hexahedron, np.zeros((8, 3)), name="lid")
        self.refused(InputError, "lid", touchstone.Hexahedron, np.zeros((8, 3)), name="lid")
        self.refused(InputError, "has 7 vertices", touchstone.Hexahedron, np.zeros((7, 3)))
        self.refused(InputError, "warp", touchstone.Hexahedron, self.box.vertices, warp="perhaps")


if __name__ == "__main__":
    unittest.main()
