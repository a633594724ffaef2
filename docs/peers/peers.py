"""tribos and its peers on the same recordings: error on what was not fitted, time, and what each says.

    python3 -m venv venv && venv/bin/pip install -r docs/peers/requirements.txt
    cargo build --release -p tribos
    venv/bin/python docs/peers/peers.py --tribos target/release/tribos --data ../shared/data > docs/peers.md

Everybody predicts the force from the motion alone (position, and velocity and acceleration behind one zero-phase
filter; the sign of the velocity is handed to the peers as a ready regressor) and never sees the force of what is
judged. Prediction and measured force pass one and the same filter before they are compared, ||e|| / ||F||.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
import scipy.io
import scipy.signal

warnings.filterwarnings("ignore")


class Case:
    """A recording cut into what is fitted and what is judged; masks over samples."""

    def __init__(self, name, pieces, unit, cutoff, train, judge, every):
        self.name, self.unit, self.cutoff = name, unit, cutoff
        self.pieces = pieces  # (time, position, force) of each file
        self.train, self.judge, self.every = train, judge, every


def low_pass(x, dt, cutoff):
    b, a = scipy.signal.butter(4, min(0.9, 2 * cutoff * dt))
    return scipy.signal.filtfilt(b, a, x)


def features(t, x, cutoff):
    dt = np.median(np.diff(t))
    x = low_pass(x, dt, cutoff)
    # four-point central differences, as everybody's judge has them; the sign behind the same filter as the force
    d = lambda y: np.convolve(np.pad(y, 2, "edge"), np.array([-1, 8, 0, -8, 1]) / (12 * dt), "valid")
    v = d(x)
    return np.column_stack([x, v, d(v), low_pass(np.sign(v), dt, cutoff)])


def emps(data):
    m = scipy.io.loadmat(data / "emps/DATA_EMPS.mat")
    t, x, g = (m[k].ravel() for k in ("t", "qm", "qg"))
    return t, x, m["vir"].ravel() * float(m["gtau"].ravel()[0]), g


def speed_of(g):
    """Which of the three speeds of the reference each sample belongs to."""
    v = np.abs(np.gradient(g, 1e-3))
    out, start = np.zeros(len(g), int), 0
    for i in range(1, len(g) + 1):
        if i == len(g) or (v[i] < 0.004 and v[i] <= v[i - 1] and i > start + 100):
            out[start:i] = np.clip(round(v[start:i].max() / 0.0415), 1, 3)
            start = i
    return out


def cases(data):
    t, x, f, g = emps(data)
    half, speed = np.arange(len(t)) < len(t) // 2, speed_of(g)
    yield Case("EMPS, second half", [(t, x, f)], "m N", 40.0, [half], [~half], 10)
    for k, what in ((1, "slowest"), (2, "middle"), (3, "fastest")):
        out = speed == k
        yield Case(f"EMPS, {what} speed left out", [(t, x, f)], "m N", 40.0, [~out], [out], 10)
    m = scipy.io.loadmat(data / "silverbox/SNLS80mV.mat")
    u, y = m["V1"].ravel(), m["V2"].ravel()
    t = np.arange(len(u)) / 610.35
    # the ten multisines are fitted, but the last; it and the growing noise before them are judged
    train = (t > 40800 / 610.35) & (t < 118000 / 610.35)
    for name, judge in (("multisine", t > 119000 / 610.35), ("growing noise", t < 39500 / 610.35)):
        yield Case(f"Silverbox, {name}", [(t, y, u)], "m N", 60.0, [train], [judge], 4)
    pieces, train, judge = [], [], []
    for file in sorted((data / "servo_pendulum").glob("*.json")):
        log = json.loads(file.read_text())
        e = log["entries"]
        col = lambda k: np.array([s[k] for s in e], float)
        duty = np.clip(0.166 * log["kp"] * (col("goal_position") - col("position")), -0.97, 0.97)
        tq = log["vin"] * duty * col("torque_enable")
        if "lift" in file.name:
            continue  # most of it is with the torque off: without the winding's back-EMF it is another machine
        pieces.append((col("timestamp"), col("position"), tq))
        judged = "square" in file.name
        train.append(np.full(len(e), not judged))
        judge.append(np.full(len(e), judged))
    yield Case("Servo pendulum, the chirp", pieces, "rad nm", 5.0, train, judge, 1)


def table(case, which, width=None):
    """Rows of features and force where `which` holds, every few samples."""
    rows_x, rows_f = [], []
    for (t, x, f), keep in zip(case.pieces, which):
        take = np.flatnonzero(keep)[:: case.every]
        edge = 4.0 / (case.cutoff * np.median(np.diff(t)))
        take = take[(take > edge) & (take < len(f) - edge)]
        rows_x.append(features(t, x, case.cutoff)[take])
        rows_f.append(low_pass(f, np.median(np.diff(t)), case.cutoff)[take])
    return np.vstack(rows_x), np.concatenate(rows_f)


# Each peer: fit on a table, give back a prediction for another, and what can be read off.


def sindy(x, f):
    import pysindy as ps

    library = ps.PolynomialLibrary(degree=2, include_bias=True)
    scale = np.abs(x).max(axis=0)
    made = np.asarray(library.fit_transform(x / scale))
    best = None
    for threshold in (0.003, 0.01, 0.03, 0.1, 0.3):
        optimizer = ps.STLSQ(threshold=threshold * np.abs(f).max(), alpha=1e-6, normalize_columns=False)
        cut = len(made) * 3 // 4
        optimizer.fit(made[:cut], f[:cut, None])
        error = np.linalg.norm(made[cut:] @ np.asarray(optimizer.coef_).ravel() - f[cut:])
        if best is None or error < best[0]:
            best = (error, threshold)
    optimizer = ps.STLSQ(threshold=best[1] * np.abs(f).max(), alpha=1e-6, normalize_columns=False)
    optimizer.fit(made, f[:, None])
    c = np.asarray(optimizer.coef_).ravel()
    names = library.get_feature_names(["x", "v", "a", "sgn_v"])
    said = " + ".join(n for n, k in zip(names, c) if k != 0)
    return (lambda z: np.asarray(library.transform(z / scale)) @ c), said


def narx(x, f):
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS
    from sysidentpy.parameter_estimation import LeastSquares

    scale = np.abs(x).max(axis=0)
    model = FROLS(
        order_selection=True, n_info_values=25, xlag=[[1, 2]] * x.shape[1], info_criteria="bic",
        model_type="NFIR", basis_function=Polynomial(degree=2), estimator=LeastSquares(),
    )  # NFIR: no measured force of the past, as for everybody
    model.fit(X=x / scale, y=f[:, None])
    lag = model.max_lag
    def predict(z):
        z = np.vstack([z[:1]] * lag + [z]) / scale
        # shifted by one: this tool's inputs begin one step back
        z = np.vstack([z[1:], z[-1:]])
        return np.asarray(model.predict(X=z, y=np.zeros((lag, 1)))).ravel()[lag:]
    return predict, f"{len(model.final_model)} lagged products"


def gp(x, f):
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    take = np.linspace(0, len(x) - 1, min(len(x), 500)).astype(int)
    scale, size = x.std(axis=0), f.std()
    kernel = ConstantKernel(1.0) * RBF(np.ones(x.shape[1]), (1e-2, 1e3)) + WhiteKernel(1e-3)
    model = GaussianProcessRegressor(kernel, n_restarts_optimizer=0, random_state=0)
    model.fit((x / scale)[take], f[take] / size)
    return (lambda z: model.predict(z / scale) * size), "nothing"


def judged_error(case, predictions):
    error = size = 0.0
    for (t, x, f), keep, p in zip(case.pieces, case.judge, predictions):
        if keep.any():
            dt = np.median(np.diff(t))
            e, y = low_pass(f - p, dt, case.cutoff), low_pass(f, dt, case.cutoff)
            take = np.flatnonzero(keep)[:: case.every]
            # the ends of a recording are the filters', not the models'
            edge = 4.0 / (case.cutoff * dt)
            take = take[(take > edge) & (take < len(f) - edge)]
            error, size = error + (e[take] ** 2).sum(), size + (y[take] ** 2).sum()
    return np.sqrt(error / size)


def peer(case, make):
    x, f = table(case, case.train)
    began = time.perf_counter()
    predict, said = make(x, f)
    seconds = time.perf_counter() - began
    out = []
    for (t, pos, force), keep in zip(case.pieces, case.judge):
        # predicted on the judging grid, the other samples are not looked at
        p = np.array(force, float)
        if keep.any():
            z = features(t, pos, case.cutoff)
            grid = np.arange(0, len(t), case.every)
            p = np.interp(np.arange(len(t)), grid, predict(z[grid]))
        out.append(p)
    return judged_error(case, out), seconds, said


def write(path, case, piece, keep):
    t, x, f = piece
    pos, force = ("position_m", "force_n") if case.unit == "m N" else ("position_rad", "torque_nm")
    rows = np.flatnonzero(keep)
    lines = [f"time_s,{pos},{force}"] + [f"{t[i]!r},{x[i]!r},{f[i]!r}" for i in rows]
    path.write_text("\n".join(lines).replace("np.float64(", "").replace(")", "") + "\n")


def tribos(case, binary):
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        train = []
        for i, (piece, keep) in enumerate(zip(case.pieces, case.train)):
            if keep.any():
                train.append(folder / f"train{i}.csv")
                write(train[-1], case, piece, keep)
        model, found = folder / "model.toml", folder / "found.json"
        began = time.perf_counter()
        subprocess.run([binary, "diagnose", *train, "--out", model, "--json", found], check=True, capture_output=True)
        seconds = time.perf_counter() - began
        out = []
        for i, (piece, keep) in enumerate(zip(case.pieces, case.judge)):
            p = np.array(piece[2], float)
            if keep.any():
                whole = folder / "judge.csv"
                # the force of what is judged is not there to be seen
                write(whole, case, (piece[0], piece[1], np.zeros_like(p)), np.full(len(p), True))
                subprocess.run([binary, "predict", "--model", model, whole, "--out", folder / "p.csv"], check=True, capture_output=True)
                lines = [l for l in (folder / "p.csv").read_text().splitlines() if l and l[0] in "-0123456789"]
                p = np.array([float(l.split(",")[1]) for l in lines])
            out.append(p)
        said = json.loads(found.read_text())
        names = ", ".join(m["effect"] for m in said["missing"]) or said["verdict"]
        return judged_error(case, out), seconds, names


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--tribos", default="target/release/tribos")
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    args = parser.parse_args()
    tools = [
        ("tribos", lambda c: tribos(c, args.tribos)),
        ("PySINDy 2.1.0", lambda c: peer(c, sindy)),
        ("SysIdentPy 0.9.0 (FROLS)", lambda c: peer(c, narx)),
        ("GP (scikit-learn 1.9.1)", lambda c: peer(c, gp)),
    ]
    rows = {}
    for case in cases(args.data):
        for name, run in tools:
            try:
                rows[case.name, name] = run(case)
                e, s, said = rows[case.name, name]
                print(f"{case.name:34} {name:26} {100 * e:7.2f} % {s:7.1f} s  {said[:90]}", file=sys.stderr)
            except Exception as why:  # a peer that fails is shown as failing
                rows[case.name, name] = (float("nan"), float("nan"), f"failed: {why}")
                print(case.name, name, "failed:", why, file=sys.stderr)
    print("# tribos and its peers\n")
    print(__doc__.split("\n\n", 1)[1].replace("    ", "    "))
    names = list(dict.fromkeys(c for c, _ in rows))
    print("Error on what was not fitted, % of the force (time to fit, s):\n")
    print("| judged on | " + " | ".join(n for n, _ in tools) + " |")
    print("| --- |" + " ---: |" * len(tools))
    for c in names:
        cells = [f"{100 * rows[c, n][0]:.2f} ({rows[c, n][1]:.1f})" for n, _ in tools]
        print(f"| {c} | " + " | ".join(cells) + " |")
    print("\n| tool | says where the mismatch is | says what it is |\n| --- | --- | --- |")
    print("| tribos | yes: regions of velocity, position, time … with their share | named effects with equation, interval and rivals |")
    print("| PySINDy | no | products of what it was handed |")
    print("| SysIdentPy | no | lagged products of what it was handed |")
    print("| GP | no | no |")
    print("\nWhat each said:\n")
    for (c, n), (_, _, said) in rows.items():
        print(f"* {c}, {n}: {said if len(said) < 300 else said[:300] + ' …'}")


if __name__ == "__main__":
    main()
