"""A pair of solids as a MuJoCo model, for the engines that are MuJoCo's."""
import sys

from engine_protocol import half_sides, need, np

mujoco = need("mujoco")


def pair_model(corners_a, corners_b, options=""):
    """The model of the pair alone, of corners 8 x 3: boxes as its boxes, others as its meshes; None: below or above its range."""
    meshes, geoms = "", ""
    for i, corners in enumerate((corners_a, corners_b)):
        half = half_sides(corners)
        numbers = " ".join(repr(float(value)) for value in (np.ravel(corners) if half is None else half))
        kind = f'type="box" size="{numbers}"' if half is not None else f'type="mesh" mesh="m{i}"'
        meshes += f'<mesh name="m{i}" inertia="shell" vertex="{numbers}"/>' if half is None else ""
        geoms += f'<body><freejoint/><geom name="g{i}" {kind}/></body>'
    xml = (f'<mujoco>{options}<compiler boundmass="1" boundinertia="1"/><asset>{meshes}</asset><worldbody>{geoms}</worldbody>'
           '<contact><pair geom1="g0" geom2="g1"/></contact></mujoco>')
    try:
        return mujoco.MjModel.from_xml_string(xml)
    except ValueError as error:
        print(f"{corners_a.tolist()} {corners_b.tolist()}: {error}", file=sys.stderr)
        return None


def placed(model, geom, pose):
    """Position and rotation of a geom. A mesh is kept about its own centre, by its own axes: geom_pos and geom_quat."""
    turn, frame = np.empty(9), pose["R"].T
    mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
    return frame @ model.geom_pos[geom] + pose["p"], frame @ turn.reshape(3, 3)


def contact(depth, middle, frame, geom):
    """It is in the middle between the surfaces; its frame begins with the normal from geom1 to geom2."""
    normal = frame.ravel()[:3] * (1 if geom[0] == 0 else -1)
    return depth, middle - depth / 2 * normal, middle + depth / 2 * normal, normal
