"""A campaign of random pairs, flights or dynamics runs, cut into shards that run anywhere and merge to the same bytes.

    campaign.py run --pairs 1000000 --shard 3/64 --out shards     # writes shards/shard_3_of_64.json
    campaign.py merge shards/*.json --out campaign.json           # any order; names the shards that are lost
    campaign.py dask --pairs 1000000 --shards 64 --out campaign.json    # all of it, on a local cluster or --scheduler ADDRESS

In place of --pairs N (native against exact): --flights N, worlds in which four boxes are moved at random among others, each frame judged by
exact; --dynamics N, boxes that fall on a floor for a second. A fault is a wrong class or a distance off; a frame in which two overlap; a step
that fails, or an overlap of more than 1 cm at every 25th step, where the deepest is looked at.

They come in blocks; block b's are drawn from Philox keyed by (seed, b) alone, and shard k of n has the blocks k - 1, k - 1 + n, ... So the
merged file does not depend on how many shards there were, where they ran or in which order they come. A shard's file appears whole or not
at all: one that was killed is lost, and is run again. One that is there twice counts once.
"""

import argparse
import json
import os
import pathlib
import sys

import numpy as np
import touchstone

SCHEMA = "touchstone.campaign/3"
BLOCKS = {"pairs": 500, "flights": 1, "dynamics": 1}  # of a block
FAMILIES = {"pairs": ("boxes", "sheared", "grid"), "flights": ("advance", "slide"), "dynamics": ("dropped", "thrown", "stacked")}
FAULTS_KEPT = 100
FLIGHT_FRAMES, MOVERS, STANDING = 25, 4, 14
RUN_SECONDS, RUN_STEP, LOOK_EVERY, MOST_DEPTH = 1.0, 1 / 500, 25, 1e-2  # half of what a fall of a second goes in a step; looked at every 25th step
BOUND_OVER_S = 1e-14  # of the signed distance; S: max(size, largest |coordinate|)
UNIT_CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


class Draw:
    """Doubles in [0, 1) from Philox's raw bits: the same with every version of NumPy."""

    def __init__(self, seed, block):
        self.bits = np.random.Philox(key=np.array([seed, block], np.uint64))

    def __call__(self, low, high, shape):
        raw = self.bits.random_raw(int(np.prod(shape))) >> np.uint64(11)
        return low + (high - low) * (raw * 2.0**-53).reshape(shape)


def largest_coordinate(corners, poses):
    """Of each solid's world vertices. Sums are written out: einsum's order is the machine's."""
    x, y, z = (corners[:, :, k] for k in range(3))
    rows = [(poses[:, i, 0, None] * x + poses[:, i, 1, None] * y) + poses[:, i, 2, None] * z + poses[:, i, 3, None] for i in range(3)]
    return np.abs(rows).max(axis=(0, 2))


def family_of(kind, block):
    return FAMILIES[kind][block % len(FAMILIES[kind])]


def note(tally, **values):
    """Adds to counts; of what begins with "worst" the larger one stays. No sum of fractions: its bits are of its order."""
    for name, value in values.items():
        known = tally.get(name, 0)
        tally[name] = max(known, float(value)) if name.startswith("worst") else known + int(value)


def make_block(seed, block, count):
    """Corners (2 n, 8, 3) and poses (2 n, 4, 4); solids 2 i and 2 i + 1 are pair i's."""
    draw, n, family = Draw(seed, block), 2 * count, family_of("pairs", block)
    if family == "grid":  # sizes and places in eighths: faces, edges and corners meet exactly
        corners = UNIT_CUBE * np.floor(draw(1, 9, (n, 1, 3))) / 4
        poses = np.tile(np.eye(4), (n, 1, 1))
        poses[:, :3, 3] = np.floor(draw(-9, 10, (n, 3))) / 8
        return corners, poses
    corners = UNIT_CUBE * draw(0.2, 2.0, (n, 1, 3))
    if family == "sheared":
        along = draw(-0.7, 0.7, (n, 2))
        corners[:, :, 0] += along[:, :1] * corners[:, :, 1]
        corners[:, :, 0] += along[:, 1:] * corners[:, :, 2]
    poses = touchstone.Poses(np.zeros((n, 3)), draw(-1.0, 1.0, (n, 4))).matrices()
    poses[:, :3, 3] = draw(-1.0, 1.0, (n, 3))
    return corners, poses


def judge_pairs(seed, block, count, tally, faults):
    corners, poses = make_block(seed, block, count)
    solids = [touchstone.Hexahedron(c) for c in corners]
    pairs = np.arange(2 * count, dtype=np.uint32).reshape(-1, 2)
    placed = touchstone.Poses(poses)
    found = touchstone.Narrowphase("native", solids).distance(placed, pairs)
    overlap = touchstone.Narrowphase("native", solids).overlap(placed, pairs)
    truth = touchstone.Narrowphase("exact", solids).distance(placed, pairs)
    size = np.array([solid.size for solid in solids])
    scale = np.maximum(size, largest_coordinate(corners, poses)).reshape(-1, 2).max(axis=1)
    error = np.abs(found.geometry["separation"] - truth.geometry["separation"]) / scale
    contact = truth.status == touchstone.Status.OVERLAPPING
    wrong = (found.status != truth.status) | (overlap.status != truth.status)
    beyond = ~(error <= BOUND_OVER_S)  # NaN is, too
    note(tally, pairs=count, contacts=contact.sum(), touching=(truth.geometry["separation"] == 0).sum(), missed=(wrong & contact).sum(),
         phantom=(wrong & ~contact).sum(), beyond=beyond.sum(), worst_over_S=np.nanmax(error))
    for i in np.flatnonzero(wrong | beyond):
        faults.append([block, int(i), "class" if wrong[i] else "distance", float(np.nan_to_num(error[i], nan=-1.0))])


def box_tree(name, size):
    return touchstone.HexahedronTree([("box", touchstone.Hexahedron.box(size), None)], name)


def judge_flights(seed, block, count, tally, faults):
    """Movers between blocks that stand on a grid, apart at the start."""
    draw, n = Draw(seed, block), MOVERS + STANDING
    sizes, turns = draw(0.2, 0.6, (n, 3)), draw(-1.0, 1.0, (n, 4))
    places = 1.2 * np.array([[k % 3, k // 3 % 3, k // 9] for k in range(n)])
    world = touchstone.World()
    world.set_default_rule(policy=family_of("flights", block))
    objects = [world.add(box_tree(f"box {k}", sizes[k]), (places[k], turns[k]), is_static=k >= MOVERS) for k in range(n)]
    exact = touchstone.Narrowphase("exact", [touchstone.Hexahedron.box(size) for size in sizes])
    pairs = np.array([[a, b] for a in range(MOVERS) for b in range(a + 1, n)], np.uint32)
    for frame in range(FLIGHT_FRAMES):
        moves = draw(-0.4, 0.4, (MOVERS, 2, 3))
        report = world.frame(moves={objects[k]: (moves[k, 0], moves[k, 1]) for k in range(MOVERS)})
        poses = np.stack([world.pose(each) for each in objects])
        merged = np.count_nonzero(exact.overlap(poses, pairs).status == touchstone.Status.OVERLAPPING)
        note(tally, frames=1, blocked=report.blocked_movers, slide_steps=report.slide_steps, iteration_limits=report.iteration_limits, merged=merged)
        if merged:
            faults.append([block, frame, "merged", float(merged)])
    note(tally, flights=count)


def make_scene(seed, block):
    draw, family, n = Draw(seed, block), family_of("dynamics", block), 2 + block % 5
    scene = touchstone.DynamicScene(f"run {block}", RUN_SECONDS, RUN_STEP, gravity=[0, 0, -9.81])
    scene.add(box_tree("floor", [20, 20, 1]), ([0, 0, -0.5], [1, 0, 0, 0]), kind="static", friction=0.5)
    sizes, turns, aside, speeds = draw(0.2, 0.6, (n, 3)), draw(-1.0, 1.0, (n, 4)), draw(-0.1, 0.1, (n, 2)), draw(-1.0, 1.0, (n, 6))
    floor = 0.0
    for k in range(n):
        upright = family == "stacked"
        height = sizes[k, 2] if upright else np.sqrt((sizes[k] * sizes[k]).sum())
        place = ([*aside[k], floor + height / 2], [1, 0, 0, 0] if upright else turns[k])
        floor += height
        moves = {"velocity": speeds[k, :3], "angular_velocity": speeds[k, 3:]} if family == "thrown" else {}
        scene.add(box_tree(f"box {k}", sizes[k]), place, density=1000.0, friction=0.5, restitution=0.3 * (family == "thrown"), **moves)
    return scene


def judge_dynamics(seed, block, count, tally, faults):
    run = touchstone.Simulation(make_scene(seed, block))
    energy = run.energy
    note(tally, deep=0, failed=0)
    while not run.is_over:
        try:
            run.advance(LOOK_EVERY)
        except RuntimeError as error:
            faults.append([block, run.steps, f"failed: {error}", -1.0])
            note(tally, failed=1)
            break
        depth, gain = run.worst_depth, run.energy - energy
        energy = run.energy
        note(tally, looked_at=1, contacts=run.last_step["contacts"], unconverged=run.last_step["unconverged"], worst_depth_m=depth, worst_gain_J=gain)
        if not depth <= MOST_DEPTH:  # NaN is, too
            faults.append([block, run.steps, "deep", float(np.nan_to_num(depth, nan=-1.0))])
            note(tally, deep=1)
    note(tally, runs=count, steps=run.steps)


JUDGES = {"pairs": judge_pairs, "flights": judge_flights, "dynamics": judge_dynamics}


def parse_shard(text):
    try:
        k, n = (int(part) for part in text.split("/"))
    except ValueError:
        k, n = 0, 0
    if not 1 <= k <= n:
        raise argparse.ArgumentTypeError(f"'{text}' is no shard, 3/64 is the third of 64")
    return k, n


def shard_root(seed, kind, total, k, n):
    """Shard k of n: what its file holds."""
    each = BLOCKS[kind]
    blocks = -(-total // each)
    tallies, faults = {name: {} for name in FAMILIES[kind]}, []
    mine = range(k - 1, blocks, n)
    for done, block in enumerate(mine):
        JUDGES[kind](seed, block, min(each, total - block * each), tallies[family_of(kind, block)], faults)
        if done % 20 == 19:
            print(f"shard {k}/{n}: {done + 1} of {len(mine)} blocks", file=sys.stderr)
    settings = {"seed": seed, kind: total, "block": each, "version": touchstone.__version__}
    return {"schema": SCHEMA, "settings": settings, "shard": [k, n], "families": tallies, "faults": faults[:FAULTS_KEPT]}


def asked(options):
    """What, and how many."""
    given = [(kind, getattr(options, kind)) for kind in BLOCKS if getattr(options, kind) is not None]
    return given[0] if given else ("pairs", 100_000)


def run(options):
    k, n = options.shard
    root = shard_root(options.seed, *asked(options), k, n)
    options.out.mkdir(parents=True, exist_ok=True)
    write(options.out / f"shard_{k}_of_{n}.json", root)


def run_dask(options):
    """A worker that dies is no loss: its shards are run again elsewhere."""
    try:
        import distributed
    except ImportError:
        sys.exit("Python package 'distributed' is not installed (Debian: python3-distributed; PyPI: distributed)")
    where = options.scheduler or distributed.LocalCluster(n_workers=options.workers, threads_per_worker=1, dashboard_address=None)
    with distributed.Client(where) as client:
        print(f"scheduler: {client.scheduler.address}", file=sys.stderr, flush=True)
        waiting = [client.submit(shard_root, options.seed, *asked(options), k, options.shards, retries=3) for k in range(1, options.shards + 1)]
        shards = {}
        for future, root in distributed.as_completed(waiting, with_results=True):
            shards[tuple(root["shard"])] = root
            print(f"{len(shards)} of {options.shards} shards", file=sys.stderr, flush=True)
    return write_merged(shards, options.out)


def write(path, root):
    """Whole or not at all."""
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    part.write_text(json.dumps(root, indent=1, sort_keys=True) + "\n")
    os.replace(part, path)
    print(path)


def load(path):
    try:
        root = json.loads(path.read_text())
        shard = tuple(root["shard"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        sys.exit(f"{path}: no shard's file ({type(error).__name__})")
    if root.get("schema") != SCHEMA:
        sys.exit(f"{path}: schema is {root.get('schema')!r}, must be {SCHEMA!r}")
    return shard, root


def merge(options):
    shards = {}
    for path in options.files:
        shard, root = load(path)
        if shards.setdefault(shard, root) != root:
            sys.exit(f"{path}: shard {shard[0]}/{shard[1]} is there twice, and the two differ")
    return write_merged(shards, options.out)


def write_merged(shards, path):
    """The shards' files, by (k, n), as one: the same bytes in any order."""
    (first, *others) = shards.values()
    if any(root["settings"] != first["settings"] or root["shard"][1] != first["shard"][1] for root in others):
        sys.exit("the files are of different campaigns")
    n = first["shard"][1]
    lost = [f"{k}/{n}" for k in range(1, n + 1) if (k, n) not in shards]
    if lost:
        sys.exit(f"lost: {' '.join(lost)}")
    families = {}
    for root in shards.values():
        for name, tally in root["families"].items():
            note(families.setdefault(name, {}), **tally)
    faults = sorted(fault for root in shards.values() for fault in root["faults"])[:FAULTS_KEPT]
    write(path, {"schema": SCHEMA, "settings": first["settings"], "families": families, "faults": faults})
    return 1 if faults else 0


def positive(text):
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is not above 0")
    return value


def add_kinds(parser):
    kinds = parser.add_mutually_exclusive_group()
    for kind in BLOCKS:
        kinds.add_argument(f"--{kind}", type=positive, help="how many (100000 pairs unless one of these is given)")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(required=True)
    one = commands.add_parser("run", help="one shard, or all")
    add_kinds(one)
    one.add_argument("--seed", type=int, default=1)
    one.add_argument("--shard", type=parse_shard, default=(1, 1), help="3/64: the third of 64")
    one.add_argument("--out", type=pathlib.Path, default=pathlib.Path("shards"), help="folder")
    one.set_defaults(call=run)
    all_of = commands.add_parser("merge", help="the shards' files to one")
    all_of.add_argument("files", type=pathlib.Path, nargs="+")
    all_of.add_argument("--out", type=pathlib.Path, default=pathlib.Path("campaign.json"))
    all_of.set_defaults(call=merge)
    spread = commands.add_parser("dask", help="all shards on Dask's workers")
    add_kinds(spread)
    spread.add_argument("--seed", type=int, default=1)
    spread.add_argument("--shards", type=int, default=64)
    spread.add_argument("--workers", type=int, default=os.cpu_count(), help="of a local cluster")
    spread.add_argument("--scheduler", help="address of one that runs; none: a local cluster")
    spread.add_argument("--out", type=pathlib.Path, default=pathlib.Path("campaign.json"))
    spread.set_defaults(call=run_dask)
    options = parser.parse_args()
    if "exact" not in touchstone.backends():
        sys.exit("this build has no exact (Debian: libgmp-dev)")
    sys.exit(options.call(options))


if __name__ == "__main__":
    main()
