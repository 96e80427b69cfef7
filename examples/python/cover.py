"""An L-shaped bracket with a slanted foot as a mesh, and the hexahedra that cover it, by the error that they may have."""

import numpy as np
import touchstone
from pictures import BLUE, GREEN, GREY, ORANGE, Poly3DCollection, draw, folder, frame_axes, pyplot, save

OUTLINE = np.array([[0, 0], [2.4, 0], [2.0, 0.6], [0.8, 0.6], [0.8, 2], [0, 2]], float)
CAPS = [[0, 1, 2], [0, 2, 3], [0, 3, 5], [3, 4, 5]]
COLOURS = [BLUE, ORANGE, GREEN, GREY]


def bracket():
    n = len(OUTLINE)
    vertices = np.concatenate([np.c_[OUTLINE, np.zeros(n)], np.c_[OUTLINE, np.ones(n)]])
    triangles = [[c, b, a] for a, b, c in CAPS] + [[a + n, b + n, c + n] for a, b, c in CAPS]
    for i in range(n):
        k = (i + 1) % n
        triangles += [[i, k, k + n], [i, k + n, i + n]]
    return touchstone.Mesh(vertices, triangles)


def main():
    out = folder(__doc__)
    mesh = bracket()
    figure = pyplot.figure(figsize=(13, 4.8))
    axes = figure.add_subplot(1, 3, 1, projection="3d")
    axes.add_collection3d(Poly3DCollection(mesh.vertices[mesh.triangles], facecolor=GREY, edgecolor="#333333", linewidth=0.5,
                                           alpha=0.7))
    frame_axes(axes, [mesh.vertices], f"{len(mesh.triangles)} triangles")
    for i, over in enumerate((1.5, 0.1)):
        fit = touchstone.fit(mesh, over=over, repairs=10)
        axes = figure.add_subplot(1, 3, i + 2, projection="3d")
        solids = fit.tree("bracket").solids
        drawn = [draw(axes, solid, X, COLOURS[k % 4], 0.5) for k, (_, solid, X) in enumerate(solids)]
        frame_axes(axes, drawn, f"{len(fit)} hexahedr{'on' if len(fit) == 1 else 'a'}, at most {fit.excess:.2f} m outside\n"
                                f"({over:.2f} m allowed)")
    save(figure, out, "cover")


if __name__ == "__main__":
    main()
