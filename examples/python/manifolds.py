"""Contact points of three resting pairs: a face, an edge across a face, a corner."""

import numpy as np
import touchstone
from pictures import BLUE, GREEN, RED, draw, folder, frame_axes, pyplot, save


def about(axis, angle):
    return np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * np.array(axis) / np.linalg.norm(axis)])


CASES = {
    "face on face": ([0.25, 0.2, 0.745], about([0, 0, 1], 0.5)),
    "edge on face": ([0.1, 0.1, 0.25 + 0.5 * np.sqrt(2) - 0.005], about([1, 0, 0], np.pi / 4)),
    "corner on face": ([0, 0, 0.25 + 0.5 * np.sqrt(3) - 0.005], about([1, -1, 0], np.arctan(np.sqrt(2)))),
}


def main():
    out = folder(__doc__)
    table, box = touchstone.Hexahedron.box([2, 1.6, 0.5]), touchstone.Hexahedron.box([1, 1, 1])
    check = touchstone.Narrowphase("native", [table, box])
    figure = pyplot.figure(figsize=(13, 4.8))
    for i, (name, (position, quaternion)) in enumerate(CASES.items()):
        poses = touchstone.Poses([[0, 0, 0], position], [[1, 0, 0, 0], quaternion])
        answers = check.manifold(poses, [[0, 1]])
        row = answers.geometry[0]
        points = answers.points[0, : row["point_count"]]
        axes = figure.add_subplot(1, 3, i + 1, projection="3d", computed_zorder=False)
        drawn = [draw(axes, table, poses[0], BLUE, 0.35), draw(axes, box, poses[1], GREEN, 0.25)]
        axes.scatter(*points["p_A_W"].T, color=RED, s=40, depthshade=False, zorder=5)
        axes.quiver(*points["p_A_W"].T, *np.repeat(row["n_AB_W"][:, None], len(points), axis=1), length=0.35, color=RED, zorder=5)
        frame_axes(axes, drawn, f"{name}: {len(points)} point{'s' * (len(points) > 1)}, {1e3 * row['separation']:.0f} mm")
        axes.view_init(18, -60)
    save(figure, out, "manifolds")


if __name__ == "__main__":
    main()
