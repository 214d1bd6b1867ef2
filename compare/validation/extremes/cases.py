"""Cases at and beyond the limits of parameters, and what they amount to."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from importlib.util import find_spec
from typing import Any, Literal, get_args

import numpy as np

from femic.reference.run_options import RunOptions
from femic.scenes.load import in_keys
from geometries.errors import Failure, WrongInput

ANALYTIC, HARMONIC, SOLID = "analytic", "harmonic", "solid"
CONTACT, FRICTION = "contact", "friction"
Part = Literal["analytic", "harmonic", "solid", "contact", "friction"]
PARTS: tuple[Part, ...] = get_args(Part)

Entry = dict[str, Any]  # a limit of a part, or a case, as in extremes.json


def available() -> bool:
    """Whether hypothesis and mpmath are installed, which draw cases and provide many digits."""
    return all(find_spec(name) is not None for name in ("hypothesis", "mpmath"))


@dataclass(frozen=True)
class WithinLimit:
    """A case within the limits, under the label `at`, with its largest error and its largest estimate.

    Errors and estimates are shares [-]; `used` is the largest error over its own estimate, of any component
    on any line. `estimate` and `used` are None without estimates. `exact` says what errors were measured
    against, `note` has further facts, or the reason why the case failed.
    """

    at: str
    error: float
    estimate: float | None
    used: float | None
    exact: str
    seconds: float
    note: str = ""

    @property
    def honest(self) -> bool:
        """Whether every estimate is at least as large as its error."""
        return self.used is None or self.used <= 1


@dataclass(frozen=True)
class BeyondLimit:
    """A case beyond the limits, under the label `at`, with the program's message, or an empty text.

    `computed`: it is computed all the same, and the text has its error. `failed`: it is not refused, but
    fails on the way, and the text says why.
    """

    at: str
    says: str
    computed: bool = False
    failed: bool = False


@dataclass(frozen=True)
class Limit:
    """A parameter of a part with its range, and functions that run cases within and beyond it.

    `engine` is the name of the part: of the analytic ICs, an engine, or contact without or with friction.
    """

    engine: str
    name: str
    range: str
    reached: Sequence[Callable[[RunOptions], WithinLimit]]
    beyond: Sequence[Callable[[RunOptions], BeyondLimit]] = ()


def refusal(
    label: str, call: Callable[[RunOptions], object], also: tuple[type[Failure], ...] = ()
) -> Callable[[RunOptions], BeyondLimit]:
    """Return a case that makes a call beyond the limits; its text is the last line of the error message.

    Input is refused before any work. What shows on the way only is refused by the failures `also`; any other
    failure is one of the case. A plain `Failure` is of the kind that it was raised in place of.
    """

    def case(options: RunOptions) -> BeyondLimit:
        try:
            call(options)
        except WrongInput as error:
            return BeyondLimit(label, str(error).rsplit("\n", maxsplit=1)[-1].strip())
        except Failure as error:
            cause: BaseException | None = error
            while type(cause) is Failure:
                cause = cause.__context__
            text = in_keys(error).rsplit("\n", maxsplit=1)[-1].strip()
            return BeyondLimit(label, text, failed=not isinstance(cause, also))
        return BeyondLimit(label, "")

    return case


def run_limits(limits: Sequence[Limit], options: RunOptions) -> Iterator[Entry]:
    """Run all cases of all limits, report each, and yield the limits with their cases, as JSON has them.

    A case that fails has infinite errors and the program's message.
    """
    for limit in limits:
        reached = []
        for case in limit.reached:
            try:
                result = case(options)
            except Failure as error:
                result = WithinLimit("failed", np.inf, None, np.inf, "", 0.0, in_keys(error))
            estimate_text = "" if result.estimate is None else f", estimate {result.estimate:.1e}"
            text = f"  {limit.engine}: {limit.name}: {result.at}: error {result.error:.1e}{estimate_text}"
            options.watch.on_stage(f"{text}, {result.seconds:.1f} s")
            entry = asdict(result) | {"honest": result.honest}
            for key in ("error", "estimate", "used"):  # JSON has no infinity
                entry[key] = None if entry[key] is None or not np.isfinite(entry[key]) else entry[key]
            reached.append(entry)
        yield {
            "engine": limit.engine,
            "parameter": limit.name,
            "range": limit.range,
            "reached": reached,
            "beyond": [asdict(case(options)) for case in limit.beyond],
        }


def summary(rows: Sequence[Entry]) -> str:
    """Return how many cases there are, how many estimates hold, and how femic answers beyond the limits."""
    within, beyond = ([case for row in rows for case in row[kind]] for kind in ("reached", "beyond"))
    finished = [case for case in within if case["error"] is not None]
    estimated = [case for case in finished if case["used"] is not None]
    held = sum(case["honest"] for case in estimated)
    failed = sum(case["failed"] for case in beyond)
    silent = sum(not (case["says"] or case["failed"]) for case in beyond)
    computed = sum(case["computed"] for case in beyond)
    refused = len(beyond) - failed - silent - computed
    return (
        f"{len(within)} cases within the limits, {len(within) - len(finished)} failed; estimates bound every "
        f"error in {held} of the {len(estimated)} cases that have them. {len(beyond)} cases beyond the "
        f"limits: {refused} refused with a message, {computed} computed all the same, {silent} without a "
        f"message, {failed} failed."
    )
