"""Recordings of the tests, and the command they are compared with."""

import os
import pathlib
import subprocess

import numpy as np
import pytest

import tribos


def slide(seconds, spring=60.0, seed=1, cubic=0.0):
    """A block of 0.4 kg with 1.5 N of friction, 2 N·s/m and a spring that no model has; 1 kHz."""
    t = np.arange(int(seconds * 1000)) * 1e-3
    x, v, a = (0.0 * t for _ in range(3))
    for r, w in [(0.010, 9.0), (0.006, 23.0)]:
        x, v, a = x + r * np.sin(w * t), v + r * w * np.cos(w * t), a - r * w * w * np.sin(w * t)
    noise = 0.02 * np.random.default_rng(seed).standard_normal(t.size)
    force = 0.4 * a + 1.5 * np.sign(v) + 2.0 * v + spring * x + cubic * x**3 + noise
    return {"time_s": t, "position_m": x, "force_n": force}


@pytest.fixture(scope="session")
def recording():
    return tribos.Recording(slide(8), name="slide.csv")


@pytest.fixture(scope="session")
def files(tmp_path_factory, recording):
    folder = tmp_path_factory.mktemp("files")
    recording.to_csv(folder / "slide.csv")
    tribos.Recording(slide(8, seed=2)).to_csv(folder / "again.csv")
    (folder / "short.csv").write_text("time_s,position_m,force_n\n0,1,2\n")
    (folder / "hole.csv").write_text("time_s,position_m,force_n\n0,1,2\n0.001,x,2\n")
    (folder / "foreign.csv").write_text("t,x,f\n0,1,2\n1,2,3\n")
    (folder / "wrong.toml").write_text('law = "coulomb"\nmass = 1\nf_dynamic = -3\n')
    return folder


@pytest.fixture(scope="session")
def command():
    """Runs the command `tribos` of the same commit: TRIBOS_BIN."""
    binary = os.environ.get("TRIBOS_BIN")
    if not binary:
        if os.environ.get("CI", "") not in ("", "false"):
            pytest.fail("TRIBOS_BIN is not set")
        pytest.skip("TRIBOS_BIN is not set: cargo build -p tribos, then TRIBOS_BIN=target/debug/tribos")
    binary = str(pathlib.Path(binary).resolve())

    def run(folder, *arguments):
        return subprocess.run([binary, *arguments], cwd=folder, capture_output=True, text=True, check=False)

    return run
