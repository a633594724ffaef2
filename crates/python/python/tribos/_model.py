"""Models: a mass, a friction law, effects, and the errors of the sensors."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Dict, Union

from . import _tribos
from ._motion import Array, ArrayLike, motion_of, shaped

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Model:
    """A sliding body, as identified or diagnosed: ``model.toml``, which is a preset of the device.

    >>> import tribos
    >>> rubber = tribos.Model.from_toml('law = "coulomb"\\nmass = 0.4\\nf_dynamic = 3.0\\ndamping = 8.0')
    >>> rubber.law, rubber.mass, rubber.parameters["f_dynamic_p"]
    ('coulomb', 0.4, 3.0)
    >>> rubber.friction([0.1, -0.1]).tolist()                            # N
    [3.8, -3.8]
    >>> tribos.Model.from_toml('law = "coulomb"\\nmass = -1\\nf_dynamic = 3.0')
    Traceback (most recent call last):
    tribos.ModelError: model.toml:2:1: mass = -1: accepted from 0 to 1000000
    """

    def __init__(self, native: _tribos.Model) -> None:
        self._native = native

    @classmethod
    def read(cls, path: Union[str, os.PathLike[str]]) -> Model:
        """Reads ``model.toml``. Raises :class:`ModelError` with file, line and column."""
        return cls(_tribos.Model.read(os.fspath(path)))

    @classmethod
    def from_toml(cls, text: str) -> Model:
        """The model of the text of a ``model.toml``."""
        return cls(_tribos.Model.from_toml(text, "model.toml"))

    def to_toml(self) -> str:
        """The text of ``model.toml``."""
        return self._native.to_toml()

    def write(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes ``model.toml``, completely or not at all."""
        self._native.write(os.fspath(path))

    @property
    def name(self) -> str:
        """Name, as a preset is called."""
        return self._native.name

    @property
    def geometry(self) -> str:
        """``linear`` or ``rotary``."""
        return self._native.geometry

    @property
    def law(self) -> str:
        """Id of the friction law."""
        return self._native.law

    @property
    def mass(self) -> float:
        """Moving mass, kg, or inertia, kg·m²."""
        return self._native.mass

    @property
    def parameters(self) -> Dict[str, float]:
        """Numbers of the preset by name; those of an effect are ``EFFECT.PARAMETER``."""
        return {name: float(value) for name, value in self._native.preset if name not in ("law", "renderer")}

    @property
    def std(self) -> Dict[str, float]:
        """Standard deviations of parameters, by name."""
        return self._native.std

    def friction(self, velocity: ArrayLike, **motion: Any) -> Array:
        """Friction of law, effects and curves along a motion, N (N·m), of the shape of ``velocity``.

        ``motion`` as for :mod:`tribos.laws`. Positive against positive motion.
        """
        made, shape = motion_of(velocity, **motion)
        return shaped(self._native.friction(made), shape)

    def plot(self, fastest: float = 0.1) -> Figure:
        """Steady friction over velocity up to ``fastest`` m/s (rad/s); matplotlib."""
        from . import _plot

        return _plot.model(self, fastest)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Model) and self.to_toml() == other.to_toml()

    def __hash__(self) -> int:
        return hash(self.to_toml())

    def __reduce__(self) -> Any:
        return (Model.from_toml, (self.to_toml(),))

    def __repr__(self) -> str:
        unit = "kg·m²" if self.geometry == "rotary" else "kg"
        return f"<tribos.Model {self.name or 'unnamed'}: {self.law}, {self.mass:.4g} {unit}>"
