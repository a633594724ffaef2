"""What the command does, as functions."""

from __future__ import annotations

import os
import warnings
from typing import List, Optional, Sequence, Tuple, Union, overload

from . import _tribos
from ._model import Model
from ._motion import Array
from ._progress import Progress, Shown
from ._recording import Maps, Recording, Source, maps_of, recordings
from ._results import Diagnosis, Identification, diagnosis, identification

Path = Union[str, "os.PathLike[str]"]
Paths = Union[List[Path], Tuple[Path, ...]]
Sources = Union[Source, Sequence[Source]]


@overload
def read(path: Path, map: Maps = None, joint: Optional[str] = None) -> Recording: ...


@overload
def read(path: Paths, map: Maps = None, joint: Optional[str] = None) -> List[Recording]: ...


def read(
    path: Union[Path, Paths], map: Maps = None, joint: Optional[str] = None
) -> Union[Recording, List[Recording]]:
    """Reads a recording, or several: text, ``.mat``, ``.json``, ``.h5``, ``.parquet``, ``.mcap``, or a bag of ROS 2.

    ``map`` says what the variables of a file are, if their names do not: ``"position_m=qm,force_n=35.15*vir"``; for files of several
    kinds a list of maps. ``joint`` picks one of a file that has several: ``"elbow"``, ``"j2"``, ``"2"``. Raises :class:`RecordingError` with file, line, column, the value found and what would be accepted.

    >>> import tribos
    >>> tribos.read("nowhere.csv")
    Traceback (most recent call last):
    tribos.RecordingError: nowhere.csv: No such file or directory
    """
    if isinstance(path, (str, os.PathLike)):
        return Recording._of(_tribos.read([os.fspath(path)], maps_of(map), joint)[0])
    return [Recording._of(native) for native in _tribos.read([os.fspath(p) for p in path], maps_of(map), joint)]


def identify(
    recording: Sources,
    *,
    law: str = "karnopp",
    preprocess: str = "tribos",
    cutoff: Optional[float] = None,
    delta_v: Optional[float] = None,
    least_squares: bool = False,
) -> Identification:
    """Mass and friction of a recording, or of several together, with standard errors.

    ``recording``      a :class:`Recording`, a path, columns (dict or data frame), or a list of these
    ``law``            ``karnopp`` or ``dahl``
    ``preprocess``     ``tribos``, ``emps`` or ``thesis``: how velocity and acceleration are derived
    ``cutoff``         of the filter, Hz; chosen from the noise when not given
    ``delta_v``        slower samples are excluded, m/s (rad/s); chosen from the data when not given
    ``least_squares``  plain least squares instead of Fuller's errors in variables

    What the recording does not determine is in ``not_identifiable``, without a number.

    The GIL is released; Ctrl-C ends it, a fit of ``karnopp`` or a preparation at its end.

    >>> import numpy as np, tribos
    >>> t = np.arange(4000) * 1e-3                                        # s, shape (n,)
    >>> x, v, a = 0.01 * np.sin(9 * t), 0.09 * np.cos(9 * t), -0.81 * np.sin(9 * t)
    >>> force = 0.4 * a + 1.5 * np.sign(v) + 2.0 * v                      # N
    >>> found = tribos.identify({"time_s": t, "position_m": x, "force_n": force})
    >>> bool(abs(found.parameters["coulomb_p"].value - 1.5) < 0.01)      # N
    True
    """
    return identification(
        _tribos.identify(recordings(recording), law, preprocess, cutoff, delta_v, least_squares)
    )


def diagnose(
    recording: Sources,
    *,
    validate: Sources = (),
    noise: Optional[float] = None,
    cutoff: Optional[float] = None,
    per_recording: Sequence[str] = (),
    absolute: bool = False,
    exclude: Sequence[str] = (),
    progress: Progress = None,
) -> Diagnosis:
    """Where a simulation goes wrong on recordings, and what physics it leaves out.

    ``recording``      a :class:`Recording`, a path, columns (dict or data frame), or a list of these, fitted together
    ``validate``       recordings that are only predicted, to judge the findings
    ``noise``          standard deviation of one force sample, N (N·m); estimated when not given
    ``cutoff``         of the filter, Hz; chosen from the noise when not given
    ``per_recording``  what differs between the recordings: ``offset``, ``origin``, ``friction``
    ``absolute``       the position is zero at the same place in every recording
    ``exclude``        effects that are not searched
    ``progress``       True: a line on standard error; or a function of the share done, 0 to 1, and what is being done

    The GIL is released; Ctrl-C, or an exception of ``progress``, ends it.

    >>> import numpy as np, tribos
    >>> t = np.arange(6000) * 1e-3                                        # s
    >>> x = sum(r * np.sin(w * t) for r, w in [(0.010, 9), (0.006, 23)])            # m
    >>> v = sum(r * w * np.cos(w * t) for r, w in [(0.010, 9), (0.006, 23)])        # m/s
    >>> a = -sum(r * w * w * np.sin(w * t) for r, w in [(0.010, 9), (0.006, 23)])   # m/s²
    >>> noise = 0.02 * np.random.default_rng(1).standard_normal(t.size)
    >>> force = 0.4 * a + 1.5 * np.sign(v) + 2.0 * v + 60.0 * x + noise   # N; no model has the spring
    >>> why = tribos.diagnose({"time_s": t, "position_m": x, "force_n": force})
    >>> why.verdict, why.missing[0].effect
    ('mismatch', 'spring')
    """
    with Shown(progress) as callback:
        return diagnosis(
            _tribos.diagnose(
                recordings(recording),
                recordings(validate),
                noise,
                cutoff,
                list(per_recording),
                absolute,
                list(exclude),
                callback,
            )
        )


def predict(model: Union[Model, Path], recording: Source, *, absolute: bool = False) -> Array:
    """The force that a model predicts from the motion of a recording, N (N·m), shape ``(n,)``; NaN where the velocity is not known.

    The measured force is not used. Effects with a phase along the stroke are left out of a recording that the model was not made of,
    unless the position is ``absolute``; a warning says so.

    >>> import numpy as np, tribos
    >>> t = np.arange(2000) * 1e-3                                        # s
    >>> x, v, a = 0.01 * np.sin(9 * t), 0.09 * np.cos(9 * t), -0.81 * np.sin(9 * t)
    >>> model = tribos.Model.from_toml('law = "coulomb"\\nmass = 0.4\\nf_dynamic = 1.5\\ndamping = 2.0')
    >>> force = tribos.predict(model, {"time_s": t, "position_m": x, "force_n": 0 * t})
    >>> force.shape, bool(abs(force[1396] - (0.4 * a + 2.0 * v + 1.5)[1396]) < 0.02)   # N
    ((2000,), True)
    """
    made = model if isinstance(model, Model) else Model.read(model)
    natives = recordings(recording)
    if len(natives) != 1:
        raise ValueError(f"predict: {len(natives)} recordings; one is accepted")
    force, notes, _ = made._native.predict(natives[0], absolute)
    for note in notes:
        warnings.warn(f"{natives[0].name}: {note}", stacklevel=2)
    return force


def simulate(
    model: Union[Model, Path], move: str, *, seconds: float = 10.0, seed: int = 1, progress: Progress = None
) -> Recording:
    """Moves the simulated rig, whose block slides by a model, with the device's own control step, and records it.

    ``move``     ``"sine 0.01 2 10"``: wave, amplitude m (rad), frequency Hz, and perhaps seconds
    ``seconds``  length, s, if the move does not give it
    ``seed``     of the sensors' noise

    >>> import tribos
    >>> rubber = tribos.Model.from_toml('law = "coulomb"\\nmass = 0.4\\nf_dynamic = 3.0\\ndamping = 8.0')
    >>> made = tribos.simulate(rubber, "sine 0.01 2 4")
    >>> len(made), made.metadata["move"]
    (4000, 'sine 0.01 2 4')
    >>> found = tribos.identify(made)
    >>> bool(abs(found.parameters["coulomb_p"].value - 3.0) < 0.1)       # N
    True
    """
    made = model if isinstance(model, Model) else Model.read(model)
    with Shown(progress) as callback:
        return Recording._of(made._native.simulate(move, seconds, seed, callback))
