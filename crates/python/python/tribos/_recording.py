"""Recordings: columns of equal length in SI units."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, Iterable, Iterator, List, Mapping, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from . import _tribos
from ._results import Fault, from_dict

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = npt.NDArray[np.float64]
Maps = Union[None, str, Sequence[str]]
Source = Union["Recording", Mapping[str, Any], str, "os.PathLike[str]"]


def maps_of(map: Maps) -> List[str]:
    if map is None:
        return []
    return [map] if isinstance(map, str) else list(map)


class Recording:
    """Columns of one recording, shape ``(n,)`` each, read-only.

    Made of a mapping of columns (a dict of arrays, a pandas data frame) whose names carry the units: ``time_s``, ``position_m``,
    ``force_n``, optional ``velocity_m_s``, ``acceleration_m_s2``, ``normal_force_n``, ``command_n``, ``reference_m``,
    ``temperature_c``; on an axis ``position_rad``, ``velocity_rad_s``, ``acceleration_rad_s2``, ``torque_nm``. Further columns of
    numbers are kept; a mismatch may follow one. ``map`` says what columns of other names are.

    >>> import numpy as np, tribos
    >>> t = np.arange(5) * 1e-3
    >>> r = tribos.Recording({"t": t, "x": t**2, "u": t}, map="time_s=t,position_m=x,force_n=35.15*u", name="bench")
    >>> r
    <tribos.Recording bench: 5 samples, 0.001 s apart, time_s position_m force_n>
    >>> float(r["force_n"][4])
    0.1406
    >>> tribos.Recording({"t": t, "x": t})
    Traceback (most recent call last):
    tribos.RecordingError: columns: no variable time_s; the file has t (5 column), x (5 column); say what they are with a map such as time_s=t,position_m=x,force_n=k*u
    """

    def __init__(
        self,
        columns: Mapping[str, Any],
        *,
        map: Maps = None,
        name: str = "columns",
        metadata: Optional[Mapping[str, str]] = None,
    ) -> None:
        arrays = {str(key): np.asarray(columns[key]) for key in columns}
        for key, values in arrays.items():
            if values.ndim != 1 or not np.issubdtype(values.dtype, np.number) or np.iscomplexobj(values):
                if key in _NAMES or map is not None:
                    raise _tribos.RecordingError(
                        f"{name}: {key} has the shape {values.shape} and the type {values.dtype}; "
                        "accepted are real numbers of the shape (n,)"
                    )
        numbers = {
            key: np.ascontiguousarray(values, dtype=np.float64)
            for key, values in arrays.items()
            if values.ndim == 1 and np.issubdtype(values.dtype, np.number)
        }
        notes = {str(k): str(v) for k, v in (metadata or {}).items()}
        self._set(_tribos.Recording.from_columns(name, numbers, maps_of(map), notes))

    def _set(self, native: _tribos.Recording) -> None:
        self._native = native
        self._columns: Optional[dict[str, Array]] = None
        self._faults: Optional[List[Fault]] = None

    @classmethod
    def _of(cls, native: _tribos.Recording) -> Recording:
        made = cls.__new__(cls)
        made._set(native)
        return made

    @property
    def name(self) -> str:
        """File name, or what it is called in messages."""
        return self._native.name

    @property
    def geometry(self) -> str:
        """``linear`` (m, N, kg) or ``rotary`` (rad, N·m, kg·m²)."""
        return self._native.geometry

    @property
    def metadata(self) -> dict[str, str]:
        """``# key: value`` lines of the file."""
        return self._native.metadata

    @property
    def remarks(self) -> List[str]:
        """What reading did to the numbers: units converted, clocks joined."""
        return self._native.remarks

    @property
    def sample_period(self) -> Optional[float]:
        """Median time between samples, s."""
        return self._native.sample_period

    @property
    def columns(self) -> dict[str, Array]:
        """Columns by name, shape ``(n,)``, time first."""
        if self._columns is None:
            self._columns = self._native.columns()
        return self._columns

    @property
    def faults(self) -> List[Fault]:
        """What the audit finds: faults of the recording, which are not physics."""
        if self._faults is None:
            self._faults = [from_dict(Fault, fault) for fault in json.loads(self._native.faults())]
        return self._faults

    @property
    def time(self) -> Array:
        """s, shape ``(n,)``."""
        return self.columns["time_s"]

    @property
    def position(self) -> Array:
        """m (rad), shape ``(n,)``."""
        return self.columns["position_rad" if self.geometry == "rotary" else "position_m"]

    @property
    def force(self) -> Array:
        """N (N·m), shape ``(n,)``."""
        return self.columns["torque_nm" if self.geometry == "rotary" else "force_n"]

    def __len__(self) -> int:
        return len(self._native)

    def __getitem__(self, name: str) -> Array:
        try:
            return self.columns[name]
        except KeyError:
            raise KeyError(f"{self.name}: no column {name}; it has {', '.join(self.columns)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def keys(self) -> Iterable[str]:
        """Names of the columns: ``dict(recording)`` and ``pandas.DataFrame(dict(recording))`` work."""
        return self.columns.keys()

    def to_csv(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes the CSV file of the command; reading it gives equal columns, bit for bit."""
        self._native.write_csv(os.fspath(path))

    def plot(self) -> Figure:
        """Position, velocity if recorded, and force over time; matplotlib."""
        from . import _plot

        return _plot.recording(self)

    def __repr__(self) -> str:
        period = self.sample_period
        apart = "" if period is None else f", {period:g} s apart"
        return f"<tribos.Recording {self.name}: {len(self)} samples{apart}, {' '.join(self.columns)}>"


#: Columns whose values must be numbers.
_NAMES = frozenset(
    "time_s position_m position_rad velocity_m_s velocity_rad_s acceleration_m_s2 acceleration_rad_s2 force_n torque_nm "
    "normal_force_n command_n command_nm reference_m reference_rad temperature_c".split()
)


def recordings(source: Union[Source, Sequence[Source]]) -> List[_tribos.Recording]:
    """One source or several as native recordings."""
    if isinstance(source, Recording):
        return [source._native]
    if isinstance(source, (str, os.PathLike)):
        return _tribos.read([os.fspath(source)], [], None)
    if isinstance(source, Mapping) or hasattr(source, "columns"):
        return [Recording(source)._native]  # type: ignore[arg-type]
    return [native for one in source for native in recordings(one)]
