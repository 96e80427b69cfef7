"""Hexahedra, trees, meshes and fits."""

import os
import pickle
import struct
import tempfile
import unittest

import numpy as np
import touchstone
from touchstone import InputError


def l_shape():
    """A prism over an L of 2 x 2 less 1 x 1, one high, as a closed mesh."""
    outline = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], float)
    vertices = np.concatenate([np.c_[outline, np.zeros(6)], np.c_[outline, np.ones(6)]])
    caps = [[0, 1, 3], [1, 2, 3], [0, 3, 5], [3, 4, 5]]
    triangles = [[c, b, a] for a, b, c in caps] + [[a + 6, b + 6, c + 6] for a, b, c in caps]
    for i in range(6):
        k = (i + 1) % 6
        triangles += [[i, k, k + 6], [i, k + 6, i + 6]]
    return touchstone.Mesh(vertices, triangles)


class Hexahedra(unittest.TestCase):
    def test_a_box_has_its_vertices_by_bits(self):
        box = touchstone.Hexahedron.box([2, 4, 6])
        self.assertTrue(box.is_box)
        np.testing.assert_array_equal(box.vertices[0], [-1, -2, -3])
        np.testing.assert_array_equal(box.vertices[1], [-1, -2, 3])
        np.testing.assert_array_equal(box.vertices[7], [1, 2, 3])
        np.testing.assert_array_equal(box.half_extents, [1, 2, 3])

    def test_planes_hold_all_vertices(self):
        planes = touchstone.Hexahedron(touchstone.Hexahedron.box([1, 2, 3]).vertices * [1, 1, 2] + 5).face_planes
        self.assertEqual(planes.shape, (6, 4))
        np.testing.assert_allclose(np.linalg.norm(planes[:, :3], axis=1), 1)

    def test_shuffled_corners_are_understood(self):
        corners = touchstone.Hexahedron.box([1, 2, 3]).vertices
        solid = touchstone.Hexahedron(np.random.default_rng(1).permutation(corners))
        self.assertEqual({tuple(v) for v in solid.vertices}, {tuple(v) for v in corners})

    def test_pickles_keep_every_bit(self):
        corners = touchstone.Hexahedron.box([1, 2, 3]).vertices.copy()
        corners[7] += 0.001
        block = touchstone.Hexahedron(corners, warp="accept")
        for solid in (touchstone.Hexahedron.box([0.1, 0.2, 0.3]), block, block.padded(0.1),
                      touchstone.Hexahedron.capsule(0.1, 0.3)):
            twin = pickle.loads(pickle.dumps(solid))
            np.testing.assert_array_equal(twin.vertices, solid.vertices)
            self.assertEqual((twin.is_box, twin.is_warped, twin.radius), (solid.is_box, solid.is_warped, solid.radius))

    def test_rounded_solids_are_exact(self):
        solids = [touchstone.Hexahedron.sphere(0.5), touchstone.Hexahedron.rounded_box([1, 1, 0], 0.25)]
        self.assertEqual([solid.radius for solid in solids], [0.5, 0.25])
        poses = np.tile(np.eye(4), (2, 1, 1))
        poses[1, 2, 3] = 2
        answer = touchstone.Narrowphase("native", solids).distance(poses, [[0, 1]])
        self.assertEqual(answer.geometry["separation"][0], 1.25)
        with self.assertRaisesRegex(InputError, "solid 0 is rounded"):
            touchstone.Narrowphase("edge_face", solids)


class Trees(unittest.TestCase):
    def test_poses_of_its_hexahedra_go_with_the_object(self):
        box = touchstone.Hexahedron.box([1, 1, 1])
        shifted = np.eye(4)
        shifted[0, 3] = 2
        tree = touchstone.HexahedronTree([("left", box, None), ("right", box, shifted)], "pair")
        self.assertEqual((tree.name, len(tree)), ("pair", 2))
        turned = (np.array([0, 0, 5.0]), np.array([np.sqrt(0.5), 0, 0, np.sqrt(0.5)]))  # 90 degrees about z
        matrices = tree.world_poses(turned).matrices()
        np.testing.assert_allclose(matrices[1][:3, 3], [0, 2, 5], atol=1e-15)
        check = touchstone.Narrowphase("native", [solid for _, solid, _ in tree.solids])
        answer = check.distance(tree.world_poses(turned), [[0, 1]])
        self.assertAlmostEqual(answer.geometry["separation"][0], 1.0, delta=1e-14)

    def test_nodes_are_a_tree_whose_spheres_hold_what_is_below(self):
        box = touchstone.Hexahedron.box([1, 1, 1])
        poses = np.tile(np.eye(4), (9, 1, 1))
        poses[:, 0, 3] = 2 * np.arange(9)
        nodes = touchstone.HexahedronTree([(f"b{i}", box, X) for i, X in enumerate(poses)], "row").nodes
        self.assertEqual(len(nodes), 17)
        self.assertEqual(sorted(nodes["solid"][nodes["solid"] >= 0]), list(range(9)))
        for node in nodes[nodes["left"] >= 0]:
            for child in (nodes[node["left"]], nodes[node["right"]]):
                if child["solid"] >= 0:
                    corners = box.vertices + poses[child["solid"]][:3, 3]
                    reach = np.linalg.norm(corners - node["centre_O"], axis=1).max()
                    self.assertLessEqual(reach, node["radius"] + 1e-12)
        with self.assertRaises(ValueError):
            nodes["radius"][0] = 0

    def test_errors_have_the_names(self):
        box = touchstone.Hexahedron.box([1, 1, 1])
        with self.assertRaisesRegex(InputError, "twice|taken|lid"):
            touchstone.HexahedronTree([("lid", box, None), ("lid", box, None)], "chest")
        with self.assertRaises(InputError):
            touchstone.HexahedronTree([], "nothing")
        with self.assertRaises(TypeError):
            touchstone.HexahedronTree([3])


class Fits(unittest.TestCase):
    def test_an_l_takes_two_hexahedra_that_cover_it(self):
        mesh = l_shape()
        stages = []
        fit = touchstone.fit(mesh, over=0.3, repairs=5, progress=lambda stage, share: stages.append((stage, share)))
        self.assertEqual(len(fit), 2)
        self.assertLessEqual(fit.excess, 0.3)
        self.assertTrue(stages)
        tree = fit.tree("l")
        self.assertEqual(len(tree), 2)
        points = np.random.default_rng(2).uniform([0, 0, 0], [2, 2, 1], (2000, 3))
        points = points[(points[:, 0] < 1) | (points[:, 1] < 1)]
        held = np.zeros(len(points), bool)
        for _, solid, X in tree.solids:
            planes = solid.face_planes
            local = (points - X[:3, 3]) @ X[:3, :3]
            held |= (local @ planes[:, :3].T + planes[:, 3] <= 1e-12).all(axis=1)
        self.assertTrue(held.all())

    def test_a_count_is_kept(self):
        self.assertLessEqual(len(touchstone.fit(l_shape(), over=0.3, repairs=5, count=1)), 1)

    def test_an_exception_in_progress_ends_the_search(self):
        def stop(stage, share):
            raise KeyError(stage)

        with self.assertRaises(KeyError):
            touchstone.fit(l_shape(), over=0.3, repairs=5, progress=stop)

    def test_meshes_that_are_none(self):
        with self.assertRaisesRegex(InputError, "triangle 0"):
            touchstone.Mesh(np.zeros((3, 3)), [[0, 1, 3]])
        with self.assertRaisesRegex(InputError, "finite|triangle"):
            touchstone.Mesh([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]])
        with self.assertRaises(InputError):
            touchstone.fit(l_shape(), over=-1.0)


class Stl(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def write(self, content):
        path = os.path.join(self.folder.name, "part.stl")
        with open(path, "wb") as file:
            file.write(content)
        return path

    def test_a_binary_file_is_read_in_metres(self):
        corners = [0.0] * 3 + [0, 0, 0, 1000, 0, 0, 0, 1000, 0]
        mesh = touchstone.read_stl(self.write(b" " * 80 + struct.pack("<I", 1) + struct.pack("<12fH", *corners, 0)), 1e-3)
        np.testing.assert_array_equal(mesh.vertices, [[0, 0, 0], [1, 0, 0], [0, 1, 0]])
        np.testing.assert_array_equal(mesh.triangles, [[0, 1, 2]])

    def test_errors_name_the_file(self):
        with self.assertRaisesRegex(InputError, "part.stl"):
            touchstone.read_stl(self.write(b"solid cut off"), 1.0)
        with self.assertRaisesRegex(InputError, "nowhere.stl"):
            touchstone.read_stl("nowhere.stl", 1.0)


if __name__ == "__main__":
    unittest.main()
