"""The chat client against a real server that misbehaves in every way a server can."""

import json
import socket
import threading
from email.utils import formatdate
from time import time

import pytest

from tests.language.chat_server import (
    breaks_off,
    chat_server,
    closes,
    dribbles,
    fails,
    hangs,
    says,
    sends,
)
from ucon.core.errors import AnswerError, ConfigError, ServerError
from ucon.language.servers.answer_cache import AnswerCache
from ucon.language.servers.answers import json_object
from ucon.language.servers.chat import ChatClient

ASK = [{"role": "user", "content": "Where is the wallet?"}]
SCHEMA = {"type": "object", "required": ["place"], "properties": {"place": {"type": "string"}}}
GOOD = says({"place": "desk"})
KEY = "sk-very-secret-123"


@pytest.fixture
def client(tmp_path):
    def make(url, **options):
        options = {"timeout_s": 0.4, "backoff_s": 0.01, "attempts": 3, "cache": AnswerCache(tmp_path)} | options
        return ChatClient(url, "tiny", **options)

    return make


PASSING = {
    "internal error": fails(500),
    "bad gateway": sends(b"<html>502</html>", 502),
    "overloaded": fails(429),
    "overloaded for a moment": fails(429, **{"Retry_After": "0.05"}),
    "hanging": hangs(0.6),
    "dribbling": dribbles,
    "closed": closes,
    "broken off": breaks_off,
    "not JSON": sends(b"<html>hello</html>"),
    "truncated body": sends(b'{"choices": [{"message": {"content": "{'),
    "not UTF-8": sends(b'{"choices": [{"message": {"content": "\xff\xfe"}}]}'),
    "not a completion": sends(b'{"choices": []}'),
    "not an object": sends(b"[1, 2]"),
    "deeply nested": sends(b"[" * 100_000),
    "empty": says(""),
    "null": says(None),
    "blank": says(" \n"),
    "prose without JSON": says("I would look on the desk."),
    "truncated JSON": says('{"place": "de'),
    "truncated with a whole object inside": says('{"x": {"y": 1}, "place": "de', "length"),
}


@pytest.mark.parametrize("fault", PASSING)
def test_a_fault_that_passes_costs_one_attempt(client, fault):
    patient = {} if fault in ("hanging", "dribbling") else {"timeout_s": 5.0}  # a busy machine may take .4 s to answer
    with chat_server(PASSING[fault], GOOD) as server:
        asker = client(server.url, **patient)
        reply = asker.ask(ASK, schema=SCHEMA)
    assert reply.data == {"place": "desk"}
    assert (reply.attempts, len(server.asked)) == (2, 2)
    assert (asker.usage.calls, asker.usage.attempts) == (1, 2)


@pytest.mark.parametrize("fault", PASSING)
def test_a_fault_that_stays_ends_in_one_error(client, fault):
    with chat_server(PASSING[fault]) as server:
        asker = client(server.url, attempts=2, timeout_s=0.2)
        with pytest.raises(ServerError) as caught:
            asker.ask(ASK, schema=SCHEMA)
    error, text = caught.value, str(caught.value)
    assert (error.server, error.attempts, len(server.asked)) == (server.url, 2, 2)
    assert server.url in text
    assert "2 attempts" in text
    assert "\n" not in text
    assert isinstance(error, AnswerError) == (error.status == 200)
    assert asker.usage.calls == 0


def test_messages_say_what_to_do(client):
    with chat_server(says('{"place": "de', "length")) as server, pytest.raises(AnswerError, match="raise it"):
        client(server.url).ask(ASK, schema=SCHEMA)
    with chat_server(hangs(0.3)) as server, pytest.raises(ServerError, match=r"within 0\.1 s.*raise timeout_s"):
        client(server.url, timeout_s=0.1, attempts=1).ask(ASK)
    with chat_server(fails(404, "no such model")) as server, pytest.raises(ServerError, match=r"no such model.*model"):
        client(server.url).ask(ASK)


@pytest.mark.parametrize("status", [301, 401, 403, 404, 413])
def test_refusals_are_not_repeated(client, status):
    with chat_server(fails(status, Location="http://127.0.0.1:9/elsewhere")) as server:
        with pytest.raises(ServerError) as caught:
            client(server.url).ask(ASK)
        assert len(server.asked) == 1
    assert (caught.value.status, caught.value.attempts) == (status, 1)
    assert not isinstance(caught.value, AnswerError)


def test_nobody_listens(client):
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        url = f"http://127.0.0.1:{unused.getsockname()[1]}/v1"
        with pytest.raises(ServerError, match=r"refused.*check that the server is running") as caught:
            client(url).ask(ASK)
    assert (caught.value.status, caught.value.attempts) == (None, 3)


def test_proxies_are_not_asked_for_the_loopback(client, monkeypatch):
    monkeypatch.setenv("http_proxy", "http://127.0.0.1:9")
    monkeypatch.delenv("no_proxy", raising=False)
    with chat_server(says("yes")) as server:
        assert client(server.url).ask(ASK).text == "yes"


def test_retry_after_is_honoured_and_capped(client):
    waits = []
    dates = formatdate(time() + 40, usegmt=True)
    acts = [fails(429, Retry_After=after) for after in ("7", "9999", dates, "soon", "-3", "nan")]
    with chat_server(*acts, says("yes")) as server:
        client(server.url, attempts=7, max_wait_s=60, sleep=waits.append).ask(ASK)
    assert waits[:2] == [7, 60]
    assert 35 < waits[2] <= 40
    assert 0 < waits[3] <= 0.08
    assert waits[4] == 0
    assert 0 < waits[5] <= 0.32


def test_retry_after_is_really_waited(client):
    with chat_server(fails(503, Retry_After="0.3"), says("yes")) as server:
        client(server.url).ask(ASK)
    assert server.times[1] - server.times[0] >= 0.3


def test_backoff_grows_with_jitter_from_the_seed(client, tmp_path):
    def waits(seed):
        found = []
        with chat_server(fails(500)) as server:
            asker = client(server.url, attempts=6, backoff_s=1, max_wait_s=6, seed=seed, sleep=found.append)
            with pytest.raises(ServerError):
                asker.ask(ASK)
        return found

    first = waits(1)
    assert all(2**i / 2 <= wait <= 2**i for i, wait in enumerate(first[:3]))
    assert max(first) <= 6
    assert len(set(first)) > 2


def test_a_server_without_schemas_is_asked_in_words(client):
    def plain_only(handler):
        if "response_format" in handler.server.asked[-1]:
            fails(400, "response_format is not supported")(handler)
        else:
            says('Of course!\n```json\n{"place": "sofa"}\n```\nAnything else?')(handler)

    with chat_server(plain_only) as server:
        asker = client(server.url, attempts=1)
        reply = asker.ask(ASK, schema=SCHEMA)
        assert (reply.data, reply.attempts) == ({"place": "sofa"}, 2)
        assert '"place"' in server.asked[1]["messages"][-1]["content"]
        assert asker.ask([*ASK, *ASK], schema=SCHEMA).attempts == 1  # it remembers that schemas are refused
    assert server.asked[0]["response_format"]["json_schema"]["schema"] == SCHEMA


def test_a_bad_request_is_not_taken_for_a_missing_schema(client):
    with chat_server(fails(400, "context too long")) as server:
        with pytest.raises(ServerError, match="context too long"):
            client(server.url).ask(ASK, schema=SCHEMA)
        assert len(server.asked) == 2


def test_an_unusable_answer_is_asked_for_with_another_seed(client):
    with chat_server(says("hm"), says("hm"), GOOD) as server:
        client(server.url, seed=5).ask(ASK, schema=SCHEMA, seed=10)
    assert [asked["seed"] for asked in server.asked] == [15, 16, 17]
    assert server.asked[0]["path"] == "/v1/chat/completions"
    assert {asked["temperature"] for asked in server.asked} == {0.0}


def test_a_rerun_is_free_and_the_same(client):
    with chat_server(GOOD) as server:
        first, again = client(server.url), client(server.url)
        a, b = first.ask(ASK, schema=SCHEMA), again.ask(ASK, schema=SCHEMA)
        assert (a.text, a.data, a.prompt_tokens) == (b.text, b.data, b.prompt_tokens)
        assert (b.attempts, len(server.asked)) == (0, 1)
        assert b.seconds == pytest.approx(a.seconds, abs=1e-3)
        assert (first.usage.prompt_tokens, first.usage.completion_tokens) == (100, 20)
        assert (again.usage.calls, again.usage.cached, again.usage.attempts, again.usage.prompt_tokens) == (1, 1, 0, 0)
        for other in ({"seed": 1}, {"temperature": 1.0}, {"max_tokens": 7}):
            client(server.url, **other).ask(ASK, schema=SCHEMA)
        client(server.url).ask(ASK)
        assert len(server.asked) == 5


def test_a_damaged_answer_is_asked_for_again(client, tmp_path, capsys):
    with chat_server(GOOD) as server:
        client(server.url).ask(ASK, schema=SCHEMA)
        (file,) = tmp_path.rglob("*.json")
        whole = file.read_bytes()
        for bad in (whole[:-30], whole.replace(b"desk", b"sofa"), b"\xff", b"[]", b"{}"):
            file.write_bytes(bad)
            assert client(server.url).ask(ASK, schema=SCHEMA).data == {"place": "desk"}
            assert "damaged" in capsys.readouterr().err
        assert len(server.asked) == 6
        assert file.read_bytes() != bad


def test_answers_are_given_where_they_cannot_be_kept(client, tmp_path, capsys):
    blocked = tmp_path / "file"
    blocked.write_text("")
    with chat_server(GOOD) as server:
        asker = client(server.url, cache=AnswerCache(blocked / "chat"))
        assert asker.ask(ASK, schema=SCHEMA).data == {"place": "desk"}
        assert asker.ask(ASK, schema=SCHEMA).data == {"place": "desk"}
    assert capsys.readouterr().err.count("cannot be written") == 1


def test_the_key_goes_to_the_server_and_nowhere_else(client, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("CHAT_KEY", f"{KEY}\n")
    with chat_server(fails(401, f"wrong key {KEY}"), says("yes")) as server:
        asker = client(server.url, api_key_env="CHAT_KEY")
        with pytest.raises(ServerError, match=r"wrong key \*\*\*.*api_key_env") as caught:
            asker.ask(ASK)
        asker.ask(ASK)
    assert server.headers[0]["Authorization"] == f"Bearer {KEY}"
    assert KEY not in json.dumps(server.asked)
    assert not [p for p in tmp_path.rglob("*") if p.is_file() and KEY in p.read_text()]
    assert KEY not in str(caught.value) + str(vars(asker)) + "".join(capsys.readouterr())
    monkeypatch.delenv("CHAT_KEY")
    assert client(server.url, api_key_env="CHAT_KEY").ask(ASK).text == "yes"  # cached answers need no key
    with pytest.raises(ConfigError, match="'CHAT_KEY' holds no usable key"):
        client(server.url, api_key_env="CHAT_KEY", seed=1).ask(ASK)
    monkeypatch.setenv("CHAT_KEY", "two\nlines")
    with pytest.raises(ConfigError, match="no usable key") as broken:
        client(server.url, api_key_env="CHAT_KEY", seed=1).ask(ASK)
    assert "lines" not in str(broken.value)


def test_threads_share_a_client(client):
    with chat_server(fails(500), fails(500), says("yes")) as server:
        asker = client(server.url)
        threads = [threading.Thread(target=asker.ask, args=(ASK,), kwargs={"seed": i}) for i in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert (asker.usage.calls, asker.usage.attempts, asker.usage.prompt_tokens) == (8, 10, 800)


@pytest.mark.parametrize("url", ["", "localhost:80", "ftp://x", "http://", "http://a b", "http://[", "http://x:99999"])
def test_addresses_that_are_none(url):
    with pytest.raises(ConfigError, match="expected one like"):
        ChatClient(url, "tiny")


@pytest.mark.parametrize("url", ["https://me:secret@host/v1", "https://host/v1?api_key=secret"])
def test_addresses_with_secrets(url):
    with pytest.raises(ConfigError, match="api_key_env") as caught:
        ChatClient(url, "tiny")
    assert "secret" not in str(caught.value)


@pytest.mark.parametrize("options", [{"attempts": 0}, {"timeout_s": 0}, {"temperature": -1}, {"max_tokens": 0}])
def test_numbers_out_of_range(options):
    with pytest.raises(ConfigError, match="expected a model name"):
        ChatClient("http://127.0.0.1:1/v1", "tiny", **options)


def test_json_in_text():
    good = {"place": "desk", "why": {"a": 1}}
    text = json.dumps(good)
    for around in (
        text,
        f"```json\n{text}\n```",
        f"Sure {{no}} thing:\n{text} and so on",
        f'<think>{{"place": "x"}} or</think>{text}',
        f'First {{"other": 1}}, then {text}',
        f"`{text}`",
    ):
        assert json_object(around, ("place",)) == good
    assert json_object('{"other": 1}', ("place",)) == {"other": 1}  # the check against the schema will refuse it
    for none in ("", "[1]", "null", "{", '{"x": {"place": ', '{"x": {"other": 1}, ', "{" * 5000, '{"a":' * 5000):
        assert json_object(none, ("place",)) is None
