"""Does a test notice a changed line? Changes one thing at a time in the core rooms and runs the tests of that module.

    python tools/mutants.py --number 200 --seed 1        about an hour on two cores (`make mutants`)
    python tools/mutants.py --module mien.core.timeline    all of one module

A mutant is a comparison, a sign, a number, a truth value or a boundary that is another one. It is killed if a doctest
of the module, the test file that mirrors it, or one that names it fails, or takes more than two minutes of processor
time; quick tests are tried before slow ones. A module whose tests fail unchanged is left out and listed. It works on a
copy: the files of the project are never touched.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from queue import Queue

ROOT = Path(__file__).parent.parent
ROOMS = ("core", "text", "animation", "motion", "metrics", "pipeline")
SECONDS = 120  # of processor time
LIMITED = (
    "import resource, sys, pytest; "
    f"resource.setrlimit(resource.RLIMIT_CPU, ({SECONDS}, {SECONDS})); sys.exit(pytest.main(sys.argv[1:]))"
)
NO_TESTS = 5  # what pytest returns when none was chosen
QUICK, SLOW = "not slow", "slow"
_COMPARED = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq}
_WORKED = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}


@dataclass(frozen=True)
class Mutant:
    """A file with one thing in it changed."""

    path: Path
    line: int
    was: str
    text: str


class _Changing(ast.NodeTransformer):
    """Changes the thing of one number; counts all."""

    def __init__(self, number: int) -> None:
        self.number, self.count, self.place = number, 0, (0, "")

    def _mine(self, node: ast.expr | ast.stmt, was: str) -> bool:
        self.count += 1
        if self.count - 1 == self.number:
            self.place = node.lineno, was
            return True
        return False

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        self.generic_visit(node)
        other = _COMPARED.get(type(node.ops[0]))
        if other is not None and self._mine(node, ast.unparse(node)):
            node.ops[0] = other()
        return node

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        other = _WORKED.get(type(node.op))
        text = isinstance(node.left, ast.Constant | ast.JoinedStr) and not isinstance(
            getattr(node.left, "value", None), int | float
        )
        if other is not None and not text and self._mine(node, ast.unparse(node)):
            node.op = other()
        return node

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.AST:
        self.generic_visit(node)
        if self._mine(node, ast.unparse(node)):
            node.op = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if type(node.value) in (int, float) and self._mine(node, repr(node.value)):
            return ast.copy_location(ast.Constant(node.value + 1), node)
        if type(node.value) is bool and self._mine(node, repr(node.value)):
            return ast.copy_location(ast.Constant(not node.value), node)
        return node

    def visit_Expr(self, node: ast.Expr) -> ast.AST:
        return node if isinstance(node.value, ast.Constant) else self.generic_visit(node)


def _changed(source: str, number: int) -> tuple[ast.Module, _Changing]:
    tree, change = ast.parse(source), _Changing(number)
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            change.visit(node)
    return tree, change


def places_in(path: Path) -> int:
    """How many things in a file can be changed; tables of constants at its top and annotations are left alone."""
    return _changed(path.read_text(encoding="utf-8"), -1)[1].count


def mutant(path: Path, number: int) -> Mutant:
    """The file with one thing changed."""
    tree, change = _changed(path.read_text(encoding="utf-8"), number)
    return Mutant(path, *change.place, ast.unparse(ast.fix_missing_locations(tree)))


def tests_of(path: Path) -> list[str]:
    """Where the module is tested: itself (doctests), its mirror, and test files that import it."""
    module = ".".join(path.relative_to(ROOT / "src").with_suffix("").parts)
    parent, name = module.rpartition(".")[::2]
    said = (f"from {module} import", f"import {module}\n", f"from {parent} import {name}\n")
    files = [
        test
        for test in sorted((ROOT / "tests").rglob("test_*.py"))
        if any(form in test.read_text(encoding="utf-8") for form in said) or test.name == f"test_{name}.py"
    ]
    mirror = [test for test in files if test.name == f"test_{name}.py"]
    return [str(test.relative_to(ROOT)) for test in (*mirror, *(test for test in files if test not in mirror))][:6]


def tests_pass(path: Path, copy: Path, which: str) -> bool:
    """Whether the tests of a module pass in the copy: those that are "not slow", or the "slow" ones."""
    tests = [str(copy / path.relative_to(ROOT)), *tests_of(path)]
    command = [sys.executable, "-c", LIMITED, "-x", "-q", "-p", "no:cacheprovider", *tests, "-m", which]
    environment = {**os.environ, "PYTHONPATH": str(copy / "src")}
    done = subprocess.run(command, cwd=copy, env=environment, capture_output=True, check=False)
    return done.returncode in (0, NO_TESTS)


def _write_anew(target: Path, text: str) -> None:
    """Write a source file whose compiled form is not to be taken for that of the text before it."""
    target.write_text(text, encoding="utf-8")
    for compiled in target.parent.glob(f"__pycache__/{target.stem}.*.pyc"):
        compiled.unlink()


def survives(mutant: Mutant, copy: Path) -> bool:
    """Whether all tests pass with the change in: the quick ones, and only then the slow ones that pass without it."""
    target = copy / mutant.path.relative_to(ROOT)
    kept = target.read_text(encoding="utf-8")
    for which in (QUICK, SLOW):
        if not _sound(mutant.path, copy, which):
            continue
        _write_anew(target, mutant.text)
        try:
            if not tests_pass(mutant.path, copy, which):
                return False
        finally:
            _write_anew(target, kept)
    return True


def main() -> None:
    """Make mutants, run their tests, print the survivors and the share that was killed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--number", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="how many are tried at once")
    parser.add_argument("--module", help="only this one, such as mien.core.timeline, and all of its mutants")
    options = parser.parse_args()
    if options.module:
        files = [ROOT / "src" / (options.module.replace(".", "/") + ".py")]
    else:
        files = sorted(path for room in ROOMS for path in (ROOT / "src/mien" / room).rglob("*.py"))
    places = [(path, number) for path in files if tests_of(path) for number in range(places_in(path))]
    if not options.module:
        places = random.Random(options.seed).sample(places, min(options.number, len(places)))
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(options.workers) as workers:
        copies: Queue[Path] = Queue()
        for number in range(options.workers):
            copies.put(_copied(Path(folder) / str(number)))
        judge = partial(_judged, copies)
        found = alive = 0
        for done, told in enumerate(workers.map(judge, [mutant(*place) for place in sorted(places)]), start=1):
            found += told is not None
            alive += bool(told)
            if told:
                print(f"{done}/{len(places)} survived: {told}", flush=True)
        print(f"{found - alive} of {found} mutants killed ({(found - alive) / max(found, 1):.0%})")


def _copied(folder: Path) -> Path:
    """A copy of the project to make changes in."""
    for name in ("src", "tests", "tools", "benchmarks", "examples", "docs"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "constraints.txt"):
        shutil.copy(ROOT / name, folder / name)
    return folder


def _judged(copies: Queue[Path], change: Mutant) -> str | None:
    """Where a mutant survived and what was changed, "" if it was killed, None if its tests fail unchanged."""
    copy = copies.get()
    try:
        if not _sound(change.path, copy, QUICK):
            return None
        if not survives(change, copy):
            return ""
        return f"{change.path.relative_to(ROOT)}:{change.line}: {change.was[:80]}"
    finally:
        copies.put(copy)


_KNOWN: dict[tuple[Path, str], bool] = {}


def _sound(path: Path, copy: Path, which: str) -> bool:
    """Whether the tests of a module pass unchanged; each asked once, or twice if two want to know at once."""
    if (path, which) not in _KNOWN:
        _KNOWN[path, which] = tests_pass(path, copy, which)
        if not _KNOWN[path, which]:
            print(f"left out, {which} tests fail unchanged: {path.relative_to(ROOT)}", flush=True)
    return _KNOWN[path, which]


if __name__ == "__main__":
    main()
