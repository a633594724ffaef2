"""A model in the format of a simulator moves as the model file says."""

import json
import re
import xml.etree.ElementTree as xml

import numpy as np
import pytest

import tribos

MODEL = """law = "coulomb"
mass = 0.4
f_dynamic = 1.5
damping = 2.0
spring.stiffness = 60.0
offset.force = -0.12
"""


def moved(seconds=4.0):
    """The motion of two sines and the force of MODEL along it, without noise; 1 kHz."""
    t = np.arange(int(seconds * 1000)) * 1e-3
    x, v, a = (np.zeros_like(t) for _ in range(3))
    for r, w in [(0.010, 9.0), (0.006, 23.0)]:
        x, v, a = x + r * np.sin(w * t), v + r * w * np.cos(w * t), a - r * w * w * np.sin(w * t)
    return t, x, v, 0.4 * a + tribos.Model.from_toml(MODEL).friction(v, position=x)


def follow(text, t, x, v, force):
    """Position of the joint under the recorded force, from where the recording begins."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = x[0], v[0]
    if model.na:  # a body that moves has bent its bristles
        data.act[0] = np.sign(v[0]) * model.actuator_biasprm[0][3] / model.actuator_dynprm[0][5]
    out = np.empty_like(t)
    for i in range(t.size):
        out[i] = data.qpos[0]
        while data.time < t[i] + 1e-3 - 0.5 * model.opt.timestep:
            data.qfrc_applied[0] = np.interp(data.time + 0.5 * model.opt.timestep, t, force)
            mujoco.mj_step(model, data)
    return out


@pytest.fixture(scope="module")
def exported(command, tmp_path_factory):
    folder = tmp_path_factory.mktemp("export")
    (folder / "model.toml").write_text(MODEL)
    t, x, v, force = moved()
    tribos.Recording({"time_s": t, "position_m": x, "velocity_m_s": v, "force_n": force}).to_csv(folder / "rec.csv")

    def run(*arguments):
        return command(folder, "export", *arguments)

    return run


def test_mujoco_follows_the_recording(exported):
    said = exported("mujoco", "--model", "model.toml", "--recording", "rec.csv")
    assert said.returncode == 0, said.stderr
    t, x, v, force = moved()
    error = np.abs(follow(said.stdout, t, x, v, force) - x).max()
    print(f"largest error {1e6 * error:.1f} µm of a stroke of {1e3 * np.ptp(x):.1f} mm")
    assert error < 0.01 * np.ptp(x)
    # and it would show: friction or spring a tenth off
    for attribute in ("frictionloss", "stiffness"):
        wrong = re.sub(rf'{attribute}="([^"]+)"', lambda m: f'{attribute}="{1.1 * float(m[1])}"', said.stdout)
        assert np.abs(follow(wrong, t, x, v, force) - x).max() > 5 * error


BRISTLES = MODEL.replace('"coulomb"', '"dahl"') + """sigma = 3e4
stribeck.force_p = 0.5
stribeck.force_n = 0.5
stribeck.v_s = 0.02
stribeck.delta = 2.0
cogging.sine_1 = 0.15
cogging.wavelength = 0.02
"""


def test_mujoco_holds_bristles_their_fall_and_cogging(command, tmp_path):
    t, x, v, _ = moved()
    a = sum(-r * w * w * np.sin(w * t) for r, w in [(0.010, 9.0), (0.006, 23.0)])
    force = 0.4 * a + tribos.Model.from_toml(BRISTLES).friction(v, position=x)
    (tmp_path / "rich.toml").write_text(BRISTLES)
    tribos.Recording({"time_s": t, "position_m": x, "velocity_m_s": v, "force_n": force}).to_csv(tmp_path / "rec.csv")
    said = command(tmp_path, "export", "mujoco", "--model", "rich.toml", "--recording", "rec.csv")
    assert said.returncode == 0 and "not held: reversal of stribeck" in said.stderr, said.stderr
    error = np.abs(follow(said.stdout, t, x, v, force) - x).max()
    print(f"largest error {1e6 * error:.1f} µm of a stroke of {1e3 * np.ptp(x):.1f} mm")
    assert error < 0.01 * np.ptp(x)
    # and it would show: friction a tenth off, no fall over the speed, no cogging
    scaled = lambda factors: lambda m: f'{m[1]}="{" ".join(str(float(n) * k) for n, k in zip(m[2].split(), factors))}"'
    for attribute, factors in [("lugre", (1, 1, 1.1, 1.1, 1)), ("lugre", (1, 1, 1, 0.75, 1)), ("cogging", (0, 1, 1))]:
        wrong = re.sub(rf'({attribute})="([^"]+)"', scaled(factors), said.stdout)
        off = np.abs(follow(wrong, t, x, v, force) - x).max()
        print(f"{attribute} by {factors}: {1e6 * off:.1f} µm")
        assert off > 3 * error


def test_an_axis_is_a_hinge(command, tmp_path):
    text = "[preset]\n" + MODEL + '[model]\ngeometry = "rotary"\n'
    (tmp_path / "axis.toml").write_text(text)
    said = command(tmp_path, "export", "mujoco", "--model", "axis.toml", "--out", "axis.xml")
    assert said.returncode == 0 and said.stdout == "", said.stderr
    t, x, v, force = moved(2.0)
    error = np.abs(follow((tmp_path / "axis.xml").read_text(), t, x, v, force) - x).max()
    assert error < 0.01 * np.ptp(x)


def test_urdf_has_what_it_can_hold(exported):
    said = exported("urdf", "--model", "model.toml", "--recording", "rec.csv")
    assert said.returncode == 0, said.stderr
    assert "not held: spring (stiffness*x): " in said.stderr and "N rms on the recording" in said.stderr
    joint = xml.fromstring(said.stdout).find("joint")
    dynamics, limit = joint.find("dynamics").attrib, joint.find("limit").attrib
    assert (float(dynamics["damping"]), float(dynamics["friction"])) == (2.0, 1.5)
    _, x, v, force = moved()
    assert float(limit["upper"]) == x.max() and float(limit["lower"]) == x.min()
    assert float(limit["effort"]) == np.abs(force).max() and float(limit["velocity"]) == np.abs(v).max()
    assert exported("urdf", "--model", "model.toml").returncode == 2


def components(text):
    """Components of a Modelica model by name, with their parameters, and the pairs that are connected; as a parser reads them."""
    parser = pytest.importorskip("pymoca.parser")
    # beside the types of the language
    (model,) = (model for name, model in parser.parse(text).classes.items() if name.startswith("joint_"))

    def number(value):
        # rows, numbers, and numbers with a sign
        if hasattr(value, "values"):
            return [number(v) for v in value.values]
        if hasattr(value, "operator"):
            assert str(value.operator) == "-"
            return -number(value.operands[0])
        return float(value.value)

    parts = {}
    for name, symbol in model.symbols.items():
        arguments = symbol.class_modification.arguments if symbol.class_modification else []
        values = {str(a.value.component): number(a.value.modifications[0]) for a in arguments}
        parts[name] = (str(symbol.type), values)
    return parts, [(str(c.left), str(c.right)) for c in model.equations]


def matrix(text, parameter):
    rows = re.search(parameter + r" = \[([^\]]*)\]", text)[1].split(";")
    return np.array([[float(cell) for cell in row.split(",")] for row in rows])


def integrate(text, t, x, v, force, friction=1.0):
    """The joint of a Modelica text under the recorded force, by the equations of its components: friction that stops it or slides."""
    value = lambda name: float(m[1]) if (m := re.search(rf"\b{name} = ([-+0-9.e]+)", text)) else 0.0
    table, mass = matrix(text, "f_pos"), value("m")
    stiffness, rest, constant, peak = value("c"), value("s_rel0"), value("f_constant"), value("peak")
    place = matrix(text, "place_table.table") if "place_table" in text else np.zeros((2, 2))
    steps, dt = 20, (t[1] - t[0]) / 20
    at, speed, out = x[0], v[0], np.empty_like(t)
    last = (table[-1, 1] - table[-2, 1]) / (table[-1, 0] - table[-2, 0])
    for i in range(t.size):
        out[i] = at
        for k in range(steps):
            drive = np.interp(t[i] + (k + 0.5) * dt, t, force) + constant - stiffness * (at - rest)
            drive += np.interp(at, *place.T) if place[-1, 0] else 0.0
            beyond = max(0.0, abs(speed) - table[-1, 0]) * last
            level = friction * (np.interp(abs(speed), *table.T) + beyond)
            stop = drive + mass * speed / dt
            most = level if speed else peak * level
            speed += (drive - np.clip(stop, -most, most)) / mass * dt
            at += speed * dt
    return out


RICH = MODEL + """stribeck.force_p = 0.5
stribeck.force_n = 0.5
stribeck.v_s = 0.02
stribeck.delta = 1.0
cogging.sine_1 = 0.15
cogging.wavelength = 0.02
"""  # a pattern steeper than the spring holds the body at places that an open-loop run may miss


def test_modelica_follows_the_recording(command, tmp_path):
    t, x, v, _ = moved()
    force = 0.4 * np.gradient(v, t) + tribos.Model.from_toml(RICH).friction(v, position=x)
    (tmp_path / "rich.toml").write_text(RICH)
    tribos.Recording({"time_s": t, "position_m": x, "velocity_m_s": v, "force_n": force}).to_csv(tmp_path / "rec.csv")
    said = command(tmp_path, "export", "modelica", "--model", "rich.toml", "--recording", "rec.csv")
    assert said.returncode == 0 and "not held: on the recording the model errs" in said.stderr, said.stderr
    error = np.abs(integrate(said.stdout, t, x, v, force) - x).max()
    print(f"largest error {1e6 * error:.1f} µm of a stroke of {1e3 * np.ptp(x):.1f} mm")
    assert error < 0.01 * np.ptp(x)
    # and it would show: friction a tenth off, or the table over the place gone
    assert np.abs(integrate(said.stdout, t, x, v, force, friction=1.1) - x).max() > 5 * error
    assert np.abs(integrate(said.stdout.replace("place_table", "gone"), t, x, v, force) - x).max() > 5 * error


def test_a_parser_of_modelica_reads_the_joint(command, tmp_path):
    (tmp_path / "model.toml").write_text(MODEL)
    (tmp_path / "axis.toml").write_text("[preset]\n" + MODEL + '[model]\ngeometry = "rotary"\n')
    for file, package, body, friction in [
        ("model.toml", "Translational", "Mass", "SupportFriction"),
        ("axis.toml", "Rotational", "Inertia", "BearingFriction"),
    ]:
        said = command(tmp_path, "export", "modelica", "--model", file)
        parts, connected = components(said.stdout)
        package = f"Modelica.Mechanics.{package}"
        assert parts["body"][0] == f"{package}.Components.{body}"
        assert parts["friction"][0] == f"{package}.Components.{friction}"
        assert parts["spring"][0] == f"{package}.Components.Spring"
        assert ("flange", "body.flange_a") in connected and ("body.flange_b", "friction.flange_a") in connected


def test_bam_has_the_friction_of_the_model(command, tmp_path):
    bam = pytest.importorskip("bam.model")
    axis = """[preset]
law = "coulomb"
mass = 0.02
f_dynamic = 0.1
damping = 0.05
stribeck.force_p = 0.08
stribeck.force_n = 0.08
stribeck.v_s = 0.25
stribeck.delta = 1.4
load_dependent_friction.share = 0.07
[model]
geometry = "rotary"
"""
    (tmp_path / "axis.toml").write_text(axis)
    said = command(tmp_path, "export", "bam", "--model", "axis.toml", "--out", "bam.json")
    assert said.returncode == 0, said.stderr
    assert json.loads((tmp_path / "bam.json").read_text())["model"] == "m4"
    loaded = bam.load_model(str(tmp_path / "bam.json"))
    model = tribos.Model.from_toml(axis)
    for speed in (0.01, 0.2, 0.9, 4.0):
        for torque in (0.0, 0.3, -1.2):
            loss, damping = loaded.compute_frictions(torque, 0.0, speed)
            ours = float(model.friction(np.array([speed]), applied=np.array([torque]))[0])
            assert abs(loss + damping * speed - ours) < 1e-9, (speed, torque)
    assert loaded.actuator.get_extra_inertia() == 0.02
