#!/usr/bin/env python3
"""Drake (double precision) as an engine: pip install drake. Boxes are its Box, others its Convex; defaults.
Overlap is HasCollisions(), distances and depths are ComputeSignedDistancePairClosestPoints()."""
from importlib.metadata import version

from engine_protocol import OVERLAP, OVERLAPPING, SEPARATED, half_sides, need, serve

need("pydrake", "drake")
from pydrake.geometry import (Box, Convex, FramePoseVector, GeometryFrame, GeometryInstance, ProximityProperties,  # noqa: E402
                              SceneGraph)
from pydrake.math import RigidTransform, RotationMatrix  # noqa: E402

MOST_SCENES = 256  # the least recently asked one goes first
shapes, scenes = [], {}


def shape_of(corners):
    half = half_sides(corners)
    return Box(*(2 * half)) if half is not None else Convex(corners.T, "hull")


class Scene:
    """A scene graph of two solids, each on a frame of its own; asked again it gets new poses alone."""

    def __init__(self, pair):
        self.graph, self.frames, self.geometries = SceneGraph(), [], []
        source = self.graph.RegisterSource("pair")
        for name in ("a", "b"):
            frame = self.graph.RegisterFrame(source, GeometryFrame(name))
            instance = GeometryInstance(RigidTransform(), shapes[pair[name]], name)
            self.geometries.append(self.graph.RegisterGeometry(source, frame, instance))
            self.graph.AssignRole(source, self.geometries[-1], ProximityProperties())
            self.frames.append(frame)
        self.context, self.port = self.graph.CreateDefaultContext(), self.graph.get_source_pose_port(source)

    def at(self, pair):
        poses = FramePoseVector()
        for frame, pose in zip(self.frames, (pair["X_WA"], pair["X_WB"])):
            poses.set_value(frame, RigidTransform(RotationMatrix(pose["R"].T), pose["p"]))
        self.port.FixValue(self.context, poses)
        return self.graph.get_query_output_port().Eval(self.context)


def build(corners):
    shapes[:] = [shape_of(each) for each in corners]
    scenes.clear()


def answer(head, pairs, slots):
    for pair, slot in zip(pairs, slots):
        key = (int(pair["a"]), int(pair["b"]))
        scene = scenes[key] = scenes.pop(key, None) or Scene(pair)
        if len(scenes) > MOST_SCENES:
            del scenes[next(iter(scenes))]
        query = scene.at(pair)
        if head["query"] == OVERLAP:
            slot["status"] = OVERLAPPING if query.HasCollisions() else SEPARATED
            continue
        found = query.ComputeSignedDistancePairClosestPoints(*scene.geometries)
        slot["status"] = SEPARATED if found.distance > 0 else OVERLAPPING
        if found.distance <= head["max_separation"]:
            slot["separation"], slot["n_AB_W"] = found.distance, -found.nhat_BA_W
            for name, pose, point in (("p_A_W", pair["X_WA"], found.p_ACa), ("p_B_W", pair["X_WB"], found.p_BCb)):
                slot[name] = pose["R"].T @ point + pose["p"]


if __name__ == "__main__":
    serve(build, answer, name="drake", description=f"Drake {version('drake')} (PyPI): HasCollisions, signed distance", distance=True,
          penetration=True, relative_resolution=1e-6, depth_resolution=None)
