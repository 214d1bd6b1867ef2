"""How hypothesis draws cases: the same ones in every run, a given number, with no limit of time."""

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
