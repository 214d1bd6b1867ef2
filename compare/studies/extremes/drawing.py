"""How hypothesis draws cases: the same ones in every run, as many as asked for, however long each takes."""

from hypothesis import HealthCheck, Phase, settings


def drawing(examples: int) -> settings:
    """Settings for `given`."""
    return settings(
        max_examples=examples,
        derandomize=True,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
