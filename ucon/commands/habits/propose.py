"""``python -m ucon habits propose``: lets a language model propose entries for categories and households."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ucon.generation.propose import EntryWish


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the action's options to its parser."""
    parser.add_argument(
        "categories", metavar="CATEGORY[=COUNT]", nargs="+", help="what to write about, and how many entries"
    )
    parser.add_argument(
        "--out", metavar="FILE", required=True, help="text file in the book's format; extended if it exists"
    )
    parser.add_argument("--server", metavar="URL", required=True, help="its address, such as http://127.0.0.1:8000/v1")
    parser.add_argument("--model", required=True, help="name of the model as the server knows it")
    parser.add_argument("--api-key-env", metavar="NAME", default="", help="environment variable that holds the key")
    parser.add_argument("--kind", help="office, shop, restaurant or garden; default: any home")
    parser.add_argument("--rounds", type=int, default=3, help="times that an entry may be corrected (default 3)")
    parser.add_argument("--seed", type=int, default=0, help="another seed asks for other entries")
    parser.add_argument("--temperature", type=float, default=0.7, help="sampling temperature (default 0.7)")
    parser.add_argument("--max-tokens", type=int, default=4096, help="most tokens in an answer (default 4096)")
    parser.add_argument(
        "--timeout", type=float, default=180, metavar="SECONDS", help="time limit of an attempt (default 180)"
    )
    parser.add_argument("--attempts", type=int, default=6, help="most times that a question is sent (default 6)")
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(args: argparse.Namespace) -> int:
    """Propose entries, and print counts and cost.

    Args:
        args: parsed options.

    Returns:
        Exit code 0, or 1 if an entry was left out.

    Raises:
        ConfigError: a wrong option.
    """
    from ucon.core.progress import Progress
    from ucon.generation.propose import propose
    from ucon.language.servers.chat import ChatClient

    client = ChatClient(
        args.server,
        args.model,
        api_key_env=args.api_key_env,
        timeout_s=args.timeout,
        temperature=args.temperature,
        seed=args.seed,
        max_tokens=args.max_tokens,
        attempts=args.attempts,
    )
    wishes = [_wish(text, args.kind) for text in args.categories]
    out = Path(args.out).expanduser()
    with Progress("propose", sum(wish.count for wish in wishes), unit="entries") as progress:
        found = propose(
            client,
            wishes,
            out,
            rounds=args.rounds,
            seed=args.seed,
            progress=lambda done, total: progress.update(done),
        )
    counts = {"entries": len(found.entries), "new": found.new}
    if args.json:
        lists = {"left_out": [asdict(one) for one in found.left_out], "usage": asdict(found.usage)}
        print(json.dumps({"path": str(out), **counts, **lists}, indent=1))
    else:
        spent = found.usage.prompt_tokens + found.usage.completion_tokens
        print(
            f"{out}: {counts['entries']} entries, {found.new} of them new; {spent} tokens, {found.usage.seconds:.0f} s"
        )
        for one in found.left_out:
            print(f"left out: {one.category}: {'; '.join(one.complaints)}")
    return 1 if found.left_out else 0


def _wish(text: str, kind: str | None) -> EntryWish:
    from ucon.core.errors import ConfigError, brief
    from ucon.generation.propose import EntryWish

    category, _, count = text.partition("=")
    if count and (not count.isdecimal() or len(count) > 6):
        raise ConfigError(
            f"'{brief(text)}': '{brief(count)}' is not a number up to 999999; expected CATEGORY or CATEGORY=COUNT"
        )
    return EntryWish(category, int(count or 1), kind)
