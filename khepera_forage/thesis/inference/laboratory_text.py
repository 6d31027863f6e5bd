"""Laboratories as text: JSON with the decisions that differ from the defaults, and the noise."""

import json
from dataclasses import asdict

from khepera_forage.noise import Noise
from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.inference.prior import Laboratory


def laboratory_text(laboratory: Laboratory) -> str:
    """The text of a laboratory; equal laboratories have equal texts."""
    decisions, noise = laboratory
    return json.dumps({"decisions": decisions.changed(), "noise": asdict(noise)})


def laboratory_from_text(text: str) -> Laboratory:
    """The laboratory that a text of `laboratory_text` describes.

    Raises:
        ValueError: Not of this form, an unknown field, or a value that is not allowed.
    """
    try:
        parts = json.loads(text)
        return Laboratory(Decisions.from_changes(parts["decisions"]), Noise(**parts["noise"]))
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"{text!r} is no laboratory: {error}") from error
