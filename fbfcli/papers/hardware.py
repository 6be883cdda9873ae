"""What the papers measured on machines: numbers that no program can recompute, with what stands in for each here."""

from __future__ import annotations

from fbfcli.papers.item import Item, Progress, Result, not_reproducible

MEASURED = (  # quantity, as printed, why, with what to run instead
    (
        "Duan 2015 Sec. 5: time to compute the command, ZPETC and FBF [s]",
        "0.2496, 0.5460",
        "a time on one machine of 2015; benchmarks/ measures this program",
    ),
    (
        "Ramani 2018 Fig. 6, Ramani 2020 Fig. 1.3: RMS roughness of a block, less by [%]",
        77.0,
        "printed blocks; ramani-2018-table-1 simulates the printer's path",
    ),
    (
        "Ramani 2020 Table 1.1: models of the US Capitol",
        "photographs",
        "printed models; ramani-2018-table-1 simulates print time and contour error",
    ),
    (
        "Ramani 2020 Fig. 4.8, Table 4.3: e_RMS/y_d,RMS, robust and CE-Opt basis, robust nominal model",
        "0.5494 ± 0.0284, 0.6160 ± 0.0761",
        "measured on a printer; ramani-2020-table-4.1 compares the same methods on the family that is published",
    ),
    (
        "Ramani 2020 Table H.1, Y axis: e_RMS/y_d,RMS, optimal basis and B-splines",
        "0.05, 0.94",
        "measured on a stage whose model is not in the paper; ramani-2020-app-h simulates one with its features",
    ),
    (
        "Ramani 2020b Fig. 7: thickness error of 72 printed triangles, robust over standard, mean [%]",
        "7, 2, 12",
        "measured with calipers; ramani-2020b-fig-5 simulates the robust filter on a synthetic family",
    ),
)


def _measured(seeds: int, progress: Progress) -> Result:
    return Result(tuple(not_reproducible(what, paper, why) for what, paper, why in MEASURED))


ITEMS = (Item("hardware", "What was measured on machines", "all papers", "no equations", True, _measured),)
