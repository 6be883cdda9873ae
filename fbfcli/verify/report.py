"""One page on a simulated print that opens in any browser, without a network and for as long as there are browsers.

Everything is inside: the drawing library, the numbers, the words. The page's own rules forbid it to load anything.
"""

from __future__ import annotations

import json
from html import escape
from pkgutil import get_data

from fbfcli import __version__
from fbfcli.verify import palette
from fbfcli.verify.report_data import data
from fbfcli.verify.subject import Card, Sheet, Subject
from fbfcli.verify.traces import Kept

RULES = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"


def html(kept: Kept, subject: Subject) -> str:
    """The whole page, less than 15 MB of it."""
    from plotly.offline import get_plotlyjs

    numbers = json.dumps(data(kept, subject), allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    parts = {
        "RULES": RULES,
        "TITLE": escape(subject.title),
        "STYLE": _style(),
        "LEAD": escape(subject.lead),
        "CARDS": "".join(_card(card) for card in subject.cards),
        "WARNINGS": "".join(f'<p class="warning">{escape(words)}</p>' for words in subject.warnings),
        "FIRST": "".join(_sheet(sheet) for sheet in subject.sheets[:1]),
        "SHEETS": "".join(_sheet(sheet) for sheet in subject.sheets[1:]),
        "THINNED": escape(thinned(kept)),
        "SETTINGS": _settings(subject),
        "DATA": numbers,
        "PLOTLY": get_plotlyjs().replace("</script", "<\\/script"),
        "SCRIPT": _packaged("report.js"),
    }
    page = _packaged("report.html")
    pieces = page.split("@@")  # text and names by turns: what is put in may hold anything
    return "".join(parts[piece] if i % 2 else piece for i, piece in enumerate(pieces))


def thinned(kept: Kept) -> str:
    """What was left out of the pictures, in words."""
    t = kept.thinning
    words = [
        f"Paths are drawn with {t.kept:,} of {t.samples:,} samples: those left out are within "
        f"{1e3 * t.tolerance:.0f} µm of the drawn lines."
    ]
    if t.stride > 1:
        shown = len(kept.layers)
        words.append(f"{shown} of {t.layers} layers are drawn: every {t.stride}th, the same ones of every method.")
    words.append("Corners are drawn with every sample. Tables and curves over time count every sample.")
    return " ".join(words)


def _style() -> str:
    """The page's style, in the colours of its pictures."""
    style = _packaged("report.css")
    for name, colour in (("INK", palette.INK), ("FAINT", palette.FAINT), ("GRID", palette.GRID),
                         ("STRONG", palette.METHODS[1])):  # fmt: skip
        style = style.replace(f"@{name}@", colour)
    return style


def _card(card: Card) -> str:
    return (
        f'<div class="card"><div class="name">{escape(card.name)}</div><div class="value">{escape(card.value)}</div>'
        f'<div class="beside">{escape(card.beside)}</div></div>'
    )


def _sheet(sheet: Sheet) -> str:
    head = "".join(f"<th>{escape(column)}</th>" for column in sheet.columns)
    rows = "".join(
        f'<tr><th scope="row">{escape(row[0])}</th>' + "".join(f"<td>{escape(cell)}</td>" for cell in row[1:]) + "</tr>"
        for row in sheet.rows
    )
    return (
        f'<section class="sheet"><h2>{escape(sheet.title)}</h2><p class="caption">{escape(sheet.caption)}</p>'
        f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div></section>'
    )


def _settings(subject: Subject) -> str:
    pairs = (*subject.settings, ("fbf", __version__))
    return "".join(f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in pairs)


def _packaged(name: str) -> str:
    """A part of the page that lies beside this file."""
    part = get_data(__package__, name)
    assert part is not None, name
    return part.decode()
