"""What a report tells besides its pictures: words, tables, and what the curves are held against."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fbfcli.plant.model import BA


@dataclass(frozen=True)
class Sheet:
    """A table; a row has a cell for each column, the first one names it."""

    title: str
    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Card:
    """One figure that is read first: what it is, its value, and what it was or may be."""

    name: str
    value: str
    beside: str


@dataclass(frozen=True)
class Spans:
    """Errors of one method, part by part of the print; k parts.

    rms, largest : ndarray, shape (k,)   distance of the nozzle from the desired path [um]; nan where nothing is drawn
    """

    rms: np.ndarray
    largest: np.ndarray


@dataclass(frozen=True)
class Face:
    """A straight wall of the part, from its beginning.

    name        : where it is, for people
    along, off  : of each method, ndarrays of equal length: place [mm], and how far the nozzle was beside the path [um]
    """

    name: str
    along: dict[str, np.ndarray]
    off: dict[str, np.ndarray]


@dataclass(frozen=True)
class Ceilings:
    """What the machine stands, X and Y; inf where nobody has said."""

    velocity: tuple[float, float] = (np.inf, np.inf)  # [mm/s]
    acceleration: tuple[float, float] = (np.inf, np.inf)  # [mm/s^2]
    segments_per_second: float = np.inf


@dataclass(frozen=True)
class Subject:
    """The rest of a report.

    title, lead : of the page: what is shown, in a sentence
    warnings    : sentences
    cards       : figures that are read first
    sheets      : tables, the first of them beside the cards
    by_layer    : of each method, by number of the layer
    by_feature  : of each method, one for each of `features`
    faces       : walls that are shown as people see them
    features    : names of what is printed: walls, infill, ...
    plants      : (b, a) of X and Y, coefficients of z^-1 at period `dt` [s]; None: the pictures leave them out
    ceilings    : limits
    settings    : names and values
    """

    title: str
    lead: str
    warnings: tuple[str, ...] = ()
    cards: tuple[Card, ...] = ()
    sheets: tuple[Sheet, ...] = ()
    by_layer: dict[str, Spans] | None = None
    by_feature: dict[str, Spans] | None = None
    faces: tuple[Face, ...] = ()
    features: tuple[str, ...] = ()
    plants: tuple[BA, BA] | None = None
    dt: float = 1e-3
    ceilings: Ceilings = Ceilings()
    settings: tuple[tuple[str, str], ...] = ()
