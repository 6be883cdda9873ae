"""One thread unless the user says otherwise: many small matrices are slower with more."""

from __future__ import annotations

import os

import pytest

from fbfcli.cli.main import THREADS, main


@pytest.mark.parametrize(("said", "kept"), [(None, "1"), ("3", "3")])
def test_the_number_of_threads(monkeypatch, said, kept):
    for variable in THREADS:
        if said is None:
            monkeypatch.setenv(variable, "")  # so that it is put back after the test
            monkeypatch.delenv(variable)
        else:
            monkeypatch.setenv(variable, said)
    with pytest.raises(SystemExit):
        main(["--version"])
    assert {os.environ[variable] for variable in THREADS} == {kept}
