"""Every page is in the tree of pages, and every public name in the API reference."""

import re
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest
from site_extension.public_names import exported_names, public_modules, public_names
from site_extension.repository import DOCS, PACKAGE, module_name

PAGES = {path.relative_to(DOCS).with_suffix("").as_posix(): path for path in DOCS.rglob("*.md")}
WRITTEN = {
    name: path for name, path in PAGES.items() if not name.startswith("api/")
}  # those are made by `make docs`


@cache
def modules() -> list[Path]:
    """The files of all public modules; to read them takes a second, which only these tests need."""
    return [path for paths in public_modules().values() for path in paths]


def entries(page: str) -> set[str]:
    """The pages below a page."""
    found: set[str] = set()
    folder = WRITTEN[page].parent
    for block in re.findall(
        r"```\{toctree\}\n(.*?)```", WRITTEN[page].read_text(encoding="utf-8"), flags=re.DOTALL
    ):
        for entry in re.findall(r"^([\w/*]+)$", block, flags=re.MULTILINE):
            paths = folder.glob(f"{entry}.md") if "*" in entry else [folder / f"{entry}.md"]
            found |= {path.relative_to(DOCS).with_suffix("").as_posix() for path in paths}
    return found


def test_every_page_is_in_the_tree_once() -> None:
    below = [entry for page in WRITTEN for entry in entries(page) if not entry.startswith("api/")]
    assert sorted(below) == sorted(WRITTEN.keys() - {"index"})


def test_every_page_can_be_reached_from_the_index() -> None:
    reached, open_pages = set(), {"index"}
    while open_pages:
        page = open_pages.pop()
        reached.add(page)
        open_pages |= {entry for entry in entries(page) if entry in WRITTEN} - reached
    assert reached == set(WRITTEN)


def test_every_module_is_public_or_left_out_for_a_reason() -> None:
    for path in set(PACKAGE.rglob("*.py")) - set(modules()):
        command_or_compiler = module_name(path).startswith(
            ("khepera_forage.cli", "khepera_forage.compilation")
        )
        compiled = "from khepera_forage.compilation import" in path.read_text(encoding="utf-8")
        assert command_or_compiler or (compiled and not public_names(path))


@pytest.mark.parametrize(
    "name",
    [
        "Decisions",
        "Noise",
        "envs.behaviours_env.BehavioursEnv",
        "envs.training.TrainingEnv",
        "envs.compiled.vector_env.BehavioursVectorEnv",
        "experience.minari.to_minari",
        "lab.laboratory.Laboratory",
        "policies.as_policy",
        "policies.imitator.NearestNeighbourImitator",
        "policies.learner_registry.register_learner",
        "robots.serial.serial_khepera.SerialKhepera",
        "rollouts.compiled.recalls.run_recalls",
        "rollouts.compiled.training.train_learners",
        "rollouts.sb3_vector_env.VecEnvAdapter",
        "task.behaviours.command",
        "thesis.claims.claims",
        "vision.tracker.Tracker",
        "wrappers.HoldVectorAction",
    ],
)
def test_name_that_users_import_is_public(name: str) -> None:
    module, _, last = f"khepera_forage.{name}".rpartition(".")
    (path,) = (path for path in modules() if module_name(path) == module)
    assert last in public_names(path) + exported_names(path)


def test_exported_names_exist_where_their_documentation_is() -> None:
    exporting = [path for path in modules() if path.name == "__init__.py" and exported_names(path)]
    assert len(exporting) >= 4
    documented = {f"{module_name(path)}.{name}" for path in modules() for name in public_names(path)}
    for path in exporting:
        package = import_module(module_name(path))
        for name in exported_names(path):
            value = getattr(package, name)
            where = f"{getattr(value, '__module__', '')}.{name}"
            constant = name.isupper() or name in ("__version__", "Observation")
            assert where in documented or constant, name


@pytest.mark.parametrize("notebook", sorted((DOCS / "notebooks").glob("*.md")), ids=lambda path: path.stem)
def test_cells_of_notebook_are_python(notebook: Path) -> None:
    text = notebook.read_text(encoding="utf-8")
    assert text.startswith("---\nkernelspec:\n  name: python3\n")
    cells = re.findall(r"```\{code-cell\} ipython3\n(?::[^\n]*\n\n)?(.*?)```", text, flags=re.DOTALL)
    assert len(cells) >= 4
    for cell in cells:
        compile(cell, notebook.name, "exec")
