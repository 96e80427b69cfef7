"""Contact detection for convex hexahedra.

SI units, float64. ``X_WA`` is the pose of frame A in world W, ``p_A_W`` a point on A in W's axes, ``n_AB_W`` the unit normal from
A to B. Separations are signed: above 0 apart, below 0 overlapping; touching is contact. Bad input raises ``InputError`` (a
``ValueError``), or ``TypeError`` for what is no array of numbers.

    >>> import numpy as np, touchstone
    >>> box = touchstone.Hexahedron.box([1, 1, 1])
    >>> check = touchstone.Narrowphase("native", [box, box])
    >>> poses = touchstone.Poses([[0.0, 0, 0], [1.5, 0, 0]], [[1, 0, 0, 0], [1, 0, 0, 0]])
    >>> check.distance(poses, [[0, 1]]).geometry["separation"]
    array([0.5])
"""

from enum import IntEnum

from . import _core
from ._core import *  # noqa: F401,F403
from ._core import __version__  # noqa: F401


class Status(IntEnum):
    """An answer about one pair: the values of ``Answers.status``."""

    SEPARATED = 0  #: apart by more than the declared resolution
    OVERLAPPING = 1  #: touching or penetrating
    UNDECIDED = 2  #: closer to touching than the declared resolution; carries geometry
    FAILED = 3  #: no answer was found; carries nothing
    UNSUPPORTED = 4  #: the backend does not answer this query; carries nothing


class EventKind(IntEnum):
    """An event of a frame: the values of the field ``kind`` of ``FrameReport.events``."""

    NEAR = 0  #: within the warn distance, at the frame's end
    BEGAN = 1  #: came within the gap
    PERSISTS = 2  #: still within twice the gap, at the frame's end
    ENDED = 3  #: further apart than twice the gap again
    PENETRATING_AT_START = 4  #: overlaps at the frame's start
    BLOCKED = 5  #: stopped its movers
    REFUSED = 6  #: a command that is none
    AT_LIMIT = 7  #: a joint was told to go beyond its limits


__all__ = [name for name in dir(_core) if not name.startswith("_")] + ["EventKind", "Status"]
