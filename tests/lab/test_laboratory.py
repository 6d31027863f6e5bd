"""What a laboratory asks of its operator, how it checks it, and what happens when something is lost."""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from khepera_forage.lab.laboratory import Laboratory
from khepera_forage.lab.operator import OperatorGaveUp, Request
from khepera_forage.lab.settings_file import load
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import Motors, RobotLost
from khepera_forage.robots.virtual.faults import Faults
from khepera_forage.sim.arena import CORRIDOR, Point, Pose, copies
from khepera_forage.sim.world import Layout
from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.video import CameraLost

cv2 = pytest.importorskip("cv2")

ARENAS = copies(CORRIDOR, 2)
LAYOUT = Layout(
    tuple(arena.start for arena in ARENAS), tuple(food for arena in ARENAS for food in arena.foods)
)
STILL = Motors(0, 0, 215, 200)


class Clumsy:
    """An operator that does something else the first times it is asked.

    Args:
        *errors: What it makes of a request, one after the other; then it does as told.
    """

    def __init__(self, *errors: Callable[[Request], Request]) -> None:
        self.errors = list(errors)
        self.requests: list[Request] = []
        self.lab: VirtualLaboratory

    def __call__(self, request: Request) -> None:
        self.requests.append(request)
        self.lab.hand(self.errors.pop(0)(request) if self.errors else request)


def laboratory(operator: Clumsy | None = None, real_time: bool = False) -> VirtualLaboratory:
    lab = VirtualLaboratory.of(
        CORRIDOR, 2, noise=Noise.none(), look=CameraAppearance.none(), operator=operator, real_time=real_time
    )
    if operator is not None:
        operator.lab = lab
    return lab


@pytest.fixture
def lab() -> Iterator[VirtualLaboratory]:
    with laboratory() as lab:
        lab.reset(np.random.default_rng(0), LAYOUT)
        yield lab


def moved(request: Request, robot: int, dx: float = 0, dy: float = 0, degrees: float = 0) -> Request:
    marks = list(request.robots)
    x, y, heading = marks[robot].pose
    marks[robot] = marks[robot]._replace(pose=Pose(x + dx, y + dy, heading + math.radians(degrees)))
    return request._replace(robots=tuple(marks))


def test_reset_asks_checks_and_asks_again() -> None:
    operator = Clumsy(
        lambda request: moved(request, 1, dy=30),
        lambda request: request._replace(foods=(request.foods or ())[:1]),
        lambda request: moved(request, 0, degrees=170),
    )
    with laboratory(operator) as lab:
        lab.reset(np.random.default_rng(0), LAYOUT)
        told = [request.wrong for request in operator.requests]
        assert told == [
            (),
            ("robot learner_0 stands at (90, 445) mm, 30 mm off its mark",),
            ("no food is seen at (370, 415) mm",),
            ("robot teacher is turned 170 degrees too far to the left",),
        ]
        assert all(request.robots[0].name == "teacher" for request in operator.requests)
        for pose, start in zip(lab.poses(), LAYOUT.starts, strict=True):
            assert math.dist(pose[:2], start[:2]) < 3


def test_a_laboratory_that_cannot_be_put_right_ends_with_the_operator() -> None:
    def always(request: Request) -> Request:
        return moved(request, 0, dx=40)

    with laboratory(Clumsy(*[always] * 20)) as lab, pytest.raises(OperatorGaveUp, match="40 mm off its mark"):
        lab.reset(np.random.default_rng(0), LAYOUT)
    with pytest.raises(RuntimeError, match="closed"):
        lab.reset(np.random.default_rng(0), LAYOUT)


def test_nobody_is_asked_for_what_cannot_be(lab: VirtualLaboratory) -> None:
    before = len(lab.hand.requests)
    for layout, told in (
        (LAYOUT._replace(starts=LAYOUT.starts[::-1]), r"robot at \(90, 415\)"),
        (LAYOUT._replace(foods=(Point(370, 5), LAYOUT.foods[1])), r"food at \(370, 5\)"),
        (LAYOUT._replace(foods=(Point(100, 115), LAYOUT.foods[1])), "overlaps robot"),
    ):
        with pytest.raises(ValueError, match=told):
            lab.reset(np.random.default_rng(0), layout)
    for pose, told in (
        (Pose(20, 115, 0), r"robot at \(20, 115\)"),
        (Pose(600, 115, 0), "gripper in a wall"),
        (Pose(370, 120, 0), "overlaps"),
        (Pose(200, 415, 0), r"robot at \(200, 415\)"),
    ):
        with pytest.raises(ValueError, match=told):
            lab.place(0, pose)
    assert len(lab.hand.requests) == before
    lab.advance()


def test_pause_and_resume() -> None:
    operator = Clumsy()
    with laboratory(operator) as lab:
        lab.reset(np.random.default_rng(0), LAYOUT)
        labels = [region.label for region in lab.camera.look().regions]
        for robot in lab.robots:
            robot.drive(Motors(5, 5, 215, 200))
        lab.advance()
        operator.errors = [lambda request: moved(request, 0, dx=-50)]
        teacher = lab.poses()[0]
        lab.place(1, Pose(250, 415, 1.0))
        assert [mark.name for mark in operator.requests[-1].robots] == ["learner_0"]
        assert operator.requests[-1].foods is None
        assert "50 mm off" in operator.requests[-1].wrong[0]
        assert math.dist(lab.poses()[1][:2], (250, 415)) < 3
        assert math.dist(lab.poses()[0][:2], teacher[:2]) < 1, "everybody stands while it is paused"
        assert [region.label for region in lab.camera.look().regions] == labels, "the tracks go on"


def test_carried_food_is_where_the_gripper_is(lab: VirtualLaboratory) -> None:
    lab.place(0, Pose(LAYOUT.foods[0].x - 57, LAYOUT.foods[0].y, 0.0))
    for rounds, motors in (
        (12, Motors(0, 0, 255, 200)),
        (8, Motors(0, 0, 255, 0)),
        (12, Motors(0, 0, 215, 0)),
        (10, Motors(-8, -8, 215, 0)),
    ):
        lab.robots[0].drive(motors)
        for _ in range(rounds):
            lab.advance()
    seen, truth = lab.food_places()[0], lab.bodies.food_places()[0]
    assert seen.lifted
    assert truth.lifted
    assert math.dist(seen[:2], truth[:2]) < 5
    assert not lab.food_places()[1].lifted
    lab.robots[0].drive(Motors(0, 0, 255, 0))
    for _ in range(12):
        lab.advance()
    assert not lab.food_places()[0].lifted


def test_real_time_takes_its_time() -> None:
    with laboratory(real_time=True) as lab:
        lab.reset(np.random.default_rng(0), LAYOUT)
        begin = time.monotonic()
        for _ in range(3):
            lab.advance()
        assert time.monotonic() - begin > 0.25
        assert lab.beat.rounds >= 4


# ---- what is lost


def standing(lab: VirtualLaboratory) -> bool:
    """Whether no body moves any more."""
    lab.bodies.advance()
    before = [(robot.sense().left_pulses, robot.sense().right_pulses) for robot in lab.bodies.robots]
    lab.bodies.advance()
    return before == [(robot.sense().left_pulses, robot.sense().right_pulses) for robot in lab.bodies.robots]


def driving(lab: VirtualLaboratory) -> None:
    for robot in lab.robots:
        robot.drive(Motors(5, 5, 215, 200))
    lab.advance()
    assert not standing(lab)


def test_a_lost_robot_stops_all_and_is_found_again(lab: VirtualLaboratory) -> None:
    driving(lab)
    lab.ports[1].faults = Faults(unplug=1.0)
    with pytest.raises(RobotLost) as lost:
        lab.advance()
    assert lost.value.port == lab.settings.robots[1].port
    assert standing(lab)
    with pytest.raises(RuntimeError, match="reset"):
        lab.advance()
    lab.reset(np.random.default_rng(1), LAYOUT)
    assert [request.reason.split(":")[0] for request in lab.hand.requests] == [
        "see to what is lost",
        "start of an episode",
    ]
    driving(lab)


def test_an_old_frame_stops_all(lab: VirtualLaboratory, monkeypatch: pytest.MonkeyPatch) -> None:
    driving(lab)
    frame, _ = lab.frames.newest()
    monkeypatch.setattr(lab.frames, "newest", lambda: (frame, 0.6))
    with pytest.raises(CameraLost, match=r"no frame for 0\.5 s"):
        lab.advance()
    assert standing(lab)
    monkeypatch.undo()
    lab.reset(np.random.default_rng(1), LAYOUT)
    driving(lab)


def test_an_interrupt_stops_all(lab: VirtualLaboratory, monkeypatch: pytest.MonkeyPatch) -> None:
    driving(lab)

    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(lab.beat, "wait", interrupted)
    with pytest.raises(KeyboardInterrupt):
        lab.advance()
    assert standing(lab)


def test_close_stops_all(lab: VirtualLaboratory) -> None:
    driving(lab)
    lab.close()
    assert standing(lab)


def test_advance_before_reset() -> None:
    with laboratory() as lab, pytest.raises(RuntimeError, match="before reset"):
        lab.advance()


# ---- from a file, with a film for a camera


def test_a_laboratory_from_a_file_until_its_film_ends(tmp_path: Path) -> None:
    """Real driver on the port in the file, real video source, wall clock."""
    with laboratory() as virtual:
        virtual.reset(np.random.default_rng(0), LAYOUT)
        film = cv2.VideoWriter(
            str(tmp_path / "film.avi"), cv2.VideoWriter_fourcc(*"MJPG"), 20, (640, 480), False
        )
        for _ in range(24):
            film.write(virtual.frames.newest()[0])
        film.release()
        ports = virtual.urls
        for robot in virtual.robots:
            robot.close()  # a port is for one driver only
        path = tmp_path / "lab.toml"
        path.write_text(
            f'safe_speed = 3\n[camera]\nsource = "{tmp_path / "film.avi"}"\n'
            + "".join(f'[[robots]]\nport = "{url}"\noffset = [0, {300 * i}]\n' for i, url in enumerate(ports))
        )
        asked: list[Request] = []
        with Laboratory(load(path), asked.append) as lab:
            assert lab.arenas == ARENAS
            lab.reset(np.random.default_rng(0), LAYOUT)
            assert len(asked) == 1
            assert lab.robots[0].drive(Motors(10, 10, 215, 200)) == Motors(3, 3, 215, 200)
            lab.advance()
            with pytest.raises(CameraLost, match="the video has ended"):  # noqa: PT012 (some time or other)
                for _ in range(100):
                    lab.advance()
            assert lab.beat.rounds > 2
            assert standing(virtual)


def test_a_port_that_is_not_there_leaves_nothing_open(tmp_path: Path) -> None:
    with laboratory() as virtual:
        for robot in virtual.robots:
            robot.close()
        settings = replace(
            virtual.settings,
            robots=(
                virtual.settings.robots[0],
                replace(virtual.settings.robots[1], port=str(tmp_path / "none")),
            ),
        )
        for _ in range(2):
            with pytest.raises(ConnectionError, match="none"):
                Laboratory(settings, source=virtual.frames)
