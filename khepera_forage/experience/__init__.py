"""Experience: state vectors with the behaviours heard, in memory, in text files and as Minari datasets."""

from khepera_forage.experience.experience import Experience
from khepera_forage.experience.text_format import ExperienceError, ExperienceWarning, ExperienceWriter

__all__ = ["Experience", "ExperienceError", "ExperienceWarning", "ExperienceWriter"]
