"""Effects beside a law as NumPy functions: what a complete law leaves out.

Each function of this module is an effect of the catalogue that a diagnosis searches. Arguments and answer are those of
:mod:`tribos.laws`. Gains (the parameters that the force is proportional to) are 0 unless given; shape parameters are required.

>>> import tribos
>>> tribos.effects.stribeck([0.02, -0.02], force_p=0.5, force_n=0.4, v_s=0.02, delta=1.0).round(4).tolist()   # N
[0.1839, -0.1472]
>>> "stribeck" in dir(tribos.effects)
True
>>> tribos.effects.stribeck(0.1, force_p=0.5, v_s=-1.0, delta=1.0)
Traceback (most recent call last):
tribos.TribosError: stribeck: v_s = -1: accepted from 0.000001 to 100
"""

from __future__ import annotations

from typing import Any, Callable, List, Tuple

from . import _tribos
from ._motion import Array, ArrayLike, motion_of, shaped
from .laws import document, split


def _effect(id: str, text: str, parameters: List[Tuple[str, str]], gains: int) -> Callable[..., Array]:
    # required first, as Python's signatures have it
    ordered = parameters[gains:] + parameters[:gains]
    required = [name for name, _ in parameters[gains:]]

    def effect(velocity: ArrayLike, **given: Any) -> Array:
        motion, values = split(given)
        missing = [name for name in required if name not in values]
        if missing:
            raise TypeError(f"{id}: missing parameter `{missing[0]}`")
        made, shape = motion_of(velocity, **motion)
        return shaped(_tribos.effect_force(id, {k: float(v) for k, v in values.items()}, made), shape)

    effect.__name__ = effect.__qualname__ = id
    effect.__module__ = __name__
    document(effect, text.strip(), ordered, len(required))
    return effect


__all__: List[str] = []
for (_id, _text, _parameters), _gains in _tribos.effects():
    globals()[_id] = _effect(_id, _text, _parameters, _gains)
    __all__.append(_id)


def __dir__() -> List[str]:
    return __all__


