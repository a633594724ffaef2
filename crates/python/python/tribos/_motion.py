"""The motion along which friction is computed."""

from __future__ import annotations

from typing import Any, Dict, Optional, Tuple, Union

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
ArrayLike = Union[npt.ArrayLike, float]


def motion_of(
    velocity: ArrayLike,
    *,
    dt: float = 1e-3,
    position: Optional[ArrayLike] = None,
    displacement: Optional[ArrayLike] = None,
    applied: ArrayLike = 0.0,
    normal: Optional[ArrayLike] = None,
    mass: float = 0.0,
) -> Tuple[Dict[str, Any], Tuple[int, ...]]:
    """A motion of equal columns, and the shape of the answer."""
    given = np.asarray(velocity, dtype=np.float64)
    shape = given.shape
    if given.ndim > 1:
        raise ValueError(f"velocity has the shape {shape}; a number or the shape (n,) is accepted: friction has a memory")
    v = np.atleast_1d(given)

    def column(values: ArrayLike) -> Array:
        return np.ascontiguousarray(np.broadcast_to(np.asarray(values, dtype=np.float64), v.shape))

    slid = v * dt if displacement is None else column(displacement)
    made: Dict[str, Any] = {
        "dt": float(dt),
        "mass": float(mass),
        "velocity": np.ascontiguousarray(v),
        "displacement": slid,
        "position": np.cumsum(slid) if position is None else column(position),
        "applied": column(applied),
    }
    if normal is not None:
        made["normal"] = column(normal)
    return made, shape


def shaped(force: Array, shape: Tuple[int, ...]) -> Array:
    """A number for a number, an array for an array."""
    return force if shape else force[0]
