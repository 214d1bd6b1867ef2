"""The command `contact`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from femic.cache import folders
from femic.cli.progress import terminal
from femic.cli.work import DEFAULT_WORK, Work, announce, print_warnings
from femic.lazy import lazy_imports
from femic.scenes.ic_names import AUTO, MAP, is_map
from femic.scenes.load import load_scene
from geometries.errors import WrongInput

with lazy_imports():
    from compare.campaigns import maps as c_map
    from compare.pages import contact as page
    from compare.pages import finite_elements as fe_page
    from compare.pages import friction_pages
    from compare.studies import contact_advice, contact_frontier, frontier
    from femic.advice import expected
    from femic.contact import supports
    from femic.results import contact as compute
    from femic.results import friction as friction_compute


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
    changes = None
    if ics:  # files of maps are relative to the working directory
        own = [MAP + str(Path(n.removeprefix(MAP)).absolute()) if is_map(n) else n for n in ics.split(",")]
        changes = {"contact": {"ics": own}}
    scenes = [load_scene(name, changes) for name in scene]
    questions = {  # of scenes whose ICs are chosen by what they want
        loaded.name: frontier.Question(loaded.want, loaded.ics_tolerance)
        for loaded in scenes
        if not ics and loaded.ics == AUTO and loaded.want
    }
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
    scene_folders = work.scene_folders(scenes, map_folders)
    console, contacts = terminal(), {}
    for name, loaded, folder in zip(scene, scenes, scene_folders, strict=True):
        print_warnings(loaded, console)
        with work.options(folder, console) as options:
            solved, choice = loaded, ""
            if question := questions.get(loaded.name):
                maps = c_map.maps_of_scene(loaded)
                chosen, _ = contact_advice.advise_contact(
                    name, question, options, maps, expect=expected.expect
                )
                solved, choice = load_scene(name, chosen.changes), chosen.text
                console.print(choice, soft_wrap=True)
            if solved.contact.friction is None:
                results = compute.compute_contact(solved, options, c_map.maps_of_scene(solved))
                contacts[solved.name] = results
                others = supports.changed_supports(results.solved, options)
                stored = fe_page.stored_solution(results, options.store)
                report = page.write_contact(results, folder, others, stored, choice=choice)
            else:
                dataset = friction_compute.compute_with_friction(solved, options)
                dataset = friction_compute.with_supports(solved, dataset, options)
                write = friction_pages.PAGES[solved.contact.motion].write
                report = write(dataset.assign_attrs(choice=choice), folder)
        announce(report, console)
    for folder in map_folders:
        with folders.locked(folder):
            report = page.write_sensitivity({name: contacts[name] for name in mapped}, folder)
        announce(report, console)
