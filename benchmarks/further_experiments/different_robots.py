"""Different robots: the teacher's program copied to a different robot, or imitated by it (1.2)."""

from further_experiments.analysis import (
    ATTEMPTS,
    DELIVERED,
    FOOD_POINTS,
    ROUNDS,
    SCORE,
    STEPS,
    TRUE,
    Analysis,
    amounts_of,
    claim,
)
from further_experiments.episodes import ARENAS, recall_all, recall_imitators, train_files, training_seeds
from further_experiments.experiment import Experiment, Report, Trial
from further_experiments.pictures import INTERVALS
from further_experiments.rows import Row
from khepera_forage.envs.arguments import checked_arena, timing_of
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import UNKNOWN, pick
from khepera_forage.experience import Experience
from khepera_forage.figures import legend, levels, panels
from khepera_forage.policies import Teacher
from khepera_forage.robots.parameters import RobotParameters
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.sim.arena import copies
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.thesis.claims.claim import Above, Claim

ROBOTS = {
    "same robot": RobotParameters(),
    "infra-reds at 30 %": RobotParameters(infra_red_gain=0.3),
    "blind infra-reds": RobotParameters(infra_red_gain=0.0),
    "left wheel 20 % slow": RobotParameters(left_wheel_error=-0.2),
    "left wheel 30 % slow": RobotParameters(left_wheel_error=-0.3),
    "fingers of 30 mm": RobotParameters(finger_length=30.0),
    "arm reads 231 when raised": RobotParameters(arm_reading_scale=0.6),
}


def run(trial: Trial) -> list[Row]:
    """Forage with the teacher's program on this robot; train this robot, and forage with what it recorded."""
    robot = ROBOTS[trial.condition]
    decisions, timing = DEFAULT_DECISIONS, timing_of(DEFAULT_DECISIONS)
    corridors = copies(checked_arena(CORRIDOR, decisions), 2)
    pair = PymunkWorld(corridors, (1, 2), robot_parameters=(RobotParameters(), robot), timing=timing)
    env = TrainingEnv(max_cycles=trial.size.rounds, world=pair)
    rows: list[Row] = []
    files: list[Experience] = []
    try:
        for experience, row in train_files(env, trial, training_seeds(trial).spawn(trial.size.files)):
            files.append(experience)
            rows.append(row)
    except IncompleteTrainingError:
        pass  # A result: training this robot hardly ever succeeds.
    env.close()
    for arena in ARENAS:
        world = PymunkWorld(
            [checked_arena(arena, decisions)],
            (decisions.recall_marker,),
            robot_parameters=(robot,),
            timing=timing,
        )
        alone = recall_env(arena, limit=trial.size.steps, world=world)
        rows += recall_all(alone, Teacher.of(alone), trial, 0)
        rows += recall_imitators(alone, trial, files)
        alone.close()
    return rows


def report(found: Analysis) -> Report:
    """Which robot forages better by imitating than by copying."""
    claims = [_claim(found, robot, arena) for robot in ROBOTS for arena in ARENAS]
    tables = (
        found.recall_table(
            "0 episodes: the teacher's program, copied. The score counts steps in which the robot did what that "
            "program would have done on the robot's own readings, so a copy always scores 100 % less its penalty. "
            "Compare the food delivered.",
            (DELIVERED, SCORE, STEPS),
        ),
        found.training_table(
            "The teacher is a standard robot, the learner is the robot of this line. A learner whose training episode "
            "failed a hundred times in a row gets no further episodes.",
            (ATTEMPTS, ROUNDS, TRUE),
        ),
    )
    last = max(found.amounts, default=0)
    figure, axes = panels(2, "Different robots: the teacher's program copied, and imitated")
    for panel, arena in zip(axes, ARENAS, strict=True):
        estimates = {
            robot: [
                found.mean(pick(found.recalls, condition=robot, amount=n, arena=arena), DELIVERED)
                for n in (0, last)
            ]
            for robot in ROBOTS
        }
        levels(panel, estimates, f"{DELIVERED.name}, {arena}", ("copied", f"imitated, {last} episodes"))
        panel.set_xlim(-4, 104)
    axes[1].set_yticklabels([])
    legend(figure, axes[0], INTERVALS)
    return Report(claims, tables, figure)


def _claim(found: Analysis, robot: str, arena: str) -> Claim:
    rows = pick(found.recalls, condition=robot, arena=arena)
    copied, last = pick(rows, amount=0), max(amounts_of(rows), default=0)
    imitated = pick(rows, amount=last) if last else []
    result = (
        f"the imitator delivers {found.percent(imitated)} after {last} episodes"
        if imitated
        else "there is no imitator, because no training episode was complete"
    )
    return claim(
        f"{robot}, {arena}: imitating delivers more than copying",
        "1.2",
        found.difference(imitated, copied, DELIVERED) if imitated else UNKNOWN,
        Above(0.0),
        FOOD_POINTS,
        f"The copied program delivers {found.percent(copied)} of the food on this robot; {result}.",
    )


EXPERIMENT = Experiment(
    "different_robots",
    "Different robots",
    "1.2, 6.3",
    "On a robot that differs from the teacher, is it better to imitate the teacher's program than to copy it?",
    "The learner differs from the teacher in one parameter. Copied: the teacher's decision tree and rules run on that "
    "robot. Imitated: that robot is trained beside a standard teacher, in the set-up of figure 5.1, and recalls. Both "
    "have the ten behaviours (4.2.1); what may differ is when each is executed. Weak or blind infra-reds, a slow wheel "
    "and short fingers change what behaviours achieve, but neither the camera nor the state vector. An arm that reads "
    "231 when it is raised changes what the robot perceives, because figure 4.2 expects 225 or less.",
    tuple(ROBOTS),
    run,
    report,
)
