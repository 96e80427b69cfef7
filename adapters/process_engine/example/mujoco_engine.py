#!/usr/bin/env python3
"""MuJoCo as an engine: pip install mujoco. Overlap and manifolds by mj_collision, distances by mj_geomDistance. Default options."""
from functools import cache

from engine_protocol import DISTANCE, OVERLAPPING, SEPARATED, UNSUPPORTED, np, put, serve
from mujoco_pair import contact, mujoco, pair_model, placed

solids, FURTHEST = [], 1e10


@cache
def model_of(a, b):
    """A model of the pair alone; poses are written into its data."""
    model = pair_model(solids[a], solids[b])
    return model, mujoco.MjData(model) if model is not None else None


def build(corners):
    solids[:] = corners
    model_of.cache_clear()


def place(model, data, geom, pose):
    p, R = placed(model, geom, pose)
    data.geom_xpos[geom], data.geom_xmat[geom] = p, R.ravel()


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
            put(slot, [contact(each.dist, each.pos, each.frame, each.geom) for each in data.contact], head)
            continue
        separation = mujoco.mj_geomDistance(model, data, 0, 1, limit, fromto)
        slot["status"] = SEPARATED if separation > 0 else OVERLAPPING
        if separation < limit:
            along = (fromto[3:] - fromto[:3]) / separation if separation else np.full(3, np.nan)
            slot["separation"], slot["n_AB_W"], slot["p_A_W"], slot["p_B_W"] = separation, along, fromto[:3], fromto[3:]


if __name__ == "__main__":
    serve(build, answer, name="mujoco_py", description=f"MuJoCo {mujoco.__version__} (PyPI): mj_collision, mj_geomDistance", distance=True,
          penetration=True, manifold=True)
