"""The module runs on any processor of its type: kernels are chosen when it is loaded, and none of them shows in an answer."""

import os
import platform
import shutil
import subprocess
import sys
import unittest

ANSWERS = """
import hashlib, numpy as np, touchstone
random = np.random.default_rng(11)
n = 60
corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
solids = [touchstone.Hexahedron.box(size) for size in random.uniform(0.2, 1, (n, 3))]
solids += [touchstone.Hexahedron(corners * size + [0.3, 0, 0] * (corners[:, 1:2] > 0)) for size in random.uniform(0.2, 1, (n, 3))]
poses = touchstone.Poses(random.uniform(-1, 1, (2 * n, 3)), random.normal(size=(2 * n, 4)))
pairs = np.argwhere(np.triu(np.ones((2 * n, 2 * n)), 1)).astype(np.uint32)
check = touchstone.Narrowphase("native", solids)
found = [check.overlap(poses, pairs).status]
for query in (check.distance, check.manifold):
    answers = query(poses, pairs)
    found += [answers.status, *(answers.geometry[name] for name in ("separation", "n_AB_W", "p_A_W", "p_B_W"))]
assert 500 < np.count_nonzero(found[0] == touchstone.Status.OVERLAPPING) < len(pairs) - 500
print(touchstone.instruction_set(), hashlib.sha256(b"".join(np.ascontiguousarray(f).tobytes() for f in found)).hexdigest())
"""
EMULATOR = shutil.which("qemu-x86_64-static") or shutil.which("qemu-x86_64")


def run(*prefix, isa=None, script=ANSWERS):
    environment = {**os.environ, "TOUCHSTONE_ISA": isa or "", "OPENBLAS_NUM_THREADS": "1"}
    return subprocess.run([*prefix, sys.executable, "-B", "-c", script], capture_output=True, text=True, env=environment)


class InstructionSets(unittest.TestCase):
    def answers(self, *prefix, isa=None):
        done = run(*prefix, isa=isa)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.split()

    def test_every_one_gives_the_same_bits(self):
        chosen, expected = self.answers()
        self.assertIn(chosen, ("generic", "avx2", "avx512"))
        self.assertEqual(self.answers(isa="generic"), ["generic", expected])
        self.assertEqual(self.answers(isa="avx2")[1], expected)  # or what there is, on a processor without it

    def test_one_that_nobody_knows_is_an_error(self):
        done = run(isa="avx3", script="import touchstone")
        self.assertIn("ImportError: TOUCHSTONE_ISA=avx3: there is no such instruction set", done.stderr)

    @unittest.skipUnless(platform.machine() == "x86_64" and EMULATOR, "not installed: qemu-x86_64 (Debian: qemu-user-static)")
    def test_a_processor_without_avx_is_served_by_the_plain_kernels(self):
        """The first x86-64 processors: no SSSE3, no SSE4, no AVX. An instruction beyond them ends the process there."""
        self.assertEqual(self.answers(EMULATOR, "-cpu", "qemu64"), ["generic", self.answers()[1]])


if __name__ == "__main__":
    unittest.main()
