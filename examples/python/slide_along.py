"""A box is commanded through a fence of blocks: what each policy of the contact world makes of it."""

import numpy as np
import touchstone
from pictures import BLUE, GREEN, GREY, ORANGE, RED, folder, pyplot, save

STYLES = {"cue": (RED, ":"), "hold": (ORANGE, "--"), "advance": (BLUE, "-."), "slide": (GREEN, "-")}
FRAMES = 40
UNIT = [1, 0, 0, 0]


def fly(policy):
    """Positions after each frame of a way from left to right, and how many contacts began."""
    world = touchstone.World(gap=1e-6)
    world.set_default_rule(policy=policy)
    for i, (x, y) in enumerate(FENCE):
        world.add(touchstone.HexahedronTree([touchstone.Hexahedron.box([1, 1, 1])], f"block{i}"), ([x, y, 0], TURNED),
                  is_static=True)
    box = world.add(touchstone.HexahedronTree([touchstone.Hexahedron.box([0.4, 0.4, 0.4])], "box"), ([-3, 0.35, 0], UNIT))
    way, began = [world.pose(box)[:2, 3]], 0
    for x in np.linspace(-3, 3, FRAMES + 1)[1:]:
        report = world.frame({box: ([x, 0.35, 0], UNIT)})
        began += int(np.sum(report.events["kind"] == touchstone.EventKind.BEGAN))
        way.append(world.pose(box)[:2, 3])
    return np.array(way), began


FENCE = [(-1.2, -0.35), (0.2, 0.9), (1.3, -0.6)]
TURNED = [np.cos(0.3), 0, 0, np.sin(0.3)]


def main():
    out = folder(__doc__)
    figure, axes = pyplot.subplots(figsize=(9.5, 5))
    turn = np.array([[np.cos(0.6), -np.sin(0.6)], [np.sin(0.6), np.cos(0.6)]])
    square = 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    for centre in FENCE:
        axes.fill(*(square @ turn.T + centre).T, color=GREY, alpha=0.5)
    for policy, (colour, line) in STYLES.items():
        way, began = fly(policy)
        axes.plot(*way.T, color=colour, linestyle=line, linewidth=2, marker="o", markersize=3,
                  label=f"{policy}: contacts begun {began}, ends at x = {way[-1, 0]:.2f} m")
        axes.fill(*(0.4 * square + way[-1]).T, edgecolor=colour, facecolor="none", linestyle=line)
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", ylim=(-1.9, 2.6),
             title="One command, four policies: y = 0.35 m from x = -3 to 3 m in 40 frames")
    axes.legend(loc="upper left")
    save(figure, out, "slide_along")


if __name__ == "__main__":
    main()
