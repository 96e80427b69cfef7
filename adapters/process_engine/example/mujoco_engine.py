#!/usr/bin/env python3
"""MuJoCo as an engine: pip install mujoco. Overlap and manifolds by mj_collision, distances by mj_geomDistance. Default options."""
import sys
from functools import cache

from engine_protocol import np, DISTANCE, MANIFOLD, OVERLAPPING, SEPARATED, UNSUPPORTED, half_sides, need, serve

mujoco = need("mujoco")
solids, FURTHEST = [], 1e10


@cache
def model_of(a, b):
    """A model of the pair alone; poses are written into its data."""
    meshes, geoms = "", ""
    for i, corners in enumerate((solids[a], solids[b])):
        half = half_sides(corners)
        numbers = " ".join(repr(float(value)) for value in (np.ravel(corners) if half is None else half))
        kind = f'type="box" size="{numbers}"' if half is not None else f'type="mesh" mesh="m{i}"'
        meshes += f'<mesh name="m{i}" inertia="shell" vertex="{numbers}"/>' if half is None else ""
        geoms += f'<body><freejoint/><geom name="g{i}" {kind}/></body>'
    xml = (f'<mujoco><compiler boundmass="1" boundinertia="1"/><asset>{meshes}</asset><worldbody>{geoms}</worldbody>'
           '<contact><pair geom1="g0" geom2="g1"/></contact></mujoco>')
    try:
        model = mujoco.MjModel.from_xml_string(xml)
        return model, mujoco.MjData(model)
    except ValueError as error:  # below or above its range
        print(f"pair {a} {b}: {error}", file=sys.stderr)
        return None, None


def build(corners):
    solids[:] = corners
    model_of.cache_clear()


def place(model, data, geom, pose):
    """A mesh is kept about its own centre, by its own axes: geom_pos and geom_quat."""
    turn, frame = np.empty(9), pose["R"].T
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    data.geom_xpos[geom], data.geom_xmat[geom] = frame @ model.geom_pos[geom] + pose["p"], (frame @ turn.reshape(3, 3)).ravel()


def put_contacts(data, slot):
    """Contacts are in the middle between the surfaces, frames begin with the normal from geom1 to geom2."""
    contacts = sorted(data.contact, key=lambda contact: contact.dist)[:len(slot["points"])]
    for contact, point in zip(contacts, slot["points"]):
        normal, point["separation"] = contact.frame[:3] * (1 if contact.geom[0] == 0 else -1), contact.dist
        point["p_A_W"], point["p_B_W"] = contact.pos - contact.dist / 2 * normal, contact.pos + contact.dist / 2 * normal
        if contact is contacts[0]:
            slot["n_AB_W"] = normal
    slot["separation"], slot["p_A_W"], slot["p_B_W"] = (slot["points"][0][name] for name in ("separation", "p_A_W", "p_B_W"))
    slot["point_count"] = len(contacts)


def answer(head, pairs, slots):
    fromto, limit = np.empty(6), min(float(head["max_separation"]), FURTHEST)
    for pair, slot in zip(pairs, slots):
        model, data = model_of(int(pair["a"]), int(pair["b"]))
        if model is None:
            slot["status"] = UNSUPPORTED
            continue
        place(model, data, 0, pair["X_WA"]), place(model, data, 1, pair["X_WB"])
        if head["query"] != DISTANCE:
            mujoco.mj_collision(model, data)
            slot["status"] = OVERLAPPING if data.ncon > 0 else SEPARATED
            if head["query"] == MANIFOLD and data.ncon > 0:
                put_contacts(data, slot)
            continue
        separation = mujoco.mj_geomDistance(model, data, 0, 1, limit, fromto)
        slot["status"] = SEPARATED if separation > 0 else OVERLAPPING
        if separation < limit:
            along = (fromto[3:] - fromto[:3]) / separation if separation else np.full(3, np.nan)
            slot["separation"], slot["n_AB_W"], slot["p_A_W"], slot["p_B_W"] = separation, along, fromto[:3], fromto[3:]


if __name__ == "__main__":
    serve(build, answer, name="mujoco_py", description=f"MuJoCo {mujoco.__version__} (PyPI): mj_collision, mj_geomDistance", distance=True,
          penetration=True, manifold=True)
