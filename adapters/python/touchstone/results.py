"""What compare_backends wrote, as tables.

``read_results`` reads a report's results.json, ``read_answers`` the answers about one's own pairs (--answers, JSON). Tables are lists of
dicts; ``frame()`` makes a pandas.DataFrame of one where pandas is there (Debian: python3-pandas). The figure "inf" of the files is
``math.inf``, null is left out (NaN in frames). Names and units are the files': ``_ns`` a pair, ``_m``, ``_over_S`` by the pair's scale.
"""

import json
import math
import os
import pathlib
from typing import Any, Dict, Iterator, List, Tuple, Union

from ._core import InputError

Row = Dict[str, Any]

_SCHEMA, _ANSWERS = "touchstone.compare_backends/2", "touchstone.compare_backends.answers/1"


def frame(rows: List[Row]) -> Any:
    """The rows as a pandas.DataFrame."""
    try:
        import pandas
    except ImportError as error:
        raise ImportError("no pandas (Debian: python3-pandas); the table itself is a list of dicts") from error
    return pandas.DataFrame.from_records(rows)


def _load(name: Union[str, os.PathLike[str]], schema: str) -> Any:
    path = pathlib.Path(name)
    if path.is_dir():
        path /= "results.json"
    try:
        root = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from error
    except ValueError as error:
        raise InputError(f"{path}: no JSON: {error}") from error
    found = root.get("schema") if isinstance(root, dict) else None
    if found != schema:
        raise InputError(f"{path}: schema is {found!r}, must be {schema!r}")
    return root


def _value(value: Any) -> Any:
    return {"inf": math.inf, "-inf": -math.inf}.get(value, value) if isinstance(value, str) else value


def _flat(prefix: str, value: Any, row: Row) -> Row:
    """Dicts become columns a_b_c; lists stay out: they are tables of their own."""
    if isinstance(value, dict):
        for key, below in value.items():
            _flat(f"{prefix}_{key}" if prefix else key, below, row)
    elif value is not None and not isinstance(value, list):
        row[prefix] = _value(value)
    return row


class Results:
    """A report. ``root`` is the whole file; methods are tables of it."""

    def __init__(self, root: Row) -> None:
        self.root = root

    def _backends(self) -> Iterator[Tuple[Row, Row]]:
        for pairs in self.root["pair_sets"]:
            for backend in pairs["backends"]:
                yield {"set": pairs["name"], "backend": backend["backend"]}, backend

    def backends(self) -> List[Row]:
        """A row a backend: name, description."""
        return [_flat("", backend, {}) for backend in self.root["backends"]]

    def queries(self) -> List[Row]:
        """A row a set, backend and query: times of every kind of call [ns a pair], wrong answers, worst cost."""
        rows: List[Row] = []
        for head, backend in self._backends():
            for query, of in backend.get("queries", {}).items():
                rows.append(_flat("", of, {**head, "query": query}))
        return rows

    def errors(self) -> List[Row]:
        """A row a set, backend and measure of error: median, p99 and worst, over_S and over_size, or a ratio."""
        rows: List[Row] = []
        for head, backend in self._backends():
            for measure, of in backend.get("errors", {}).items():
                rows.append(_flat("", of, {**head, "measure": measure}))
        return rows

    def wrong_cases(self) -> List[Row]:
        """A row a wrong answer that the file lists: case, cost_m, reason."""
        rows: List[Row] = []
        for head, backend in self._backends():
            for query, of in backend.get("queries", {}).items():
                rows += [_flat("", case, {**head, "query": query}) for case in of.get("wrong_cases", [])]
        return rows


class Answers:
    """Answers about pairs of a file."""

    def __init__(self, root: Row) -> None:
        self.root = root

    def answers(self) -> List[Row]:
        """A row a case and backend: status, separation, normal_0 ... witness_b_2, exact_class, exact_separation;
        invalid cases have their reason."""
        rows: List[Row] = []
        for case in self.root["cases"]:
            head = _flat("", case, {})
            for answer in case.get("answers", [{}]):
                row = _flat("", answer, dict(head))
                for name in ("normal", "witness_a", "witness_b"):
                    for i, value in enumerate(answer.get(name) or []):
                        row[f"{name}_{i}"] = _value(value)
                rows.append(row)
        return rows


def read_results(path: Union[str, os.PathLike[str]]) -> Results:
    """A Results of a results.json, or of the folder that holds it. Raises InputError naming the file."""
    return Results(_load(path, _SCHEMA))


def read_answers(path: Union[str, os.PathLike[str]]) -> Answers:
    """An Answers of a file of answers. Raises InputError naming the file."""
    return Answers(_load(path, _ANSWERS))
