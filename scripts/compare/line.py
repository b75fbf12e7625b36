"""A measurement, and a line of the table."""

from dataclasses import dataclass, field


class NotRun(Exception):
    """Why a measurement was not made."""


@dataclass
class Measurement:
    """A program that prints its result; `cores` if not the default core."""

    name: str
    command: list
    cores: str | None = None


@dataclass
class Line:
    """A ratio of gemtrace to a peer; `better` is the better direction."""

    what: str
    must: float | None
    aim: float | None
    caveat: str
    better: str = "more"
    ratios: list = field(default_factory=list)  # one a round
    not_run: str | None = None
