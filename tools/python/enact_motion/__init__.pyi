from collections.abc import Callable, Iterable, Sequence
from os import PathLike
from typing import Any, Literal, NamedTuple, NoReturn, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "Estimate",
    "Event",
    "Fit",
    "FitParameter",
    "Impact",
    "Motion",
    "Parameter",
    "Proposal",
    "Residuals",
    "Scene",
    "SceneError",
    "Take",
    "TakeError",
    "TimeMap",
    "fit",
    "join",
    "read",
    "reduce",
]

_Array: TypeAlias = NDArray[np.float64]
_Vector: TypeAlias = tuple[float, float, float]
_Path: TypeAlias = str | PathLike[str]

class _Rotation(Protocol):
    def as_quat(self) -> Any: ...

class SceneError(ValueError):
    message: str
    file: str | None
    line: int
    column: int
    def __init__(self, message: str, file: str | None = None, line: int = 1, column: int = 1) -> None: ...

class TakeError(ValueError):
    message: str
    diagnoses: tuple[str, ...]
    def __init__(self, message: str, diagnoses: Iterable[str] = ()) -> None: ...

class Scene:
    @classmethod
    def from_toml(cls, text: str) -> Scene: ...
    @classmethod
    def from_file(cls, path: _Path) -> Scene: ...
    @classmethod
    def new(
        cls,
        object: _Path,
        *,
        mass_g: float | None = None,
        size_mm: Sequence[float] | None = None,
        material: str | None = None,
        tracker_mm: Sequence[float] | None = None,
        bounces: int = 1,
        stamps: Literal["tempo", "physical"] = "tempo",
        lands: str | None = None,
        unit: Literal["mm", "cm", "m", "in"] | None = None,
        hull: bool = False,
    ) -> Scene: ...
    def __init__(self, core: Any) -> None: ...
    @property
    def toml(self) -> str: ...
    @property
    def file(self) -> str | None: ...
    @property
    def name(self) -> str: ...
    @property
    def bodies(self) -> tuple[str, ...]: ...
    @property
    def tracks(self) -> tuple[str, ...]: ...
    @property
    def events(self) -> tuple[str, ...]: ...
    @property
    def goals(self) -> list[dict[str, Any]]: ...
    def __setattr__(self, name: str, value: object) -> NoReturn: ...
    def __eq__(self, other: object) -> bool: ...
    def __hash__(self) -> int: ...

class Take:
    def __init__(self, scene: Scene) -> None: ...
    def poses(
        self,
        track: str,
        t: ArrayLike,
        position: ArrayLike,
        quaternion: ArrayLike | _Rotation | None = None,
        *,
        order: Literal["wxyz", "xyzw"] | None = None,
    ) -> Take: ...
    def keyframes(
        self,
        body: str,
        t: ArrayLike,
        position: ArrayLike,
        quaternion: ArrayLike | _Rotation,
        *,
        order: Literal["wxyz", "xyzw"] | None,
        within: float = 0,
    ) -> Take: ...
    def mark(self, event: str | None, t: float) -> Take: ...
    def proposals(self, count: int | None = None) -> tuple[Proposal, ...]: ...
    def estimate(
        self,
        *,
        free: Literal["auto"] | None = None,
        deadline: float | None = None,
        diagnose: bool = True,
        told: Callable[[str], object] | None = None,
    ) -> Estimate: ...
    def preview(self) -> Estimate: ...
    def to_bytes(self) -> bytes: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def notes(self) -> tuple[str, ...]: ...

class Impact(NamedTuple):
    contact: str | None
    point: _Vector
    normal: _Vector
    impulse: _Vector
    moment: _Vector
    approach_speed: float
    slip_speed: float
    parting_speed: float
    slip_speed_after: float

class Parameter(NamedTuple):
    value: float
    sd: float | None
    determined: bool
    unit: str
    lower: float
    upper: float
    at_bound: Literal["lower", "upper", "cone"] | None

class Proposal(NamedTuple):
    event: str | None
    t: float
    body: str | None
    score: float | None

class Motion(NamedTuple):
    t: _Array
    position: _Array
    quaternion: _Array
    velocity: _Array
    angular_velocity: _Array

class Residuals(NamedTuple):
    acted: _Array
    t: _Array
    position: _Array
    rotation: _Array

class TimeMap(NamedTuple):
    acted: _Array
    physical: _Array

class _EventFields(NamedTuple):
    name: str
    kind: Literal["start", "collision", "change", "waypoint", "end"]
    time: float
    sd: float | None
    determined: bool
    acted: float
    at_bound: Literal["lower", "upper"] | None
    bodies: tuple[str, ...]
    contact: str | None
    impacts: tuple[Impact, ...]

class Event(_EventFields):
    @property
    def impulse(self) -> _Vector | None: ...
    @property
    def contact_point(self) -> _Vector | None: ...
    @property
    def approach_speed(self) -> float | None: ...

class Estimate:
    def __init__(self) -> None: ...
    def __setattr__(self, name: str, value: object) -> NoReturn: ...
    @property
    def report(self) -> dict[str, Any]: ...
    @property
    def take(self) -> Take: ...
    @property
    def verdict(self) -> Literal["physical", "plausible", "failed"]: ...
    @property
    def reason(self) -> str: ...
    @property
    def fit(self) -> Literal["yes", "unknown", "no"]: ...
    @property
    def against(self) -> tuple[str, ...]: ...
    @property
    def events(self) -> tuple[Event, ...]: ...
    @property
    def parameters(self) -> dict[str, Parameter]: ...
    @property
    def undetermined(self) -> tuple[str, ...]: ...
    @property
    def is_late(self) -> bool: ...
    @property
    def is_warm(self) -> bool: ...
    @property
    def spent(self) -> dict[str, float]: ...
    @property
    def time_map(self) -> dict[str, TimeMap]: ...
    @property
    def numbers(self) -> tuple[str, ...]: ...
    def span(self, body: str | None = None) -> tuple[float, float] | None: ...
    def sample(self, rate: float, body: str | None = None) -> Motion: ...
    def at(self, t: ArrayLike, body: str | None = None) -> Motion: ...
    def simulated(self, body: str | None = None) -> tuple[_Array, _Array, _Array]: ...
    def residuals(self, track: str | None = None) -> Residuals: ...
    def covariance(self, names: Iterable[str] | None = None) -> _Array: ...
    def update(
        self,
        *,
        goals: Iterable[dict[str, Any]],
        sd: bool = True,
        deadline: float | None = None,
        told: Callable[[str], object] | None = None,
        chained: bool = True,
    ) -> Estimate: ...
    def write(self, path: _Path) -> None: ...

def read(source: _Path | bytes | bytearray | memoryview, *, scene: Scene | None = None) -> Take: ...

class FitParameter(NamedTuple):
    value: float
    sd: float | None
    interval: tuple[float, float] | None
    unit: str
    drawn: bool
    spread: float | None
    spread_interval: tuple[float, float] | None
    determined: bool
    at_bound: bool
    in_scene: float

class Fit:
    def __init__(self, texts: tuple[str, str, str]) -> None: ...
    def __setattr__(self, name: str, value: object) -> NoReturn: ...
    @property
    def parameters(self) -> dict[str, FitParameter]: ...
    @property
    def correlations(self) -> _Array: ...
    @property
    def against(self) -> tuple[str, ...]: ...
    @property
    def undetermined(self) -> tuple[str, ...]: ...
    @property
    def held_out(self) -> dict[str, Any] | None: ...
    @property
    def takes(self) -> list[dict[str, Any]]: ...
    @property
    def report(self) -> dict[str, Any]: ...
    @property
    def toml(self) -> str: ...

def fit(
    takes: Iterable[_Path | Take],
    *,
    shared: Iterable[str] = (),
    drawn: Iterable[str] = (),
    hold_out: float | Iterable[_Path] | None = None,
) -> Fit: ...
def reduce(
    take: _Path | Take, *, shared: Iterable[str] = (), drawn: Iterable[str] = (), question: bytes | None = None
) -> bytes | None: ...
def join(blocks: Iterable[bytes]) -> bytes | Fit: ...
