"""Every script of the gallery makes its picture, where there is matplotlib."""

import importlib.util
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

FOLDER = pathlib.Path(os.environ["TOUCHSTONE_SOURCE"]) / "examples" / "python"
SCRIPTS = sorted(path.stem for path in FOLDER.glob("*.py") if path.stem not in ("campaign", "pictures"))


class Gallery(unittest.TestCase):
    @unittest.skipUnless(importlib.util.find_spec("matplotlib"), "no matplotlib")
    def test_scripts_make_pictures(self):
        self.assertEqual(len(SCRIPTS), 5)
        for script in SCRIPTS:
            with self.subTest(script), tempfile.TemporaryDirectory() as folder:
                subprocess.run([sys.executable, "-B", FOLDER / f"{script}.py", "--out", folder], check=True,
                               stdout=subprocess.DEVNULL)
                picture = pathlib.Path(folder) / f"{script}.png"
                self.assertEqual(picture.read_bytes()[:4], b"\x89PNG")
                self.assertGreater(picture.stat().st_size, 10000)

    def test_without_matplotlib_they_say_what_is_missing(self):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "matplotlib.py").write_text("raise ImportError('hidden')")
            paths = os.pathsep.join([folder, os.environ["PYTHONPATH"]])
            run = subprocess.run([sys.executable, "-B", FOLDER / f"{SCRIPTS[0]}.py"], capture_output=True, text=True,
                                 env={**os.environ, "PYTHONPATH": paths})
            self.assertEqual(run.returncode, 1)
            self.assertIn("python3-matplotlib", run.stderr)


if __name__ == "__main__":
    unittest.main()
