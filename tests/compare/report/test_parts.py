"""Sentences that pages share."""

import pytest

from compare.report.parts import join_words, onset

ANGLES = [46.2, 80.0, 97.4]


@pytest.mark.parametrize(
    ("beyond", "text"),
    [
        ([False, False, False], ""),
        ([True, True, True], "already at 46 degrees, the least that was solved"),
        ([False, True, True], "from between 46 and 80 degrees on"),
        ([False, False, True], "from between 80 and 97 degrees on"),
        ([False, True, False], "from between 46 and 80 degrees on (not at 97)"),
        ([True, False, False], "already at 46 degrees, the least that was solved (not at 80 and 97)"),
    ],
)
@pytest.mark.parametrize("order", [[0, 1, 2], [2, 0, 1]])
def test_an_onset_lies_between_the_cases_that_were_solved(beyond, text, order):
    assert onset([ANGLES[k] for k in order], [beyond[k] for k in order]) == text


@pytest.mark.parametrize(("words", "text"), [("", ""), ("a", "a"), ("ab", "a and b"), ("abc", "a, b and c")])
def test_words_are_listed_with_commas_and_and(words, text):
    assert join_words(words) == text
