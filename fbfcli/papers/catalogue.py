"""Every item that rests on the papers' equations alone, in the order of the papers; modules are imported on demand."""

from __future__ import annotations

from importlib import import_module

from fbfcli.papers.item import Item

MODULES = (  # in fbfcli.papers, in the order of the papers; each has ITEMS, a tuple of Item
    "duan_2015",
    "duan_2015_points",
    "ramani_2018",
    "ramani_2020_ch2",
    "ramani_2020_ch3",
    "versatility",
    "ramani_2020_stages",
    "ramani_2020_ch4",
    "ramani_2020_tables_4",
    "ramani_2020b",
    "ramani_2020b_printer",
    "hardware",
)


def items() -> tuple[Item, ...]:
    """All of them."""
    return tuple(item for name in MODULES for item in import_module(f"fbfcli.papers.{name}").ITEMS)
