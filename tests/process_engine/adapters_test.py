#!/usr/bin/env python3
"""The example adapters: their length, and what engine_protocol.put() makes of an engine's contacts."""
import pathlib
import sys
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


if __name__ == "__main__":
    unittest.main()
