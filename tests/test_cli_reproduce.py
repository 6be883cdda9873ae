"""`fbf reproduce`: what it lists, writes and says, and how it leaves."""

from __future__ import annotations

import json

import pytest

from fbfcli.cli import reproduce
from fbfcli.cli.main import run
from fbfcli.papers import catalogue
from fbfcli.papers.item import Item, Result, judged, not_reproducible

PNG = b"\x89PNG\r\n"
GOOD = judged(True, "a number", "0.5", 0.5, "exact")
WRONG = judged(False, "another", "2", 3.0, "exact")
ABSENT = not_reproducible("a third", "7", "measured on hardware")


def item(name: str, *rows, figure=None) -> Item:
    return Item(
        name,
        "A title",
        "Paper 2000",
        "Eq. 1",
        name.endswith("1"),
        lambda seeds, progress: Result(rows, figure, "Eq. 1"),
    )


@pytest.fixture(autouse=True)
def three(monkeypatch, tmp_path):
    """Items of no paper, in a folder of their own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(reproduce, "SAMPLE", tmp_path / "no.gcode")
    drawn = item("paper-fig-1", GOOD, ABSENT, figure=lambda figure: figure.subplots().plot([1, 2]))
    monkeypatch.setattr(catalogue, "items", lambda: (drawn, item("paper-table-2", WRONG), item("paper-table-20", GOOD)))


def test_without_a_name_it_lists(capsys):
    assert run(["reproduce"]) == 0
    listed = capsys.readouterr().out
    assert "paper-fig-1" in listed and "quick" in listed and "paper-table-2 " in listed


def test_an_item_is_told_and_drawn(capsys, tmp_path):
    assert run(["reproduce", "paper-fig-1", "-o", "figures"]) == 0
    told = capsys.readouterr()
    assert "holds" in told.out and "not reproducible" in told.out and "measured on hardware" in told.out
    assert (tmp_path / "figures" / "paper-fig-1.png").read_bytes().startswith(PNG)
    assert "1 holds, 0 differs, 1 not reproducible" in told.err


def test_a_number_that_differs_leaves_with_1(capsys):
    assert run(["reproduce", "paper-table-2"]) == 1
    assert "1 number differs" in capsys.readouterr().err


def test_a_whole_name_is_not_the_beginning_of_another(capsys):
    run(["reproduce", "paper-table-2"])
    assert "paper-table-20" not in capsys.readouterr().out


def test_a_beginning_names_several(capsys):
    assert run(["reproduce", "paper", "-q"]) == 1
    told = capsys.readouterr()
    assert told.out.count("A title") == 3 and "holds," not in told.err


def test_quick_ones_alone(capsys):
    assert run(["reproduce", "--quick", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [each["name"] for each in found["items"]] == ["paper-fig-1"]
    assert found["items"][0]["rows"][0]["verdict"] == "holds"


def test_json_of_all_is_whole_where_a_number_differs(tmp_path):
    assert run(["reproduce", "--all", "--json", "all.json"]) == 1
    found = json.loads((tmp_path / "all.json").read_text())
    assert found["differs"] == 1 and len(found["items"]) == 3


def test_markdown_has_every_row(capsys):
    run(["reproduce", "paper-fig-1", "--markdown", "-"])
    page = capsys.readouterr().out
    assert "### `paper-fig-1`" in page and "| a number | 0.5 | 0.5 | exact | holds |" in page


def test_a_typing_error_is_one_clear_line(capsys):
    assert run(["reproduce", "paper-fgi-1"]) == 2
    assert "did you mean 'paper-fig-1'" in capsys.readouterr().err


def test_an_empty_name_is_not_the_beginning_of_all():
    assert run(["reproduce", ""]) == 2


@pytest.mark.parametrize(
    "words", [["x", "--all"], ["--all", "--quick"], ["--all", "--json", "-", "--markdown", "-"], ["--seeds", "0"]]
)
def test_contradictions_are_refused(words):
    assert run(["reproduce", *words]) == 2


def test_a_folder_that_is_a_file_is_said(capsys, tmp_path):
    (tmp_path / "taken").write_text("")
    assert run(["reproduce", "paper-fig-1", "-o", "taken"]) == 1
    assert "taken: is not a folder" in capsys.readouterr().err


def test_a_file_that_cannot_be_written_is_said_before_the_work(capsys):
    assert run(["reproduce", "--all", "--json", "nowhere/all.json"]) == 1
    told = capsys.readouterr()
    assert "there is no folder nowhere" in told.err and "A title" not in told.out
