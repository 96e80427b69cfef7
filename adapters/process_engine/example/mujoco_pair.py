"""A pair of solids as a MuJoCo model, for the engines that are MuJoCo's."""
import sys

from engine_protocol import half_sides, need, np

mujoco = need("mujoco")


def mesh(name, corners):
    return f'<mesh name="{name}" inertia="shell" vertex="{" ".join(repr(float(value)) for value in np.ravel(corners))}"/>'


def pair_model(corners_a, corners_b, options="", meshes=""):
    """The model of the pair alone, of corners 8 x 3: boxes as its boxes, others as its meshes, after `meshes`; None: below or above its
    range."""
    geoms = ""
    for i, corners in enumerate((corners_a, corners_b)):
        half = half_sides(corners)
        kind = f'type="mesh" mesh="m{i}"' if half is None else f'type="box" size="{" ".join(repr(float(value)) for value in half)}"'
        meshes += mesh(f"m{i}", corners) if half is None else ""
        geoms += f'<body><freejoint/><geom name="g{i}" {kind}/></body>'
    xml = (f'<mujoco>{options}<compiler boundmass="1" boundinertia="1"/><asset>{meshes}</asset><worldbody>{geoms}</worldbody>'
           '<contact><pair geom1="g0" geom2="g1"/></contact></mujoco>')
    try:
        return mujoco.MjModel.from_xml_string(xml)
    except ValueError as error:
        print(f"{corners_a.tolist()} {corners_b.tolist()}: {error}", file=sys.stderr)
        return None


def placed(model, geom, pose, mesh=None):
    """Position and rotation of a geom, as if it had that mesh. A mesh is kept about its own centre, by its own axes."""
    turn, frame = np.empty(9), pose["R"].T
    p, q = (model.geom_pos[geom], model.geom_quat[geom]) if mesh is None else (model.mesh_pos[mesh], model.mesh_quat[mesh])
    mujoco.mju_quat2Mat(turn, q)
    return frame @ p + pose["p"], frame @ turn.reshape(3, 3)


def contact(depth, middle, frame, geom):
    """It is in the middle between the surfaces; its frame begins with the normal from geom1 to geom2."""
    normal = frame.ravel()[:3] * (1 if geom[0] == 0 else -1)
    return depth, middle - depth / 2 * normal, middle + depth / 2 * normal, normal
