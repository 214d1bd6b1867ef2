"""All contacts of a wheelset over its lateral shifts, as one labelled dataset, `shifts.nc`.

Finished contacts are stored: an interrupted run goes on with the next one.
"""

import json
from time import perf_counter

import xarray as xr

from compare.shifts import geometry
from compare.shifts.contacts import Study, contacts, labelled
from compare.shifts.geometry import ABOUT
from compare.shifts.rolling import labelled_rolling, rolling_wheelsets
from compare.shifts.values import assumed_text, canted_rails, require_track, values_used
from femic.cache.digests import results_digest, versions
from femic.reference.run_options import DEFAULT, RunOptions
from femic.shifts.placement import doubts, layout_of, sections_of, understood
from femic.shifts.specification import ShiftsFile
from geometries.errors import Failure
from geometries.track.layout import Layout
from geometries.track.wheelset import Position, settle

SECOND = 0.5  # mm: touching points with a distance below this are stated


def compute_shifts(specification: ShiftsFile, text: str = "", options: RunOptions = DEFAULT) -> xr.Dataset:
    """Return positions and contacts at all shifts of a specification; raises WrongInput before any contact.

    Shifts at which the wheelset cannot stand, and contacts that are not found, are NaN, with the reasons in
    the attribute `refused`; `values` has all values that were used, given or assumed.
    """
    start = perf_counter()
    require_track(specification)
    sections = sections_of(specification)
    layout = layout_of(specification, sections)
    used = values_used(specification, layout)
    doubtful = [*filter(None, [assumed_text(used)]), *canted_rails(specification), *doubts(sections)]
    for doubt in doubtful:
        options.watch.on_stage(doubt)
    study = Study(specification, layout, options)
    positions, refused = _positions(layout, specification)
    for shift, reason in refused.items():
        options.watch.on_stage(f"shift {shift} mm is left out: {reason}")
    solved = dict(contacts(study, positions, refused))
    if not solved:
        raise Failure(f"shifts: no contact was found: {next(iter(refused.values()))}")
    parts = [
        geometry.wheelset(specification, positions),
        geometry.touching(layout, specification, positions),
        labelled(study, solved),
        geometry.sections(layout),
        geometry.conicity(layout, specification, options.watch, alike=study.alike),
    ]
    if specification.rolling is not None:
        parts.append(labelled_rolling(study, dict(rolling_wheelsets(study, positions, solved))))
    dataset = xr.merge(parts, compat="no_conflicts", join="outer", combine_attrs="no_conflicts")
    unusual = {f"{shift:g}": "; ".join(at.notes) for shift, at in positions.items() if at.notes} | {
        f"{shift:g}, {side}": entry.attrs["notes"]
        for (shift, side), entry in solved.items()
        if entry.attrs["notes"]
    }
    return dataset.assign_attrs(
        title=specification.title or f"{sections[2].name} on {sections[0].name}",
        load=specification.contact.load,
        alike=int(study.alike),
        refused=json.dumps(refused),
        notes=json.dumps(understood(sections, layout)),
        doubts=json.dumps(doubtful),
        values=json.dumps(used),
        unusual=json.dumps(unusual),
        E=min(table.E for table in (*specification.rails, *specification.wheels)),
        specification=text,
        seconds=perf_counter() - start,
        code=results_digest(__name__),
        versions=json.dumps(versions()),
    )


def _positions(layout: Layout, specification: ShiftsFile) -> tuple[dict[float, Position], dict[str, str]]:
    """Return the positions at shifts [mm] at which the wheelset stands, and the reasons for the others."""
    positions, refused = {}, {}
    for shift in specification.shifts:
        try:
            given = specification.roll_at(shift)
            positions[shift] = settle(layout, shift, roll=ABOUT if given is None else given, within=SECOND)
        except Failure as failure:
            refused[f"{shift:g}"] = str(failure)
    if not positions:
        raise Failure(f"shifts: none is possible: {next(iter(refused.values()))}")
    return positions, refused
