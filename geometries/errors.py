"""Errors that a user can act on: wrong input, and results that could not be computed."""


class WrongInput(ValueError):
    """An input that cannot be used; the message names field, value and remedy."""


class Failure(RuntimeError):
    """A result that could not be computed as asked; the message has the numbers and what to try."""
