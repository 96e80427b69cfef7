"""A block hits a stack: dynamics, with the engine's contact forces and energy."""

import numpy as np
import touchstone
from pictures import BLUE, GREY, ORANGE, RED, draw, folder, frame_axes, pyplot, save

UNIT = [1, 0, 0, 0]
SHOWN = (0.0, 0.35, 0.8)  # s


def block(name, size):
    return touchstone.HexahedronTree([touchstone.Hexahedron.box(size)], name)


def make_scene():
    scene = touchstone.DynamicScene("a block hits a stack", 1.2, step=1e-3, gravity=[0, 0, -9.81])
    scene.add(block("ground", [8, 4, 0.2]), ([0, 0, -0.1], UNIT), kind="static")
    for i in range(5):
        scene.add(block(f"crate{i}", [0.5, 0.5, 0.4]), ([0, 0, 0.2 + 0.4 * i], UNIT), density=300.0)
    scene.add(block("block", [0.4, 0.4, 0.4]), ([-1.6, 0.05, 1.1], UNIT), density=900.0, velocity=[5, 0, 1.5])
    return scene


def main():
    out = folder(__doc__)
    scene = make_scene()
    run = touchstone.Simulation(scene)
    solids = [scene.tree(i).solids[0][1] for i in range(len(scene.objects))]
    figure = pyplot.figure(figsize=(13, 8))
    time, energy, force, depth = [], [], [], []
    for i, until in enumerate(SHOWN):
        while run.time < until - 1e-9:
            run.advance(5)
            contacts = run.contacts
            time.append(run.time)
            energy.append(run.energy)
            force.append(np.abs(contacts["force_W"][(contacts["solid_a"] == 0) | (contacts["solid_b"] == 0), 2].sum()))
            depth.append(1e6 * run.worst_depth)
        axes = figure.add_subplot(2, 3, i + 1, projection="3d", computed_zorder=False)
        poses = run.poses
        for k, solid in enumerate(solids):
            draw(axes, solid, poses[k], GREY if k == 0 else RED if k == len(solids) - 1 else (BLUE, ORANGE)[k % 2], 0.25 if k == 0 else 0.9)
        frame_axes(axes, [np.array([[-2, -1.2, 0], [1.4, 1.2, 2.2]])], f"t = {run.time:.2f} s")
        axes.view_init(12, -75)
    for k, (values, label) in enumerate(((energy, "energy [J]"), (force, "force on the ground [N]"), (depth, "deepest overlap [um]"))):
        axes = figure.add_subplot(2, 3, 4 + k)
        axes.plot(time, values, color=BLUE)
        axes.set(xlabel="t [s]", ylabel=label, ylim=(0, None))
        axes.grid(alpha=0.3)
    figure.tight_layout()
    save(figure, out, "tumbling_stack")


if __name__ == "__main__":
    main()
