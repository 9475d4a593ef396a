"""The page Play without a browser: what is shown and what never is, how games continue, and the resulting run."""

from __future__ import annotations

import json
import os
import threading
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient

from tests.pages.serve.conftest import PORT, TOKEN
from ucon.__main__ import main
from ucon.core.errors import ConfigError, DataError
from ucon.evaluation.kept.finished import FinishedRun
from ucon.evaluation.playing.human import HumanAgent
from ucon.habits import book
from ucon.pages.serve.app import make_app
from ucon.pages.serve.desk import Desk
from ucon.pages.serve.play.games import Games, named_homes
from ucon.pages.serve.play.journal import Journal
from ucon.programs.composing import eval_config
from ucon.programs.evaluating import Evaluation
from ucon.task.sets import load_episodes

ANN = {"player": "ann", "level": "retrieval", "episodes": "mini", "n": 2, "picture_px": 128}


def begin(client: TestClient, **options: Any) -> tuple[str, dict[str, Any]]:
    answer = client.post("/api/play/begin", json=ANN | options)
    assert answer.status_code == 200, answer.text
    found = answer.json()
    return found["game"], found["state"]


def act(client: TestClient, game: str, state: dict[str, Any], actions: str) -> dict[str, Any]:
    for digit in actions:
        view = state["view"]
        sent = {"game": game, "episode": view["episode"], "step": view["step"], "action": int(digit)}
        answer = client.post("/api/play/act", json=sent)
        assert answer.status_code == 200, answer.text
        state = answer.json()
    return state


def test_what_is_shown_tells_nothing_of_the_place(client: TestClient) -> None:
    """Only what an agent gets: no home, no world coordinates, no place, no solution."""
    episode = load_episodes("mini")[0]
    game, state = begin(client)
    told = {**state["view"], "picture": "", "map": ""}
    assert set(told) == {
        "picture", "map", "pitch_deg", "things", "effect", "episode", "number", "target", "context", "n_habits", "step",
        "max_steps",
    }  # fmt: skip
    text = json.dumps([told, {k: v for k, v in state.items() if k not in ("view", "run")}])
    assert episode.scene not in text
    assert "breakfast" not in text
    assert all(set(thing) == {"name", "metres", "target", "opened"} for thing in told["things"])
    assert client.get("/api/play/result", params={"game": game, "episode": episode.id}).status_code == 400
    assert (
        client.get("/api/play/result", params={"game": game, "episode": load_episodes("mini")[1].id}).status_code == 400
    )
    habits = client.get("/api/play/habits", params={"game": game}).json()
    env = Evaluation(eval_config("agent=human", "limit=1"), Path("nowhere"))
    assert tuple(habits) == env.given(episode)


def test_effects_are_told(client: TestClient) -> None:
    game, state = begin(client, level="none")
    assert client.get("/api/play/habits", params={"game": game}).json() == []
    said = []
    for digit in "0123335":
        state = act(client, game, state, digit)
        said.append(state["view"]["effect"])
    assert said == [
        "Moved 0.25 m ahead.", "Turned right.", "Turned left.", "Looked up.", "Looked up.", "Cannot look further up.",
        "Nothing to open in view within 1 m.",
    ]  # fmt: skip
    state = act(client, game, state, "44")
    while state["view"]["effect"] != "Blocked: something is in the way.":
        state = act(client, game, state, "0")
    assert state["view"]["step"] < 60


def test_an_action_that_comes_twice_counts_once(client: TestClient) -> None:
    game, state = begin(client)
    sent = {"game": game, "episode": state["view"]["episode"], "step": 0, "action": 1}
    first, again = (client.post("/api/play/act", json=sent).json() for _ in range(2))
    assert first["view"]["step"] == again["view"]["step"] == 1
    assert (first["dropped"], again["dropped"]) == (False, True)  # the page says so
    other = client.post("/api/play/act", json=sent | {"episode": "another", "step": 1}).json()
    assert other["view"]["step"] == 1


def test_a_sharper_picture_shows_the_same(client: TestClient) -> None:
    _, plain = begin(client)
    game, sharp = begin(client, picture_px=384)
    assert game.endswith("-384px")
    assert len(sharp["view"]["picture"]) > 2 * len(plain["view"]["picture"])
    assert [t["name"] for t in sharp["view"]["things"]] == [t["name"] for t in plain["view"]["things"]]


def test_a_run_goes_on_in_another_server_and_is_compared(tmp_path: Path, capsys: Any) -> None:
    """Left within an episode, continued with a new server, finished, and compared with an agent."""
    episodes, out = load_episodes("mini")[:2], tmp_path / "out"

    def server() -> TestClient:
        app = make_app(Desk(out, (tmp_path,), book()), TOKEN, PORT)
        return TestClient(app, base_url=f"http://127.0.0.1:{PORT}/{TOKEN}")

    with server() as client:
        game, state = begin(client)
        act(client, game, state, episodes[0].solution[:7])
    with server() as client:
        assert client.get("/api/play/choices").json()["left"][0]["done"] == 0
        game, state = begin(client)
        assert state["view"]["step"] == 7
        state = act(client, game, state, episodes[0].solution[7:])
        assert state["last"] == episodes[0].id
        assert state["figures"]["success_rate"] == 1
        act(client, game, state, "1")
    with server() as client:
        game, state = begin(client)
        assert (state["done"], state["view"]["number"], state["view"]["step"]) == (1, 2, 1)
        end = client.get("/api/play/result", params={"game": game, "episode": episodes[0].id}).json()
        assert end["success"]
        assert end["path"] == end["shortest"]
        assert end["turn"] == episodes[0].start.heading
        state = act(client, game, state, "6")
        assert state["over"]
        lost = client.get("/api/play/result", params={"game": game, "episode": episodes[1].id}).json()
        assert not lost["success"]
        assert lost["why"].startswith(
            f"You said Found it at step 2, but the {lost['target']} was not in view within reach."
        )
        again, _ = begin(client)
        assert again == f"{game}-2"  # a finished run stays as it is
    folder = out / "play" / "ann" / "mini-retrieval-2"
    run = FinishedRun.read(folder)
    assert run.records is not None
    assert [record.actions for record in run.records] == [episodes[0].solution, "16"]
    other = Evaluation(
        eval_config("agent=random", "limit=2", "workers=0", "pictures=0", "progress=false"), tmp_path / "r"
    )
    other.play()
    assert main(["compare", str(folder), str(tmp_path / "r")]) == 0
    assert "human, retrieval" in capsys.readouterr().out
    assert main(["watch", str(folder), "0", "--actions", "--out", str(tmp_path / "film")]) == 0
    assert list((tmp_path / "film").glob("000_found_*"))
    assert main(["replay", str(folder), "--out", str(tmp_path / "replay"), "--workers", "0"]) == 1
    assert "a person searches on the page Play" in capsys.readouterr().err


def test_nobody_is_asked_outside_the_page() -> None:
    with pytest.raises(ConfigError, match="on the page Play of"):
        HumanAgent("ann").reset([{}])


def test_a_journal_is_read_as_far_as_it_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "run" / "journal.jsonl"
    journal = Journal(path)
    for action in (0, 1, 5):
        journal.add("e", action)
    journal.add("f", 2)
    whole = path.read_bytes()
    assert (Journal(path).of("e"), Journal(path).of("f"), Journal(path).of("g")) == ((0, 1, 5), (2,), ())
    for size in range(len(whole)):
        path.write_bytes(whole[:size])
        read = Journal(path)
        read.add("e", 6)
        assert Journal(path).of("e") == (*read.of("e"),)
        assert read.of("e") == (*(0, 1, 5)[: whole[:size].count(b"\n")], 6)
    path.write_bytes(b'{"episode":"e","step":0,"action":1}\n{"episode":"e","step":5,"action":1}\nx\n')
    assert Journal(path).of("e") == (1,)
    path.write_bytes(b'{"episode":["e"],"step":0,"action":1}\n')
    assert Journal(path).of("e") == ()


def test_a_part_of_a_line_is_taken_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As on a full disk: the action does not count, and later ones are read."""
    path, write = tmp_path / "journal.jsonl", os.write
    journal = Journal(path)
    journal.add("e", 1)
    with monkeypatch.context() as full:
        full.setattr(os, "write", lambda handle, data: write(handle, data[: len(data) // 2]))
        with pytest.raises(DataError, match="no room left"):
            journal.add("e", 2)
    journal.add("e", 3)
    assert Journal(path).of("e") == journal.of("e") == (1, 3)


def test_games_are_had_while_another_is_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And no game is opened any more once all were left."""
    games, begun, may, said = Games(tmp_path), threading.Event(), threading.Event(), []
    name = games.open("ann", "none", "mini", 1, 128)

    def slow(*given: Any, **more: Any) -> Evaluation:
        begun.set()
        assert may.wait(60)
        return Evaluation(*given, **more)

    def open_another() -> None:
        with pytest.raises(ConfigError) as error:
            games.open("bob", "none", "mini", 1, 128)
        said.append(str(error.value))

    monkeypatch.setattr("ucon.pages.serve.play.games.Evaluation", slow)
    opening = threading.Thread(target=open_another, daemon=True)
    opening.start()
    assert begun.wait(60)
    closing = threading.Thread(target=lambda: said.append(games.get(name)) or games.close(), daemon=True)
    closing.start()
    closing.join(30)
    assert not closing.is_alive()
    may.set()
    opening.join(60)
    game, error = said
    assert error == "the server is shutting down; start it again and continue"
    with pytest.raises(ConfigError, match="have left this search"):  # and not "all searches are done"
        game.state()


def test_a_home_of_ones_own_is_played_with_its_habits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("UCON_CACHE", str(tmp_path / "cache"))
    file = tmp_path / "my-home no 1.yaml"
    file.write_text(
        "rooms: {kitchen: [3.5, 4]}\nhabits: [My sister hides her mug in the fridge.]\nrequests: [mug: in the fridge]\n"
    )
    out, homes = tmp_path / "out", named_homes([file, file])

    def server(homes: dict[str, Path]) -> TestClient:
        app = make_app(Desk(out, (tmp_path,), book(), homes), TOKEN, PORT)
        return TestClient(app, base_url=f"http://127.0.0.1:{PORT}/{TOKEN}")

    with server(homes) as client:
        assert client.get("/api/play/choices").json()["sets"][:2] == ["my-home_no_1", "mini"]
        game, state = begin(client, episodes="my-home_no_1", level="gt")
        assert (game, state["n"], state["view"]["target"]) == ("ann/my-home_no_1-gt-1", 1, "mug")
        habits = client.get("/api/play/habits", params={"game": game}).json()
        assert habits == ["My sister hides her mug in the fridge."]
        act(client, game, state, "1")
    with server(homes) as client:
        (left,) = client.get("/api/play/choices").json()["left"]
        assert (left["episodes"], left["level"], left["n"]) == ("my-home_no_1", "gt", 1)
        game, state = begin(client, **{key: left[key] for key in ("episodes", "level", "n")})
        assert state["view"]["step"] == 1
        state = act(client, game, state, "6")
        end = client.get("/api/play/result", params={"game": game, "episode": state["last"]}).json()
        assert end["place"] == "in the fridge in the kitchen"
    with server({}) as client:
        answer = client.post("/api/play/begin", json=ANN | {"episodes": "my-home_no_1"})
        assert answer.status_code == 400
        assert "serve --home FILE.yaml" in answer.json()["error"]
    with pytest.raises(ConfigError, match="another set is called mini"):
        named_homes([tmp_path / "mini.yaml"])
    with pytest.raises(ConfigError, match="expected a home file"):
        named_homes([tmp_path / "home.txt"])
