"""The layers of the source, and the rules that follow from them, checked on the syntax tree alone.

Every rule takes `sources`, the text of each module by its path from the repository root, and returns its
findings, one sentence each, beginning with `file:line:`. So the rules can be tried on made-up trees as well
as on the real one.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

Sources = Mapping[str, str]

LAYERS: tuple[tuple[str, ...], ...] = (
    (
        "jaxstick.compilation_cache",
        "jaxstick.compiled",
        "jaxstick.deferred",
        "jaxstick.enclosure",
        "jaxstick.errors",
        "jaxstick.freed_memory",
        "jaxstick.precision",
        "jaxstick.turns",
        "jaxstick.version",
    ),
    (
        "jaxstick.parameter",
        "jaxstick.sizes",
    ),
    ("jaxstick.parts",),
    ("jaxstick.oscillator",),
    ("jaxstick.effect",),
    ("jaxstick.effects",),
    (
        "jaxstick.catalogue",
        "jaxstick.hypothesis",
    ),
    ("jaxstick.solver",),
    (
        "jaxstick.outcome",
        "jaxstick.trajectory",
    ),
    (
        "jaxstick.cycle_sums",
        "jaxstick.return_map",
        "jaxstick.simulate",
    ),
    (
        "jaxstick.chord",
        "jaxstick.laps",
        "jaxstick.pursuit",
        "jaxstick.recurrence",
    ),
    ("jaxstick.side_by_side",),
    ("jaxstick.formats",),
    ("jaxstick.output",),
    ("jaxstick.sources",),
    ("jaxstick.traced",),
    ("jaxstick.record",),
    (
        "jaxstick.cycle",
        "jaxstick.noise",
        "jaxstick.nominal",
        "jaxstick.outliers",
    ),
    (
        "jaxstick.check",
        "jaxstick.signature",
        "jaxstick.sensitivity",
        "jaxstick.simulations",
        "jaxstick.steady",
        "jaxstick.steady_effects",
        "jaxstick.steady_outcome",
        "jaxstick.sweep",
    ),
    ("jaxstick.sweeps",),
    ("jaxstick.plots",),
    (
        "jaxstick.progress_bar",
        "jaxstick.terminal",
    ),
    ("jaxstick.command",),
    ("jaxstick.verbs",),
    (
        "jaxstick.cli",
        "jaxstick.__main__",
    ),
    ("jaxstick",),
    (
        "fitting.aside",
        "fitting.progress",
        "fitting.settings",
        "fitting.unknowns",
    ),
    (
        "fitting.cycle",
        "fitting.lanes",
        "fitting.signals",
    ),
    ("fitting.history",),
    (
        "fitting.cuts",
        "fitting.opening",
        "fitting.segments",
    ),
    ("fitting.of_the_rig",),
    ("fitting.problem",),
    ("fitting.stage",),
    (
        "fitting.misfit",
        "fitting.newton",
    ),
    ("fitting.descent",),
    (
        "fitting.joining",
        "fitting.search",
    ),
    ("fitting.climb",),
    (
        "fitting.input_noise",
        "fitting.intervals",
        "fitting.uncertainty",
    ),
    (
        "fitting.account",
        "fitting.result",
    ),
    ("fitting.fit",),
    (
        "fitting.against",
        "fitting.correction",
    ),
    ("fitting.corrected_rig",),
    (
        "fitting.save",
        "fitting.saved",
    ),
    ("fitting.compare",),
    (
        "fitting.diagnosis.accounts",
        "fitting.diagnosis.settings",
    ),
    ("fitting.diagnosis.findings",),
    (
        "fitting.diagnosis.judging",
        "fitting.diagnosis.save",
    ),
    ("fitting.diagnosis.lanes",),
    ("fitting.diagnosis.refits",),
    ("fitting.diagnosis.noise",),
    ("fitting.diagnosis.how_far",),
    ("fitting.diagnosis.which",),
    ("fitting.diagnosis.where",),
    ("fitting.diagnosis.unlisted",),
    ("fitting.diagnosis",),
    ("fitting.blind",),
    ("fitting.plots",),
    ("fitting.report",),
    ("fitting.blind_run",),
    ("fitting.blind_score",),
    ("fitting.show",),
    ("fitting.show_diagnosis",),
    ("fitting.verbs",),
    (
        "fitting.cli",
        "fitting.__main__",
    ),
    ("fitting",),
)
"""Lowest first; a module imports from its own layer or from below.

A name stands for the module and for everything inside it, so a new file in such a folder needs no entry.
The two root packages stand for their `__init__` alone.
"""

ROOTS = ("jaxstick", "fitting")
EFFECTS = "jaxstick.effects"
IMPORT_BY_NAME = ("jaxstick.catalogue", "jaxstick.deferred")
BLIND = "fitting.blind"
HIDDEN_FROM_BLIND = ("jaxstick.simulate", "jaxstick.effects", "fitting.diagnosis")
REFERENCE = "tests.reference"
HIDDEN_FROM_REFERENCE = ("jax", "jaxlib", "equinox", "diffrax", "optax", "jaxstick", "fitting")


class Import(NamedTuple):
    """One imported module: where the statement stands, what it takes, and from which names."""

    path: str
    line: int
    importer: str
    module: str
    names: tuple[str, ...]

    @property
    def place(self) -> str:
        """`file:line`, as editors understand it."""
        return f"{self.path}:{self.line}"


def read_sources(root: Path, *folders: str) -> dict[str, str]:
    """The text of every Python file under the folders, by its path from the root."""
    return {
        path.relative_to(root).as_posix(): path.read_text(encoding="utf-8")
        for folder in folders
        for path in sorted((root / folder).rglob("*.py"))
    }


def module_name(path: str) -> str:
    """`jaxstick/parts/rig.py` is `jaxstick.parts.rig`; `jaxstick/parts/__init__.py` is `jaxstick.parts`."""
    return path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def inside(module: str, *prefixes: str) -> bool:
    """Whether the module is one of the named modules or lies in one of the named packages."""
    return any(module == prefix or module.startswith(prefix + ".") for prefix in prefixes)


def layer(module: str) -> int | None:
    """The number of the module's layer, counted from the lowest; None where the list has no place for it."""
    for number, prefixes in enumerate(LAYERS):
        if any(module == prefix or (prefix not in ROOTS and inside(module, prefix)) for prefix in prefixes):
            return number
    return None


def imports(path: str, source: str, modules: frozenset[str]) -> list[Import]:
    """The absolute imports of one file.

    `from package import module` counts as an import of that module, and so does `deferred("module", "name")`.
    """
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found += [Import(path, node.lineno, module_name(path), name.name, ()) for name in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            for alias in node.names:
                submodule = f"{node.module}.{alias.name}"
                module = submodule if submodule in modules else node.module
                found.append(Import(path, node.lineno, module_name(path), module, (alias.name,)))
        elif (written := deferral(node)) is not None:
            found.append(Import(path, written.line, module_name(path), written.module, (written.name,)))
    return found


class Deferral(NamedTuple):
    """A call `deferred("module", "name")`: an import that is carried out at the first use."""

    line: int
    module: str
    name: str


def deferral(node: ast.AST) -> Deferral | None:
    """What the node defers, if it is such a call with both arguments written out."""
    match node:
        case ast.Call(
            func=ast.Name(id="deferred"),
            args=[ast.Constant(value=str(module)), ast.Constant(value=str(name))],
        ):
            return Deferral(node.lineno, module, name)
    return None


def all_imports(sources: Sources) -> list[Import]:
    """The imports of every file."""
    modules = frozenset(map(module_name, sources))
    return [found for path, source in sources.items() for found in imports(path, source, modules)]


def unplaced_modules(sources: Sources) -> Iterator[str]:
    """Every module has a place among the layers."""
    for path in sources:
        if layer(module_name(path)) is None:
            yield (
                f"{path}:1: {module_name(path)} has no layer; add its name to the layer it belongs to"
                " in LAYERS, tests/architecture/layers.py"
            )


def upward_imports(sources: Sources) -> Iterator[str]:
    """No module imports what lies above it; in particular jaxstick never imports fitting."""
    for found in all_imports(sources):
        below, above = layer(found.importer), layer(found.module)
        if below is not None and above is not None and above > below:
            yield f"{found.place}: imports {found.module}, which lies above it"


def relative_imports(sources: Sources) -> Iterator[str]:
    """Imports spell out the whole name."""
    for path, source in sources.items():
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.ImportFrom) and node.level:
                yield f"{path}:{node.lineno}: relative import of {'.' * node.level}{node.module or ''}"


def imports_through_packages(sources: Sources) -> Iterator[str]:
    """Names come from the module that defines them, never from a package that passes them on."""
    modules = set(map(module_name, sources))
    packages = {module_name(path) for path in sources if path.endswith("/__init__.py")}
    for path, source in sources.items():
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.ImportFrom) and not node.level and node.module in packages:
                for name in (alias.name for alias in node.names):
                    if f"{node.module}.{name}" not in modules:
                        yield (
                            f"{path}:{node.lineno}: takes {name} from the package {node.module};"
                            " import from the module that defines it"
                        )
            elif isinstance(node, ast.Import):
                for alias in node.names:
                    if alias.name in ROOTS:
                        yield (
                            f"{path}:{node.lineno}: imports the whole package {alias.name};"
                            " import from the module that defines what is needed"
                        )


def hidden_imports(sources: Sources) -> Iterator[str]:
    """Imports stand at the top of the file, and nobody makes up a module's name at run time."""
    for path, source in sources.items():
        tree = ast.parse(source)
        hidden: dict[int, str] = {}
        for scope in ast.walk(tree):
            if isinstance(scope, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
                for node in ast.walk(scope):
                    if isinstance(node, (ast.Import, ast.ImportFrom)) or deferral(node):
                        hidden[getattr(node, "lineno", 0)] = scope.name
        for line, scope in sorted(hidden.items()):
            yield f"{path}:{line}: import inside {scope}; imports stand at the top of the file"
        if module_name(path) in IMPORT_BY_NAME:
            continue
        for node in ast.walk(tree):
            if isinstance(node, ast.Call):
                called = ast.unparse(node.func).split(".")[-1]
                if called in ("__import__", "import_module") or (called == "deferred" and not deferral(node)):
                    yield f"{path}:{node.lineno}: {called} imports what is not written out here"


def dangling_deferrals(sources: Sources) -> Iterator[str]:
    """What is imported at its first use is there."""
    defined = {module_name(path): names_defined(source) for path, source in sources.items()}
    for path, source in sources.items():
        for written in filter(None, map(deferral, ast.walk(ast.parse(source)))):
            if written.name not in defined.get(written.module, ()):
                yield f"{path}:{written.line}: {written.module} defines no {written.name}"


def names_defined(source: str) -> frozenset[str]:
    """The functions and classes of a file."""
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
    return frozenset(node.name for node in ast.parse(source).body if isinstance(node, kinds))


def circles(sources: Sources) -> Iterator[str]:
    """No module imports itself, directly or through others."""
    edges: dict[str, dict[str, Import]] = {}
    ours = frozenset(map(module_name, sources))
    for found in all_imports(sources):
        if found.module in ours:
            edges.setdefault(found.importer, {}).setdefault(found.module, found)
    done: set[str] = set()

    def visit(module: str, trail: list[str]) -> Iterator[str]:
        for target, found in edges.get(module, {}).items():
            if target in trail:
                circle = " -> ".join([*trail[trail.index(target) :], target])
                yield f"{found.place}: imports {target}, which closes the circle {circle}"
            elif target not in done:
                yield from visit(target, [*trail, target])
        done.add(module)

    for module in sorted(ours):
        if module not in done:
            yield from visit(module, [module])


def sibling_effects(sources: Sources) -> Iterator[str]:
    """No effect knows another effect."""
    for found in all_imports(sources):
        if (
            inside(found.importer, EFFECTS)
            and inside(found.module, EFFECTS)
            and found.module != found.importer
        ):
            yield f"{found.place}: imports {found.module}, a sibling effect"


def effect_keys(sources: Sources) -> frozenset[str]:
    """The names of the files on the shelf."""
    names = (module_name(path) for path in sources)
    return frozenset(name.removeprefix(EFFECTS + ".") for name in names if name.startswith(EFFECTS + "."))


def named_effects(sources: Sources) -> Iterator[str]:
    """Nobody but an effect's own file names it, in an import or in a string that is no docstring; sealed
    cases, which make effects by formulas of their own, name what they make."""
    keys = effect_keys(sources)
    for found in all_imports(sources):
        if found.module.startswith(EFFECTS + ".") and not inside(found.importer, EFFECTS):
            yield f"{found.place}: imports {found.module}; only the catalogue finds effects, by listing them"
    for path, source in sources.items():
        if inside(module_name(path), BLIND):
            continue
        own = module_name(path).removeprefix(EFFECTS + ".")
        tree = ast.parse(source)
        docs = {id(node) for node in docstring_nodes(tree)}
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docs:
                for key in sorted(keys.intersection(re.findall(r"\w+", node.value)) - {own}):
                    yield f"{path}:{node.lineno}: names the effect {key}; only its own file may"


def docstring_nodes(tree: ast.Module) -> Iterator[ast.Constant]:
    """Every string that stands as a statement of its own: docstrings, and those below a name."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            yield node.value


def blind_sees(sources: Sources) -> Iterator[str]:
    """The sealed cases come from code of their own: not from our simulation, effects or diagnosis."""
    for found in all_imports(sources):
        if inside(found.importer, BLIND) and inside(found.module, *HIDDEN_FROM_BLIND):
            yield f"{found.place}: imports {found.module}, which sealed cases must not rest on"


def reference_sees(sources: Sources) -> Iterator[str]:
    """The reference models are independent: no jax and nothing of ours."""
    for found in all_imports(sources):
        if inside(found.importer, REFERENCE) and inside(found.module, *HIDDEN_FROM_REFERENCE):
            yield f"{found.place}: imports {found.module}; reference models use numpy and scipy alone"


def missing_docstrings(sources: Sources) -> Iterator[str]:
    """Every public function and class of a module says what it is."""
    for path, source in sources.items():
        for node in ast.parse(source).body:
            if not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
                continue
            if "overload" in map(ast.unparse, node.decorator_list):
                continue
            if not node.name.startswith("_") and not ast.get_docstring(node):
                yield f"{path}:{node.lineno}: {node.name} has no docstring"


RULES: tuple[Callable[[Sources], Iterator[str]], ...] = (
    unplaced_modules,
    upward_imports,
    relative_imports,
    imports_through_packages,
    hidden_imports,
    dangling_deferrals,
    circles,
    sibling_effects,
    named_effects,
    blind_sees,
    missing_docstrings,
)
"""The rules for jaxstick and fitting; `reference_sees` is for tests/reference."""
