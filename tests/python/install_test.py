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
    def metadata(self, pybind11, header=None):
        """What the package says of itself where PyPI's pybind11 is the given one, or, None, a system's is that of the header."""
        with tempfile.TemporaryDirectory() as folder:
            found = f"version_info = {pybind11}\ndef get_cmake_dir(): return '/nowhere'\n"
            (pathlib.Path(folder) / "pybind11.py").write_text(found if pybind11 else "raise ImportError\n")
            if header is not None:
                at = pathlib.Path(folder) / "include" / "pybind11" / "detail" / "common.h"
                at.parent.mkdir(parents=True)
                at.write_text(header)
            if pybind11 is None:  # nor is the machine's own looked at
                (pathlib.Path(folder) / "sitecustomize.py").write_text(
                    "import pathlib, sysconfig\n"
                    f"sysconfig.get_config_var = lambda name, of=sysconfig.get_config_var: {folder!r} if name == 'prefix' else of(name)\n"
                    "pathlib.Path.exists = lambda self, of=pathlib.Path.exists: not str(self).startswith('/usr/include') and of(self)\n")
            told = subprocess.run([sys.executable, "-B", "-c", ASK, folder], cwd=ROOT, capture_output=True, text=True,
                                  env=os.environ | {"PYTHONPATH": folder})
            self.assertEqual(told.returncode, 0, told.stderr)
            return (pathlib.Path(folder) / told.stdout.splitlines()[-1] / "METADATA").read_text()

    def test_from_the_root(self):
        metadata = self.metadata((2, 12, 0))  # the first that knows NumPy 2
        self.assertIn("\nName: touchstone\n", metadata)
        self.assertIn(f"\nVersion: {touchstone.__version__}\n", metadata)
        self.assertIn("\nRequires-Dist: numpy\n", metadata)

    def test_numpy_2_is_asked_for_only_where_it_is_read_rightly(self):
        self.assertRegex(self.metadata((2, 11, 9)), r"\nRequires-Dist: numpy ?\(?<2\)?\n")  # as setuptools has it

    def test_a_system_s_pybind11_is_read_from_its_header(self):
        for major, minor, wanted in ((2, 10, r" ?\(?<2\)?"), (2, 13, "")):
            header = f"#define PYBIND11_VERSION_MAJOR {major}\n#define PYBIND11_VERSION_MINOR {minor}\n#define PYBIND11_VERSION_PATCH 0\n"
            self.assertRegex(self.metadata(None, header), f"\nRequires-Dist: numpy{wanted}\n")
        self.assertRegex(self.metadata(None), r"\nRequires-Dist: numpy ?\(?<2\)?\n")  # none at all: CMake says so


if __name__ == "__main__":
    unittest.main()
