"""Types, pictures, arrays, interruption."""

import doctest
import importlib
import inspect
import os
import pathlib
import pickle
import pkgutil
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import tribos
from conftest import slide
from tribos import _results

os.environ.setdefault("MPLBACKEND", "Agg")
#: The package's sources: stubs are compared with those, types are checked in them.
SOURCES = pathlib.Path(os.environ.get("TRIBOS_SOURCES", pathlib.Path(__file__).parents[1] / "python")) / "tribos"
MODULES = ["tribos"] + [f"tribos.{m.name}" for m in pkgutil.iter_modules(tribos.__path__) if m.name != "_tribos"]


@pytest.mark.parametrize("module", MODULES)
def test_examples_in_docstrings(module):
    made = importlib.import_module(module)
    failed, _ = doctest.testmod(made, optionflags=doctest.ELLIPSIS)
    assert failed == 0


def test_there_are_examples():
    finder = doctest.DocTestFinder()
    found = [t for m in MODULES for t in finder.find(importlib.import_module(m)) if t.examples]
    assert sum(len(t.examples) for t in found) > 20


def unread(kind, data, at=""):
    """Fields of the JSON for which the type has no attribute."""
    hints = {f.name.rstrip("_"): f.name for f in _results.fields(kind)}
    types = _results.get_type_hints(kind)
    out = [at + key for key in data if key not in hints]
    for key, value in data.items():
        if key in hints:
            out += nested(types[hints[key]], value, f"{at}{key}.")
    return out


def nested(hint, value, at):
    args = _results.get_args(hint)
    if _results.get_origin(hint) is _results.Union:
        return [] if value is None else nested(args[0], value, at)
    if _results.is_dataclass(hint):
        return unread(hint, value, at)
    if isinstance(value, list) and args:
        return [line for item in value for line in nested(args[0], item, at)]
    if isinstance(value, dict) and len(args) == 2:
        return [line for item in value.values() for line in nested(args[1], item, at)]
    return []


def test_every_field_of_the_json_is_an_attribute(recording):
    found = tribos.identify(recording)
    assert unread(tribos.Identification, found.to_dict()) == []
    # a shape that no effect has: `missing` with a curve
    odd = slide(8, spring=0.0)
    odd["force_n"] = odd["force_n"] + 0.8 * np.tanh(900 * odd["position_m"]) * np.sin(700 * odd["position_m"])
    for data in [tribos.diagnose(recording, validate=slide(8, seed=3)), tribos.diagnose(odd)]:
        assert unread(tribos.Diagnosis, data.to_dict()) == []
    assert unread(tribos.Diagnosis, {**data.to_dict(), "new": 1}) == ["new"]


def test_attributes_are_typed(recording):
    found = tribos.diagnose(recording)
    first = found.missing[0]
    assert isinstance(first, tribos.Missing) and first.effect == "spring"
    assert isinstance(first.parameters["stiffness"], tribos.Quantity)
    assert abs(first.parameters["stiffness"].value - 60) < 3 * first.parameters["stiffness"].std + 0.5
    assert isinstance(found.location[0].from_, float)
    assert found.model.parameters["spring.stiffness"] == first.parameters["stiffness"].value
    assert repr(found).startswith("<tribos.Diagnosis slide.csv: mismatch.")
    page = found._repr_html_()
    assert page.startswith("<iframe srcdoc=") and "&lt;script&gt;" in page and "<script>" not in page


def test_pictures_are_drawn(recording, tmp_path):
    diagnosis = tribos.diagnose(recording)
    for i, shown in enumerate([recording, tribos.identify(recording), diagnosis, diagnosis.model]):
        figure = shown.plot()
        assert all(axis.lines for axis in figure.axes)
        figure.savefig(tmp_path / f"{i}.png")
        assert (tmp_path / f"{i}.png").stat().st_size > 5000


def test_importing_does_not_import_matplotlib():
    code = "import sys, tribos; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_data_frame_is_a_recording(recording):
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame(dict(recording))
    frame["note"] = "text is left out"
    assert np.array_equal(tribos.Recording(frame).force, recording.force)
    assert tribos.identify(frame).json().replace("columns", "slide.csv") == tribos.identify(recording).json()


def test_columns_are_kept_whatever_their_memory(recording):
    table = np.column_stack([recording.time, recording.position, recording.force, 20 + recording.time])
    names = ["time_s", "position_m", "force_n", "motor_temperature"]
    strided = {name: table[:, i] for i, name in enumerate(names)}
    again = tribos.Recording(strided, metadata={"bench": 3})
    assert np.array_equal(again.force, recording.force) and again.metadata == {"bench": "3"}
    assert np.array_equal(again["motor_temperature"], table[:, 3])
    assert tribos.Recording({k: v.astype(np.float32) for k, v in strided.items()}).force.dtype == np.float64
    with pytest.raises(ValueError, match="read-only"):
        again.force[0] = 1.0


@pytest.mark.parametrize(
    ("columns", "says"),
    [
        ({"time_s": [0, 1], "position_m": [0, 1]}, "no variable force_n or torque_nm"),
        ({"time_s": [0, 1], "position_m": [0, 1], "force_n": [0]}, "force_n has 1 samples, time_s has 2"),
        ({"time_s": [0, 1], "position_m": [[0], [1]], "force_n": [0, 1]}, "position_m has the shape (2, 1)"),
        ({"time_s": [0, 1], "position_m": [0, 1], "force_n": [1j, 1]}, "the type complex128"),
        ({"time_s": [0, 1], "position_m": [0, 1], "force_N": [0, 1]}, "`force_N` is an unknown column; accepted is force_n"),
        ({"time_s": [], "position_m": [], "force_n": []}, "no samples"),
        ({"time_s": [0, 1], "position_m": [0, 1], "force_n": [0, 1], "velocity_mm_s": [0, 1]}, "velocity_m_s"),
        ({}, "no variable time_s"),
    ],
)
def test_columns_that_make_no_recording_are_refused(columns, says):
    with pytest.raises(tribos.RecordingError) as raised:
        tribos.Recording({k: np.array(v) for k, v in columns.items()})
    assert says in str(raised.value)


@pytest.mark.parametrize("seed", range(20))
def test_rubbish_is_an_exception_or_a_result(seed):
    random = np.random.default_rng(seed)
    n = int(random.integers(1, 400))
    values = [0.0, -0.0, np.nan, np.inf, -np.inf, 1e308, -1e308, 5e-324, 1.0, -1.0]

    def column():
        out = random.standard_normal(n) * 10.0 ** random.integers(-12, 12)
        where = random.random(n) < random.choice([0.0, 0.05, 0.9])
        return np.where(where, random.choice(values, n), out)

    made = tribos.Recording({"time_s": column() if seed % 2 else np.arange(n) * 1e-3, "position_m": column(), "force_n": column()})
    for work in (tribos.identify, tribos.diagnose):
        try:
            assert work(made).json()
        except tribos.TribosError as refused:
            assert str(refused)
    assert isinstance(made.faults, list)


def test_laws_hold_their_closed_forms():
    v = np.linspace(-0.2, 0.2, 401)
    force = tribos.laws.viscous(v, damping_p=3.0, damping_n=5.0)
    assert np.allclose(force, np.where(v > 0, 3.0 * v, 5.0 * v), rtol=0, atol=1e-15)
    karnopp = dict(c_p=1.0, c_n=2.0, b_p=0.5, b_n=0.25, d_p=1.5, d_n=2.5, delta_v=0.0)
    moving = v != 0
    wanted = np.where(v > 0, 1.0 + 0.5 * v, -2.0 + 0.25 * v)
    assert np.allclose(tribos.laws.karnopp(v, **karnopp)[moving], wanted[moving])
    # Dahl at constant speed: F = limit·(1 − e^(−σx/limit))
    x = np.full(200, 1e-6)
    dahl = tribos.laws.dahl(x / 1e-3, displacement=x, limit_p=2.0, limit_n=2.0, sigma=1e5, exponent=1.0, viscous=0.0)
    assert np.allclose(dahl, 2.0 * (1 - np.exp(-1e5 * np.cumsum(x) / 2.0)), rtol=1e-9)
    # rate and state, steady: (a − b)·ln(v/v_0)
    slow = tribos.effects.rate_and_state(np.full(5000, 1e-2), d_c=1e-5, healing=1.0, force_a=0.2, force_b=0.3)
    assert slow[-1] == pytest.approx((0.2 - 0.3) * np.log(10), abs=1e-12)


def middle(function, name):
    """A value in the middle of the documented range; 1.5 where none is documented."""
    found = re.search(rf"^    {name}: .*; (\S+) to (\S+)\.$", function.__doc__, re.M)
    if not found:
        return 1.5
    low, high = map(float, found.groups())
    return (low * high) ** 0.5 if low > 0 else 0.5 * (low + high)


def test_every_law_and_effect_runs_and_refuses():
    v = 0.05 * np.sin(np.linspace(0, 20, 500))
    arrays = {"stiffness": [1e5, 5e4, 2e4, 1e4, 5e3, 2e3], "share": [0.25, 0.25, 0.2, 0.1, 0.1, 0.1]}
    for module in (tribos.laws, tribos.effects):
        assert len(dir(module)) >= 12
        for name in dir(module):
            function = getattr(module, name)
            given = {}
            for p in inspect.signature(function).parameters.values():
                if p.default is inspect.Parameter.empty and p.name != "velocity":
                    given[p.name] = arrays.get(p.name, 1.5) if name == "maxwell_slip" else middle(function, p.name)
            given.update({"adhesion": "stick_slide"} if "adhesion" in given else {})
            given.update({"elastic": 0.5} if "elastic" in given else {})
            force = function(v, **given)
            assert force.shape == v.shape and np.all(np.isfinite(force)), name
            assert "velocity: m/s" in function.__doc__ and "```" not in function.__doc__
            with pytest.raises((TypeError, tribos.TribosError)):
                function(v, **{**given, "phlogiston": 1.0})
            with pytest.raises(tribos.TribosError):
                function(v, dt=-1.0, **given)
            bad = next(iter(given), None)
            if bad is not None:
                with pytest.raises(tribos.TribosError):
                    function(v, **{**given, bad: float("nan")})
    with pytest.raises(ValueError, match="shape"):
        tribos.laws.viscous(np.zeros((2, 2)), damping_p=1.0, damping_n=1.0)
    with pytest.raises(AttributeError):
        tribos.laws.phlogiston  # noqa: B018


def test_models_survive_files_and_pickles(files, tmp_path):
    model = tribos.identify(files / "slide.csv").model
    model.write(tmp_path / "m.toml")
    assert tribos.Model.read(tmp_path / "m.toml") == model == pickle.loads(pickle.dumps(model))
    force = model.friction([0.05, -0.05])
    p = model.parameters
    assert force[0] == pytest.approx(p["f_dynamic_p"] + 0.05 * p["damping_p"])
    with pytest.raises(OSError, match="cannot be written"):
        model.write(tmp_path / "no" / "m.toml")


def test_progress_is_told_and_may_refuse(recording):
    seen = []
    tribos.diagnose(recording, progress=lambda share, what: seen.append((share, what)))
    assert seen and all(0 <= share <= 1 and what for share, what in seen)

    def stop(share, what):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        tribos.diagnose(tribos.Recording(slide(60)), progress=stop)


def test_other_threads_run_meanwhile():
    import threading

    counted = [0]
    done = threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    began = time.monotonic()
    tribos.diagnose(tribos.Recording(slide(20)))
    took = time.monotonic() - began
    done.set()
    thread.join()
    assert counted[0] > 5 * took


INTERRUPTED = """
import pathlib, sys, threading, time
import numpy as np
sys.path.insert(0, sys.argv[1])
from conftest import slide
import tribos

def busy():
    before = time.process_time()
    time.sleep(0.5)
    return time.process_time() - before > 0.1

made = tribos.Recording(slide(60, cubic=9e4))
def told(share, what):
    print("at", share, flush=True)

try:
    if sys.argv[2] == "diagnose":
        tribos.diagnose(made, progress=told)
    else:
        told(0, "")
        while True:  # a fit may be done before the signal comes
            tribos.identify(made, law="dahl")
except KeyboardInterrupt:
    raised = time.monotonic()
    print("interrupted", flush=True)
    while busy() and time.monotonic() < raised + 300:
        pass
    print("ended, busy:", busy(), flush=True)
"""


@pytest.mark.parametrize(("work", "wait"), [("diagnose", 0.0), ("diagnose", 0.5), ("diagnose", 2.0), ("identify", 1.0)])
def test_control_c_ends_the_work(work, wait):
    child = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED, str(pathlib.Path(__file__).parent), work],
        stdout=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    assert child.stdout.readline().startswith("at")
    time.sleep(wait)
    assert child.poll() is None, "it was done before"
    child.send_signal(signal.SIGINT)
    sent = time.monotonic()
    for line in child.stdout:
        if line.startswith("interrupted"):
            assert time.monotonic() - sent < 20.0
            break
    assert child.stdout.read().splitlines()[-1] == "ended, busy: False"
    assert child.wait(10) == 0
    print(f"idle {time.monotonic() - sent:.1f} s after the signal")


def stub(module):
    """The stub of a module whose functions are made of the catalogue."""
    out = [f'"""{module.__doc__.splitlines()[0]} Written by test_package.py."""', ""]
    out += ["from typing import List, Optional", "", "from ._motion import Array, ArrayLike", "", "__all__: List[str]", ""]
    for name in module.__all__:
        out.append(f"def {name}(")
        out.append("    velocity: ArrayLike,\n    *,")
        for p in list(inspect.signature(getattr(module, name)).parameters.values())[1:]:
            default = "" if p.default is inspect.Parameter.empty else f" = {p.default!r}"
            hint = {"adhesion": "str", "dt": "float", "mass": "float"}.get(p.name, "ArrayLike" if p in tribos.laws.MOTION or name == "maxwell_slip" else "float")
            hint = f"Optional[{hint}]" if p.default is None else hint
            out.append(f"    {p.name}: {hint}{default},")
        out.append(") -> Array: ...")
    return "\n".join(out) + "\n"


@pytest.mark.parametrize("name", ["laws", "effects"])
def test_stubs_are_of_today(name):
    """After a change of the catalogue: TRIBOS_ACCEPT=1 pytest crates/python/tests -k stubs."""
    wanted = stub(getattr(tribos, name))
    source = SOURCES / f"{name}.pyi"
    if os.environ.get("TRIBOS_ACCEPT"):
        source.write_text(wanted)
    assert source.read_text() == wanted


def test_types_are_consistent():
    pytest.importorskip("mypy")
    root = pathlib.Path(__file__).parents[1]
    said = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", str(root / "pyproject.toml"), str(SOURCES)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert said.returncode == 0, said.stdout
