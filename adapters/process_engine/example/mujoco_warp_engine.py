#!/usr/bin/env python3
"""MuJoCo Warp (single precision) as an engine: pip install mujoco-warp. Overlap and manifolds by its collision, on the processor.
Default options; --primitive: without native CCD, which gives boxes a routine of their own; --deterministic: Warp's mode of that name."""
import sys
from functools import cache

from engine_protocol import AT_ONCE, UNSUPPORTED, half_sides, need, np, put, serve
from mujoco_pair import contact, mesh, pair_model, placed

wp = need("warp", "warp-lang")
PRIMITIVE, DETERMINISTIC = "--primitive" in sys.argv, "--deterministic" in sys.argv
OPTIONS = '<option><flag nativeccd="disable"/></option>' if PRIMITIVE else ""
if DETERMINISTIC:
    wp.config.deterministic, wp.config.deterministic_max_records = wp.DeterministicMode.RUN_TO_RUN, 64
warp_engine = need("mujoco_warp", "mujoco-warp")
UNIT = np.array([[i >> 2 & 1, i >> 1 & 1, i & 1] for i in range(8)]) * 2.0 - 1
solids, halves, mesh_of = [], [], {}  # halves: of boxes; mesh_of: the others that MuJoCo takes, by solid


def meshes_of(hulls):
    return "".join(mesh(f"of{solid}", solids[solid]) for solid in hulls)


def build(corners):
    solids[:], halves[:] = corners, [half_sides(each) for each in corners]
    hulls = [i for i, half in enumerate(halves) if half is None]
    hulls = hulls if pair_model(UNIT, UNIT, "", meshes_of(hulls)) else [i for i in hulls if pair_model(solids[i], UNIT)]
    mesh_of.clear()
    mesh_of.update((solid, i) for i, solid in enumerate(hulls))
    model_of.cache_clear()


@cache
def model_of(*are_boxes):
    """A model of AT_ONCE worlds of a pair each, which has all meshes: sizes, meshes and poses are written into it."""
    corners = (UNIT if is_box else solids[next(iter(mesh_of))] for is_box in are_boxes)
    model = pair_model(*corners, OPTIONS, "" if all(are_boxes) else meshes_of(mesh_of))
    on_device = warp_engine.put_model(model)
    on_device.opt.broadphase_filter = 0  # the pair is asked about, whatever its bounds
    return model, on_device, warp_engine.make_data(model, nworld=AT_ONCE, nconmax=64, njmax=256)


def ask(are_boxes, head, pairs, slots):
    """All `pairs` in one go, a world each. A contact that is apart is none."""
    model, on_device, data = model_of(*are_boxes)
    p, R, sizes = np.zeros((data.nworld, 2, 3)), np.tile(np.eye(3), (data.nworld, 2, 1, 1)), np.ones((data.nworld, 2, 3))
    meshes = np.tile(model.geom_dataid, (data.nworld, 1))
    for world, pair in enumerate(pairs):
        for geom, (solid, pose) in enumerate(((pair["a"], pair["X_WA"]), (pair["b"], pair["X_WB"]))):
            sizes[world, geom] = 1 if halves[solid] is None else halves[solid]
            meshes[world, geom] = mesh_of.get(solid, -1)
            p[world, geom], R[world, geom] = placed(model, geom, pose, mesh_of.get(solid))
    on_device.geom_size, on_device.geom_dataid = wp.array(sizes.astype(np.float32), dtype=wp.vec3), wp.array(meshes, dtype=int)
    data.geom_xpos, data.geom_xmat = wp.array(p.astype(np.float32), dtype=wp.vec3), wp.array(R.astype(np.float32), dtype=wp.mat33)
    warp_engine.collision(on_device, data)
    count = int(data.nacon.numpy()[0])
    found = {world: [] for world in range(len(pairs))}
    for world, *each in zip(*(getattr(data.contact, name).numpy()[:count] for name in ("worldid", "dist", "pos", "frame", "geom"))):
        if int(world) in found and not each[0] > 0:
            found[int(world)].append(contact(*each))
    for slot, points in zip(slots, found.values()):
        put(slot, points, head)


def answer(head, pairs, slots):
    slots["status"] = UNSUPPORTED
    both = [(int(pair["a"]), int(pair["b"])) for pair in pairs]
    kinds = [tuple(halves[solid] is not None for solid in pair) if all(halves[solid] is not None or solid in mesh_of for solid in pair)
             else None for pair in both]
    for kind in dict.fromkeys(kind for kind in kinds if kind):
        those = [i for i, each in enumerate(kinds) if each == kind]
        chosen = slots[those]
        ask(kind, head, pairs[those], chosen)
        slots[those] = chosen


if __name__ == "__main__":
    serve(build, answer, name="mujoco_warp", description=f"MuJoCo Warp {warp_engine.__version__} (PyPI): collision" +
          ", no native CCD" * PRIMITIVE + ", deterministic" * DETERMINISTIC,
          manifold=True, scalar_bits=32, relative_resolution=1e-6, depth_resolution=None)
