"""What stands behind --set, read as bedload-fluid reads it (fluid/settings/settings.cpp)."""

import re
import tomllib

from .errors import UserError

# A word that needs no quotes to be told from TOML's own values: off, no_slip, states/begun.h5.
_BARE_WORD = re.compile(r"""\s*([A-Za-z0-9_.\-"']+)\s*=\s*([A-Za-z_./][A-Za-z0-9_./+\-]*)\s*""")


def override_table(text: str) -> dict:
    """`key=value` as TOML's table; a bare word stands for a text, as the shell eats quotes.

    Raises UserError with the text where it is neither.
    """
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        if word := _BARE_WORD.fullmatch(text):
            return tomllib.loads(f'{word[1]}="{word[2]}"')
        raise UserError(
            f"--set {text}: {error}; write it as in TOML, for instance time.end=20."
        ) from error
