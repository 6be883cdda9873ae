"""Laws of kept lines between segments: each once, in order, near its time."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from reading_cases import block_of

from fbfcli.gcode.dialects import Kind
from fbfcli.gcode.listing import listing
from fbfcli.gcode.placement import Places, after, forced, place, segment_of
from fbfcli.motion.moves import E, Moves
from fbfcli.motion.profile import Profile
from fbfcli.motion.stretches import Grid, Rests, lay
from fbfcli.motion.timing import executed

DT = 1e-3
RESTS = Rests(3, 4, 0)
PIECES = (
    "G1 X{x} Y{y} E1 F3000",
    "G1 X{x} Y{y}",
    "G1 E{x}",
    "G1 Z{z}",
    "M106 S{z}",
    "; note {z}",
    "G92 E0",
    "M204 S{x}",
    "G4 P{x}",
    "G1 F600",
    "M82",
)


@st.composite
def texts(draw: st.DrawFn) -> str:
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    chosen = rng.choice(PIECES, draw(st.integers(1, 30)))
    return "M83\nG1 X5 Y5 F3000\n" + "".join(
        str(piece).format(x=rng.integers(6, 90), y=rng.integers(6, 90), z=rng.integers(1, 9)) + "\n" for piece in chosen
    )


def placed(
    text: str, continued: bool = False, open_last: bool = False
) -> tuple[Places, Moves, np.ndarray, Grid, Profile]:
    """Places of a text whose moves of X and Y are compensated, except the first."""
    block = block_of(text)
    moves = block.moves
    inside = (moves.delta[:, :2] != 0.0).any(axis=1)
    inside[0] = False
    stop = moves.stop | (np.diff(inside, prepend=False) != 0)
    moves = Moves(moves.start, moves.delta, moves.speed, stop, moves.state, moves.line, moves.limits)
    profile = executed(moves, "marlin")
    first = bool(continued and len(inside) > 1 and inside.any())
    opened = bool(open_last and inside[-1])
    grid = lay(moves, inside, profile.duration, DT, RESTS, 0.25 if first else None, opened)
    found = place(listing(block), moves, inside, grid, np.where(inside, 0.0, profile.duration), 0.0)
    return found, moves, inside, grid, profile


@given(texts(), st.booleans())
def test_every_line_is_kept_once_and_in_order_unless_segments_stand_for_it(text, open_last):
    places, moves, inside, _, _ = placed(text, open_last=open_last)
    gone = set(moves.line[inside].tolist())
    number = places.lines.number
    assert (np.diff(number) > 0).all() and (np.diff(places.sample) >= 0).all()
    lines = text.splitlines()
    for missing in set(range(len(lines))) - set(number.tolist()):
        still = not (set(moves.line.tolist()) & {missing})
        assert missing in gone or (still and lines[missing].startswith("G1")), "only motion is left out"
    assert not gone & set(number.tolist())


@given(texts())
def test_a_place_is_the_time_of_the_next_move(text):
    places, moves, inside, grid, _ = placed(text)
    start = dict(zip(grid.move.tolist(), grid.t0.tolist(), strict=True))
    begins = set(grid.move[grid.first[:-1]].tolist())
    for line, sample in zip(places.lines.number, places.sample, strict=True):
        following = int(np.searchsorted(moves.line, line, side="right"))
        if sample == np.floor(sample):
            assert inside[following] and following not in begins and abs(sample - start[following]) <= 0.5
        else:
            before = np.searchsorted(grid.move, following)
            assert following in begins or following == len(moves) or not inside[following]
            last = grid.end[grid.stretch[before - 1]] if before else -1
            assert sample == last + 0.5


@given(texts())
def test_time_and_e_before_each_line_are_those_of_the_moves_before_it(text):
    places, moves, inside, _, profile = placed(text)
    idle = np.where(inside, 0.0, profile.duration)
    wait = np.zeros(text.count("\n"))
    wait[places.lines.number] = places.lines.wait
    for i, line in enumerate(places.lines.number.tolist()):
        earlier = moves.line < line
        np.testing.assert_allclose(places.passed[i], idle[earlier].sum() + wait[:line].sum(), atol=1e-12)
        until = moves.line <= line
        e = (moves.start + moves.delta)[until][-1, E] if until.any() else 0.0
        np.testing.assert_allclose(places.e_machine[i], e, atol=1e-12)


@given(texts())
def test_moves_that_stay_are_marked(text):
    places, moves, inside, _, _ = placed(text)
    np.testing.assert_array_equal(places.lines.number[places.moves], np.unique(moves.line[~inside]))


@given(texts(), st.integers(0, 30))
def test_places_cut_and_joined_are_the_places(text, cut):
    places, *_ = placed(text)
    again = after(places[:cut], places[cut:]) if cut < len(places) else after(None, places)
    np.testing.assert_array_equal(again.sample, places.sample)
    assert [again.lines.raw(i) for i in range(len(again))] == [places.lines.raw(i) for i in range(len(places))]


@given(texts())
def test_lines_that_act_at_their_time_force_a_node_there(text):
    places, _, _, grid, _ = placed(text)
    found = forced(places, 0, grid.count - 1)
    timely = np.isin(places.lines.kind, (Kind.IN_ORDER, Kind.MODE)) & (places.sample == np.floor(places.sample))
    wanted = np.unique(places.sample[timely])
    np.testing.assert_array_equal(found, wanted[(wanted > 0) & (wanted < grid.count - 1)])


nodes_and_samples = st.tuples(
    st.lists(st.integers(0, 200), min_size=2, max_size=20, unique=True).map(sorted),
    st.lists(st.one_of(st.integers(0, 200).map(float), st.integers(-1, 200).map(lambda k: k + 0.5)), max_size=20).map(
        sorted
    ),
)


@given(nodes_and_samples)
def test_a_line_is_written_at_the_nearest_node_and_after_all_before_a_rest(case):
    nodes, sample = np.array(case[0]), np.array(case[1])
    expected, so_far = [], 0
    for k in sample:
        at_time = int(np.argmin(np.abs(nodes - k)))  # the earlier of two
        in_rest = min(int(np.count_nonzero(nodes < k)), len(nodes) - 1)
        so_far = max(so_far, at_time if k == np.floor(k) else in_rest)
        expected.append(so_far)
    np.testing.assert_array_equal(segment_of(sample, nodes), expected)
