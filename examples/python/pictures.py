"""What the gallery's scripts share: where pictures go, and how solids are drawn."""

import argparse
import pathlib
import sys

import numpy as np
import touchstone

try:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection
except ImportError:
    sys.exit("no matplotlib (Debian: python3-matplotlib): the gallery makes pictures with it")

# Told apart by who sees few colours, too; with a shape or label of its own wherever it counts.
BLUE, ORANGE, GREEN, RED, GREY = "#0072b2", "#e69f00", "#009e73", "#d55e00", "#8a8a8a"


def folder(doc):
    """The folder that the command line names, made where it is not there."""
    parser = argparse.ArgumentParser(description=doc.strip().splitlines()[0])
    parser.add_argument("--out", default="gallery", type=pathlib.Path, help="folder of the picture")
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    return out


def save(figure, out, name):
    path = out / f"{name}.png"
    # "tight" leaves out labels of z axes, which the padding has room for.
    figure.savefig(path, dpi=110, bbox_inches="tight", pad_inches=0.4)
    print(path)


def corners(solid, X):
    return solid.vertices @ X[:3, :3].T + X[:3, 3]


def draw(axes, solid, X, colour, alpha=0.6):
    """A hexahedron in a 3D plot."""
    world = corners(solid, X)
    faces = [world[face] for face in touchstone.Hexahedron.FACE_VERTICES]
    axes.add_collection3d(Poly3DCollection(faces, facecolor=colour, edgecolor="#333333", linewidth=0.4, alpha=alpha))
    return world


def frame_axes(axes, points, title=""):
    """Equal scales around `points`."""
    points = np.concatenate(points)
    middle, half = (points.max(axis=0) + points.min(axis=0)) / 2, np.ptp(points, axis=0).max() / 2
    axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half),
             zlim=(middle[2] - half, middle[2] + half), xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_major_locator(pyplot.MaxNLocator(4))
    axes.set_box_aspect((1, 1, 1))
    if title:
        axes.set_title(title)
