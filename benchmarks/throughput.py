"""Speed of environments, policies and compiled worlds: against goals, or also beside another commit.

With --beside, this checkout and the commit run the same cases alternately; targets are of the ratio to a0e33ed, the
last commit whose kernels worked on blocks of worlds. Each measurement has a process of its own. All cases but pymunk,
import and paired need numba. With --quick some minutes, nearly all of them compilation.

Modules of the package are imported in functions: their time counts in first calls, and an older commit has others.
"""

import argparse
import compileall
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter
from timeit import repeat
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np

ROOT, PACKAGE = Path(__file__).resolve().parents[1], "khepera_forage"
CORRIDOR = "khepera_forage:khepera_forage/Corridor-v1"
WORLDS, IMITATORS = 4096, 64
MEDIUM: Any = {"foods": 2, "limit": 1900}  # medium procedural arenas, and the corridor beside them


def pymunk(steps: int, seed: int, act: Any = None, **settings: Any) -> float:
    """Steps a second of Corridor-v1 of gym.make, resets included, after a tenth of as many; under the teacher."""
    env: Any = gym.make(CORRIDOR, **settings)
    from khepera_forage.policies import Teacher

    teacher = Teacher.of(env).act
    act = act or (lambda observation, _: teacher(observation))
    for count in (steps // 10, steps):
        start = perf_counter()
        observation, info = env.reset(seed=seed)
        for _ in range(count):
            observation, _, terminated, truncated, info = env.step(act(observation, info))
            if terminated or truncated:
                observation, info = env.reset()
    return steps / (perf_counter() - start)


def paired(rounds: int, seed: int) -> float:
    """Rounds a second of the paired corridors, resets included."""
    from khepera_forage.envs import paired_corridors_v1
    from khepera_forage.policies import Teacher

    env = paired_corridors_v1.parallel_env()
    teacher, start = Teacher.of(env), perf_counter()
    shown, _ = env.reset(seed=seed)
    for _ in range(rounds):
        shown, *_ = env.step({"teacher_0": teacher.act(shown["teacher_0"]), "learner_0": shown["learner_0"][5]})
        if not env.agents:
            shown, _ = env.reset()
    return rounds / (perf_counter() - start)


def decisions(count: int, seed: int) -> float:
    """Decisions a second of an imitator in Python, while it forages in the corridor."""
    from khepera_forage.policies import NearestNeighbourImitator

    imitator, rng = NearestNeighbourImitator().fit(*experience(1, seed)[0]), np.random.default_rng(seed)
    seconds = []

    def act(observation: Any, _: Any) -> int:
        start = perf_counter()
        behaviour = imitator.act(observation, rng)
        seconds.append(perf_counter() - start)
        return behaviour

    pymunk(count, seed, act)
    return len(seconds) / sum(seconds)


def make_vec(rounds: int, seed: int, name: str = CORRIDOR, resets: int = 1, **settings: Any) -> float:
    """Steps a second of all worlds of make_vec under the teacher: the median round, once episodes end in turn."""
    env: Any = gym.make_vec(name, num_envs=WORLDS, **settings)
    for reset in range(resets):
        _, infos = env.reset(seed=seed + reset * WORLDS)
    seconds = []
    for _ in range(2 * rounds):
        actions = infos["correct_behaviour"]
        start = perf_counter()
        infos = env.step(actions)[4]
        seconds.append(perf_counter() - start)
    return WORLDS / median(seconds[rounds:])


def procedural_make_vec(arenas: int, seed: int) -> float:
    """Rate of make_vec in medium arenas, all entered before, as a share of that in the corridor with as much food."""
    corridor = make_vec(100, seed, resets=5, foods=MEDIUM["foods"])
    return make_vec(100, seed, "khepera_forage/Procedural-v1", resets=5, num_levels=arenas) / corridor


def kernel(episodes: int, seed: int) -> float:
    """Steps a second of whole recalls under the teacher in the kernel."""
    from khepera_forage.rollouts.compiled.recalls import run_teacher

    return of_calls(lambda: run_teacher("corridor", episodes, seed=seed).steps.sum())


def imitators(episodes: int, seed: int) -> float:
    """The same under imitators with ten training episodes each."""
    from khepera_forage.rollouts.compiled.recalls import run_recalls

    module = "khepera_forage.policies.memories"
    if find_spec(module) is None:  # an older commit
        module = "khepera_forage.policies.nearest_neighbour.memories"
    memories = import_module(module).memories_of(experience(IMITATORS, seed))
    which = [episode % IMITATORS for episode in range(episodes)]
    return of_calls(lambda: run_recalls("corridor", memories, which, seed).steps.sum())


def trainings(learners: int, seed: int) -> float:
    """Rounds a second of whole training episodes in the kernel, failed attempts included."""
    from khepera_forage.rollouts.compiled.training import train_learners

    return of_calls(lambda: train_learners(learners, seed=seed).attempts.rounds.sum())


def procedural_recalls(arenas: int, seed: int) -> float:
    """Rate of recalls, nearly all in an arena of their own, as a share of that in the corridor with as much food."""
    from khepera_forage.rollouts.compiled.recalls import TEACHER, Recalls
    from khepera_forage.sim.arenas.procedural import ProceduralArenas

    def rate(arena: Any) -> float:
        recalls = Recalls(arena, **MEDIUM)  # the first call prepares the arenas
        return of_calls(lambda: recalls.run(None, [TEACHER] * arenas, seed).steps.sum())

    return rate(ProceduralArenas("medium")) / rate("corridor")


def design(replications: int, seed: int) -> float:
    """Seconds of replications of the thesis's design: training and recalls as rows, without the report."""
    module = import_module("khepera_forage.thesis.compiled_replications")

    def replicate(first: int, count: int) -> None:
        if hasattr(module, "replicate"):
            module.replicate(seed, first, count)
        else:  # an older commit
            module.CompiledReplications(seed, first, count).run()

    replicate(0, 1)  # compiles, or loads the kernels
    start = perf_counter()
    for first in range(0, replications, module.GROUP_SIZE):
        replicate(first, min(module.GROUP_SIZE, replications - first))
    return perf_counter() - start


def import_alone(_: int, __: int) -> float:
    """Seconds of the import in a process that has imported nothing else."""
    code = "from time import time; start = time(); import khepera_forage; print(time() - start)"
    return float(subprocess.check_output([sys.executable, "-P", "-c", code]))


def memory(worlds: int, _: int) -> float:
    """Bytes of a world with one food object."""
    env: Any = gym.make_vec(CORRIDOR, num_envs=worlds)
    return float(sum(part.nbytes for part in env.unwrapped.batch.worlds) / worlds)


def of_calls(call: Callable[[], Any]) -> float:
    """Steps or rounds a second in the median of five calls that do the same work, after one that compiles."""
    return int(call()) / median(repeat(call, number=1, repeat=5))


def experience(learners: int, seed: int) -> list[tuple[Any, Any]]:
    """State vectors and behaviours of ten training episodes of each learner."""
    from khepera_forage.rollouts.compiled.training import train_learners

    trained = train_learners(learners, seed=seed, episodes=10)
    return [(own[:, :5], own[:, 5]) for own in map(trained.vectors_of, range(learners))]


class Case(NamedTuple):
    """Something to measure; of seconds and bytes less is better."""

    name: str
    measure: Callable[[int, int], float]  # of the size and a seed
    label: str
    unit: str
    size: int
    quick: int
    goal: float  # of this checkout
    target: float | None = None  # of the ratio to a0e33ed; without, --beside leaves the case out
    first_call: bool = False  # the value is the time of it all, import and compilation included
    one_core: bool = False  # one thread, so that both processes of a pair can run on the same core

    def met(self, value: float, bound: float) -> bool:
        """Whether a value is as good as a goal or target."""
        return value <= bound if self.unit in ("s", "bytes") else value >= bound


one_world = partial(pymunk, act=lambda _, info: info["correct_behaviour"], backend="compiled")
CASES = (
    Case("pymunk", pymunk, "Corridor-v1 on pymunk", "steps/s", 30_000, 400, 1e4, 0.6, one_core=True),
    Case("make_vec", make_vec, f"make_vec, {WORLDS:,} worlds", "steps/s", 200, 5, 2e6, 0.35),
    Case("kernel", kernel, "teacher in the kernel", "steps/s", 32_768, 128, 4e6, 0.3),
    Case("imitators", imitators, "imitators in the kernel", "steps/s", 32_768, 128, 1e6, 0.3),
    Case("trainings", trainings, "trainings in the kernel", "rounds/s", 8_192, 128, 1e6, 0.3),
    Case("one_world", one_world, "one compiled world", "steps/s", 100_000, 1_000, 6e4, 0.6, one_core=True),
    Case("procedural_recalls", procedural_recalls, "recalls, procedural/corridor", "", 2_000, 50, 0.5),
    Case("procedural_make_vec", procedural_make_vec, "make_vec, procedural/corridor", "", 2_000, 50, 0.5),
    Case("first_make_vec", make_vec, "first make_vec", "s", 1, 1, 45, 0.8, first_call=True),
    Case("first_run_teacher", kernel, "first run_teacher", "s", 128, 128, 45, 0.8, first_call=True),
    Case("first_train_learners", trainings, "first train_learners", "s", 128, 128, 45, 0.8, first_call=True),
    Case("design", design, "{:,} replications of the design", "s", 1_000, 2, 60, 4.0),
    Case("import", import_alone, "import khepera_forage", "s", 1, 1, 0.5),
    Case("paired", paired, "paired corridors", "rounds/s", 10_000, 100, 4_000, one_core=True),
    Case("decisions", decisions, "imitator in Python", "decisions/s", 20_000, 200, 4e4, one_core=True),
    Case("memory", memory, "memory of a world", "bytes", 128, 128, 2_000),
)
BY_NAME = {case.name: case for case in CASES}


def measure_here(name: str, size: str, seed: str, core: str) -> None:
    """In a fresh process: print the value of a case, and where its package is."""
    if core:
        os.sched_setaffinity(0, [int(core)])
    case, start = BY_NAME[name], perf_counter()
    value = case.measure(int(size), int(seed))
    print(perf_counter() - start if case.first_call else value, __import__(PACKAGE).__file__, sep="\n")


def measure(case: Case, folder: Path, size: int, seed: int, core: str) -> float:
    """The value of a case for the package in a folder, measured in a process of its own."""
    code = "import sys; sys.path.append(sys.argv[1]); import throughput as t; t.measure_here(*sys.argv[2:])"
    command = [sys.executable, "-P", "-c", code, str(ROOT / "benchmarks"), case.name, str(size), str(seed), core]
    with TemporaryDirectory(dir=folder) as empty:
        kernels = empty if case.first_call else str(folder / "kernels")
        kept = {"NUMBA_CACHE_DIR": kernels, "XDG_CACHE_HOME": kernels, "PYTHONPATH": str(folder)}
        done = subprocess.run(command, env=os.environ | kept, capture_output=True, text=True)
    if done.returncode:
        last = (done.stderr.strip().splitlines() or [f"status {done.returncode}"])[-1]
        raise RuntimeError(f"case {case.name} failed in {folder.name}: {last}; --only measures other cases")
    value, package = done.stdout.splitlines()[-2:]
    if not Path(package).is_relative_to(folder):
        raise RuntimeError(f"case {case.name} measured the package in {package}; allowed: the one in {folder}")
    return float(value)


@dataclass(frozen=True, slots=True)
class CaseValue:
    """The value of a case in one repeat."""

    case: str
    unit: str
    repeat: int
    checkout: str
    value: float


def repeated(case: str, number: int, size: int, seed: int, found: dict[str, Path]) -> list[CaseValue]:
    """A case, once in each checkout; each repeat with another seed, core and order of the checkouts."""
    measured, names = BY_NAME[case], list(found)[:: 1 if number % 2 else -1]
    cores = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []
    core = str(cores[number % len(cores)]) if measured.one_core and cores else ""
    values = [measure(measured, found[name], size, seed + number, core) for name in names]
    return [CaseValue(case, measured.unit, number, *one) for one in zip(names, values, strict=True)]


def git(*arguments: str) -> str:
    """What git prints; empty if it fails or is not installed."""
    if not shutil.which("git"):
        return ""
    done = subprocess.run(["git", "-C", str(ROOT), *arguments], capture_output=True, text=True)
    return "" if done.returncode else done.stdout.strip()


def checkouts(commit: str | None, folder: Path) -> dict[str, Path]:
    """Folders with a copy of this package, which edits do not change, and with that of the commit."""
    shutil.copytree(ROOT / PACKAGE, folder / "here" / PACKAGE, ignore=shutil.ignore_patterns("__pycache__"))
    found = {name: folder / name for name in ("here", commit) if name}
    if commit:  # an archive, not a worktree: nothing of it has to be removed from git's own state
        git("archive", f"--output={folder / 'commit.zip'}", commit, "--", PACKAGE)
        shutil.unpack_archive(folder / "commit.zip", found[commit])
    compileall.compile_dir(folder, quiet=2)  # else the first process would do it
    return found


def short(value: float) -> str:
    """Three digits, with M for millions and k for thousands."""
    value = float(f"{value:.3g}")
    size, letter = (1e6, " M") if value >= 1e6 else (1e3, " k") if value >= 1e4 else (1, "")
    return f"{value / size:,g}{letter}"


def spread(values: Sequence[float], text: Callable[[float], str]) -> str:
    """Median, lowest and highest."""
    return f"{text(median(values))} [{text(min(values))}, {text(max(values))}]"


def line(case: Case, size: int, now: Sequence[float], before: Sequence[float] = ()) -> tuple[str, ...]:
    """The case's line in the table, from its repeats in this checkout and in the other one, if there is one."""
    sign = "≤" if case.unit in ("s", "bytes") else "≥"
    cells, bounds, met = [spread(now, short)], f"{sign} {short(case.goal)}", case.met(median(now), case.goal)
    if before and case.target:
        ratios = [new / old for new, old in zip(now, before, strict=True)]
        cells = [short(median(before)), short(median(now)), spread(ratios, "{:.2f}".format)]
        bounds, met = f"{sign} {case.target}; {bounds}", met and case.met(median(ratios), case.target)
    label = case.label.format(size) + (case.unit and f", {case.unit}")
    return label, *cells, bounds, "yes" if met else "no"


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--beside", metavar="COMMIT", help="also measure this commit, such as a0e33ed")


def main() -> int:
    """Measure, print the table, and write page and rows."""
    from khepera_forage.estimates import Column, Table, pick
    from khepera_forage.study import Count, Job, Page, collect, finish, parse

    count = Count("repeats", 5, 1, "repeats; of seconds 3 at most")
    given = parse("throughput", __doc__, count, parts=BY_NAME, jobs=None, add=_add_arguments)
    commit = git("rev-parse", "--short", f"{given.beside}^{{commit}}") if given.beside is not None else None
    if commit is not None and not git("ls-tree", commit, "--", PACKAGE):
        given.refuse(f"commit {given.beside!r} is unknown; allowed: one of a git clone in {ROOT}, with {PACKAGE}")
    chosen = [case for name in given.parts if (case := BY_NAME[name]).target or not commit]
    sizes = {case: case.quick if given.quick else case.size for case in chosen}
    for end in {signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)}:
        signal.signal(end, lambda number, _: sys.exit(128 + number))  # the folder below is then removed
    with TemporaryDirectory(prefix="throughput-") as folder:
        found = checkouts(commit, Path(folder).resolve())
        units = [
            Job(f"{case.name} {number}", repeated, (case.name, number, size, given.seed, found))
            for number in range(given.repeats)
            for case, size in sizes.items()
            if number < 3 or case.unit != "s"
        ]
        try:
            rows = collect(given, units, {CaseValue: "rows"}).of(CaseValue)
        except RuntimeError as error:
            given.refuse(str(error))
    values = {
        case: [[row.value for row in pick(rows, case=case.name, checkout=name)] for name in found] for case in sizes
    }
    lines = [line(case, size, *values[case]) for case, size in sizes.items()]
    note = (
        f"Speed of this checkout ({git('describe', '--always', '--dirty') or 'not in git'}): median [lowest, highest]. "
        "Targets are of the ratio, goals of this checkout. Only first calls include import and compilation."
    )
    names = ["case", *([commit, "here", "ratio", "target; goal"] if commit else ["measured", "goal"]), "met"]
    table = Table("throughput", "Cases", note, tuple(map(Column, names)), lines)
    return finish(given, Page(f"Throughput beside commit {commit}" if commit else "Throughput", [table]))


if __name__ == "__main__":
    sys.exit(main())
