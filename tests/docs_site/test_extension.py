"""The parts of the extension that need no Sphinx."""

from dataclasses import fields
from pathlib import Path

import pytest
from site_extension.built_links import broken_links
from site_extension.docstring_markup import to_rst
from site_extension.generated_parts import commands, filled_in, noise_table
from site_extension.repository import DOCS, ROOT, module_name, page_of

from khepera_forage.cli.main import COMMANDS
from khepera_forage.noise import Noise


def test_code_in_text_gets_two_backticks() -> None:
    assert to_rst(["Takes `rng`, and `a", "b`; not ``c``."]) == ["Takes ``rng``, and ``a", "b``; not ``c``."]


def test_heading_becomes_a_rubric() -> None:
    assert to_rst(["## Action space", "Ten."]) == ["", ".. rubric:: Action space", "", "Ten."]


def test_table_becomes_a_list_table() -> None:
    rows = ["| key | meaning |", "|---|---|", "| `arm` | 255 down |"]
    assert [line for line in to_rst(rows) if line] == [
        ".. list-table::",
        "   :header-rows: 1",
        "   * - key",
        "     - meaning",
        "   * - ``arm``",
        "     - 255 down",
    ]


def test_fenced_code_keeps_its_backticks() -> None:
    lines = ["So:", "```python", "f(`x`)", "```", "Then."]
    assert [line for line in to_rst(lines) if line] == ["So:", ".. code-block:: python", "   f(`x`)", "Then."]


@pytest.mark.parametrize(
    ("path", "page"),
    [
        ("khepera_forage/noise.py", "source/khepera_forage/noise.py"),
        (
            "khepera_forage/policies/index.py",
            "source/khepera_forage/policies/index.py",
        ),
        ("khepera_forage/task", "source/khepera_forage/task/index"),
        ("tests/contracts", "source/tests/contracts/index"),
        ("CHANGELOG.md", "changelog"),
        ("docs/thesis/table_errata.csv", None),
        ("pyproject.toml", None),
        (".", None),
        ("..", None),
    ],
)
def test_page_of_file(path: str, page: str | None) -> None:
    assert page_of((ROOT / path).resolve()) == page


def test_module_name_of_package_is_that_of_its_folder() -> None:
    assert module_name(Path(ROOT / "khepera_forage/task/__init__.py")) == "khepera_forage.task"


PARTS = [path for path in sorted(DOCS.rglob("*.md")) if "<!-- generated: " in path.read_text("utf-8")]


@pytest.mark.parametrize("path", PARTS, ids=lambda path: path.stem)
def test_generated_part_of_page_is_up_to_date(path: Path) -> None:
    text = path.read_text("utf-8")
    assert filled_in(text) == text, "run PYTHONPATH=docs python -m site_extension.generated_parts"


def test_docstring_of_environment_is_filled_in() -> None:
    begin = "<!-- generated: docstring khepera_forage.envs.training.TrainingEnv -->\n"
    part = filled_in(f"# Title\n\n{begin}<!-- end -->\n")
    assert part.startswith(f"# Title\n\n{begin}\nA teacher forages and shouts")
    assert "\n## Action space\n`Discrete(11)`" in part
    assert part.endswith("\n\n<!-- end -->\n")
    assert filled_in(part) == part


def test_help_of_commands_has_all_their_subcommands() -> None:
    part = commands()
    assert [f"## khepera-forage {command.name}" for command in COMMANDS] == [
        line for line in part.splitlines() if line.startswith("## ")
    ]
    for usage in ("reproduce [-h]", "robot probe [-h]", "camera calibrate [-h]"):
        assert part.count(f"usage: khepera-forage {usage}") == 1


def test_noise_is_filled_in_with_sizes_and_sources() -> None:
    part = noise_table("")
    assert "| `wheel_slip` | 0.05 | Standard deviation of each wheel's travel, as a share of it" in part
    assert len(part.splitlines()) == 2 + len(fields(Noise))


def test_unknown_generated_part_is_an_error() -> None:
    with pytest.raises(KeyError, match="weather"):
        filled_in("<!-- generated: weather -->\n<!-- end -->")


def test_broken_links_of_a_site_are_found(tmp_path: Path) -> None:
    (tmp_path / "a.html").write_text('<a href="b.html#there">1</a> <a href="https://example.org/x">2</a>')
    (tmp_path / "b.html").write_text(
        '<p id="there"></p> <a href="a.html">1</a><a href="#here">2</a><a href="b.html#away">3</a><img src="lost.png">'
    )
    assert list(broken_links(tmp_path)) == ["b.html: #here", "b.html: b.html#away", "b.html: lost.png"]
