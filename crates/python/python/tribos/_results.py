"""Results as types: an attribute for each field of the JSON. A number that the JSON has as ``null`` is None."""

from __future__ import annotations

import html
import json
from dataclasses import dataclass, field, fields, is_dataclass
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Type, TypeVar, Union, get_args, get_origin, get_type_hints

from . import _tribos
from ._model import Model
from ._motion import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

T = TypeVar("T")


@dataclass(frozen=True)
class Estimate:
    """A parameter with its uncertainty."""

    #: Value, in ``unit``; levels are magnitudes.
    value: float
    #: Standard deviation, in ``unit``.
    std: Optional[float]
    #: SI unit.
    unit: str
    #: 95 % confidence interval.
    ci95: List[Optional[float]]
    #: Standard deviation as if every residual were independent of the next.
    std_white: Optional[float] = None


@dataclass(frozen=True)
class Quantity:
    """A number with its standard deviation and unit."""

    value: Optional[float]
    std: Optional[float]
    unit: str


@dataclass(frozen=True)
class Estimated:
    """A number and its standard deviation."""

    value: Optional[float]
    std: Optional[float]


@dataclass(frozen=True)
class NotIdentifiable:
    """A parameter that the recording does not determine."""

    parameter: str
    #: Why.
    because: str
    #: The move that would determine it, a line for the device's console.
    experiment: str


@dataclass(frozen=True)
class Fault:
    """A fault of a recording, which is not physics."""

    kind: str
    #: When, s; None for the whole recording.
    at_s: Optional[float]
    why: str


@dataclass(frozen=True)
class Channel:
    """A channel of a recording: its noise, its quantum, and what is wrong with it."""

    unit: str
    used: bool
    #: Standard deviation of its white noise, in ``unit``.
    noise: Optional[float]
    #: Step it is quantised in, in ``unit``; 0 where it is continuous.
    quantum: Optional[float]
    lag_s: Optional[Estimated] = None
    scale: Optional[Estimated] = None
    zero: Optional[Estimated] = None


@dataclass(frozen=True)
class EncoderWave:
    """A wave on the encoder's reading, taken off, m (rad)."""

    amplitude: Estimated
    wavelength: Estimated


@dataclass(frozen=True)
class Cutoffs:
    """Cut-offs that a recording asks for, Hz: a search and a fit need different ones."""

    search: float
    fit: float


@dataclass(frozen=True)
class Preparation:
    """What was done to a recording before anything was fitted."""

    recording: str
    samples: int
    used: int
    stretches: int
    sample_period_s: Optional[float]
    filter: str
    #: Cut-off of the filter that was used, Hz.
    cutoff_hz: Optional[float]
    channels: Dict[str, Channel]
    faults: List[Fault]
    cutoffs_hz: Optional[Cutoffs] = None
    encoder_wave: Optional[EncoderWave] = None


@dataclass(frozen=True)
class NoiseFloor:
    """Level below which nothing can be told, in ``unit``."""

    rms: Optional[float]
    unit: str
    how: str


@dataclass(frozen=True)
class Baseline:
    """The model that everything is compared with."""

    law: str
    parameters: Dict[str, Quantity]
    rms_heldout: Optional[float]


@dataclass(frozen=True)
class Location:
    """A stretch of a coordinate in which the model goes wrong."""

    coordinate: str
    from_: Optional[float]
    to: Optional[float]
    unit: str
    share_of_mismatch: Optional[float]
    p: Optional[float]


@dataclass(frozen=True)
class LooksLike:
    """A formula within the band of a curve."""

    formula: str
    parameters: Dict[str, Quantity]
    runner_up: Optional[str]
    made_by: str


@dataclass(frozen=True)
class FreeCurve:
    """A curve over one coordinate, or a map over two."""

    times: str
    knots: List[Optional[float]]
    values: List[Optional[float]]
    band: List[Optional[float]]
    unit: str
    memory_s: Optional[float] = None
    period_s: Optional[float] = None
    knots_across: List[Optional[float]] = field(default_factory=list)


@dataclass(frozen=True)
class Missing:
    """Physics that was left out. Errors are in the force unit."""

    effect: str
    says: str
    equation: str
    parameters: Dict[str, Quantity]
    rms_heldout_before: Optional[float]
    rms_heldout_after: Optional[float]
    gain_ci95: List[Optional[float]]
    p: Optional[float]
    indistinguishable_from: List[str]
    experiment: str
    coordinates: Optional[List[str]] = None
    units: Optional[List[str]] = None
    curve: Optional[FreeCurve] = None
    looks_like: Optional[LooksLike] = None
    kin: Optional[List[str]] = None


@dataclass(frozen=True)
class DoesNotCarryOver:
    """An effect that does not predict what it was not fitted on."""

    effect: str
    regime: str
    rms_before: Optional[float]
    rms_after: Optional[float]


@dataclass(frozen=True)
class LeftOut:
    """Error on what was not fitted."""

    on: str
    rms_before: Optional[float]
    rms_after: Optional[float]


@dataclass(frozen=True)
class Blind:
    """An effect that the recordings cannot show, and the move that would."""

    effect: str
    because: str
    experiment: str


@dataclass(frozen=True)
class Rejected:
    """An effect that is not there, with the bound of its force."""

    effect: str
    upper_bound: Optional[float]
    unit: str


@dataclass(frozen=True)
class After:
    """The model with everything that was named."""

    rms_heldout: Optional[float]
    free_run_error: Optional[float]
    explained_share: Optional[float]
    parameters: Dict[str, Quantity]


@dataclass(frozen=True)
class PerRecording:
    """A nuisance of one recording relative to the first."""

    recording: str
    nuisance: str
    value: Optional[float]
    std: Optional[float]
    unit: str


@dataclass(frozen=True)
class Validation:
    """A recording that was only predicted."""

    recording: str
    rms_before: Optional[float]
    rms_after: Optional[float]
    relative_before: Optional[float]
    relative_after: Optional[float]
    refitted: List[str]
    rms_before_refitted: Optional[float]
    rms_after_refitted: Optional[float]
    relative_before_refitted: Optional[float]
    relative_after_refitted: Optional[float]
    nuisances: List[PerRecording]


@dataclass(frozen=True)
class Remainder:
    """What is left, and where."""

    rms: Optional[float]
    located_at: List[Location]


@dataclass(frozen=True)
class Experiment:
    """A move that answers a question. Distances are in noise floors."""

    effect: str
    rival: Optional[str]
    command: str
    move: Dict[str, Any]
    discrimination: Optional[float]
    discrimination_now: Optional[float]
    cosine_now: Optional[float]
    cosine: Optional[float]


@dataclass(frozen=True)
class NextExperiment:
    """The one move that answers most open questions."""

    command: str
    move: Dict[str, Any]
    answers: List[Experiment]


def _page(text: str, height: int) -> str:
    """A whole page inside a notebook, apart from its styles."""
    return (
        f'<iframe srcdoc="{html.escape(text, quote=True)}" sandbox="allow-scripts" '
        f'style="width:100%;height:{height}px;border:1px solid #8884"></iframe>'
    )


class _Result:
    """What both results have."""

    _native: Any

    @property
    def name(self) -> str:
        """Names of the recordings."""
        return self._native.name  # type: ignore[no-any-return]

    def json(self) -> str:
        """The JSON, digit for digit as the command writes it."""
        return self._native.json()  # type: ignore[no-any-return]

    def to_dict(self) -> Dict[str, Any]:
        """The JSON as a dict."""
        return json.loads(self.json())  # type: ignore[no-any-return]

    def html(self) -> str:
        """The report, one self-contained page."""
        return self._native.html()  # type: ignore[no-any-return]

    @property
    def series(self) -> Dict[str, Array]:
        """Series for pictures, shape ``(n,)`` each, SI."""
        return self._native.series()  # type: ignore[no-any-return]

    def _repr_html_(self) -> str:
        return _page(self.html(), 640)


@dataclass(frozen=True, repr=False, eq=False)
class Identification(_Result):
    """A law identified from recordings: ``tribos.identification/1``."""

    schema: str
    law: str
    #: Samples fitted.
    samples: int
    #: ‖e‖/‖F‖ over the samples fitted.
    relative_error: Optional[float]
    parameters: Dict[str, Estimate]
    not_identifiable: List[NotIdentifiable]
    recording_faults: List[Fault]
    preparation: List[Preparation]
    force_unit: str
    #: Root mean square of the residual, in ``force_unit``.
    residual_rms: Optional[float]
    r_squared: Optional[float]
    estimator: str
    preprocess: str
    #: Names of the rows and columns of ``correlation``.
    correlation_of: List[str]
    correlation: List[List[Optional[float]]]
    #: Independent samples that the residual is worth.
    effective_samples: Optional[float]
    _native: Any = None

    @property
    def model(self) -> Model:
        """The model found."""
        return Model(self._native.model())

    def plot(self) -> Figure:
        """Friction over velocity, and force with its prediction over time; matplotlib."""
        from . import _plot

        return _plot.identification(self)

    def __repr__(self) -> str:
        shown = ", ".join(f"{k}={_short(p)}" for k, p in self.parameters.items())
        return f"<tribos.Identification {self.name}: {self.law}, {shown}>"


@dataclass(frozen=True, repr=False, eq=False)
class Diagnosis(_Result):
    """What a simulation leaves out of recordings: ``tribos.diagnosis/2``."""

    schema: str
    #: ``mismatch``, ``no_mismatch`` or ``not_testable``.
    verdict: str
    #: The answer in one sentence.
    summary: str
    recording_faults: List[Fault]
    preparation: List[Preparation]
    noise_floor: NoiseFloor
    baseline: Baseline
    location: List[Location]
    #: What is missing, by the gain on held-out data.
    missing: List[Missing]
    instruments: List[Missing]
    does_not_carry_over: List[DoesNotCarryOver]
    left_out: Optional[LeftOut]
    blind_to: List[Blind]
    rejected: List[Rejected]
    after: After
    remainder: Remainder
    #: Force, rms, above which a typical effect would have been seen.
    detectable: Optional[float]
    #: Share of the samples that were judged: those at which the body slides and the direction is known.
    judged_share: float
    #: Share of the samples that was fitted: of a recording with more than about 100 000, evenly spread parts.
    fitted_share: float
    cutoff_hz: Optional[float]
    nuisances: List[PerRecording]
    validation: List[Validation]
    experiments: List[Experiment]
    next_experiment: Optional[NextExperiment]
    _native: Any = None

    @property
    def model(self) -> Optional[Model]:
        """The model with what was found; None where the recordings cannot be tested."""
        native = self._native.model()
        return None if native is None else Model(native)

    def plot(self) -> Figure:
        """The error over the most telling coordinate, before and after, and over time; matplotlib."""
        from . import _plot

        return _plot.diagnosis(self)

    def __repr__(self) -> str:
        return f"<tribos.Diagnosis {self.name}: {self.verdict}. {self.summary}>"


def _short(p: Estimate) -> str:
    return f"{p.value:.4g} {p.unit}"


def from_dict(kind: Type[T], data: Dict[str, Any], **more: Any) -> T:
    """A typed object of a JSON object. Fields that a newer JSON adds are left to ``to_dict``."""
    hints = get_type_hints(kind)
    given = {}
    for one in fields(kind):  # type: ignore[arg-type]
        key = one.name.rstrip("_")
        if key in data:
            given[one.name] = _value(hints[one.name], data[key])
    return kind(**given, **more)


def _value(hint: Any, value: Any) -> Any:
    if get_origin(hint) is Union:  # Optional
        return None if value is None else _value(get_args(hint)[0], value)
    if is_dataclass(hint) and isinstance(value, dict):
        return from_dict(hint, value)  # type: ignore[arg-type]
    if get_origin(hint) is list:
        return [_value(get_args(hint)[0], item) for item in value]
    if get_origin(hint) is dict and isinstance(value, dict):
        return {key: _value(get_args(hint)[1], item) for key, item in value.items()}
    return value


def identification(native: _tribos.Identification) -> Identification:
    return from_dict(Identification, json.loads(native.json()), _native=native)


def diagnosis(native: _tribos.Diagnosis) -> Diagnosis:
    return from_dict(Diagnosis, json.loads(native.json()), _native=native)
