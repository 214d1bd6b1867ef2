"""How hypothesis draws cases: a given number of them, with no limit of time, by no chance of its own.

They are the same as long as the code and the modules that are loaded are the same: it tries their constants.
"""

from hypothesis import HealthCheck, Phase, settings


def drawing(examples: int) -> settings:
    """Settings of hypothesis for drawing a number of examples."""
    return settings(
        max_examples=examples,
        derandomize=True,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
