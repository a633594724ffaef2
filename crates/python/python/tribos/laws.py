"""Friction laws as NumPy functions.

Each function of this module is a law of the crate ``friction``, the same code that runs on the device. It takes the velocity and the
parameters of the law by name, and returns the friction, N, positive against positive motion, of the shape of ``velocity``.

A law has a memory: the samples are one motion in the order of the array, ``dt`` seconds apart, from a fresh contact.

Further arguments, a number or the shape ``(n,)``:

``dt``            time between samples, s; default 0.001
``position``      m (rad); default: the sum of the displacements
``displacement``  distance slid in the step, m (rad); default ``velocity*dt``
``applied``       force on the body other than friction, N, which a body at rest balances; default 0
``mass``          kg; with it a law at rest stops the body; default 0
``normal``        normal load, N; default unknown

>>> import numpy as np, tribos
>>> tribos.laws.classic([0.0005, 0.002, -0.1], stiction=3.5, dynamic=3.0, viscous=0.0, knee=1e-3, fallen=3e-3).tolist()
[1.75, 3.25, -3.0]
>>> tribos.laws.karnopp([0.0], applied=2.0, c_p=1, c_n=1, b_p=0, b_n=0, d_p=1.2, d_n=1.2, delta_v=0.01).tolist()
[1.2]
>>> v = np.full(100, 0.01)
>>> z = tribos.laws.dahl(v, dt=1e-3, limit_p=1.0, limit_n=1.0, sigma=1e5, exponent=1.0, viscous=0.0)
>>> z.shape, round(float(z[-1]), 6)
((100,), 1.0)
>>> tribos.laws.coulomb(v, level_p=1.0)
Traceback (most recent call last):
tribos.TribosError: coulomb: missing field `level_n`
"""

from __future__ import annotations

import inspect
import json
from typing import Any, Callable, Dict, List, Tuple

import numpy as np

from . import _tribos
from ._motion import Array, ArrayLike, motion_of, shaped

#: Arguments of every law that describe the motion.
MOTION = [p for p in inspect.signature(motion_of).parameters.values() if p.name != "velocity"]


def markdown(text: str) -> str:
    """Documentation for Python: without the Rust example and the links."""
    lines = [line[1:] if line.startswith(" ") else line for line in text.splitlines()]
    out: List[str] = []
    fence = None
    for line in lines:
        if line.startswith("```"):
            fence = None if fence is not None else line[3:]
            continue
        if fence is None:
            out.append(line.replace("[`", "``").replace("`]", "``"))
        elif fence == "text":
            out.append("    " + line)
    return "\n".join(out).strip()


def document(function: Callable[..., Array], text: str, parameters: List[Tuple[str, str]], required: int) -> None:
    """Gives a function its signature and its documentation."""
    keyword = inspect.Parameter.KEYWORD_ONLY
    signature = [inspect.Parameter("velocity", inspect.Parameter.POSITIONAL_OR_KEYWORD)]
    signature += [
        inspect.Parameter(name, keyword, default=inspect.Parameter.empty if i < required else 0.0)
        for i, (name, _) in enumerate(parameters)
    ]
    signature += MOTION
    function.__signature__ = inspect.Signature(signature)  # type: ignore[attr-defined]
    listed = "\n".join(f"    {name}: {what}" for name, what in parameters)
    function.__doc__ = (
        f"{text}\n\nParameters:\n    velocity: m/s (rad/s), a number or the shape (n,)\n{listed}\n"
        "    and the motion, see ``tribos.laws``\n\nReturns the friction, N (N·m), of the shape of ``velocity``."
    )


def split(given: Dict[str, Any]) -> Tuple[Dict[str, Any], Dict[str, Any]]:
    """Arguments of the motion, and parameters."""
    names = [p.name for p in MOTION]
    motion = {name: value for name, value in given.items() if name in names}
    return motion, {name: value for name, value in given.items() if name not in names}


def _finite(value: Any) -> Any:
    if isinstance(value, str):
        return value
    array = np.asarray(value, dtype=np.float64)
    if not np.all(np.isfinite(array)):
        raise _tribos.TribosError(f"{value}: a finite number is accepted")
    return array.tolist()


def _law(id: str, text: str, parameters: List[Tuple[str, str]]) -> Callable[..., Array]:
    def law(velocity: ArrayLike, **given: Any) -> Array:
        motion, values = split(given)
        unknown = [name for name in values if name not in dict(parameters)]
        if unknown:
            accepted = ", ".join(name for name, _ in parameters)
            raise TypeError(f"{id}: no parameter `{unknown[0]}`: accepted are {accepted}")
        made, shape = motion_of(velocity, **motion)
        text = json.dumps({name: _finite(value) for name, value in values.items()})
        return shaped(_tribos.law_force(id, text, made), shape)

    law.__name__ = law.__qualname__ = id
    law.__module__ = __name__
    document(law, markdown(text), parameters, len(parameters))
    return law


__all__: List[str] = []
for _id, _text, _parameters in _tribos.laws():
    globals()[_id] = _law(_id, _text, _parameters)
    __all__.append(_id)


def __dir__() -> List[str]:
    return __all__
