"""What every command says about a mistake: one line that quotes the value and says what is allowed, and status 2."""

from pathlib import Path

import pytest

from khepera_forage.cli.main import main
from khepera_forage.experience import Experience
from khepera_forage.robots.virtual.virtual_khepera import VirtualKhepera
from tests.cli.running import Run

CORNERS = "0,0=0,2400 640,0=3200,2400 640,480=3200,0"
NOTHING = "has no effect here; allowed: "


@pytest.fixture(autouse=True)
def files(empty_folder_without_display: None, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("there").mkdir()
    Experience([(0, 60, 0, 215, 40), (0, 60, 0, 255, 18)], [0, 2]).save("there/g1.csv")
    Experience([], []).save("there/none.csv")
    Path("mine.toml").touch()
    Path("one.toml").write_text('[camera]\nsource = 0\n[[robots]]\nport = "/dev/none"\n')
    Path("deep.toml").write_text("name = " + "[" * 2000)
    Path("latin.csv").write_bytes(b"caf\xe9")
    monkeypatch.setattr(VirtualKhepera, "connected", False)  # one that is started by mistake ends at once


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("tran", "invalid choice: 'tran'"),
        ("recall --experience nowhere.csv", "nowhere.csv"),
        ("recall --experience .", "has no g1.csv; allowed: experience files, or a folder of them"),
        ("recall --experience there/none.csv", "--experience has no experience vectors; allowed: at least one"),
        ("recall --noise wind", "noise source 'wind' is unknown; allowed: wheels, infra-reds"),
        ("recall --decision next_to_foot=17", "recall: decision 'next_to_foot' is unknown; allowed: aimed, arm_after_"),
        ("recall --learner tree", f"--learner {NOTHING}with --experience"),
        ("recall --learner ppo --experience there", "--learner is 'ppo'; allowed: imitator, k_nearest"),
        ("recall --learner nowhere:f --experience there", "--learner is 'nowhere:f': No module named 'nowhere'"),
        ("recall --learner sklearn.svm:LinearSVC --experience there", "LinearSVC has no predict_proba"),
        ("recall --experience there --out there/g1.csv", "--out is 'there/g1.csv', a file of --experience"),
        ("recall --allow-other-decisions", f"--allow-other-decisions {NOTHING}with --experience"),
        ("recall --learner json:loads --experience there", "loads takes s; allowed: what makes a classifier"),
        ("recall --arena ''", "arena is ''; allowed: corridor, rectangle"),
        ("recall --arena deep.toml", "deep.toml: not TOML: maximum recursion depth exceeded"),
        ("recall --foods 17", "foods is 17; allowed: a whole number from 1 to 16"),
        ("recall --food-type CHEESE", "'CHEESE' is unknown; allowed: PICKABLE"),
        ("recall --episodes 0", "--episodes: '0'; allowed: a whole number from 1 to 100,000"),
        ("recall --lab virtual --noise none", f"--noise {NOTHING}without --lab"),
        ("train --seed -1", "--seed: '-1'; allowed: a whole number of at least 0"),
        ("train --lab virtual:cat", "--lab virtual:cat; allowed: virtual:khepera, virtual:e-puck2, virtual:toio"),
        ("train --lab lab.toml --num-learners 2", f"--num-learners {NOTHING}without --lab; the file lists the"),
        ("train --lab lab.toml --arena corridor", f"--arena {NOTHING}without --lab; the file names the arena"),
        ("train --lab one.toml", "one.toml: robots has one entry; allowed: a teacher and at least one learner"),
        ("train --patience 5 --decision patience=7", "--patience is 5, --decision patience=7; allowed: one of them"),
        ("teach --pace nan", "--pace: 'nan'; allowed: more than 0, at most"),
        ("teach --out there", "g1.csv exists; choose another --out"),
        ("teach", "no display to open a window on"),
        ("watch training", "no display to open a window on"),
        ("watch training --foods 2", f"--foods {NOTHING}with `watch recall`"),
        ("watch recall --num-learners 3", f"--num-learners {NOTHING}with `watch training`"),
        ("watch recall --every 3", f"--every {NOTHING}with --out"),
        ("watch recall --out f.gif --every 9999", "--every: '9999'; allowed: a whole number from 1 to 1,000"),
        ("watch recall --out film.mov", "'film.mov'; allowed: a name that ends in .gif, .mp4, .avi"),
        ("watch recall --out /proc/film.gif", "--out is '/proc/film.gif', where no file can be written: "),
        ("reproduce --replications 1e9", "--replications: '1e9'; allowed: a whole number from 1 to 100,000"),
        ("reproduce --jobs 0", "--jobs: '0'; allowed: a whole number of at least 1, or -1"),
        ("reproduce --jobs 2", f"--jobs {NOTHING}with --backend pymunk"),
        ("reproduce --out ''", "--out: ''; allowed: the name of a file or folder"),
        ("compare --track nowhere", "invalid choice: 'nowhere' (choose from"),
        ("compare --protocol --only oracle", "--only is 'oracle'; allowed: "),
        ("compare --protocol --only dagger", "is 'dagger'; allowed on these tracks: attribute_weights"),
        ("compare --learner nowhere:f", "--learner is 'nowhere:f': No module named 'nowhere'; allowed: package"),
        ("compare --learner ./m.py:f", "--learner is './m.py:f'; allowed: package.module:name of what makes"),
        ("compare --against there/g1.csv", "there/g1.csv: not JSON: Expecting value: line 1 column 1 (char 0); "),
        ("compare --against latin.csv", "latin.csv: not JSON: 'utf-8' codec can't decode byte"),
        ("compare --track offline", f"--track {NOTHING}with --protocol"),
        ("compare --protocol --steps 7", f"--steps {NOTHING}without --protocol"),
        ("infer --tables thesis --quick", f"--quick {NOTHING}without --tables"),
        ("arena show missing.toml", "No such file or directory: 'missing.toml'"),
        ("arena write doors mine.toml/a.toml", "File exists: 'mine.toml'"),
        ("infer --tables latin.csv", "latin.csv: not UTF-8 text"),
        ("infer --tables there/g1.csv", "header is '# khepera_forage experience, version 1'; allowed: 'replication,"),
        ("arena show mine.toml", "mine.toml: name is missing"),
        ("arena show circle", "arena is 'circle'; allowed: corridor, rectangle, t_maze"),
        ("arena show doors --level 0", f"--level {NOTHING}with the arena procedural"),
        ("arena show doors --out doors.gif", "--out is 'doors.gif'; allowed: a name that ends in .png"),
        ("arena show procedural --difficulty brutal", "invalid choice: 'brutal'"),
        ("arena write doors doors.txt", "file is 'doors.txt'; allowed: a name that ends in .toml"),
        ("arena write doors mine.toml", "mine.toml exists; choose another name"),
        ("dataset --name mine", "--name: 'mine'; allowed: NAME-vNUMBER, or FOLDER/NAME-vNUMBER"),
        ("dataset --name m/mine-v1", "with a FOLDER of two characters or more"),
        ("dataset --name ../mine-v1", "--name: '../mine-v1'; allowed: NAME-vNUMBER"),
        ("dataset --experience g.csv --episodes 2", f"--episodes {NOTHING}without --experience"),
        ("dataset --experience g.csv --decision v1", f"--decision {NOTHING}without --experience"),
        ("dataset --protocol --decision v1", f"--decision {NOTHING}without --protocol"),
        ("lab check missing.toml", "No such file or directory: 'missing.toml'"),
        ("lab check mine.toml", "mine.toml: robots is empty; allowed: at least one table [[robots]]"),
        ("lab new --out mine.toml", "mine.toml is there already; allowed: another --out"),
        ("lab new --robot toio --port virtual:a virtual:b --food-cube virtual:f virtual:g --arena rectangle",
         "arenas are 2 x rectangle; allowed: what fits a mat of 712 x 506 mm"),
        ("lab new --out none/lab.toml", "lab.toml; allowed: a file in a folder that exists"),
        ("lab new --robot toio --camera 0", "--camera has no effect here; allowed: for robots under a camera"),
        ("lab new --robot khepera --food-cube a", "--food-cube has no effect here; allowed: with --robot toio"),
        ("robot probe --port /dev/nowhere", "/dev/nowhere cannot be opened"),
        ("robot probe --port /dev/nowhere --baud 300", "baud 300; allowed: 9600"),
        ("robot probe --port x --robot toio", "--robot toio; allowed: khepera, e-puck2, which have a serial line"),
        ("robot drive --port x --robot toio --baud 9600", "--baud has no effect here; allowed: for a robot with"),
        ("robot grip --port x open --robot toio", "--robot toio has no gripper; allowed: khepera"),
        ("robot drive --port x --left 50", "--left: '50'; allowed: a whole number from -20 to 20"),
        ("robot drive --port x --seconds 0", "--seconds: '0'; allowed: more than 0, at most 60 seconds"),
        ("robot virtual --drop 2", "drop is 2"),
        ("robot virtual --drop 0.6 --delay 0.6", "rates of faults add up to 1.2; allowed: at most 1"),
        ("robot virtual --lateness 2 1", "lateness"),
        ("camera preview --frames 0", "--frames: '0'; allowed: a whole number of at least 1"),
        ("camera preview --out film.mov", "'film.mov'; allowed: a name that ends in .png, .gif, .mp4, .avi"),
        ("camera preview --source nowhere.avi", "nowhere.avi: there is no such file or device"),
        ("camera preview --source virtual --calibration nowhere.toml", "nowhere.toml"),
        ("camera preview --numbers 9-3", "--numbers: '9-3'; allowed: numbers and ranges"),
        ("camera preview --source virtual --markers tags --tag-size 40", "tags of 40 mm are 8 pixels wide in the pic"),
        ("camera preview --source virtual --rate 9", f"--rate {NOTHING}with a camera"),
        ("camera preview --source there/g1.csv --seed 1", f"--seed {NOTHING}with --source virtual"),
        ("camera preview --source there/g1.csv --exposure 9", f"--exposure {NOTHING}with a device"),
        ("camera preview --tag-size 40", f"--tag-size {NOTHING}with --markers tags"),
        ("camera preview --food-tag-size 40", f"--food-tag-size {NOTHING}with --food-tags"),
        ("camera preview --source virtual --numbers ''", "tracker numbers is []; allowed: at least one number"),
        ("camera preview --source 0 --rate 0", "camera rate is 0.0; allowed: above 0, up to 1000 frames a second"),
        ("camera preview --size 0x0", "'0x0'; allowed: width x height in pixels"),
        (f"camera calibrate --points {CORNERS}", "--points has 3 points; allowed: four or more"),
        (f"camera calibrate --points {CORNERS} 0,0=0,2400", "has the point"),
        (f"camera calibrate --points {CORNERS} 0,481=0,0", "the pixel 0,481; allowed: within --size, 640x480"),
        (f"camera calibrate --points {CORNERS} 0,480=0,0 --rate 9", f"--rate {NOTHING}with --places or --tags"),
        (f"camera calibrate --points {CORNERS} 0,480=0,0 --seed 0", f"--seed {NOTHING}with --places or --tags"),
        (f"camera calibrate --points {CORNERS} 0,480=0,0 --source 0", f"--source {NOTHING}with --places or --tags"),
        (f"camera calibrate --points {CORNERS} 0,1=0,0 --camera 1,2,nan", "--camera: '1,2,nan'; allowed: 3 numbers"),
        ("camera calibrate --points 0,0=0,24 640,0=32,24 640,480=32,0 0,480=0,0",
         "shows 0.05 mm of the floor; allowed: at least 0.62 mm"),
        (f"camera calibrate --points {CORNERS} 0,480=0,0 --camera 9,9,50", "height is 70.0 mm; allowed: below the cam"),
        ("camera calibrate --points 1,2", "--points: '1,2'; allowed: u,v=x,y"),
        ("camera calibrate --points 1=2,3", "--points: '1'; allowed: 2 numbers with commas between"),
        ("camera calibrate --source virtual --places -100,0 1,0 1,1 0,1", "needs a display"),
        ("camera calibrate --source virtual --tags 38=0,0 38=1,0", "--tags has 38 twice"),
        ("camera calibrate --source virtual --tags 0=0,0", "--tags: '0=0,0'; allowed: id=x,y"),
        ("camera calibrate --source virtual --tags 38=0,0 39=1,0 40=1,1 41=0,1", "0 of 4 floor tags are seen"),
        ("camera tags --size 5", "size of a robot's tag is 5 mm; allowed: 10 to 170 mm"),
        ("camera tags --food 5 --food-size 5", "size of a food's tag is 5 mm; allowed: 10 to 170 mm"),
        ("camera tags --robots 1-60", "tag is 50; allowed: ids 1 to 49"),
        ("camera tags --robots 1-3 --food 3", "tag 3 is given twice"),
        ("camera tags --out tags.svg", "would have 7 pages; allowed: a name that ends in .pdf"),
        ("camera markers --grid 13", "tracker numbers is [13]"),
        ("camera markers --grid ''", "tracker numbers is []; allowed: at least one number"),
        ("camera markers --out markers.doc", "'markers.doc'; allowed: a name that ends in .svg, .png, .pdf"),
    ],
)  # fmt: skip
def test_mistake_is_reported_in_one_line_and_changes_nothing(command: str, message: str, run: Run) -> None:
    assert message in run.refused(command)
    files = {path.name for path in Path().iterdir() if not path.is_dir() or any(path.iterdir())}
    assert files == {"there", "mine.toml", "one.toml", "deep.toml", "latin.csv"}


def test_error_of_a_learner_in_a_recall_shows_its_own_traceback(capsys: pytest.CaptureFixture[str]) -> None:
    Path("fickle.py").write_text(
        "class Fickle:\n"
        "    classes_ = [0, 2]\n"
        "    def fit(self, X, y): pass\n"
        "    def predict_proba(self, X): raise IndexError('too late')\n"
    )
    assert main(["recall", "--learner", "fickle:Fickle", "--experience", "there"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("khepera-forage recall: --learner fickle:Fickle failed\nTraceback")
    assert error.endswith("IndexError: too late\n")
    assert "khepera_forage/" not in error
