"""Checks that the tables of a scene fit together; each error is a line with field, value and remedy."""

from collections.abc import Iterator

from femic.scenes.bodies import body_misfits
from femic.scenes.contact import contact_misfits
from femic.scenes.effective import effective_misfits
from femic.scenes.engine import engine_misfits, ratio_misfits
from femic.scenes.lines import half_sides, line_misfits, patch_misfits, reach_of, room_of
from femic.scenes.scene import Scene


def misfits(scene: Scene) -> Iterator[str]:
    """Yield what does not fit between the tables of a scene that each scene has."""
    room = room_of(scene)
    yield from patch_misfits(scene, room)
    yield from line_misfits(scene, room)
    reaches = [(f"lines.{k} ({line.name})", reach_of(line, scene)) for k, line in enumerate(scene.lines)]
    reaches.append(("rotation_reach", scene.settings.rotation_reach))
    yield from ratio_misfits(half_sides(scene), reaches, scene)
    for name, body in scene.bodies.items():
        yield from body_misfits(name, body, scene.settings.engine.limits.inclination)
    yield from engine_misfits(scene)
    yield from contact_misfits(scene)
    yield from effective_misfits(scene)
