"""Laboratories as text: JSON with all decisions and all sizes of noise, so that it keeps its meaning."""

import json
from dataclasses import asdict

from khepera_forage.noise import Noise
from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.inference.prior import Laboratory


def laboratory_text(laboratory: Laboratory) -> str:
    """The text of a laboratory; equal laboratories have equal texts."""
    decisions, noise = laboratory
    return json.dumps({"decisions": asdict(decisions), "noise": asdict(noise)})


def laboratory_from_text(text: str) -> Laboratory:
    """The laboratory that a text of `laboratory_text` describes; decisions that it leaves out are those of version 0.1.

    Raises:
        ValueError: Not of this form, an unknown field, or a value that is not allowed.
    """
    try:
        parts = json.loads(text)
        return Laboratory(
            Decisions.from_changes(parts["decisions"], Decisions.v0_1()), Noise(**parts["noise"])
        )
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"{text!r} is no laboratory: {error}") from error
