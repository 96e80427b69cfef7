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
    def test_from_the_root(self):
        with tempfile.TemporaryDirectory() as folder:
            told = subprocess.run([sys.executable, "-B", "-c", ASK, folder], cwd=ROOT, capture_output=True, text=True)
            self.assertEqual(told.returncode, 0, told.stderr)
            metadata = (pathlib.Path(folder) / told.stdout.splitlines()[-1] / "METADATA").read_text()
        self.assertIn("\nName: touchstone\n", metadata)
        self.assertIn(f"\nVersion: {touchstone.__version__}\n", metadata)


if __name__ == "__main__":
    unittest.main()
