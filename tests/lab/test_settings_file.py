"""Reading `lab.toml`: defaults, all keys, and errors that name the key."""

import re
import tomllib
from dataclasses import fields
from pathlib import Path

import pytest

from khepera_forage.envs.arguments import set_up_of
from khepera_forage.envs.laboratories import load_settings
from khepera_forage.lab.settings_file import LabSettings, RobotSettings, parse, sample
from khepera_forage.sim.arena import Point
from khepera_forage.sim.arenas.named import named_arena
from khepera_forage.sim.arenas.thesis import SetUp
from khepera_forage.task.decisions import Decisions
from khepera_forage.vision.tracker_settings import TrackerSettings
from tests.version_0_1 import CORRIDOR, RECTANGLE, SET_UP

MINIMAL = """
[camera]
source = 0
[[robots]]
port = "/dev/ttyUSB0"
[[robots]]
port = "/dev/ttyUSB1"
offset = [0, 300]
"""

CUSTOM_ARENA = """
[arena]
name = "den"
walls = [[0, 0], [700, 0], [700, 500], [0, 500]]
home = [550, 250]
home_radius = 100
start = [100, 250, 90]
foods = [[350, 200], [350, 300]]
obstacles = [[[200, 20], [240, 20], [240, 60], [200, 60]]]
"""


def parsed(toml: str, folder: Path = Path(), set_up: SetUp = SET_UP, period: float = 0.1) -> LabSettings:
    return parse(toml, set_up, period, folder)


def test_minimal_file_uses_the_defaults() -> None:
    settings = parsed(MINIMAL)
    assert settings.robots == (
        RobotSettings("/dev/ttyUSB0", "teacher", 38400, 1),
        RobotSettings("/dev/ttyUSB1", "learner_0", 38400, 2, Point(0, 300)),
    )
    assert settings.arenas == (CORRIDOR, CORRIDOR.shifted(0, 300))
    assert settings == LabSettings(settings.arena, settings.robots, settings.camera, 0.1), (
        "the defaults are those of the dataclass"
    )
    assert settings.period == 0.1
    assert settings.camera.calibration is None


def test_every_key_is_read() -> None:
    settings = parsed(
        'safe_speed = 12\nperiod = 0.2\n[arena]\nname = "rectangle"\n'
        '[[robots]]\nname = "Ada"\nport = "socket://127.0.0.1:5000"\nbaud = 9600\nholes = 2\n'
        "offset = [10.5, 20]\ntimeout = 0.3\nwatchdog = false\n"
        '[camera]\nsource = "rtsp://camera"\ncalibration = "c.toml"\noldest = 1\n'
        "[tracker]\ncontrast = 1.7\nfeatureless = true\n"
        "[tolerance]\nposition = 20\nheading = 5\n",
        Path("lab"),
    )
    assert settings.safe_speed == 12
    assert settings.period == 0.2
    assert settings.arena == RECTANGLE
    assert settings.robots == (RobotSettings("socket://127.0.0.1:5000", "Ada", 9600, 2, Point(10.5, 20.0), 0.3, False),)
    assert settings.camera.source == "rtsp://camera"
    assert settings.camera.calibration == Path("lab/c.toml")
    assert settings.camera.oldest == 1.0
    assert settings.tracker == TrackerSettings(contrast=1.7, featureless=True)
    assert (settings.tolerance.position, settings.tolerance.heading) == (20.0, 5.0)


def test_set_up_and_period_of_the_caller_apply_where_the_file_has_none() -> None:
    set_up = SetUp(120, 200, 90, 80, start_aside=-10, food_aside=20, home_aside=5)
    assert parsed(MINIMAL, set_up=set_up).arena == named_arena("corridor", set_up)
    own = parsed("period = 0.3\n" + CUSTOM_ARENA + MINIMAL.replace("300", "600"), set_up=set_up, period=0.2)
    assert own.arena == parsed(CUSTOM_ARENA + MINIMAL.replace("300", "600")).arena
    assert own.period == 0.3


def test_sample_is_valid_and_its_comments_show_the_defaults(tmp_path: Path) -> None:
    defaults = Decisions()
    set_up, period = set_up_of(defaults), defaults.round_duration
    settings = parsed(sample(), set_up=set_up, period=period)
    assert len(settings.robots) == 2
    # Uncommenting the optional keys changes nothing, except for calibration and obstacles.
    text = re.sub(r"^#(\w+ = )", r"\1", sample(), flags=re.MULTILINE)
    text = re.sub(r"^(calibration|obstacles|size|rate|exposure|focus) .*\n", "", text, flags=re.MULTILINE)
    assert parsed(text, set_up=set_up, period=period) == settings
    keys = tomllib.loads(re.sub(r"^#(\w+ = )", r"\1", sample(), flags=re.MULTILINE))
    assert keys["tracker"].keys() == {field.name for field in fields(TrackerSettings)} - {"numbers"}
    (tmp_path / "lab.toml").write_text(sample(), encoding="utf-8")
    assert load_settings(tmp_path / "lab.toml", defaults) == settings


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("offset =", "baud = 38401\noffset =", "robots[1].baud is 38401; allowed: 9600, 19200, 38400, 57600, 115200"),
        ("offset =", "timeout = 0\noffset =", "robots[1].timeout is 0; allowed: 0.01 to 10 seconds"),
        ("offset =", "watchdog = 1\noffset =", "robots[1].watchdog is 1; allowed: true, false"),
        ("offset =", "holes = 3\noffset =", "robots[1].holes is 3; allowed: 1, 2"),
        ("offset =", 'type = "e-puck2"\noffset =', "robots are of types e-puck2, khepera; allowed: one type, because"),
        ("offset = [0, 300]", 'offset = [0, "a"]', "robots[1].offset is [0, 'a']; allowed: [x mm, y mm]"),
        ("offset = [0, 300]", "offset = [0, 200]", "robots[1].offset is [0.0, 200.0]: its arena overlaps"),
        ("offset = [0, 300]", "offset = [0, 2300]", "robots[1].offset is [0.0, 2300.0]: arenas reach"),
        ("ttyUSB1", "ttyUSB0", "robots[1].port is '/dev/ttyUSB0', as robots[0].port"),
        ('port = "/dev/ttyUSB1"', 'name = "b"', "robots[1].port is missing"),
        ("offset =", "ofset =", "robots[1].ofset is unknown (did you mean offset?); allowed: baud, holes, name, "
         "offset, port, timeout, type, watchdog"),
        ("source = 0", "source = -1", "camera.source is -1; allowed: the number of a device"),
        ("[camera]", "safe_speed = 21\n[camera]", "safe_speed is 21; allowed: 1, 2, 3"),
        ("[camera]", "period = 0\n[camera]", "period is 0; allowed: 0.05 to 0.5 seconds"),
        ("[camera]", '[arena]\nname = "cave"\n[camera]', "arena.name is 'cave' and there are no walls; allowed"),
        ("[camera]", "[arena]\nhome = [1, 2]\n[camera]", "arena.home is unknown; allowed: name, walls"),
        ("[camera]", "[tracker]\ncontrast = 0.5\n[camera]", "tracker contrast is 0.5; allowed: above 1"),
        ("[camera]", "[tracker]\ncontrast = true\n[camera]", "tracker.contrast is True; allowed: a number"),
        ("[camera]", "[tracker]\ncontrast = nan\n[camera]", "tracker contrast is nan; allowed: a finite number >= 0"),
        ("[camera]", "[tracker]\ntolerance = 0\n[camera]", "tracker tolerance is 0; allowed: between 0 and 1"),
        ("[camera]", "[tracker]\nfood_radius = 0\n[camera]", "tracker food_radius is 0; allowed: above 0 mm"),
        ("[camera]", "[tracker]\npatience = 0\n[camera]", "tracker patience is 0; allowed: whole frames, at least 1"),
        ("[camera]", "[tracker]\npatience = 1.5\n[camera]", "patience is 1.5; allowed: "),
        ("[camera]", '[tracker]\nmarkers = "qr"\n[camera]', "tracker markers is 'qr'; allowed: holes, grid, tags"),
        ("[camera]", '[tracker]\nmarkers = "tags"\nfood_tags = [2]\n[camera]', "tracker food_tags has 2, as numbers"),
        ("offset = [0, 300]\n", 'holes = 1\noffset = [0, 300]\n[tracker]\nmarkers = "tags"\n',
         "robots[1].holes is 1, as robots[0].holes; allowed: one tag each"),
        ("source = 0", "source = 0\nsize = [640]", "camera size is (640,); allowed: "),
        ("source = 0", "source = 0\nsize = [0, 480]", "camera size is (0, 480); allowed: "),
        ("source = 0", "source = 0\nrate = 0", "camera.rate is 0; allowed: 0.1 to 1000 frames a second"),
        ("[camera]", 'tracker = 3\n[camera]', "tracker is 3; allowed: a table of keys and values"),
        (MINIMAL, "robots = 3", "robots is 3; allowed: one or more tables [[robots]]"),
        (MINIMAL, "robots = [3]", "robots[0] is 3; allowed: a table"),
        ("[100, 250, 90]", "[10, 250, 90]", "arena: den: start at (10, 250) mm is 10 mm from a wall"),
    ],
)  # fmt: skip
def test_errors_name_the_key(old: str, new: str, message: str) -> None:
    text = MINIMAL if old in MINIMAL else CUSTOM_ARENA + MINIMAL.replace("300", "600")
    assert old in text
    with pytest.raises(ValueError, match=re.escape(message)):
        parsed(text.replace(old, new))


def test_example_in_the_documentation_is_valid() -> None:
    documentation = (Path(__file__).parents[2] / "docs" / "laboratory.md").read_text(encoding="utf-8")
    (shown,) = re.findall(r"```toml\n(.*?)```", documentation, flags=re.DOTALL)
    assert len(parsed(shown).robots) == 2
