"""A model in MuJoCo moves as the model file says."""

import re
import xml.etree.ElementTree as xml

import numpy as np
import pytest

import tribos

mujoco = pytest.importorskip("mujoco")

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
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = x[0], v[0]
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
