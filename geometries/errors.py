"""Errors on which a user can act: wrong input, and results that could not be computed."""


class WrongInput(ValueError):
    """An input that cannot be used; the message names the field, the value and the remedy."""


class Failure(RuntimeError):
    """A result that could not be computed; the message gives the numbers and what to try."""
