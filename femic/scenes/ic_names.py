"""Names of ICs in scene files: approximations, C, and maps of C."""

from typing import Annotated

from pydantic import AfterValidator

from approx.variants import VARIANTS, forms_of
from femic.key_types import NameOf
from femic.scenes.input_files import NamesFile

AUTO = "auto"  # the cheapest ICs that are good enough
MAP = "map:"  # before the name of the file of a campaign, whose map of C stands for C

VariantName = Annotated[str, AfterValidator(NameOf(lambda: VARIANTS))]
ICName = Annotated[str, AfterValidator(NameOf(lambda: (AUTO, "C", *VARIANTS)))]


def is_map(ics: str) -> bool:
    """Whether a name stands for a map of C."""
    return ics.startswith(MAP)


def _valid_ics(ics: str) -> str:
    """Return the name of C, a map, or approximations, perhaps with exchanged components; raise WrongInput."""
    if ics != "C" and not is_map(ics):
        forms_of(ics)
    return ics


ContactICName = Annotated[str, AfterValidator(_valid_ics), NamesFile(MAP)]
