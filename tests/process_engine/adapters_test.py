#!/usr/bin/env python3
"""The example adapters: their length, and what engine_protocol.put() makes of an engine's contacts."""
import importlib
import pathlib
import re
import sys
import types
import unittest

ADAPTERS = pathlib.Path(__file__).resolve().parent.parent.parent / "adapters" / "process_engine" / "example"
sys.path.insert(0, str(ADAPTERS))
import engine_protocol as protocol  # noqa: E402
from engine_protocol import np  # noqa: E402

MOST_LINES = 80


class Length(unittest.TestCase):
    def test_an_adapter_is_read_at_a_glance(self):
        adapters = [path for pattern in ("*engine.py", "*engine.mjs", "engine.c") for path in ADAPTERS.glob(pattern)]
        self.assertGreaterEqual(len(adapters), 8)
        for adapter in adapters:
            self.assertLessEqual(len(adapter.read_text().splitlines()), MOST_LINES, adapter.name)


class Put(unittest.TestCase):
    ALONG = np.array([1.0, 0, 0])

    def put(self, query, separations, **limits):
        head = np.zeros(1, protocol.HEAD)
        head["query"], head["max_points"], head["max_separation"] = query, 2, np.inf
        for name, value in limits.items():
            head[name] = value
        slots = protocol.answers_for(head[0], 1)
        points = [(each, self.ALONG * i, self.ALONG * i + each, self.ALONG) for i, each in enumerate(separations)]
        protocol.put(slots[0], points, head[0])
        return slots[0]

    def test_the_deepest_point_is_the_pairs(self):
        slot = self.put(protocol.MANIFOLD, [-0.1, -0.3, -0.2])
        self.assertEqual((slot["status"], slot["separation"], slot["point_count"]), (protocol.OVERLAPPING, -0.3, 2))
        self.assertEqual(slot["points"]["separation"].tolist(), [-0.3, -0.2])
        self.assertEqual(slot["p_A_W"].tolist(), [1, 0, 0])

    def test_points_beyond_the_limit_are_none(self):
        self.assertEqual(self.put(protocol.MANIFOLD, [-0.1, 0.2], max_point_separation=0.1)["point_count"], 1)

    def test_a_pair_beyond_the_limit_has_a_class_alone(self):
        slot = self.put(protocol.DISTANCE, [0.5], max_separation=0.4)
        self.assertEqual((slot["status"], slot["separation"]), (protocol.SEPARATED, np.inf))

    def test_touching_is_contact_and_nothing_is_apart(self):
        self.assertEqual(self.put(protocol.OVERLAP, [0.0])["status"], protocol.OVERLAPPING)
        self.assertEqual(self.put(protocol.OVERLAP, [])["status"], protocol.SEPARATED)


class StandInArray:
    def __init__(self, values):
        self.values = values

    def numpy(self):
        return self.values


class StandInNewton:
    """Balls for boxes: what newton_engine.py calls of newton and warp. Shapes of one pair are in the order of their sizes, as Newton sorts types."""
    __version__ = "1.8.0"
    models = 0

    class ModelBuilder:
        ShapeConfig = staticmethod(lambda **settings: settings)

        def __init__(self):
            self.radii = []

        def add_body(self):
            return len(self.radii)

        def add_shape_box(self, body, hx, hy, hz, cfg):
            self.radii.append(hx)

        def finalize(self, device):
            StandInNewton.models += 1
            n = len(self.radii)
            return types.SimpleNamespace(radii=self.radii, shape_gap=StandInArray(np.zeros(n, np.float32)),
                                         state=lambda: types.SimpleNamespace(body_q=StandInArray(np.zeros((n, 7), np.float32))))

    class CollisionPipeline:
        def __init__(self, model, broad_phase, shape_pairs_filtered):
            self.model, self.wanted = model, shape_pairs_filtered

        def contacts(self):
            return types.SimpleNamespace()

        def collide(self, state, contacts):
            found, p = [], state.body_q.numpy()[:, :3]
            for a, b in self.wanted.numpy():
                a, b = sorted((int(a), int(b)), key=lambda shape: self.model.radii[shape])
                apart = np.linalg.norm(p[b] - p[a])
                gap = self.model.shape_gap.numpy()[[a, b]].sum()
                if a != b and apart - self.model.radii[a] - self.model.radii[b] <= gap:
                    n = (p[b] - p[a]) / apart
                    found.append((a, b, n * self.model.radii[a], -n * self.model.radii[b], n))
            contacts.rigid_contact_count = StandInArray(np.array([len(found)]))
            for name, values in zip(("shape0", "shape1", "point0", "point1", "normal"), zip(*found) if found else ((),) * 5):
                setattr(contacts, "rigid_contact_" + name, StandInArray(np.array(values)))


class Newton(unittest.TestCase):
    def setUp(self):
        warp = types.SimpleNamespace(vec2i=None, zeros=lambda count, dtype, device: StandInArray(np.zeros((count, 2), np.int32)))
        sys.modules.update(newton=StandInNewton, warp=warp)
        self.addCleanup(lambda: [sys.modules.pop(name, None) for name in ("newton", "warp", "newton_engine")])
        self.engine = importlib.import_module("newton_engine")
        StandInNewton.models = 0

    def distances(self, *asked):
        """Statuses and separations of pairs (a, b, x of A, x of B), of which bodies lie on the x axis."""
        pairs, head = np.zeros(len(asked), protocol.PAIR), np.zeros(1, protocol.HEAD)[0]
        head["query"], head["max_separation"] = protocol.DISTANCE, np.inf
        for pair, (a, b, x_a, x_b) in zip(pairs, asked):
            pair["a"], pair["b"] = a, b
            for pose, x in (("X_WA", x_a), ("X_WB", x_b)):
                pair[pose]["R"], pair[pose]["p"] = np.eye(3), (x, 0, 0)
        slots = protocol.answers_for(head, len(asked))
        self.engine.answer(head, pairs, slots)
        return slots

    def build(self, *halves):
        signs = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
        self.engine.build(np.array([signs * half for half in halves]))

    def test_one_model_serves_all_questions_of_a_build(self):
        self.build(1, 2, 4)
        self.assertEqual([self.distances((0, 1, 0, x))["separation"][0] for x in (5, 4, 3)], [2, 1, 0])
        self.assertEqual(StandInNewton.models, 1)
        self.build(2, 2)
        self.assertEqual(self.distances((0, 1, 0, 5))["separation"][0], 1)
        self.assertEqual(StandInNewton.models, 2)

    def test_a_solid_may_be_in_many_pairs_at_other_poses_and_with_itself(self):
        self.build(1, 2, 4)
        slots = self.distances((0, 1, 0, 5), (0, 1, 0, 9), (1, 0, 0, 4), (2, 2, 0, 9), (2, 0, 9, 0))
        self.assertEqual(slots["separation"].tolist(), [2, 6, 1, 1, 4])
        self.assertEqual(slots["n_AB_W"][:, 0].tolist(), [1, 1, 1, 1, -1])  # from A to B, though Newton took the smaller first
        self.assertEqual(slots["p_A_W"][2].tolist(), [2, 0, 0])

    def test_what_single_precision_does_not_hold_fails_alone(self):
        self.build(1, 1e200, 2)
        slots = self.distances((0, 1, 0, 5), (0, 2, 0, 5))
        self.assertEqual(slots["status"].tolist(), [protocol.FAILED, protocol.SEPARATED])


class StandInMujoco:
    """Balls of the meshes' first corners and of the boxes' first sides: what mujoco_warp_engine.py calls of mujoco. Meshes of more than 100 are
    refused."""

    class MjModel:
        made = 0

        @staticmethod
        def from_xml_string(xml):
            StandInMujoco.MjModel.made += 1
            radii = [abs(float(corners.split()[0])) for corners in re.findall('<mesh[^>]* vertex="([^"]*)"', xml)]
            if any(radius > 100 for radius in radii):
                raise ValueError("too large")
            n = len(radii)
            meshes = [n - 1 if kind == "mesh" else -1 for kind in re.findall('<geom [^>]*type="(mesh|box)"', xml)]
            unturned = np.array([[1.0, 0, 0, 0]])
            return types.SimpleNamespace(radii=radii, geom_dataid=np.array(meshes), mesh_pos=np.zeros((n, 3)), mesh_quat=unturned.repeat(n, 0),
                                         geom_pos=np.zeros((2, 3)), geom_quat=unturned.repeat(2, 0))

    @staticmethod
    def mju_quat2Mat(out, _):
        out[:] = np.eye(3).ravel()


class StandInMujocoWarp:
    __version__ = "4.0.0"

    @staticmethod
    def put_model(model):
        return types.SimpleNamespace(radii=model.radii, opt=types.SimpleNamespace())

    @staticmethod
    def make_data(model, nworld, nconmax, njmax):
        return types.SimpleNamespace(nworld=nworld, contact=types.SimpleNamespace())

    @staticmethod
    def collision(model, data):
        found = []
        for world in range(data.nworld):
            radii = [model.geom_size[world, geom, 0] if mesh < 0 else model.radii[mesh] for geom, mesh in enumerate(model.geom_dataid[world])]
            apart = float(np.linalg.norm(data.geom_xpos[world, 1] - data.geom_xpos[world, 0]))
            if apart <= sum(radii):
                found.append((world, apart - sum(radii), np.zeros(3), np.eye(3), (0, 1)))
        data.nacon = StandInArray(np.array([len(found)]))
        for name, values in zip(("worldid", "dist", "pos", "frame", "geom"), zip(*found) if found else ((),) * 5):
            setattr(data.contact, name, StandInArray(np.array(values)))


class MujocoWarp(unittest.TestCase):
    def setUp(self):
        warp = types.SimpleNamespace(array=lambda values, dtype: values, vec3=None, mat33=None)
        sys.modules.update(mujoco=StandInMujoco, warp=warp, mujoco_warp=StandInMujocoWarp)
        self.addCleanup(lambda: [sys.modules.pop(name, None) for name in ("mujoco", "warp", "mujoco_warp", "mujoco_pair", "mujoco_warp_engine")])
        self.engine = importlib.import_module("mujoco_warp_engine")

    def test_each_pair_of_a_question_has_its_own_solids_in_one_model(self):
        signs = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
        bent = signs + [[0, 0, 0.1 * (i == 7)] for i in range(8)]
        self.engine.build(np.array([bent, signs * 2, bent * 4, bent * 8, bent * 200]))
        asked = [(0, 2), (2, 0), (3, 0), (1, 1), (1, 3), (3, 1), (0, 4)]
        pairs, head = np.zeros(len(asked), protocol.PAIR), np.zeros(1, protocol.HEAD)[0]
        head["query"], head["max_points"] = protocol.MANIFOLD, 8
        for pair, (a, b) in zip(pairs, asked):
            pair["a"], pair["b"] = a, b
            pair["X_WA"]["R"] = pair["X_WB"]["R"] = np.eye(3)
            pair["X_WB"]["p"] = (5, 0, 0)
        made, slots = StandInMujoco.MjModel.made, protocol.answers_for(head, len(asked))
        self.engine.answer(head, pairs, slots)
        self.assertEqual(slots["status"].tolist(), [1, 1, 1, protocol.SEPARATED, 1, 1, protocol.UNSUPPORTED])
        self.assertEqual(slots["separation"][[0, 1, 2, 4, 5]].tolist(), [0, 0, -4, -5, -5])
        self.engine.answer(head, pairs, slots)
        self.assertEqual(StandInMujoco.MjModel.made - made, 4)  # of two meshes, two boxes, and one of either, both ways


if __name__ == "__main__":
    unittest.main()
