"""Every kind of file that others may have written: a small real example, and the command that reads it.

A new kind is one function: it makes its files in an empty folder and returns a :class:`Kind`.
"""

import contextlib
import io
import json
import lzma
import shutil
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from hydra import compose, initialize_config_dir
from omegaconf import OmegaConf

from tests.learning.tiny import Line
from ucon.__main__ import main
from ucon.configuration.wiring import load_dataset
from ucon.core.errors import UconError
from ucon.core.files import sha256_bytes, write_atomic, write_manifest
from ucon.evaluation.datasets.survey import draw_items, key_csv, sheet_csv
from ucon.evaluation.kept.folder import PARTIAL, RunFolder
from ucon.habits import book
from ucon.habits.datafile import save_dataset
from ucon.habits.types import HabitDataset
from ucon.language.servers.answer_cache import AnswerCache
from ucon.language.servers.answers import Completion
from ucon.language.sparse import SparseRows
from ucon.language.store import TextCache
from ucon.learning.run.network_files import load_network, network_files
from ucon.learning.run.training_run import Plan, TrainingRun
from ucon.programs.evaluating import Evaluation
from ucon.sim import cache
from ucon.sim.homefile import house_from_bytes, house_to_bytes
from ucon.task.check import check_home
from ucon.task.making.make_sets import verify_episode
from ucon.task.sets import load_episodes, save_episodes

ROOT = Path(__file__).resolve().parents[2]
HOME = "procedural:flat:890013"


@dataclass(frozen=True)
class Kind:
    """One kind of file."""

    files: tuple[str, ...]
    """The files that are mutated, relative to its folder."""
    read: Callable[[Path], Any]
    """Reads the files as the command does, from a copy of the folder; the results are compared."""
    other: bytes = b""
    """Content of another file of this kind, for values of another run."""
    authored: bool = False
    """Whether people write these values, so that another value is intended and not damage."""
    unpack: Callable[[bytes], bytes] | None = None
    pack: Callable[[bytes], bytes] | None = None
    seal: Callable[[Path], None] | None = None
    """Updates the folder's checksums, as a forger would; other values then cannot be noticed."""


def command(copy: Path, *arguments: str) -> Any:
    """The output of ``python -m ucon`` without the folder's path; raises :class:`UconError` on exit code 1 or 2."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(list(arguments))
    if code:
        raise UconError(err.getvalue().strip() if code == 2 else f"ends with {code}")
    return out.getvalue().replace(str(copy), "")


def run_of(folder: Path, agent: str, *, finish: bool = True) -> dict[str, Any]:
    """Play two episodes with an agent; without ``finish`` the run is interrupted after both."""
    with initialize_config_dir(str(ROOT / "configs"), version_base="1.3"):
        overrides = [f"agent={agent}", "habit_level=none", "limit=2", "workers=0", "pictures=0", f"out={folder}"]
        config: Any = OmegaConf.to_container(compose("eval", overrides), resolve=True)
    _play(config, folder, finish=finish)
    return config


def _play(config: dict[str, Any], folder: Path, *, finish: bool = True) -> dict[str, Any]:
    ended = RunFolder.finish

    def interrupted(*_: Any) -> None:
        raise KeyboardInterrupt

    RunFolder.finish = ended if finish else interrupted  # type: ignore[method-assign, assignment]
    try:
        with contextlib.redirect_stderr(io.StringIO()), contextlib.suppress(KeyboardInterrupt):
            return Evaluation(config | {"out": str(folder)}, folder).play()
    finally:
        RunFolder.finish = ended  # type: ignore[method-assign]
    return {}


def _two_runs(folder: Path) -> None:
    run_of(folder / "oracle", "oracle")
    run_of(folder / "random", "random")


def _compared(folder: Path) -> Any:
    return command(folder, "compare", str(folder / "oracle"), str(folder / "random"), "--json")


def records(folder: Path) -> Kind:
    _two_runs(folder)
    return Kind(("oracle/episodes.jsonl",), _compared, (folder / "random/episodes.jsonl").read_bytes())


def summary(folder: Path) -> Kind:
    _two_runs(folder)
    return Kind(("oracle/summary.json",), _compared, (folder / "random/summary.json").read_bytes())


def partial(folder: Path) -> Kind:
    config = run_of(folder / "oracle", "oracle", finish=False)
    run_of(folder / "random", "random", finish=False)

    def figures(copy: Path) -> Any:
        _play(config, copy / "oracle")
        return (copy / "oracle/episodes.jsonl").read_text()

    other = (folder / "random" / PARTIAL).read_bytes()
    return Kind((f"oracle/{PARTIAL}",), figures, other)


def stored_configuration(folder: Path) -> Kind:
    _two_runs(folder)

    def replayed(copy: Path) -> Any:
        out = copy / "replayed"
        return command(copy, "replay", str(copy / "oracle"), "--workers", "0", "--out", str(out), "--json")

    return Kind(("oracle/config.yaml",), replayed, (folder / "random/config.yaml").read_bytes())


def _home_inside(raw: bytes) -> bytes:
    body = zlib.decompress(raw.partition(b"\n")[2])
    return body[4 : 4 + int.from_bytes(body[:4], "little")]


def _home_packed(raw: bytes) -> Callable[[bytes], bytes]:
    body = zlib.decompress(raw.partition(b"\n")[2])
    rest = body[4 + int.from_bytes(body[:4], "little") :]

    def pack(text: bytes) -> bytes:
        packed = zlib.compress(len(text).to_bytes(4, "little") + text + rest)
        return b"UCON-HOME 1 " + sha256_bytes(packed).encode() + b"\n" + packed

    return pack


def home(folder: Path) -> Kind:
    """The file of a home by itself, always with a correct checksum."""
    shipped = cache.PACKED / cache.file_name(HOME)
    raw = shipped.read_bytes()
    (folder / "some.home").write_bytes(raw)
    other = (cache.PACKED / cache.file_name("Ihlen_1_int")).read_bytes()

    def read(copy: Path) -> str:
        with contextlib.suppress(OSError):
            return sha256_bytes(
                house_to_bytes(house_from_bytes((copy / "some.home").read_bytes()[: 1 << 24], "some.home"))
            )
        raise UconError("no file")

    return Kind(("some.home",), read, _home_inside(other), unpack=_home_inside, pack=_home_packed(raw))


def home_in_pack(folder: Path) -> Kind:
    (folder / "homes").mkdir()
    shutil.copy(cache.PACKED / cache.file_name(HOME), folder / "homes")
    write_manifest(folder / "homes", [cache.file_name(HOME)])
    file = f"homes/{cache.file_name(HOME)}"

    def read(copy: Path) -> str:
        with _environment("UCON_PACK", copy), _packed(copy / "none"):
            return sha256_bytes(house_to_bytes(cache.load_house(HOME)))

    raw = (folder / file).read_bytes()
    return Kind(("homes/MANIFEST.json", file), read, unpack=_home_inside, pack=_home_packed(raw), seal=_seal("homes"))


def home_in_cache(folder: Path) -> Kind:
    """Damaged homes in the cache are rebuilt by PyBullet and come out the same."""
    inside = Path("cache") / cache.cache_folder().relative_to(cache.user_cache())
    (folder / inside).mkdir(parents=True)
    shutil.copy(cache.PACKED / cache.file_name(HOME), folder / inside)

    def read(copy: Path) -> str:
        with (
            _environment("UCON_CACHE", copy / "cache"),
            _packed(copy / "none"),
            contextlib.redirect_stderr(io.StringIO()),
        ):
            return sha256_bytes(house_to_bytes(cache.load_house(HOME)))

    return Kind(((inside / cache.file_name(HOME)).as_posix(),), read)


@contextlib.contextmanager
def _environment(name: str, value: Path) -> Any:
    import os

    before = os.environ.get(name)
    os.environ[name] = str(value)
    cache.load_house.cache_clear()
    try:
        yield
    finally:
        os.environ.pop(name) if before is None else os.environ.update({name: before})
        cache.load_house.cache_clear()


@contextlib.contextmanager
def _packed(folder: Path) -> Any:
    before, cache.PACKED = cache.PACKED, folder
    try:
        yield
    finally:
        cache.PACKED = before


def _seal(inside: str = "") -> Callable[[Path], None]:
    def seal(folder: Path) -> None:
        place = folder / inside
        with contextlib.suppress(OSError):
            write_manifest(
                place, [path.name for path in place.iterdir() if path.is_file() and path.name != "MANIFEST.json"]
            )

    return seal


def episode_file(folder: Path) -> Kind:
    """Two episodes of ``mini``, as ``episodes verify`` reads them."""
    save_episodes(load_episodes("mini")[:2], folder / "some.jsonl.xz")
    other = folder / "other" / "some.jsonl.xz"
    save_episodes(load_episodes("mini")[2:4], other)

    def read(copy: Path) -> Any:
        found = load_episodes(copy / "some.jsonl.xz")
        for episode in found:
            check_home(episode, cache.load_house(episode.scene))
            if wrong := verify_episode(episode):
                raise UconError(wrong)
        return [episode.hash for episode in found]

    return Kind(
        ("some.jsonl.xz", "MANIFEST.json"),
        read,
        lzma.decompress(other.read_bytes()),
        unpack=lzma.decompress,
        pack=lzma.compress,
        seal=_seal(),
    )


def answer_cache(folder: Path) -> Kind:
    key = sha256_bytes(b"a question")
    said = Completion("an answer \U0001f469\u200d\U0001f373", 12, 5, False)
    AnswerCache(folder).put(key, said, 1.5)
    AnswerCache(folder / "other").put("0" * 64, Completion("another", 1, 2, True), 0.5)
    file = Path(key[:2]) / f"{key}.json"

    def read(copy: Path) -> Any:
        with contextlib.redirect_stderr(io.StringIO()):
            kept = AnswerCache(copy).get(key)
        return kept or (said, 1.5)  # if damaged, the model is asked again

    return Kind((file.as_posix(),), read, (folder / "other/00" / f"{'0' * 64}.json").read_bytes())


def checkpoint(folder: Path) -> Kind:
    """A run that continues from its last checkpoint to the end."""
    begun = TrainingRun(folder / "run", Line(), Plan(4, validate_every=2, save_every=2), {"config": "a"})
    begun.start("agent: none\n")
    begun.run()
    other = TrainingRun(folder / "other", Line("b"), Plan(4, validate_every=2, save_every=2), {"config": "a"})
    other.start("agent: none\n")
    other.run()

    def read(copy: Path) -> Any:
        run = TrainingRun(copy / "run", Line(), Plan(8, validate_every=2, save_every=2), {"config": "a"})
        run.resume()
        done = run.run()
        return {name: done[name] for name in ("best", "files")}, (copy / "run/metrics.jsonl").read_text()

    newest = "run/checkpoints/step_00000004"
    files = ("tensors.safetensors", "state.json", "MANIFEST.json")
    return Kind(
        (*(f"{newest}/{name}" for name in files), "run/checkpoints/latest"),
        read,
        (folder / "other/checkpoints/step_00000004/state.json").read_bytes(),
        seal=_seal(newest),
    )


class _Net(torch.nn.Module):
    architecture = "mutated"
    max_habits = 64

    def __init__(self) -> None:
        super().__init__()
        self.line = torch.nn.Linear(3, 2)

    @property
    def arguments(self) -> dict[str, Any]:
        return {"width": 3}


def weights(folder: Path) -> Kind:
    """A network's weights, as they are given to agents."""
    torch.manual_seed(0)
    for name, content in network_files(_Net()).items():  # type: ignore[arg-type]
        write_atomic(folder / name, content)
    _seal()(folder)

    def read(copy: Path) -> Any:
        net = _Net()
        load_network(str(copy), net)  # type: ignore[arg-type]
        return [value.tolist() for value in net.state_dict().values()], net.max_habits

    return Kind(("config.json", "policy.safetensors", "MANIFEST.json"), read, seal=_seal())


def survey_sheet(folder: Path) -> Kind:
    items = draw_items(book(), 8, 3)
    (folder / "key.csv").write_text(key_csv(items))
    (folder / "rater.csv").write_text(sheet_csv(items).replace(",,\n", ",4,yes\n"))
    (folder / "other.csv").write_text(sheet_csv(draw_items(book(), 8, 4)))

    def read(copy: Path) -> Any:
        return command(copy, "habits", "survey", "score", str(copy / "key.csv"), str(copy / "rater.csv"), "--json")

    return Kind(("rater.csv", "key.csv"), read, (folder / "other.csv").read_bytes(), authored=True)


def _some_habits() -> HabitDataset:
    names = set(book().categories[:3])
    return HabitDataset("some", tuple(entry for entry in book().entries if entry.category in names))


def habit_file(folder: Path) -> Kind:
    save_dataset(_some_habits(), folder / "some.habits.xz")

    def read(copy: Path) -> Any:
        return load_dataset(str(copy / "some.habits.xz")).sha256

    return Kind(("some.habits.xz",), read, b"", authored=True, unpack=lzma.decompress, pack=lzma.compress)


def habit_text(folder: Path) -> Kind:
    """A user's own book: a folder of text files."""
    source = ROOT / "ucon/habits/book"
    (folder / "book").mkdir()
    for name in ("anchors.txt", sorted(path.name for path in source.glob("*.txt") if path.name != "anchors.txt")[0]):
        shutil.copy(source / name, folder / "book")
    files = tuple(f"book/{path.name}" for path in sorted((folder / "book").iterdir()))
    return Kind(files, lambda copy: load_dataset(str(copy / "book")).sha256, authored=True)


def release_file(folder: Path) -> Kind:
    task = {
        "user_instruction": "A retired teacher",
        "basic_object_name": "mug",
        "habits": ["She always leaves the mug on the shelf after dinner.", "It is put on the bed for the night."],
        "location": ["mug.place_ontop(shelf)", "mug.place_ontop(bed)"],
    }
    content = {scene: {"mug": [task, task]} for scene in ("Rs_int", "Ihlen_1_int")}
    (folder / "task.json").write_text(json.dumps(content, indent=1))

    def read(copy: Path) -> Any:
        with contextlib.redirect_stderr(io.StringIO()):
            return load_dataset(str(copy / "task.json")).sha256

    return Kind(("task.json",), read, authored=True)


def vectors(folder: Path) -> Kind:
    """Vectors of texts and sparse weights in the cache; damaged ones are encoded again."""
    keys, rows = [bytes([i]) * 16 for i in range(3)], np.eye(3, 8, dtype=np.float16)
    TextCache(folder / "text", 8).add(keys, rows)
    sparse = SparseRows.stack([(np.arange(3, dtype=np.int32), np.ones(3, np.float16))] * 2)
    sparse.save(folder / "sparse.npz")
    files = ("sparse.npz", *(path.relative_to(folder).as_posix() for path in (folder / "text").iterdir()))

    def read(copy: Path) -> Any:
        with contextlib.redirect_stderr(io.StringIO()):
            found, kept = TextCache(copy / "text", 8), SparseRows.load(copy / "sparse.npz", 2) or sparse
            found.refresh()
        known = [keys[i] if (row := found.get(key)) is None else row.tolist() for i, key in enumerate(keys)]
        right = all(row == keys[i] or row == rows[i].tolist() for i, row in enumerate(known))
        return right, kept.ids.tolist(), kept.weights.tolist()

    return Kind(files, read)


KINDS: dict[str, Callable[[Path], Kind]] = {
    kind.__name__: kind
    for kind in (
        *(records, summary, partial, stored_configuration, home, home_in_pack, home_in_cache, episode_file),
        *(answer_cache, checkpoint, weights, survey_sheet, habit_file, habit_text, release_file, vectors),
    )
}
