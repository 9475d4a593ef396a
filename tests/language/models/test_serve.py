"""The chat model against a real server: ``transformers serve`` with a tiny model, on this machine, without the hub."""

import importlib.util
import os
import socket
import subprocess
import sys
import time
import urllib.request
from contextlib import contextmanager

import pytest
import torch
import transformers

from tests.language.tiny_models import HABITS, INJECTED, NAMES, question, save_causal
from ucon.core.errors import ServerError
from ucon.language.models.chat_api import ChatModel, messages_of
from ucon.language.servers.answer_cache import AnswerCache
from ucon.language.servers.chat import ChatClient

pytestmark = [
    pytest.mark.slow,  # transformers' server takes half a minute to start
    pytest.mark.skipif(
        not all(importlib.util.find_spec(name) for name in ("fastapi", "uvicorn", "openai")),
        reason="transformers[serving] is not installed",
    ),
]
SAID = '{"reason": "coins", "choice": "desk"}'


def taught(folder, asked):
    """Train a tiny model to give one answer to one question."""
    save_causal(folder)
    tokenizer = transformers.AutoTokenizer.from_pretrained(folder)
    network = transformers.AutoModelForCausalLM.from_pretrained(folder)
    prompt = tokenizer.apply_chat_template(messages_of(asked), tokenize=False, add_generation_prompt=True)
    ids = tokenizer([prompt + SAID + "<|end|>"], add_special_tokens=False, return_tensors="pt")["input_ids"]
    own = len(tokenizer(SAID + "<|end|>", add_special_tokens=False)["input_ids"])
    labels = ids.clone()
    labels[:, :-own] = -100
    optimiser = torch.optim.AdamW(network.parameters(), 3e-3)
    for _ in range(400):
        loss = network(input_ids=ids, labels=labels).loss
        if loss < 0.01:
            break
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
    assert loss < 0.01
    network.save_pretrained(folder)


@contextmanager
def served(folder):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    # The folder is also the model's name, so nothing else is loaded.
    command = [sys.executable, "-m", "transformers.cli.transformers", "serve", str(folder)]
    command += ["--host", "127.0.0.1", "--port", str(port), "--device", "cpu", "--dtype", "float32"]
    environment = os.environ | {"HF_HUB_OFFLINE": "1", "TRANSFORMERS_OFFLINE": "1", "OMP_NUM_THREADS": "1"}
    with (folder.parent / "serve.log").open("w") as log:
        process = subprocess.Popen(command, env=environment, stdout=log, stderr=subprocess.STDOUT)
    try:
        for _ in range(600):
            try:
                urllib.request.urlopen(f"http://127.0.0.1:{port}/health", timeout=1).read()
                break
            except OSError:
                assert process.poll() is None, (folder.parent / "serve.log").read_text()
                time.sleep(0.2)
        yield f"http://127.0.0.1:{port}/v1"
    finally:
        process.terminate()
        process.wait(20)


def test_a_server_of_transformers(tmp_path):
    asked = question()
    taught(tmp_path / "tiny", asked)
    with served(tmp_path / "tiny") as url:

        def model(**options):
            client = ChatClient(
                url,
                str(tmp_path / "tiny"),
                timeout_s=60,
                max_tokens=30,
                cache=AnswerCache(tmp_path / "kept"),
                **options,
            )
            return ChatModel(client, retries=1, parallel=2)

        model().check()
        (answer,) = model().answer([asked])
        assert (answer.text, answer.failure) == (SAID, "")
        assert NAMES[answer.choice] == "desk"
        assert answer.prompt_tokens > 100
        assert answer.completion_tokens > 5
        others = model().answer([question(INJECTED), question(HABITS + INJECTED), question(())])
        for other in others:
            assert other.choice in range(-1, len(NAMES))
            assert other.failure == ("unusable" if other.choice < 0 else "")
            assert other.prompt_tokens > 0
    with pytest.raises(ServerError, match="check that the server is running"):
        model().check()
    assert model().answer([asked])[0].choice == answer.choice  # from the cache on disk
