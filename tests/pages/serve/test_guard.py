"""Which requests are answered and which refused: token, host, origin, size, content type."""

from __future__ import annotations

from pathlib import Path

import pytest
from starlette.testclient import TestClient

from tests.pages.serve.conftest import PORT, TOKEN
from ucon.habits import book
from ucon.pages.serve.app import make_app
from ucon.pages.serve.desk import Desk
from ucon.pages.serve.guard import new_token
from ucon.pages.serve.shell import PAGES

HERE = f"http://127.0.0.1:{PORT}"


@pytest.fixture
def bare(tmp_path: Path) -> TestClient:
    return TestClient(make_app(Desk(tmp_path, (tmp_path,), book()), TOKEN, PORT), base_url=HERE)


def test_tokens_differ_and_are_long() -> None:
    found = {new_token() for _ in range(50)}
    assert len(found) == 50
    assert min(map(len, found)) >= 22


@pytest.mark.parametrize("path", ["/", "/play", "/favicon.ico", "/api/runs/list", f"/{TOKEN}x/", f"/x/{TOKEN}/", "//"])
def test_without_the_token_nothing_is_here(bare: TestClient, path: str) -> None:
    answer = bare.get(path)
    assert answer.status_code == 404
    assert "UcON" not in answer.text


@pytest.mark.parametrize("host", ["evil.example", f"evil.example:{PORT}", "127.0.0.1", f"127.0.0.1:{PORT + 1}", ""])
def test_another_name_for_this_machine_is_refused(bare: TestClient, host: str) -> None:
    assert bare.get(f"/{TOKEN}/", headers={"host": host}).status_code == 421


def test_localhost_is_this_machine(bare: TestClient) -> None:
    assert bare.get(f"/{TOKEN}/", headers={"host": f"localhost:{PORT}"}).status_code == 200


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": f"http://127.0.0.1:{PORT + 1}"},
        {"sec-fetch-site": "cross-site"},
        {"sec-fetch-site": "same-site", "sec-fetch-mode": "cors"},
        {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate", "sec-fetch-dest": "iframe"},
    ],
)
def test_another_page_is_refused(bare: TestClient, headers: dict[str, str]) -> None:
    assert bare.get(f"/{TOKEN}/api/homes/names", headers=headers).status_code == 403


def test_a_link_is_followed(bare: TestClient) -> None:
    followed = {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate", "sec-fetch-dest": "document"}
    assert bare.get(f"/{TOKEN}/play", headers=followed).status_code == 200


@pytest.mark.parametrize("page", ["", *PAGES])
def test_pages_allow_no_script_but_their_own(client: TestClient, page: str) -> None:
    answer = client.get(f"/{page}")
    assert answer.status_code == 200
    policy = answer.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert answer.headers["cache-control"] == "no-store"
    assert "<script>" not in answer.text
    assert " style=" not in answer.text
    assert answer.text.count('aria-current="page"') + answer.text.count("aria-current=page") == bool(page)


@pytest.mark.parametrize(
    "name", ["../__init__.py", "..%2f__init__.py", "%2e%2e/serve/app.py", "nothing.js", "theme.css%00", "/etc/passwd"]
)
def test_only_files_of_the_pages_are_given(client: TestClient, name: str) -> None:
    assert client.get(f"/assets/{name}").status_code == 404


def test_scripts_are_given_as_what_they_are(client: TestClient) -> None:
    assert client.get("/assets/page.js").headers["content-type"].startswith("text/javascript")
    assert client.get("/assets/theme.css").headers["content-type"].startswith("text/css")


def test_requests_are_small_and_json(client: TestClient) -> None:
    url, kind = "/api/study/answer", {"content-type": "application/json"}
    assert client.post(url, content=b"x" * 70_000, headers=kind).status_code == 413
    assert client.post(url, data={"a": "b"}).status_code == 415
    assert client.post(url, content=b"{}", headers={"content-type": "text/plain"}).status_code == 415
    for body in (b"", b"[]", b'{"a":NaN}', b'{"a":1,"a":2}', b"[" * 3000, b'{"a":"\xff"}', b"1e999"):
        answer = client.post(url, content=body, headers=kind)
        assert answer.status_code == 400
        assert "\n" not in answer.json()["error"]
    assert client.get(url).status_code == 405


HOSTILE = [
    "",
    "../../etc/passwd",
    "..",
    "/etc/passwd",
    "a/b",
    "a\x00b",
    "x" * 5000,
    "<script>",
    "C:\\x",
    "~",
    "$HOME",
    "é",
]


@pytest.mark.parametrize("value", HOSTILE)
def test_no_name_is_a_path(client: TestClient, tmp_path: Path, value: str) -> None:
    before = sorted(path for path in tmp_path.rglob("*"))
    game = {"level": "none", "episodes": "mini", "n": 1, "picture_px": 128}
    wrong = [
        client.post("/api/play/begin", json={"player": value, **game}),
        client.post("/api/play/begin", json={"player": "ann", **game, "episodes": value}),
        client.post("/api/play/act", json={"game": value, "episode": "x", "step": 0, "action": 0}),
        client.post("/api/study/make", json={"study": value, "n": 4, "seed": 0}),
        client.get("/api/study/items", params={"study": value, "rater": "ann"}),
        client.get("/api/study/sheet", params={"study": "x", "rater": value}),
        client.get("/api/study/key", params={"study": value}),
        client.get("/api/homes/plan", params={"home": value}),
        client.get("/api/habits/household", params={"home": value}),
        client.get("/api/runs/one", params={"run": value}),
        client.get("/report/x" + value.replace("/", "%2f").replace("\x00", "%00")),
    ]
    for answer in wrong:
        assert answer.status_code in (400, 404), answer.request.url
        if answer.status_code == 400:
            assert "\n" not in answer.json()["error"]
    assert sorted(path for path in tmp_path.rglob("*")) == before


@pytest.mark.parametrize("value", [None, True, -1, 7, 1.5, "1x", 10**30, [], {}, "NaN"])
def test_numbers_are_numbers_in_their_range(client: TestClient, value: object) -> None:
    act = {"game": "ann/x", "episode": "e", "step": 0, "action": value}
    assert client.post("/api/play/act", json=act).status_code == 400
    made = {"player": "ann", "level": "none", "episodes": "mini", "picture_px": 128, "n": value}
    if value != 7:
        assert client.post("/api/play/begin", json=made).status_code == 400
    view = {"home": "Rs_int", "x": "1", "y": "1", "yaw": "0", "pitch": "0", "open": ""}
    for name in ("x", "yaw", "pitch"):
        if value not in (-1, 7, 1.5):
            assert client.get("/api/homes/frame", params=view | {name: str(value)}).status_code == 400
    assert client.get("/api/homes/frame", params=view | {"open": str(value)}).status_code == 400
