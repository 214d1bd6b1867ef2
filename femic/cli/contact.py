"""The command `contact`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from femic.cache import files as folders
from femic.cli.progress import terminal
from femic.cli.work import DEFAULT_WORK, Work, announce, print_warnings
from femic.late import lazy_imports
from femic.reference.run_options import RunOptions
from femic.scenes.ic_names import AUTO, MAP, is_map
from femic.scenes.load import load_scene
from femic.scenes.scene import Scene
from geometries.errors import WrongInput

with lazy_imports():
    from compare.campaigns import maps as c_map
    from compare.pages import contact as page
    from compare.pages import finite_elements as fe_page
    from compare.pages import friction_pages
    from compare.studies import contact_advice, contact_frontier, frontier
    from femic.advice import expected
    from femic.contact.pairs import supports
    from femic.results import contact as compute
    from femic.results import friction as friction_compute
    from femic.results import friction_dataset as friction_supports


def contact(
    *scene: Annotated[str, Parameter(help="built-in name (see `femic scenes`) or TOML file")],
    ics: Annotated[
        str | None, Parameter(help="such as A,B,Bhat,C: which ICs to solve it with; default: the scene's")
    ] = None,
    work: Work = DEFAULT_WORK,
) -> None:
    """Solve the contact of scenes with several ICs, without or with friction; write contact.nc and a report.

    `contact.motion` of a scene is none without friction, else steady or transient rolling, or compression.
    With ics = "auto" and `want` it is solved with the cheapest ICs that are good enough.
    For two frictionless scenes or more, maps show where A and B-hat differ under pressures of one on the
    patch of another.
    """
    if not scene:
        raise WrongInput("SCENE: name one scene or more, such as wide tall")
    changes = {"contact": {"ics": [_from_here(name) for name in ics.split(",")]}} if ics else None
    scenes = [load_scene(name, changes) for name in scene]
    questions = {loaded.name: question_of(loaded) for loaded in scenes if not ics and is_chosen(loaded)}
    for loaded in scenes:
        compute.require_solvable(loaded)  # raises before any work starts
        friction_pages.require_page(loaded)
        if not ics and loaded.ics == AUTO and not loaded.want:
            raise WrongInput(
                "ics = 'auto': the cheapest for what? Give want = [\"p_max\"] or others, or --ics A,Bhat"
            )
        if loaded.name in questions:
            contact_frontier.require_comparable(loaded, questions[loaded.name].names)
    mapped = [loaded.name for loaded in scenes if page.is_mapped(loaded) and loaded.name not in questions]
    map_folders = [work.joint_folder(mapped)] if len(mapped) > 1 else []
    scene_folders = work.folders_of(scenes, map_folders)
    console, contacts = terminal(), {}
    for name, loaded, folder in zip(scene, scenes, scene_folders, strict=True):
        print_warnings(loaded, console)
        with work.options(folder, console) as options:
            solved, choice = loaded, ""
            if loaded.name in questions:
                solved, choice = _chosen(name, loaded, questions[loaded.name], options)
                console.print(choice, soft_wrap=True)
            if solved.contact.friction is None:
                results = compute.compute_contact(solved, options, c_map.maps_of_scene(solved))
                contacts[solved.name] = results
                report = _write_frictionless(results, folder, options, choice)
            else:
                report = _write_with_friction(solved, folder, options, choice)
        announce(report, console)
    for folder in map_folders:
        with folders.locked(folder):
            report = page.write_sensitivity({name: contacts[name] for name in mapped}, folder)
        announce(report, console)


def _from_here(name: str) -> str:
    """Return the name of ICs; the file of a map is relative to the working directory."""
    return MAP + str(Path(name.removeprefix(MAP)).absolute()) if is_map(name) else name


def is_chosen(scene: Scene) -> bool:
    """Return whether the ICs of a scene's contact are chosen by what it wants."""
    return scene.ics == AUTO and bool(scene.want)


def question_of(scene: Scene) -> frontier.Question:
    """Return the question that a scene asks the adviser."""
    return frontier.Question(scene.want, scene.ics_tolerance)


def _chosen(name: str, scene: Scene, question: frontier.Question, options: RunOptions) -> tuple[Scene, str]:
    """Return the scene with the cheapest ICs that are good enough, and why these."""
    maps = c_map.maps_of_scene(scene)
    chosen, _ = contact_advice.advise_contact(name, question, options, maps, expect=expected.expect)
    return load_scene(name, chosen.changes), chosen.text


def _write_frictionless(
    contacts: compute.ContactResults, folder: Path, options: RunOptions, choice: str
) -> Path:
    """Write the page of contact without friction; return its path."""
    others = supports.changed_supports(contacts.solved, options)
    stored = fe_page.stored_solution(contacts, options.store)
    return page.write_contact(contacts, folder, others, stored, choice=choice)


def _write_with_friction(scene: Scene, folder: Path, options: RunOptions, choice: str) -> Path:
    """Solve a contact with friction and write its page; return its path."""
    dataset = friction_compute.compute_with_friction(scene, options)
    dataset = friction_supports.with_supports(scene, dataset, options).assign_attrs(choice=choice)
    return friction_pages.PAGES[scene.contact.motion].write(dataset, folder)
