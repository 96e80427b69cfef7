"""`pip install .` from a checkout: the root's build backend is found, and makes this package."""

import importlib.util
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import touchstone

ROOT = pathlib.Path(os.environ["TOUCHSTONE_SOURCE"])

# As pip asks: in the root, by the backend and path that its pyproject.toml names (tomllib is Python 3.11's).
ASK = """
import re, sys, importlib
text = open("pyproject.toml").read()
sys.path.insert(0, re.search(r'backend-path = \\["(.*)"\\]', text)[1])
backend = importlib.import_module(re.search(r'build-backend = "(.*)"', text)[1])
print(backend.prepare_metadata_for_build_wheel(sys.argv[1]))
"""


@unittest.skipUnless(importlib.util.find_spec("setuptools") and importlib.util.find_spec("wheel"), "needs setuptools, wheel")
class Install(unittest.TestCase):
    def metadata(self, pybind11):
        """What the package says of itself where that pybind11 is installed."""
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "pybind11.py").write_text(f"version_info = {pybind11}\ndef get_cmake_dir(): return '/nowhere'\n")
            told = subprocess.run([sys.executable, "-B", "-c", ASK, folder], cwd=ROOT, capture_output=True, text=True,
                                  env=os.environ | {"PYTHONPATH": folder})
            self.assertEqual(told.returncode, 0, told.stderr)
            return (pathlib.Path(folder) / told.stdout.splitlines()[-1] / "METADATA").read_text()

    def test_from_the_root(self):
        metadata = self.metadata((3, 0, 1))
        self.assertIn("\nName: touchstone\n", metadata)
        self.assertIn(f"\nVersion: {touchstone.__version__}\n", metadata)
        self.assertIn("\nRequires-Dist: numpy\n", metadata)

    def test_numpy_2_is_asked_for_only_where_it_is_read_rightly(self):
        self.assertRegex(self.metadata((2, 11, 9)), r"\nRequires-Dist: numpy ?\(?<2\)?\n")  # as setuptools has it
        self.assertIn("\nRequires-Dist: numpy\n", self.metadata((2, 12, 0)))


if __name__ == "__main__":
    unittest.main()
