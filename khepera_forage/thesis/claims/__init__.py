"""The claims of the thesis, each with a measured effect, its interval and a verdict."""

from khepera_forage.thesis.claims.claim import Claim, Verdict
from khepera_forage.thesis.claims.measured import claims

__all__ = ["Claim", "Verdict", "claims"]
