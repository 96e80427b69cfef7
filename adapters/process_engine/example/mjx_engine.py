#!/usr/bin/env python3
"""MJX, MuJoCo on JAX (single precision), as an engine: pip install mujoco-mjx jax. Overlap and manifolds by its collision, on the processor,
which compiles each pair for seconds: for single pairs."""
import os

from engine_protocol import FAILED, UNSUPPORTED, need, np, put, serve
from mujoco_pair import contact, pair_model, placed

os.environ.setdefault("JAX_PLATFORMS", "cpu")
jax = need("jax")
need("mujoco.mjx", "mujoco-mjx")
from importlib.metadata import version  # noqa: E402

from mujoco import mjx  # noqa: E402

collide = jax.jit(mjx.collision)
solids = []


def build(corners):
    solids[:] = corners


def answer(head, pairs, slots):
    for pair, slot in zip(pairs, slots):
        model = pair_model(solids[pair["a"]], solids[pair["b"]])
        if model is None:
            slot["status"] = UNSUPPORTED
            continue
        try:
            on_device, data = mjx.put_model(model), mjx.make_data(model)
            p, R = zip(*(placed(model, geom, pair[pose]) for geom, pose in enumerate(("X_WA", "X_WB"))))
            found = collide(on_device, data.replace(geom_xpos=jax.numpy.array(p), geom_xmat=jax.numpy.array(R))).contact
        except NotImplementedError:
            slot["status"] = FAILED
            continue
        points = zip(*(np.asarray(getattr(found, name), float) for name in ("dist", "pos", "frame", "geom")))
        put(slot, [contact(*each) for each in points if not each[0] > 0], head)


if __name__ == "__main__":
    serve(build, answer, name="mjx", description=f"MJX {version('mujoco-mjx')} (PyPI): collision", manifold=True, scalar_bits=32,
          relative_resolution=1e-6, depth_resolution=None)
