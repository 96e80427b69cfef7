"""The build backend of the project's root: setuptools' own, at work in this folder."""

import os
import pathlib

os.chdir(pathlib.Path(__file__).resolve().parent)  # pip names what it wants written by absolute paths

from setuptools.build_meta import *  # noqa: E402,F401,F403
