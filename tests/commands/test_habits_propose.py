"""``habits propose`` from the command line, against a real server."""

import copy
import json

import pytest

from tests.generation.test_propose import GOOD
from tests.language.chat_server import chat_server, fails, says
from ucon.__main__ import main


@pytest.fixture
def propose(tmp_path, monkeypatch):
    monkeypatch.setenv("UCON_CACHE", str(tmp_path / "cache"))
    out = tmp_path / "new.txt"

    def run(url, *words):
        return main(["habits", "propose", *words, "--out", str(out), "--server", url, "--model", "tiny"]), out

    return run


def test_entries_are_written(propose, capsys):
    with chat_server(says(GOOD)) as server:
        code, out = propose(server.url, "wallet=1", "--json")
    said = json.loads(capsys.readouterr().out)
    assert (code, said["entries"], said["new"], said["usage"]["attempts"]) == (0, 1, 1, 1)
    assert out.read_text().startswith("# wallet | two lighthouse keepers")


def test_what_is_left_out_is_said(propose, capsys):
    wrong = copy.deepcopy(GOOD) | {"placements": []}
    with chat_server(says(wrong)) as server:
        code, out = propose(server.url, "wallet", "--rounds", "1")
    assert (code, out.exists()) == (1, False)
    assert "left out: wallet: " in capsys.readouterr().out


def test_errors_are_one_line(propose, capsys):
    with chat_server(fails(401, "who are you?")) as server:
        assert propose(server.url, "wallet")[0] == 2
    assert propose("nowhere", "wallet")[0] == 2
    assert propose("http://127.0.0.1:9/v1", "wallet=many")[0] == 2
    assert propose("http://127.0.0.1:9/v1", "walet")[0] == 2
    assert propose("http://127.0.0.1:9/v1", "wallet=" + "9" * 5000)[0] == 2
    lines = capsys.readouterr().err.strip().split("\n")
    errors = [line for line in lines if line.startswith("error: ")]
    assert len(errors) == 5
    assert "is not a number up to 999999" in errors[4]
    assert len(errors[4]) < 300
    assert "who are you?" in errors[0]
