"""Friction from recordings.

>>> import numpy as np, tribos
>>> t = np.arange(4000) * 1e-3                                          # s
>>> x, v, a = 0.01 * np.sin(9 * t), 0.09 * np.cos(9 * t), -0.81 * np.sin(9 * t)
>>> noise = 0.01 * np.random.default_rng(1).standard_normal(t.size)
>>> recording = tribos.Recording(
...     {"time_s": t, "position_m": x, "force_n": 0.4 * a + 1.5 * np.sign(v) + 2.0 * v + noise})
>>> found = tribos.identify(recording)
>>> round(found.parameters["mass"].value, 2), found.parameters["mass"].unit
(0.4, 'kg')
>>> bool(abs(found.parameters["coulomb_p"].value - 1.5) < 0.02)        # N
True

Arrays have the shape ``(n,)``, one value a sample, in SI units: s, m, m/s, m/s², N, kg; on a rotary axis rad and N·m.
"""

from . import effects, laws
from ._api import diagnose, identify, predict, read, simulate
from ._model import Model
from ._recording import Recording
from ._results import (
    After,
    Baseline,
    Blind,
    DoesNotCarryOver,
    Channel,
    Cutoffs,
    Diagnosis,
    EncoderWave,
    Estimate,
    Estimated,
    Experiment,
    Fault,
    FreeCurve,
    Identification,
    LeftOut,
    Location,
    LooksLike,
    Missing,
    NextExperiment,
    NoiseFloor,
    NotIdentifiable,
    PerRecording,
    Preparation,
    Quantity,
    Rejected,
    Remainder,
    Validation,
)
from ._tribos import ModelError, RecordingError, TribosError, __version__

__all__ = [
    "After",
    "Baseline",
    "Blind",
    "Channel",
    "Cutoffs",
    "Diagnosis",
    "DoesNotCarryOver",
    "EncoderWave",
    "Estimate",
    "Estimated",
    "Experiment",
    "Fault",
    "FreeCurve",
    "Identification",
    "LeftOut",
    "Location",
    "LooksLike",
    "Missing",
    "Model",
    "ModelError",
    "NextExperiment",
    "NoiseFloor",
    "NotIdentifiable",
    "PerRecording",
    "Preparation",
    "Quantity",
    "Recording",
    "RecordingError",
    "Rejected",
    "Remainder",
    "TribosError",
    "Validation",
    "__version__",
    "diagnose",
    "effects",
    "identify",
    "laws",
    "predict",
    "read",
    "simulate",
]
