"""Pictures; matplotlib is imported here only."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

try:
    import matplotlib.pyplot as plt
    from matplotlib.figure import Figure
except ImportError as error:  # pragma: no cover
    raise ImportError("plot() needs matplotlib: pip install matplotlib") from error

if TYPE_CHECKING:
    from ._model import Model
    from ._recording import Recording
    from ._results import Diagnosis, Identification


def _units(rotary: bool) -> dict[str, str]:
    linear = {"position": "m", "velocity": "m/s", "force": "N"}
    return {"position": "rad", "velocity": "rad/s", "force": "N·m"} if rotary else linear


def _axes(rows: int, height: float = 2.2, **more: Any) -> Any:
    return plt.subplots(rows, 1, figsize=(8, height * rows), layout="constrained", **more)


def recording(r: Recording) -> Figure:
    rotary = r.geometry == "rotary"
    names = ["position_rad", "velocity_rad_s", "torque_nm"] if rotary else ["position_m", "velocity_m_s", "force_n"]
    names = [name for name in names if name in r.columns]
    figure, axes = _axes(len(names), sharex=True)
    for axis, name in zip(axes, names):
        axis.plot(r.time, r[name], lw=0.8)
        axis.set_ylabel(name)
    axes[0].set_title(r.name)
    axes[-1].set_xlabel("time, s")
    return figure  # type: ignore[no-any-return]


def identification(found: Identification) -> Figure:
    units = _units(found.model.geometry == "rotary")
    s = found.series
    figure, (left, right) = _axes(2, 3.0)
    left.plot(s["velocity"], s["friction"], ".", ms=1.5, alpha=0.4, label="force less inertia")
    mass = found.model.mass
    acceleration = (s["force"] - s["friction"]) / mass if mass > 0 else np.zeros_like(s["force"])
    left.plot(s["velocity"], s["predicted"] - mass * acceleration, ".", ms=1.5, label=found.law)
    left.set_xlabel(f"velocity, {units['velocity']}")
    left.set_ylabel(f"friction, {units['force']}")
    left.legend(markerscale=4)
    left.set_title(found.name)
    right.plot(s["time"], s["force"], lw=0.8, label="measured")
    right.plot(s["time"], s["predicted"], lw=0.8, label="predicted")
    right.set_xlabel("time, s")
    right.set_ylabel(f"force, {units['force']}")
    right.legend()
    return figure  # type: ignore[no-any-return]


def diagnosis(found: Diagnosis) -> Figure:
    unit = found.noise_floor.unit
    curves = found._native.curves()
    s = found.series
    figure, axes = _axes(1 + min(len(curves), 2), 2.6, squeeze=False)
    panels = [axis for row in axes for axis in row]
    for axis, (coordinate, of, subset, bins) in zip(panels[1:], curves):
        axis.fill_between(bins["at"], -bins["band"], bins["band"], color="0.85", label="95 % band")
        axis.plot(bins["at"], bins["before"], label="before")
        axis.plot(bins["at"], bins["after"], label="after")
        words = f"{coordinate.replace('_', ' ')} {subset}".strip()
        axis.set_xlabel(f"{words}, {of}" if of else words)
        axis.set_ylabel(f"mean error, {unit}")
        axis.legend()
    if len(s["time"]):
        panels[0].plot(s["time"], s["force"] - s["before"], lw=0.6, label="before")
        panels[0].plot(s["time"], s["force"] - s["after"], lw=0.6, label="after")
        panels[0].legend()
    panels[0].set_xlabel("time, s")
    panels[0].set_ylabel(f"error, {unit}")
    named = ", ".join(m.effect for m in found.missing)
    panels[0].set_title(f"{found.name}: {found.verdict}" + (f": {named}" if named else ""))
    return figure  # type: ignore[no-any-return]


def model(m: Model, fastest: float) -> Figure:
    units = _units(m.geometry == "rotary")
    speeds = np.geomspace(fastest / 1000, fastest, 60)
    # each speed until the memory of the contact has settled
    steady = [[m.friction(np.full(2000, sign * v), dt=0.01)[-1] for v in speeds] for sign in (1, -1)]
    figure, axis = _axes(1, 3.6)
    axis.plot(np.r_[-speeds[::-1], speeds], np.r_[steady[1][::-1], steady[0]])
    axis.axhline(0, color="0.8", lw=0.8)
    axis.set_xlabel(f"velocity, {units['velocity']}")
    axis.set_ylabel(f"steady friction, {units['force']}")
    axis.set_title(m.name or m.law)
    return figure  # type: ignore[no-any-return]
