"""The server's answers to the pages Runs, Homes, Habits and Study, without a browser."""

from __future__ import annotations

import json
import threading
import time
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from starlette.testclient import TestClient

from tests.pages.serve.conftest import PORT, TOKEN
from ucon.__main__ import main
from ucon.evaluation.datasets.survey import LOOK, read_key
from ucon.evaluation.figures.intervals import rate_interval
from ucon.evaluation.kept.seal import PARTIAL
from ucon.habits import book
from ucon.pages.serve.app import make_app
from ucon.pages.serve.desk import Desk
from ucon.pages.serve.guard import REPORT_POLICY
from ucon.pages.serve.tails import Tails
from ucon.pages.serve.walk import HEIGHT, WIDTH
from ucon.pages.thinning import thinned
from ucon.programs.composing import eval_config
from ucon.programs.evaluating import Evaluation
from ucon.scenes import own
from ucon.sim.cache import load_house
from ucon.sim.house import House
from ucon.task.making.residents import residents

QUICK = ("agent=random", "episodes=mini", "limit=6", "workers=0", "pictures=0", "progress=false")


def asked(client: TestClient, path: str, **words: object) -> Any:
    answer = client.get(f"/api/{path}", params={name: str(value) for name, value in words.items()})
    assert answer.status_code == 200, answer.text
    return answer.json()


def runs(client: TestClient) -> dict[str, dict[str, Any]]:
    return {run["name"]: run for run in asked(client, "runs/list")["runs"]}


def fresh(folder: Path) -> TestClient:
    """A client of a new application, which looks for runs immediately."""
    app = make_app(Desk(folder / "out", (folder,), book()), TOKEN, PORT)
    return TestClient(app, base_url=f"http://127.0.0.1:{PORT}/{TOKEN}")


def test_an_evaluation_is_followed_while_it_runs(tmp_path: Path) -> None:
    """Its partial file is read as it grows; the final figures are those of its summary."""
    run, counts = Evaluation(eval_config(*QUICK), tmp_path / "run"), []

    def on_played(_: Any) -> None:
        with fresh(tmp_path) as client:
            row = runs(client)[f"{tmp_path.name}/run"]
            detail = asked(client, "runs/one", run=row["id"])
        assert (row["kind"], row["finished"], row["total"], row["label"]) == ("eval", False, 6, "random")
        assert detail["curves"][0]["points"][-1][0] == row["done"]
        counts.append(row["done"])

    figures = run.play(on_played)
    assert counts == [1, 2, 3, 4, 5, 6]
    with fresh(tmp_path) as client:
        row = runs(client)[f"{tmp_path.name}/run"]
        detail = asked(client, "runs/one", run=row["id"])
    assert (row["finished"], row["success_rate"], row["success_rate_ci95"]) == (
        True, figures["success_rate"], figures["success_rate_ci95"],
    )  # fmt: skip
    assert len(detail["episodes"]) == 6
    n, share, low, high = detail["curves"][0]["points"][-1]
    assert (n, share) == (6, 100 * figures["success_rate"])
    same = rate_interval([False] * 6)  # Wilson's interval, used if all outcomes are equal
    assert figures["success_rate"] or (low / 100, high / 100) == pytest.approx(same.ci95)


def test_a_partial_file_in_any_state_is_read(tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    run, states = Evaluation(eval_config(*QUICK[:2], "limit=2", *QUICK[3:]), whole), []
    run.play(lambda _: states.append((whole / PARTIAL).read_bytes()))
    folder = tmp_path / "cut"
    folder.mkdir()

    def number(client: TestClient) -> str:
        return str(runs(client)[f"{tmp_path.name}/cut"]["id"])

    with fresh(tmp_path) as client:
        for size in [0, 1, 70, len(states[0]) - 1, len(states[0]), len(states[1]) - 5]:
            (folder / PARTIAL).write_bytes(states[1][:size])
            found = asked(client, "runs/one", run=number(client))
            assert found["done"] == states[1][:size].count(b"\n") - (1 if size > 500 else 0)
        (folder / PARTIAL).write_bytes(b"\x00\xff\n{}\n" * 40)
        assert asked(client, "runs/one", run=number(client))["done"] == 0


def test_a_training_is_read(tmp_path: Path) -> None:
    folder = tmp_path / "t"
    folder.mkdir()
    (folder / "config.yaml").write_text(
        "agent: {_target_: a.PolicyAgent, policy: {_target_: models.vtn.VTN}}\n"
        "learner: {_target_: ucon.learning.X.Learner}\ntraining: {steps: 50}\n"
    )
    lines = [{"step": k, "loss": 5.0 - k / 300} for k in range(1, 1001)]
    lines.insert(500, {"step": 500, "val/score": 0.25, "val/loss": 3.0})
    text = "".join(json.dumps(line) + "\n" for line in lines)
    (folder / "metrics.jsonl").write_text(text + '{"step": 1001, "loss": NaN}\nrubbish\n{"step": 1002, "lo')
    with fresh(tmp_path) as client:
        row = runs(client)[f"{tmp_path.name}/t"]
        detail = asked(client, "runs/one", run=row["id"])
    assert (row["label"], row["done"], row["total"], row["score"]) == ("VTN, Learner", 1000, 50, 0.25)
    assert [curve["name"] for curve in detail["curves"]] == ["loss", "loss (validation)", "score (validation)"]
    assert len(detail["curves"][0]["points"]) <= 400
    assert detail["curves"][0]["points"][-1] == [1000, pytest.approx(5 - 1000 / 300)]


def test_curves_are_thinned_to_their_end() -> None:
    assert thinned([], 3) == []
    assert thinned([1, 2, 3], 3) == [1, 2, 3]
    assert thinned([1, 2, 3, 4], 3) == [2, 4]
    assert thinned(range(1000), 400)[-1] == 999
    assert max(len(thinned(range(n), 7)) for n in range(100)) == 7


def test_all_that_is_recorded_is_shown() -> None:
    with fresh(Path(__file__).parents[3] / "results") as client:
        found = runs(client)
    assert len(found) > 50
    assert not [name for name, run in found.items() if "problem" in run]
    assert (found["results/learned-frontier"]["done"], found["results/trained-equal-zson"]["kind"]) == (1000, "train")
    can = {name: found[f"results/{name}"]["can_report"] for name in ("learned-frontier", "large-belief-gt")}
    assert can == {"learned-frontier": True, "large-belief-gt": False}  # only the first has stored records
    assert not found["results/trained-equal-zson"]["can_report"]


def test_a_training_of_figures_alone_has_no_report() -> None:
    with fresh(Path(__file__).parents[3] / "results") as client:
        number = runs(client)["results/trained-equal-zson"]["id"]
        detail = asked(client, "runs/one", run=number)
        refused = client.post("/api/runs/report", json={"run": number})
    assert (detail["kind"], detail["done"], detail["curves"]) == ("train", 40, [])
    assert refused.status_code == 400
    assert "only the figures" in refused.json()["error"]


def test_folders_that_are_damaged_or_point_elsewhere(tmp_path: Path) -> None:
    top, outside = tmp_path / "top", tmp_path / "outside"
    for folder in (top / "bad", top / "linked", outside):
        folder.mkdir(parents=True)
    (top / "bad" / "summary.json").write_text("{")
    (outside / "metrics.jsonl").write_text('{"step":1,"loss":1.0}\n')
    (outside / "report.html").write_text("secret")
    (top / "link").symlink_to(outside)
    (top / "linked" / "metrics.jsonl").write_text('{"step":1,"loss":1.0}\n')
    (top / "linked" / "report.html").symlink_to(outside / "report.html")
    with fresh(top) as client:
        found = runs(client)
        assert set(found) == {"top/bad", "top/linked"}
        assert "summary.json" in found["top/bad"]["problem"]
        assert client.get("/api/runs/one", params={"run": found["top/bad"]["id"]}).status_code == 400
        assert client.get(f"/report/{found['top/linked']['id']}").status_code == 400


def test_reports_run_in_a_sandbox(tmp_path: Path) -> None:
    (tmp_path / "metrics.jsonl").write_text('{"step":1,"loss":1.0}\n')
    (tmp_path / "report.html").write_text("<script>1</script>")
    with fresh(tmp_path) as client:
        (row,) = runs(client).values()
        answer = client.get(f"/report/{row['id']}")
    assert row["report"]
    assert answer.text == "<script>1</script>"
    assert answer.headers["content-security-policy"] == REPORT_POLICY
    assert "allow-same-origin" not in REPORT_POLICY


def test_only_what_is_new_of_a_file_is_read(tmp_path: Path) -> None:
    path, read = tmp_path / "f", []
    tails = Tails(lambda line: read.append(line) or line)
    path.write_bytes(b"a\nb")
    assert tails.lines(path) == [b"a"]
    path.write_bytes(b"a\nbb\nc\n")
    assert tails.lines(path) == [b"a", b"bb", b"c"]
    assert read == [b"a", b"bb", b"c"]
    path.write_bytes(b"x\n")  # replaced by another file
    assert tails.lines(path) == [b"x"]
    with pytest.raises(FileNotFoundError):
        tails.lines(tmp_path / "g")


def test_homes_are_planned_walked_and_told(client: TestClient) -> None:
    house = load_house("Rs_int")
    plan = asked(client, "homes/plan", home="Rs_int")
    assert len(plan["things"]) == len(plan["middles"]) == len(plan["room_of"]) == house.n_items
    assert np.array_equal(np.array([[c == "1" for c in row] for row in plan["free"]]), house.grid.free)
    i, j = np.argwhere(house.grid.free)[40]
    x, y = house.grid.xy((int(i), int(j)))
    view = {"home": "Rs_int", "x": x, "y": y, "yaw": 0.5, "pitch": -10}

    def frame(**more: Any) -> bytes:
        answer = client.get("/api/homes/frame", params={**view, **more})
        assert answer.headers["content-type"] == "image/jpeg"
        return answer.content

    closed = frame()
    assert frame() == closed
    assert frame(yaw=1.5) != closed
    opened = [k for k in plan["openable"] if frame(open=k) != closed]
    assert frame() == closed  # they are closed again
    assert all(plan["rooms"][plan["room_of"][k]] for k in opened)
    picked = {asked(client, "homes/pick", **view, u=u / 8, v=v / 8)["thing"] for u in range(9) for v in range(9)}
    assert picked - {None}
    for thing in sorted(picked - {None})[:3]:
        card = asked(client, "homes/card", home="Rs_int", thing=thing)
        assert card["category"] == house.spec.items[thing].category
        assert card["openable"] == (thing in plan["openable"])


def test_frames_have_their_size(client: TestClient, tmp_path: Path) -> None:
    answer = client.get("/api/homes/frame", params={"home": "Rs_int", "x": 2, "y": 2, "yaw": 0, "pitch": 0})
    (tmp_path / "f.jpg").write_bytes(answer.content)
    assert Image.open(tmp_path / "f.jpg").size == (WIDTH, HEIGHT)


def test_cards_tell_what_the_book_keeps_there(client: TestClient) -> None:
    house, dataset = load_house("Rs_int"), book()
    number = next(k for k, item in enumerate(house.spec.items) if item.category == "fridge")
    card = asked(client, "homes/card", home="Rs_int", thing=number)
    expected = {
        (place.relation, entry.category)
        for entry in dataset.entries
        for place in entry.placements
        if place.anchor == "fridge"
        and dataset.verdicts.refusal((entry.category, place.relation, "fridge"), "Rs_int") is None
    }
    assert {(relation, name) for relation, names in card["kept"].items() for name in names} == expected
    assert len(expected) > 20


def test_several_walks_at_once_do_not_mix(client: TestClient) -> None:
    homes = ("Rs_int", "Merom_1_int", "Beechwood_0_int")
    view = {"x": 2, "y": 2, "yaw": 0.3, "pitch": 0}
    alone = {home: client.get("/api/homes/frame", params={"home": home, **view}).content for home in homes}
    wrong = []

    def walk(home: str) -> None:
        for _ in range(15):
            shown = client.get("/api/homes/frame", params={"home": home, **view}).content
            wrong.extend([home] * (shown != alone[home]))

    threads = [threading.Thread(target=walk, args=(home,)) for home in homes * 2]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


@pytest.mark.parametrize("home", ["Rs_int~x", "nowhere_int", "procedural:castle:1", "procedural:house:99999999999"])
def test_homes_that_are_none_are_told_in_a_line(client: TestClient, home: str) -> None:
    for path in ("homes/plan", "habits/household"):
        answer = client.get(f"/api/{path}", params={"home": home})
        assert answer.status_code == 400
        assert "\n" not in answer.json()["error"]


def test_households_are_those_of_the_episodes(client: TestClient) -> None:
    people = residents(load_house("Merom_1_int"), book())
    found = asked(client, "habits/household", home="Merom_1_int")
    hosts = [host for one in people for host in one.hosts]
    assert len(found["entries"]) == len(hosts)
    for entry, host in zip(found["entries"], hosts, strict=True):
        assert [text for text, _ in entry["habits"]] == [habit.text for habit in host.entry.habits]
        assert [place["here"] for place in entry["places"]] == [
            k in host.realisable for k in range(len(host.entry.placements))
        ]
        assert all(place["here"] or place["why_not"] for place in entry["places"])
    assert asked(client, "habits/household", home="Merom_1_int", seed=5)["entries"] != found["entries"]


def test_a_study_is_what_the_command_scores(client: TestClient, tmp_path: Path, capsys: Any) -> None:
    made = client.post("/api/study/make", json={"study": "s", "n": 8, "seed": 3}).json()
    assert made == [{"name": "s", "items": 8, "raters": []}]
    assert "already" in client.post("/api/study/make", json={"study": "s", "n": 8, "seed": 3}).json()["error"]
    assert asked(client, "study/figures", study="s") == {"figures": None}
    items = asked(client, "study/items", study="s", rater="ann")
    assert set(items["items"][0]) == {"item", "object", "habit", "place"}  # nothing from the key
    rng = np.random.default_rng(0)
    for rater in ("ann", "bob"):
        for item in range(1, 9):
            sent = {"study": "s", "rater": rater, "item": item, "real": int(rng.integers(1, 6)), "look": None}
            client.post("/api/study/answer", json=sent).raise_for_status()
            look = LOOK[rng.integers(3)] if item != 4 else None  # one item is left out
            answers = client.post("/api/study/answer", json=sent | {"look": look}).json()["answers"]
            assert answers[str(item)] == [sent["real"], look]
    folder = tmp_path / "out" / "studies" / "s"
    sheets = [str(folder / "sheets" / f"{rater}.csv") for rater in ("ann", "bob")]
    assert main(["habits", "survey", "score", str(folder / "key.csv"), *sheets, "--json"]) == 0
    assert asked(client, "study/figures", study="s")["figures"] == json.loads(capsys.readouterr().out)
    sheet = client.get("/api/study/sheet", params={"study": "s", "rater": "ann"})
    assert sheet.content == Path(sheets[0]).read_bytes()
    assert sheet.headers["content-disposition"] == 'attachment; filename="ann.csv"'
    assert read_key(folder / "key.csv").keys() == set(range(1, 9))
    for item in range(1, 9):
        empty = {"study": "s", "rater": "bob", "item": item, "real": None, "look": None}
        client.post("/api/study/answer", json=empty).raise_for_status()
    assert not Path(sheets[1]).exists()


@pytest.mark.parametrize(
    "answer",
    [
        {"real": 6},
        {"real": "4"},
        {"real": True},
        {"real": 2.0},
        {"look": "maybe"},
        {"look": 1},
        {"item": 99},
        {"item": -1},
    ],
)
def test_answers_that_are_none_are_refused(client: TestClient, tmp_path: Path, answer: dict[str, Any]) -> None:
    client.post("/api/study/make", json={"study": "s", "n": 4, "seed": 0})
    sent = {"study": "s", "rater": "ann", "item": 1, "real": 3, "look": "yes"} | answer
    refused = client.post("/api/study/answer", json=sent)
    assert refused.status_code == 400
    assert not (tmp_path / "out" / "studies" / "s" / "sheets").exists()


def test_a_damaged_key_is_told(client: TestClient, tmp_path: Path) -> None:
    client.post("/api/study/make", json={"study": "s", "n": 4, "seed": 0})
    (tmp_path / "out" / "studies" / "s" / "key.csv").write_text("item\n")
    assert asked(client, "study/list") == [{"name": "s", "items": None, "raters": []}]
    answer = client.get("/api/study/items", params={"study": "s", "rater": "ann"})
    assert answer.status_code == 400
    assert "key.csv" in answer.json()["error"]


def test_files_beside_the_sheets_are_left_out(client: TestClient, tmp_path: Path) -> None:
    client.post("/api/study/make", json={"study": "s", "n": 2, "seed": 0})
    sheets = tmp_path / "out" / "studies" / "s" / "sheets"
    for rater in ("ann", "bob"):
        sent = {"study": "s", "rater": rater, "item": 1, "real": 3, "look": "yes"}
        client.post("/api/study/answer", json=sent).raise_for_status()
    (sheets / "ann copy.csv").write_bytes((sheets / "ann.csv").read_bytes())
    for number in range(200):
        (sheets / f"r{number}.csv").write_bytes((sheets / "ann.csv").read_bytes())
    assert len(asked(client, "study/list")[0]["raters"]) == 200
    assert asked(client, "study/figures", study="s")["figures"]["raters"] == 202


def test_a_home_is_built_once(client: TestClient, monkeypatch: pytest.MonkeyPatch) -> None:
    """Simultaneous requests for the same home wait for one build."""
    house, built = load_house("Rs_int"), []

    @lru_cache
    def slow(name: str) -> House:
        built.append(name)
        time.sleep(0.3)
        return house

    monkeypatch.setattr("ucon.pages.serve.house_by_name.load_house", slow)
    threads = [threading.Thread(target=asked, args=(client, "homes/plan"), kwargs={"home": "Rs_int"}) for _ in "123"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert built == ["Rs_int"]


def test_homes_of_ones_own_are_listed_and_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("UCON_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(own, "_KNOWN", {})  # as in a new process
    monkeypatch.chdir(tmp_path)
    assert main(["home", "new", "my_home.yaml"]) == 0
    assert main(["home", "check", "my_home.yaml"]) == 0
    client = fresh(tmp_path)
    name = asked(client, "homes/names")[0]
    assert name.startswith("own:my_flat:")
    assert {room["type"] for room in asked(client, "homes/plan", home=name)["rooms"]} == {"kitchen", "bedroom"}
    for wrong in ("own:../../etc:0123456789ab", "own:my_flat:0123456789ab"):
        assert client.get("/api/homes/plan", params={"home": wrong}).status_code == 400
