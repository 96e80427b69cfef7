"""Builds touchstone._core with CMake. Options for it: CMAKE_ARGS="-D TOUCHSTONE_WITH_BULLET=OFF ..." pip install ."""

import os
import pathlib
import re
import shlex
import subprocess
import sys
import sysconfig

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

HERE = pathlib.Path(__file__).resolve().parent
PROJECT = HERE.parent.parent


def version():
    found = re.search(r"project\(touchstone VERSION ([\d.]+)", (PROJECT / "CMakeLists.txt").read_text())
    if found is None:
        raise SystemExit("touchstone: install from a checkout: pip install .")
    return found.group(1)


def find_pybind11():
    """Its CMake folder, or None where it is the system's, and its version, (2, 12) or so."""
    try:  # PyPI's, where it is installed; else CMake looks for the system's
        import pybind11

        return pybind11.get_cmake_dir(), tuple(pybind11.version_info[:2])
    except ImportError:
        pass
    for include in (sysconfig.get_config_var("prefix") + "/include", "/usr/include"):
        header = pathlib.Path(include) / "pybind11" / "detail" / "common.h"
        if header.exists():
            found = re.findall(r"define PYBIND11_VERSION_(?:MAJOR|MINOR)\s+(\d+)", header.read_text())
            return None, tuple(map(int, found))
    return None, (0, 0)


def wanted_numpy():
    """What this module takes: built with pybind11 before 2.12 it would misread arrays of NumPy 2."""
    return "numpy" if find_pybind11()[1] >= (2, 12) else "numpy < 2"


class CMakeBuild(build_ext):
    """The module alone, in the project's build/python3.11 or so: what was built stays for the next time."""

    def build_extension(self, ext):
        folder = PROJECT / "build" / f"python{sys.version_info.major}.{sys.version_info.minor}"
        folder.mkdir(parents=True, exist_ok=True)
        options = ["-D", "CMAKE_BUILD_TYPE=Release", "-D", f"Python_EXECUTABLE={sys.executable}", "-D", "TOUCHSTONE_WITH_PYTHON=ON",
                   "-D", "TOUCHSTONE_BUILD_TESTS=OFF", "-D", "TOUCHSTONE_BUILD_EXAMPLES=OFF", "-D", "TOUCHSTONE_INSTALL=OFF",
                   "-D", "TOUCHSTONE_PRECOMPILED_HEADERS=ON", "-D", "TOUCHSTONE_UNITY_BUILD=ON"]
        cmake_folder = find_pybind11()[0]
        if cmake_folder is not None:
            options += ["-D", f"pybind11_DIR={cmake_folder}"]
        subprocess.run(["cmake", "-S", str(PROJECT), "-B", str(folder), "--log-level=NOTICE", *options,
                        *shlex.split(os.environ.get("CMAKE_ARGS", ""))], check=True)
        jobs = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count() or 1))
        subprocess.run(["cmake", "--build", str(folder), "--target", "touchstone_python", "-j", jobs], check=True)
        module = next((folder / "python" / "touchstone").glob("_core*"))
        target = pathlib.Path(self.get_ext_fullpath(ext.name)).resolve()
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(module.read_bytes())
        target.chmod(0o755)


setup(version=version(), install_requires=[wanted_numpy()], ext_modules=[Extension("touchstone._core", sources=[])],
      cmdclass={"build_ext": CMakeBuild})
