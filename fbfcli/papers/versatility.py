"""FBF on plants that are not LTI and not SISO (Ramani 2020 Remarks 2.3, 2.6): two axes that disturb each other, more or
fewer inputs than outputs, and a delta-like machine whose modes move with the position.

G lifted plant, y_d desired trajectories (channels interleaved sample by sample), truth = the state recursion itself.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import cont2discrete

from fbfcli.control.bspline import bsplines, normalised_time
from fbfcli.control.fbf import Controller, decoupled, output_space
from fbfcli.control.lifted import StateSpace, metric, varying
from fbfcli.papers.item import Item, Progress, Result, Row, between, close, judged

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAPER = "Ramani 2020"
M, N, DEGREE = 400, 100, 5
DT = 1e-3  # s
STROKE = 40.0  # mm
AGREE = 1e-9  # relative: lifted matrices against the recursion


def trajectory() -> np.ndarray:
    """Forth and half way back, from rest to rest, shape (M + 1,) [mm]."""
    s = np.clip((np.arange(M + 1) - 40) / 120, 0, 1)
    back = np.clip((np.arange(M + 1) - 220) / 100, 0, 1)
    forth, half = (x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3) for x in (s, back))
    return STROKE * (forth - half / 2)


def coupled(inputs: int, outputs: int) -> StateSpace:
    """Masses on springs: every input moves its own mode, every output sees its own mode and a part of the others."""
    frequency = 2 * np.pi * np.array([31.0, 43.0, 57.0])[:inputs]
    A = np.zeros((2 * inputs, 2 * inputs))
    B, C = np.zeros((2 * inputs, inputs)), np.zeros((outputs, 2 * inputs))
    for i, w in enumerate(frequency):
        A[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[0, 1], [-(w**2), -2 * 0.04 * w]]
        B[2 * i + 1, i] = w**2
        C[:, 2 * i] = np.where(np.arange(outputs) == i, 1.0, 0.15)
    return cont2discrete((A, B, C, np.zeros((outputs, inputs))), DT)[:4]


def delta_like(position: np.ndarray) -> list[StateSpace]:
    """One mode that falls from 55 to 35 Hz along the stroke, frozen over each sample at the desired position."""
    systems = []
    for p in position:
        w = 2 * np.pi * (55 - 20 * p / STROKE)
        A = np.array([[0, 1], [-(w**2), -2 * 0.04 * w]])
        systems.append(cont2discrete((A, np.array([[0], [w**2]]), np.array([[1.0, 0]]), np.zeros((1, 1))), DT)[:4])
    return systems


def recursion(systems: list[StateSpace], u: np.ndarray) -> np.ndarray:
    """Outputs of x(k+1) = A_k x(k) + B_k u(k), y(k) = C_k x(k) + D_k u(k), channels interleaved as in u."""
    x, y = np.zeros(len(systems[0][0])), []
    for (A, B, C, D), now in zip(systems, u.reshape(len(systems), -1), strict=True):
        y.append(C @ x + D @ now)
        x = A @ x + B @ now
    return np.concatenate(y)


def _basis(inputs: int) -> np.ndarray:
    """The same splines for every input, interleaved."""
    return np.kron(bsplines(normalised_time(M), N, DEGREE), np.eye(inputs))


def _mimo(seeds: int, progress: Progress) -> Result:
    rows, shown = [], {}
    for k, (inputs, outputs) in enumerate(((2, 2), (3, 2), (2, 3))):
        systems = [coupled(inputs, outputs)] * (M + 1)
        G, Phi = varying(systems), _basis(inputs)
        y_d = np.kron(trajectory(), np.array([1.0, -0.6, 0.3])[:outputs])
        fbf = decoupled(Phi, G @ Phi)
        name = f"{inputs} inputs, {outputs} outputs"
        u = fbf.command(y_d)
        y = recursion(systems, u)
        rows += _proof(name, G, fbf, Phi, u, y, y_d)
        if inputs >= outputs:
            rows.append(between(f"{name}: RMS error of the recursion [um]", None, 1e3 * _rms(y_d - y), 0, 1.0))
            alone = np.kron(np.eye(M + 1), np.eye(inputs, outputs)) @ y_d
            better = _rms(y_d - recursion(systems, alone)) / _rms(y_d - y)
            rows.append(judged(better > 1000, f"{name}: error without compensation over with", None, better, "> 1000"))
        else:
            away = output_space(G) @ (output_space(G).T @ y_d) - y_d
            rows.append(
                between(
                    f"{name}: error over the least that any command leaves", None, _rms(y_d - y) / _rms(away), 1, 1.01
                )
            )
        shown[name] = (y_d - y).reshape(M + 1, outputs)
        progress((k + 1) / 3)
    caption = (
        f"Tracking errors of coupled axes, the plant's own recursion under FBF's command (Eq. 2.10, 2.11, App. A); "
        f"M = {M}, {N + 1} splines of degree {DEGREE} per input. Two inputs cannot follow three outputs."
    )
    return Result(tuple(rows), lambda figure: _draw_channels(figure, shown), caption)


def _proof(
    name: str, G: np.ndarray, fbf: Controller, Phi: np.ndarray, u: np.ndarray, y: np.ndarray, y_d: np.ndarray
) -> list[Row]:
    """Against dense truth: the lifted plant is the recursion, J_e is Prop. 2.1's, the error is its projection."""
    Q = output_space(G @ Phi)
    size = len(G)
    expected = np.sqrt(1 - Q.shape[1] / size)
    apart = np.abs(G @ u - y).max() / np.abs(y).max()
    projected = np.abs(y - fbf.output(y_d)).max() / np.abs(y_d).max()
    return [
        between(f"{name}: lifted plant against the recursion", None, float(apart), 0, AGREE),
        between(f"{name}: output against the projection of y_d", None, float(projected), 0, 1e-6),
        close(f"{name}: J_e", "Eq. 2.21", metric(np.eye(size) - Q @ Q.T), float(expected), 1e-9),
    ]


def _varying(seeds: int, progress: Progress) -> Result:
    y_d = trajectory()
    systems, Phi = delta_like(y_d), _basis(1)
    G = varying(systems)
    fbf = decoupled(Phi, G @ Phi)
    u = fbf.command(y_d)
    y = recursion(systems, u)
    frozen = varying([delta_like(np.array([STROKE / 2]))[0]] * (M + 1))
    u_frozen = decoupled(Phi, frozen @ Phi).command(y_d)
    errors = {
        "LTV model": y_d - y,
        "frozen at mid-stroke": y_d - recursion(systems, u_frozen),
        "no compensation": y_d - recursion(systems, y_d),
    }
    better = _rms(errors["frozen at mid-stroke"]) / _rms(errors["LTV model"])
    rows = [
        *_proof("position-varying", G, fbf, Phi, u, y, y_d),
        between("position-varying: RMS error of the recursion [um]", None, 1e3 * _rms(errors["LTV model"]), 0, 1.0),
        judged(better > 100, "error of a model frozen at mid-stroke over the varying one's", None, better, "> 100"),
    ]
    caption = (
        f"A mode that falls from 55 to 35 Hz along the stroke: tracking error under FBF with the varying model (Eq. "
        f"2.10, lifted LTV), with a model frozen at mid-stroke, and without compensation; M = {M}, n = {N}."
    )
    return Result(tuple(rows), lambda figure: _draw_errors(figure, errors), caption)


def _rms(x: np.ndarray) -> float:
    return float(np.sqrt((x**2).mean()))


def _draw_channels(figure: Figure, shown: dict[str, np.ndarray]) -> None:
    t = DT * np.arange(M + 1)
    for axes, (name, e) in zip(figure.subplots(len(shown), 1, sharex=True), shown.items(), strict=True):
        for i, channel in enumerate(e.T):
            axes.plot(t, 1e3 * channel, label=f"output {i + 1}")
        axes.set(ylabel="error [µm]", title=name)
        axes.legend(fontsize="small", loc="upper left")
    axes.set(xlabel="time [s]")


def _draw_errors(figure: Figure, errors: dict[str, np.ndarray]) -> None:
    axes = figure.subplots()
    for name, e in errors.items():
        axes.semilogy(DT * np.arange(M + 1), np.maximum(1e3 * np.abs(e), 1e-6), label=name)
    axes.set(xlabel="time [s]", ylabel="|error| [µm]", ylim=(1e-6, 1e5))
    axes.legend()


ITEMS = (
    Item(
        "fbf-mimo",
        "Several inputs and outputs, square and not, against dense truth",
        PAPER,
        "Eq. 2.10, 2.21, App. A",
        True,
        _mimo,
    ),
    Item(
        "fbf-ltv",
        "A plant that varies with position, against dense truth",
        PAPER,
        "Eq. 2.10, 2.21, App. A",
        True,
        _varying,
    ),
)
