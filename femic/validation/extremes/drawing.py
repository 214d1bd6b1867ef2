"""Settings with which hypothesis draws cases: a given number, reproducible, without a time limit.

The cases depend on the code and on the loaded modules, since hypothesis also uses constants of these.
"""

from hypothesis import HealthCheck, Phase, settings


def drawing(examples: int) -> settings:
    """Return settings of hypothesis for drawing a number of examples."""
    return settings(
        max_examples=examples,
        derandomize=True,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
