"""The chat model against a real server that misbehaves: every question ends in time, with a valid option or none."""

import base64
import io
import json
import socket
import time

import numpy as np
import pytest
from PIL import Image

from tests.language.chat_server import breaks_off, chat_server, closes, dribbles, fails, hangs, says, sends
from tests.language.tiny_models import HABITS, INJECTED, NAMES, picture, question
from ucon.core.errors import ConfigError, ServerError
from ucon.language.models.chat_api import ChatModel
from ucon.language.servers.answer_cache import AnswerCache
from ucon.language.servers.chat import ChatClient

TIMEOUT_S = 0.15
#: Seconds that threads and the loopback interface may add to the wall time.
SLACK_S = 0.25
GOOD = says({"reason": "coins", "choice": "desk"})


@pytest.fixture
def model(tmp_path):
    def make(url, retries=3, parallel=4, **options):
        options = {"timeout_s": TIMEOUT_S, "backoff_s": 0.01, "cache": AnswerCache(tmp_path)} | options
        return ChatModel(ChatClient(url, "tiny", **options), retries=retries, parallel=parallel)

    return make


def dribbles_headers(handler):
    """Sends its headers a byte at a time: no single read waits for long, but the headers never end."""
    for byte in b"HTTP/1.0 200 OK\r\nX: " + b"x" * 200:
        handler.wfile.write(bytes([byte]))
        handler.wfile.flush()
        time.sleep(0.02)


SERVER = {
    "hanging": hangs(0.8),
    "internal error": fails(500),
    "bad gateway": sends(b"<html>502</html>", 502),
    "overloaded": fails(429),
    "overloaded for an hour": fails(429, Retry_After="3600"),
    "dropped": closes,
    "broken off": breaks_off,
    "dribbling": dribbles,
    "dribbling headers": dribbles_headers,
    "not found": fails(404),
    "bad request": fails(400, "context too long"),
    "moved": fails(301, Location="http://127.0.0.1:9/elsewhere"),
    "moved nowhere": fails(302, Location="http://["),
}
UNUSABLE = {
    "HTML": sends(b"<html>hello</html>"),
    "nothing": sends(b""),
    "not UTF-8": sends(b"\xff\xfe"),
    "no choices": sends(b'{"choices": []}'),
    "no message": sends(b'{"choices": [{}]}'),
    "a list": sends(b"[1]"),
    "deeply nested": sends(b"[" * 100_000),
    "empty": says(""),
    "null": says(None),
    "truncated JSON": says('{"reason": "coins", "choice": "de', "length"),
    "outside the set": says({"reason": "", "choice": "bathroom"}),
    "two options": says({"reason": "", "choice": "desk or sofa"}),
    "prose about two": says("The desk, or maybe the sofa."),
    "a number": says({"choice": 7}),
    "a list of options": says({"choice": ["desk"]}),
    "true": says({"choice": True}),
    "a megabyte": says("desk " * 200_000),
    "a megabyte of JSON": says({"choice": "desk " * 200_000}),
}


@pytest.mark.parametrize("fault", [*SERVER, *UNUSABLE])
def test_a_fault_that_stays_ends_in_time_without_a_choice(model, fault):
    with chat_server((SERVER | UNUSABLE)[fault]) as server:
        start = time.monotonic()
        (answer,) = model(server.url, retries=2).answer([question()])
        took = time.monotonic() - start
        asked = len(server.asked)
    assert took < 3 * TIMEOUT_S + SLACK_S
    assert (answer.choice, answer.scores, answer.text) == (-1, (), "")
    assert answer.failure == ("server" if fault in SERVER else "unusable")
    assert answer.retries <= 3
    assert 1 <= asked <= 4  # one more if a refusal may be about the schema
    assert answer.seconds == pytest.approx(took, abs=0.1)


@pytest.mark.parametrize(
    "fault", sorted((SERVER | UNUSABLE).keys() - {"not found", "bad request", "moved", "moved nowhere"})
)
def test_a_fault_that_passes_costs_a_retry(model, fault):
    with chat_server((SERVER | UNUSABLE)[fault], GOOD) as server:
        (answer,) = model(server.url, max_wait_s=0.02).answer([question()])
        seeds = [asked["seed"] for asked in server.asked]
    assert (NAMES[answer.choice], answer.retries, answer.failure) == ("desk", 1, "")
    assert (seeds[0] != seeds[1]) == (fault in UNUSABLE)
    assert answer.prompt_tokens >= 100


def test_a_good_answer(model):
    with chat_server(GOOD) as server:
        asker = model(server.url)
        (answer,) = asker.answer([question()])
        (again,) = asker.answer([question()])
        request = server.asked[0]
        assert len(server.asked) == 1
    assert (answer.choice, answer.scores, answer.retries) == (2, (), 0)
    assert json.loads(answer.text) == {"reason": "coins", "choice": "desk"}
    assert (answer.prompt_tokens, answer.completion_tokens) == (100, 20)
    assert 0 < answer.seconds < 1
    assert (again.choice, again.text, again.retries) == (2, answer.text, 0)
    schema = request["response_format"]["json_schema"]["schema"]
    assert schema["properties"]["choice"]["enum"] == list(NAMES)
    assert request["messages"][0] == {"role": "system", "content": question().system}
    assert all(f'"{name}"' in request["messages"][1]["content"] for name in NAMES)
    assert (asker.name, asker.gives_scores) == ("chat (tiny)", False)


def test_an_unusable_answer_is_not_kept(model):
    with chat_server(says({"choice": "bathroom"})) as server:
        assert model(server.url, retries=0).answer([question()])[0].choice == -1
    with chat_server(GOOD) as server:
        assert model(server.url, retries=0).answer([question()])[0].choice == 2


def test_a_server_without_schemas_is_asked_in_words(model):
    def plain_only(handler):
        if "response_format" in handler.server.asked[-1]:
            fails(400, "response_format is not supported")(handler)
        else:
            says("I would look on the desk.")(handler)

    with chat_server(plain_only) as server:
        (answer,) = model(server.url, retries=0).answer([question(images=[picture()])])
        assert server.asked[1]["messages"][1]["content"][-1]["text"].startswith("Answer with one JSON object")
    assert (answer.choice, answer.text) == (2, "I would look on the desk.")


def test_images_are_sent_as_they_are(model):
    images = [picture(0), picture(1, 9, 7)]
    with chat_server(GOOD) as server:
        model(server.url).answer([question(images=images)])
        parts = server.asked[0]["messages"][1]["content"]
    assert [part["type"] for part in parts] == ["image_url", "image_url", "text"]
    for part, image in zip(parts, images, strict=False):
        head, data = part["image_url"]["url"].split(",")
        assert head == "data:image/png;base64"
        assert (np.asarray(Image.open(io.BytesIO(base64.b64decode(data)))) == image).all()


def test_a_batch_is_asked_side_by_side(model):
    def slow(handler):
        time.sleep(0.1)
        GOOD(handler)

    asked = [question(target=f"wallet {i}") for i in range(4)]
    with chat_server(slow) as server:
        start = time.monotonic()
        answers = model(server.url, timeout_s=2).answer(asked)
        took = time.monotonic() - start
        assert len(server.asked) == 4
    assert [answer.choice for answer in answers] == [2] * 4
    assert took < 0.3
    assert model(server.url).answer([]) == []


def test_answers_come_in_the_order_of_the_questions(model):
    def echo(handler):
        text = handler.server.asked[-1]["messages"][1]["content"]
        time.sleep(0.05 if "thing 0" in text else 0)
        says({"choice": text.split("The thing ")[1][0]})(handler)

    asked = [question(target=f"thing {i}", names=tuple("012345")) for i in range(6)]
    with chat_server(echo) as server:
        assert [a.choice for a in model(server.url, parallel=1).answer(asked)] == list(range(6))


@pytest.mark.parametrize("habits", [INJECTED, HABITS + INJECTED])
@pytest.mark.parametrize("said", ["bathroom", "Done", "desk", "<|end|> desk", '{"choice": "Done"}'])
def test_habits_that_give_orders_lead_to_no_answer_outside_the_set(model, habits, said):
    with chat_server(says(said)) as server:
        (answer,) = model(server.url, retries=0).answer([question(habits)])
    assert answer.choice == (2 if "desk" in said else -1)


def test_a_key_that_is_missing_or_refused_is_the_users_mistake(model, monkeypatch):
    monkeypatch.delenv("UCON_TEST_KEY", raising=False)
    with chat_server(fails(401, "wrong key")) as server:
        for call in (lambda m: m.check(), lambda m: m.answer([question()]), lambda m: m.answer([question()] * 2)):
            with pytest.raises(ConfigError, match="'UCON_TEST_KEY' holds no usable key"):
                call(model(server.url, api_key_env="UCON_TEST_KEY"))
        with pytest.raises(ConfigError, match=r"HTTP 401, the key is refused.*that api_key_env names"):
            model(server.url).answer([question()])
        monkeypatch.setenv("UCON_TEST_KEY", "sk-wrong")
        with pytest.raises(ConfigError, match=r"HTTP 401, the key is refused.*'UCON_TEST_KEY'") as caught:
            model(server.url, api_key_env="UCON_TEST_KEY").answer([question()])
    assert "sk-wrong" not in str(caught.value)


def test_a_key_that_is_refused_later_is_a_fault_of_the_server(model):
    with chat_server(GOOD, fails(401)) as server:
        answers = model(server.url, parallel=1).answer([question(), question(target="key")])
    assert [(answer.choice, answer.failure) for answer in answers] == [(2, ""), (-1, "server")]


def test_check_asks_for_the_models(model, monkeypatch):
    with chat_server(GOOD) as server:
        model(server.url).check()  # a server without a list of models passes too
        assert server.asked == []
        monkeypatch.setenv("UCON_TEST_KEY", "sk-test")
        server.models = fails(403, "no")
        with pytest.raises(ConfigError, match="HTTP 403, the key is refused"):
            model(server.url, api_key_env="UCON_TEST_KEY").check()
        assert server.headers[-1]["Authorization"] == "Bearer sk-test"
        server.models = hangs(0.5)
        with pytest.raises(ServerError, match=r"no whole answer within 0\.15 s"):
            model(server.url).check()
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        with pytest.raises(ServerError, match="check that the server is running"):
            model(f"http://127.0.0.1:{unused.getsockname()[1]}/v1").check()


def test_numbers_out_of_range(model):
    for options in ({"retries": -1}, {"parallel": 0}):
        with pytest.raises(ConfigError, match="expected at least"):
            model("http://127.0.0.1:1/v1", **options)
