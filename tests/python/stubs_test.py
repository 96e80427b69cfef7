"""The stubs say what the module has, no more and no less; and what is there says what it is."""

import ast
import builtins
import inspect
import pathlib
import re
import unittest

import touchstone
from touchstone import results

CORE = touchstone._core
STUBS = ast.parse((pathlib.Path(touchstone.__file__).parent / "_core.pyi").resolve().read_text())


def arguments_in_stub(function):
    names = [a.arg for a in function.args.args + function.args.kwonlyargs if a.arg != "self"]
    return names


def arguments_in_doc(doc):
    """Of pybind11's first line: name(self: T, a: U = ..., b: V) -> W."""
    line = doc.splitlines()[0]
    return [name for name in re.findall(r"[(,]\s*\*{0,2}(\w+)(?=:)", re.sub(r"\[[^\]]*\]", "", line)) if name != "self"]


class Stubs(unittest.TestCase):
    def test_names_of_the_module(self):
        said = {node.name for node in STUBS.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
        there = {name for name in dir(CORE) if not name.startswith("_")}
        optional = {"load_plugin", "start_engine", "load_dynamic_scene"}
        self.assertEqual(there - said, set())
        self.assertEqual(said - there - optional, set())
        # Names of types alone are no names of the module's.
        types = {target.id for node in STUBS.body if isinstance(node, ast.Assign) for target in node.targets}
        self.assertEqual({name for name in types if not name.startswith("_")}, set())

    def test_every_name_that_types_use_is_there(self):
        there = set(dir(builtins))
        for node in ast.walk(STUBS):
            if isinstance(node, (ast.Import, ast.ImportFrom)):
                there |= {alias.asname or alias.name for alias in node.names}
            elif isinstance(node, (ast.ClassDef, ast.FunctionDef)):
                there.add(node.name)
            elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                there.add(node.id)
        used = {node.id for node in ast.walk(STUBS) if isinstance(node, ast.Name)}
        for node in ast.walk(STUBS):  # "Hexahedron" of a type that stands before the class
            if isinstance(node, ast.Subscript):
                used |= {part.value for part in ast.walk(node.slice) if isinstance(part, ast.Constant) and isinstance(part.value, str)}
        self.assertEqual(used - there, set())

    def test_members_of_classes(self):
        for node in (n for n in STUBS.body if isinstance(n, ast.ClassDef) and n.name != "InputError"):
            with self.subTest(node.name):
                said = {n.name for n in node.body if isinstance(n, ast.FunctionDef)}
                said |= {n.target.id for n in node.body if isinstance(n, ast.AnnAssign)}
                there = {name for name in vars(getattr(CORE, node.name)) if not name.startswith("_")}
                self.assertEqual(there - said, set())
                self.assertEqual({name for name in said if not name.startswith("_")} - there, set())

    def test_names_of_arguments(self):
        looked_at = 0
        for node in (n for n in STUBS.body if isinstance(n, ast.ClassDef) and n.name != "InputError"):
            for function in (n for n in node.body if isinstance(n, ast.FunctionDef)):
                member = inspect.getattr_static(getattr(CORE, node.name), function.name)
                if function.decorator_list or not getattr(member, "__doc__", None):
                    continue
                said, there = arguments_in_stub(function), arguments_in_doc(member.__doc__)
                if any(name.startswith("arg") for name in there) or function.name.startswith("__") and function.name != "__init__":
                    continue
                with self.subTest(f"{node.name}.{function.name}"):
                    self.assertEqual(said, [name for name in there if name != "args"])
                    looked_at += 1
        self.assertGreater(looked_at, 20)

    def test_what_is_no_part_of_the_module_has_types_too(self):
        self.assertIn("__version__", {node.target.id for node in STUBS.body if isinstance(node, ast.AnnAssign)})
        for of in (results, results.Results, results.Answers):
            for name, function in inspect.getmembers(of, inspect.isfunction):
                with self.subTest(name):
                    self.assertEqual(set(inspect.signature(function).parameters) - {"self"} - set(function.__annotations__), set())
                    self.assertIn("return", function.__annotations__)

    def test_every_class_and_function_has_a_docstring(self):
        for name in touchstone.__all__:
            self.assertTrue(inspect.getdoc(getattr(touchstone, name)), name)

    def test_every_member_has_one(self):
        signature = re.compile(r"(\d+\. )?\w+\(.*\)( -> .*)?$")
        looked_at = 0
        for name, of in inspect.getmembers(CORE, inspect.isclass):
            for member, value in vars(of).items():
                if member.startswith("_") or member in Exception.__dict__:
                    continue
                with self.subTest(f"{name}.{member}"):
                    lines = (inspect.getdoc(value) or "").splitlines()
                    self.assertTrue([line for line in lines if line.strip() and not signature.match(line.strip())])
                    looked_at += 1
        self.assertGreater(looked_at, 100)


if __name__ == "__main__":
    unittest.main()
