"""``python -m ucon data ACTION``: programs that fit, measure and ship the package's own weights and tables."""

from __future__ import annotations

import argparse
import importlib
from typing import Final

#: By action: the module whose ``main(words)`` runs it, and its help text.
_ACTIONS: Final[dict[str, tuple[str, str]]] = {
    "text-tables": ("ucon.fitting.text_tables", "embed the habit book and the catalogue"),
    "fit-reader": ("ucon.fitting.anchor_reader", "fit the anchor reader"),
    "fit-place-encoder": ("ucon.fitting.place_encoder", "fit the encoder that tells which place a sentence points to"),
    "fit-language-encoder": (
        "ucon.fitting.language.language_encoder",
        "fit the parameters of the embedded language model",
    ),
    "fit-location-model": (
        "ucon.fitting.language.location_model",
        "fit the embedded language model's answers about places",
    ),
    "fit-conditions": ("models.nets.belief.fit_conditions", "fit which sentences apply in a given context"),
    "fit-verifier": ("ucon.fitting.verifier", "fit the verifier of proposed habits"),
    "measure-verifiers": ("ucon.fitting.verifiers.measure", "measure the verifier, and a language model in its place"),
    "ship-retriever": ("ucon.fitting.ship_retriever", "make the retriever of a learner=retriever run the shipped one"),
    "measure-readers": ("ucon.fitting.measures", "measure retrieval and the reader on held-out categories"),
    "measure-retrieval": ("ucon.fitting.held_out_retrieval", "measure retrievers on held-out entries"),
    "fit-memory": ("ucon.fitting.place_model", "fit the model of remembered places to stored memories"),
    "measure-head": ("models.nets.belief.measure_head", "measure the belief head, or the reader, on held-out habits"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's actions to its parser; their options are parsed by the actions themselves."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    for name, (_, text) in _ACTIONS.items():
        action = actions.add_parser(name, help=text, add_help=False, prefix_chars="\0")  # the action parses its options
        action.add_argument("words", nargs="*")


def run(args: argparse.Namespace) -> int:
    """Run the chosen action.

    Args:
        args: parsed options.

    Returns:
        Exit code 0.
    """
    name, _ = _ACTIONS[args.action]
    importlib.import_module(name).main(args.words)
    return 0
