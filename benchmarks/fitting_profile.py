"""A profile that can print a file: the bundled taz6 where it can, else one derived from it."""

from __future__ import annotations

import re
from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np

from fbfcli.cli.lookup import bundled_files, find_printer
from fbfcli.gcode.interpret import initial_state, interpret
from fbfcli.gcode.scan import scan
from fbfcli.printer import Printer

BASE = "taz6"
WIDE = 500.0  # mm either side of zero
_KLIPPER = re.compile(
    rb"^(?:SET_(?:VELOCITY_LIMIT|PRESSURE_ADVANCE)|EXCLUDE_OBJECT|START_PRINT|; gcode_flavor = klipper)", re.MULTILINE)
_REPRAP = re.compile(rb"^(?:M566 |; gcode_flavor = reprapfirmware|;FLAVOR:RepRap)", re.MULTILINE)


def fitting_profile(text: bytes, folder: Path) -> tuple[str, str]:
    """What -p takes, and what it is for people; a derived profile is written into `folder`."""
    firmware = "klipper" if _KLIPPER.search(text) else "reprapfirmware" if _REPRAP.search(text) else "marlin"
    wide = not _fits(text, find_printer(BASE), firmware)
    if firmware == "marlin" and not wide:
        return BASE, BASE
    profile = bundled_files()[BASE].read_text().replace('firmware = "marlin"', f'firmware = "{firmware}"')
    if firmware == "klipper":
        profile = profile.replace("[limits]", "[limits]\nvelocity = 300.0")
    if wide:
        profile = re.sub(r"travel = .*", f"travel = [{-WIDE}, {WIDE}]", profile)
    file = folder / f"{BASE}_{firmware}{'_wide' if wide else ''}.toml"
    file.write_text(profile)
    return str(file), f"{BASE} as {firmware}" + (", wider travel" if wide else "")


def _fits(text: bytes, printer: Printer, firmware: str) -> bool:
    """Whether every X and Y of the file that is known is within the travel."""
    anywhere = replace(printer, firmware=firmware, max_extrude_cross_section=inf)
    block, _ = interpret(scan(text), initial_state(anywhere), anywhere)
    if not len(block.moves):
        return True
    end = (block.moves.start + block.moves.delta)[:, :2]
    low, high = np.array([axis.travel for axis in printer.axes[:2]]).T
    return bool(((end >= low) & (end <= high)).all())
