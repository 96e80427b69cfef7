#!/usr/bin/env python3
"""MuJoCo Warp (single precision) as an engine: pip install mujoco-warp. Overlap and manifolds by its collision, on the processor.
Default options; --primitive: without native CCD, which gives boxes a routine of their own; --deterministic: Warp's mode of that name."""
import sys
from functools import cache

from engine_protocol import AT_ONCE, MANIFOLD, OVERLAPPING, SEPARATED, UNSUPPORTED, half_sides, need, np, serve

mujoco, wp = need("mujoco"), need("warp")
PRIMITIVE, DETERMINISTIC = "--primitive" in sys.argv, "--deterministic" in sys.argv
if DETERMINISTIC:
    wp.config.deterministic, wp.config.deterministic_max_records = wp.DeterministicMode.RUN_TO_RUN, 64
warp_engine = need("mujoco_warp")
solids = []


@cache
def model_of(a, b):
    """A model of one pair, or, of boxes (None), one for any: sizes and poses are written into it, a world a pair."""
    meshes, geoms = "", ""
    for i, solid in enumerate((a, b)):
        half = np.ones(3) if solid is None else half_sides(solids[solid])
        numbers = " ".join(repr(float(value)) for value in (np.ravel(solids[solid]) if half is None else half))
        kind = f'type="box" size="{numbers}"' if half is not None else f'type="mesh" mesh="m{i}"'
        meshes += f'<mesh name="m{i}" inertia="shell" vertex="{numbers}"/>' if half is None else ""
        geoms += f'<body><freejoint/><geom name="g{i}" {kind}/></body>'
    flag = '<option><flag nativeccd="disable"/></option>' if PRIMITIVE else ""
    xml = (f'<mujoco>{flag}<compiler boundmass="1" boundinertia="1"/><asset>{meshes}</asset><worldbody>{geoms}</worldbody>'
           '<contact><pair geom1="g0" geom2="g1"/></contact></mujoco>')
    try:
        model = mujoco.MjModel.from_xml_string(xml)
    except ValueError as error:  # below or above its range
        print(f"pair {a} {b}: {error}", file=sys.stderr)
        return None
    on_device = warp_engine.put_model(model)
    on_device.opt.broadphase_filter = 0  # the pair is asked about, whatever its bounds
    return model, on_device, warp_engine.make_data(model, nworld=AT_ONCE if a is None else 1, nconmax=64, njmax=256)


def build(corners):
    solids[:] = corners
    model_of.cache_clear()


def ask(key, pairs, slots):
    """All `pairs` in one go, a world each, by the model of `key`."""
    made = model_of(*key)
    if made is None:
        slots["status"] = UNSUPPORTED
        return
    model, on_device, data = made
    p, R, sizes = np.zeros((data.nworld, 2, 3)), np.tile(np.eye(3), (data.nworld, 2, 1, 1)), np.ones((data.nworld, 2, 3))
    for world, pair in enumerate(pairs):
        for geom, (solid, pose) in enumerate(((pair["a"], pair["X_WA"]), (pair["b"], pair["X_WB"]))):
            turn, frame = np.empty(9), pose["R"].T  # a mesh is kept about its own centre, by its own axes
            mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
            p[world, geom], R[world, geom] = frame @ model.geom_pos[geom] + pose["p"], frame @ turn.reshape(3, 3)
            sizes[world, geom] = 1 if key[0] is not None else half_sides(solids[solid])
    if key[0] is None:
        on_device.geom_size = wp.array(sizes.astype(np.float32), dtype=wp.vec3)
    data.geom_xpos, data.geom_xmat = wp.array(p.astype(np.float32), dtype=wp.vec3), wp.array(R.astype(np.float32), dtype=wp.mat33)
    warp_engine.collision(on_device, data)
    count = int(data.nacon.numpy()[0])
    world, dist, pos, frame, geom = (getattr(data.contact, name).numpy()[:count] for name in ("worldid", "dist", "pos", "frame", "geom"))
    for i, slot in enumerate(slots):
        put(slot, sorted((float(dist[k]), k) for k in np.flatnonzero(world == i)), pos, frame.reshape(-1, 9), geom)


def put(slot, order, pos, frame, geom):
    """Contacts are in the middle between the surfaces, frames begin with the normal from geom1 to geom2; one that is apart is none."""
    order = [(depth, k) for depth, k in order if not depth > 0]
    slot["status"] = OVERLAPPING if order else SEPARATED
    if "points" not in slot.dtype.names or not order:
        return
    for (depth, k), point in zip(order, slot["points"]):
        normal, point["separation"] = frame[k, :3] * (1 if geom[k, 0] == 0 else -1), depth
        point["p_A_W"], point["p_B_W"] = pos[k] - depth / 2 * normal, pos[k] + depth / 2 * normal
        if k == order[0][1]:
            slot["n_AB_W"] = normal
    slot["separation"], slot["p_A_W"], slot["p_B_W"] = (slot["points"][0][name] for name in ("separation", "p_A_W", "p_B_W"))
    slot["point_count"] = min(len(order), len(slot["points"]))


def answer(head, pairs, slots):
    boxes = [half_sides(solids[pair["a"]]) is not None and half_sides(solids[pair["b"]]) is not None for pair in pairs]
    keys = [(None, None) if box else (int(pair["a"]), int(pair["b"])) for box, pair in zip(boxes, pairs)]
    for key in dict.fromkeys(keys):
        those = [i for i, each in enumerate(keys) if each == key]
        chosen = slots[those]
        ask(key, pairs[those], chosen)
        slots[those] = chosen


if __name__ == "__main__":
    serve(build, answer, name="mujoco_warp", description=f"MuJoCo Warp {warp_engine.__version__} (PyPI): collision" +
          ", no native CCD" * PRIMITIVE + ", deterministic" * DETERMINISTIC,
          manifold=True, scalar_bits=32, relative_resolution=1e-6, depth_resolution=None)
