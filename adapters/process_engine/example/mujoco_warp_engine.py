#!/usr/bin/env python3
"""MuJoCo Warp (single precision) as an engine: pip install mujoco-warp. Overlap and manifolds by its collision, on the processor.
Default options; --primitive: without native CCD, which gives boxes a routine of their own; --deterministic: Warp's mode of that name."""
import sys
from functools import cache

from engine_protocol import AT_ONCE, UNSUPPORTED, half_sides, need, np, put, serve
from mujoco_pair import contact, pair_model, placed

wp = need("warp", "warp-lang")
PRIMITIVE, DETERMINISTIC = "--primitive" in sys.argv, "--deterministic" in sys.argv
OPTIONS = '<option><flag nativeccd="disable"/></option>' if PRIMITIVE else ""
if DETERMINISTIC:
    wp.config.deterministic, wp.config.deterministic_max_records = wp.DeterministicMode.RUN_TO_RUN, 64
warp_engine = need("mujoco_warp", "mujoco-warp")
solids = []


@cache
def model_of(a, b):
    """A model of one pair, or, of boxes (None), one for any: sizes and poses are written into it, a world a pair."""
    unit = np.array([[i >> 2 & 1, i >> 1 & 1, i & 1] for i in range(8)]) * 2.0 - 1
    model = pair_model(*(unit if solid is None else solids[solid] for solid in (a, b)), OPTIONS)
    if model is None:
        return None
    on_device = warp_engine.put_model(model)
    on_device.opt.broadphase_filter = 0  # the pair is asked about, whatever its bounds
    return model, on_device, warp_engine.make_data(model, nworld=AT_ONCE if a is None else 1, nconmax=64, njmax=256)


def build(corners):
    solids[:] = corners
    model_of.cache_clear()


def ask(key, head, pairs, slots):
    """All `pairs` in one go, a world each, by the model of `key`. A contact that is apart is none."""
    made = model_of(*key)
    if made is None:
        slots["status"] = UNSUPPORTED
        return
    model, on_device, data = made
    p, R, sizes = np.zeros((data.nworld, 2, 3)), np.tile(np.eye(3), (data.nworld, 2, 1, 1)), np.ones((data.nworld, 2, 3))
    for world, pair in enumerate(pairs):
        for geom, (solid, pose) in enumerate(((pair["a"], pair["X_WA"]), (pair["b"], pair["X_WB"]))):
            p[world, geom], R[world, geom] = placed(model, geom, pose)
            sizes[world, geom] = 1 if key[0] is not None else half_sides(solids[solid])
    if key[0] is None:
        on_device.geom_size = wp.array(sizes.astype(np.float32), dtype=wp.vec3)
    data.geom_xpos, data.geom_xmat = wp.array(p.astype(np.float32), dtype=wp.vec3), wp.array(R.astype(np.float32), dtype=wp.mat33)
    warp_engine.collision(on_device, data)
    count = int(data.nacon.numpy()[0])
    world, dist, pos, frame, geom = (getattr(data.contact, name).numpy()[:count] for name in ("worldid", "dist", "pos", "frame", "geom"))
    for i, slot in enumerate(slots):
        put(slot, [contact(*each) for each in zip(dist[world == i], pos[world == i], frame[world == i], geom[world == i])
                   if not each[0] > 0], head)


def answer(head, pairs, slots):
    boxes = [half_sides(solids[pair["a"]]) is not None and half_sides(solids[pair["b"]]) is not None for pair in pairs]
    keys = [(None, None) if box else (int(pair["a"]), int(pair["b"])) for box, pair in zip(boxes, pairs)]
    for key in dict.fromkeys(keys):
        those = [i for i, each in enumerate(keys) if each == key]
        for at_once in [those] if key[0] is None else [[i] for i in those]:  # as many worlds as its model has
            chosen = slots[at_once]
            ask(key, head, pairs[at_once], chosen)
            slots[at_once] = chosen


if __name__ == "__main__":
    serve(build, answer, name="mujoco_warp", description=f"MuJoCo Warp {warp_engine.__version__} (PyPI): collision" +
          ", no native CCD" * PRIMITIVE + ", deterministic" * DETERMINISTIC,
          manifold=True, scalar_bits=32, relative_resolution=1e-6, depth_resolution=None)
