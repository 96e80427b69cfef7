"""Signed distance of a box from a turned one, everywhere on a grid: one batch a picture."""

import numpy as np
import touchstone
from pictures import BLUE, folder, pyplot, save

N = 161
REACH = 1.6


def main():
    out = folder(__doc__)
    fixed = touchstone.Hexahedron.box([1.2, 0.8, 1.0])
    moving = touchstone.Hexahedron.box([0.5, 0.3, 0.4])
    check = touchstone.Narrowphase("native", [fixed] + [moving] * N * N)
    x, y = np.meshgrid(np.linspace(-REACH, REACH, N), np.linspace(-REACH, REACH, N))
    positions = np.zeros((N * N + 1, 3))
    positions[1:, 0], positions[1:, 1] = x.ravel(), y.ravel()
    quaternions = np.tile([np.cos(0.3), 0, 0, np.sin(0.3)], (N * N + 1, 1))
    quaternions[0] = [1, 0, 0, 0]
    pairs = np.stack([np.zeros(N * N, np.uint32), np.arange(1, N * N + 1, dtype=np.uint32)], axis=1)
    answers = check.distance(touchstone.Poses(positions, quaternions), pairs)
    distance = answers.geometry["separation"].reshape(N, N)

    figure, axes = pyplot.subplots(figsize=(7.6, 6))
    shown = axes.contourf(x, y, distance, levels=np.arange(-0.8, 1.61, 0.1), cmap="RdBu", vmin=-1.2, vmax=1.2)
    axes.contour(x, y, distance, levels=[0.0], colors="black", linewidths=2)
    every = (slice(8, None, 16),) * 2
    normal = answers.geometry["n_AB_W"].reshape(N, N, 3)[every]
    axes.quiver(x[every], y[every], normal[..., 0], normal[..., 1], color="#333333", scale=28, width=0.003)
    axes.plot(*np.array([[-0.6, 0.6, 0.6, -0.6, -0.6], [-0.4, -0.4, 0.4, 0.4, -0.4]]), color=BLUE, linewidth=2)
    axes.set(xlabel="x of the small box [m]", ylabel="y of the small box [m]", aspect="equal",
             title=f"Signed distance of {N * N:,} placings; arrows: normals; black: touching".replace(",", " "))
    figure.colorbar(shown, label="separation [m], below 0 overlapping")
    save(figure, out, "distance_map")


if __name__ == "__main__":
    main()
