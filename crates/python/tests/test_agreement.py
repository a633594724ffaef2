"""What Python says is what the command says, to the last digit, errors included."""

import csv

import numpy as np
import pytest

import tribos


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"law": "dahl"},
        {"preprocess": "emps"},
        {"cutoff": 40.0, "delta_v": 0.01},
        {"least_squares": True},
    ],
)
@pytest.mark.parametrize("names", [["slide.csv"], ["slide.csv", "again.csv"]])
def test_identification_is_the_commands(command, files, options, names):
    flags = []
    for name, value in options.items():
        flags += ["--" + name.replace("_", "-")] + ([] if value is True else [str(value)])
    said = command(files, "identify", *names, *flags, "--json", "-", "--out", "model.toml")
    assert said.returncode == 0, said.stderr
    found = tribos.identify([files / name for name in names], **options)
    assert found.json() + "\n" == said.stdout
    assert found.model.to_toml() == (files / "model.toml").read_text()


def test_a_joint_of_several_is_the_commands(command, files):
    rows = ["time_s,a_position_m,a_force_n,b_position_m,b_force_n", "0,1,2,3,4", "0.001,5,6,7,8"]
    (files / "two.csv").write_text("\n".join(rows) + "\n")
    said = command(files, "convert", "two.csv", "b.parquet", "--joint", "b")
    assert said.returncode == 0, said.stderr
    theirs, own = tribos.read(files / "b.parquet"), tribos.read(files / "two.csv", joint="b")
    assert own.columns["force_n"].tolist() == [4.0, 8.0] and own.remarks == []
    assert {k: v.tolist() for k, v in own.columns.items()} == {k: v.tolist() for k, v in theirs.columns.items()}
    with pytest.raises(tribos.RecordingError, match="accepted is --joint with one of a, b"):
        tribos.read(files / "two.csv")


def test_diagnosis_is_the_commands(command, files):
    flags = ["--validate", "again.csv", "--json", "-", "--out", "d.toml", "--report", "d.html"]
    said = command(files, "diagnose", "slide.csv", *flags)
    assert said.returncode == 0, said.stderr
    found = tribos.diagnose(files / "slide.csv", validate=files / "again.csv")
    assert found.json() + "\n" == said.stdout
    assert found.model.to_toml() == (files / "d.toml").read_text()
    assert found.html() == (files / "d.html").read_text()
    assert found.verdict == "mismatch" and found.missing[0].effect == "spring"


def test_prediction_and_simulation_are_the_commands(command, files):
    found = tribos.diagnose(files / "slide.csv")
    found.model.write(files / "m.toml")
    said = command(files, "predict", "--model", "m.toml", "again.csv", "--out", "p.csv")
    assert said.returncode == 0, said.stderr
    rows = csv.reader(line for line in (files / "p.csv").open() if not line.startswith("#"))
    assert next(rows) == ["time_s", "force_n", "force_std_n"]
    theirs = np.array([float(force) for _, force, _ in rows])
    assert np.array_equal(tribos.predict(found.model, files / "again.csv"), theirs)
    said = command(files, "simulate", "--model", "m.toml", "--move", "sine 0.01 2 2", "--out", "s.csv")
    assert said.returncode == 0, said.stderr
    tribos.simulate(files / "m.toml", "sine 0.01 2 2").to_csv(files / "own.csv")
    assert (files / "own.csv").read_bytes() == (files / "s.csv").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "call"),
    [
        (["identify", "nowhere.csv"], lambda: tribos.identify("nowhere.csv")),
        (["identify", "hole.csv"], lambda: tribos.identify("hole.csv")),
        (["identify", "short.csv"], lambda: tribos.identify("short.csv")),
        (["identify", "foreign.csv"], lambda: tribos.identify("foreign.csv")),
        (["identify", "."], lambda: tribos.identify(".")),
        (
            ["identify", "foreign.csv", "--map", "time_s=t,position_m=y,force_n=f"],
            lambda: tribos.read("foreign.csv", map="time_s=t,position_m=y,force_n=f"),
        ),
        (
            ["identify", "slide.csv", "--law", "dahl", "--delta-v", "0.01"],
            lambda: tribos.identify("slide.csv", law="dahl", delta_v=0.01),
        ),
        (
            ["diagnose", "slide.csv", "--exclude", "phlogiston"],
            lambda: tribos.diagnose("slide.csv", exclude=["phlogiston"]),
        ),
        (
            ["diagnose", "slide.csv", "--per-recording", "offset"],
            lambda: tribos.diagnose("slide.csv", per_recording=["offset"]),
        ),
        (
            ["predict", "--model", "wrong.toml", "slide.csv", "--out", "-"],
            lambda: tribos.predict("wrong.toml", "slide.csv"),
        ),
        (
            ["simulate", "--model", "m.toml", "--move", "sine 1000 2 1", "--out", "-"],
            lambda: tribos.simulate("m.toml", "sine 1000 2 1"),
        ),
    ],
)
def test_errors_have_the_words_of_the_command(command, files, monkeypatch, arguments, call):
    monkeypatch.chdir(files)
    if not (files / "m.toml").exists():
        tribos.identify("slide.csv").model.write("m.toml")
    said = command(files, *arguments)
    assert said.returncode == 2, said.stdout
    with pytest.raises(tribos.TribosError) as raised:
        call()
    # an option is `--per-recording` there and `per_recording` here
    theirs = said.stderr.removeprefix("error: ").strip()
    if theirs.startswith("--"):
        option, rest = theirs[2:].split(":", 1)
        theirs = option.replace("-", "_") + ":" + rest
    assert str(raised.value) == theirs
