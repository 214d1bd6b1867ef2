"""Commands about contact: `contact`, `fe-contact`, `stresses`."""

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from femic.cache import folders
from femic.cli.progress import terminal
from femic.cli.work import DEFAULT_WORK, SceneName, Work, announce, maps_of, print_warnings
from femic.contact.finite_elements import CELLS, require_enough
from femic.lazy import lazy_imports
from femic.scenes.contact import StressTable
from femic.scenes.ic_names import AUTO, MAP, is_map
from femic.scenes.load import load_scene
from geometries.errors import WrongInput

with lazy_imports():
    from compare.pages import contact as page
    from compare.pages import finite_elements as fe_page
    from compare.pages import friction_pages
    from compare.pages import stresses as stresses_page
    from compare.studies import contact_advice, contact_frontier, frontier
    from femic.advice import expected
    from femic.contact import supports
    from femic.results import contact as compute
    from femic.results import finite_elements as fe_compute
    from femic.results import friction as friction_compute
    from femic.results import stressed_contact
    from femic.results import stresses as stresses_compute


def contact(
    *scene: Annotated[str, Parameter(help="built-in name (see `femic scenes`) or TOML file")],
    ics: Annotated[
        str | None,
        Parameter(help="ICs to solve the contact with, such as A,B,Bhat,C; default: those of the scene"),
    ] = None,
    tolerance: Annotated[
        float | None,
        Parameter(help="largest accepted error of ICs, such as 0.02; default: ics_tolerance of the scene"),
    ] = None,
    work: Work = DEFAULT_WORK,
) -> None:
    """Solve the contact of scenes with several ICs, with or without friction; write contact.nc and a report.

    The report says first which ICs are within the tolerance. The key `contact.motion` of a scene chooses
    contact without friction, steady or transient rolling, or compression. With ics = "auto" and `want`, femic
    uses the cheapest ICs that meet the tolerance. For two or more frictionless scenes, maps show where A and
    B-hat differ if the pressures of one scene act on the patch of another.
    """
    if not scene:
        raise WrongInput("SCENE: name at least one scene, such as wide tall")
    changes: dict[str, Any] = {} if tolerance is None else {"ics_tolerance": tolerance}
    if ics:  # files of maps are relative to the working directory
        own = [MAP + str(Path(n.removeprefix(MAP)).absolute()) if is_map(n) else n for n in ics.split(",")]
        changes["contact"] = {"ics": own}
    scenes = [load_scene(name, changes) for name in scene]
    questions = {  # of scenes whose ICs are chosen by what they want
        loaded.name: frontier.Question(loaded.want, loaded.ics_tolerance)
        for loaded in scenes
        if not ics and loaded.ics == AUTO and loaded.want
    }
    for loaded in scenes:
        compute.require_solvable(loaded)  # raises before any work starts
        if loaded.contact.friction:
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
                maps = maps_of(loaded)
                chosen, _ = contact_advice.advise_contact(
                    name, question, options, maps, expect=expected.expect
                )
                solved, choice = load_scene(name, {**changes, **chosen.changes}), chosen.text
                console.print(choice, soft_wrap=True)
            if solved.contact.friction is None:
                found = compute.solve_scene(solved, options, maps_of(solved))
                contacts[solved.name], others = found, supports.changed_supports(found, options)
                dataset = compute.with_supports(compute.to_dataset(solved, found), others)
                stored = fe_page.stored_solution(solved, dataset, options.store)
                report = page.write_contact(solved, dataset.assign_attrs(choice=choice), folder, stored)
            else:
                dataset = friction_compute.compute_with_friction(solved, options, maps_of(solved))
                dataset = friction_compute.with_supports(solved, dataset, options)
                write = friction_pages.PAGES[solved.contact.motion].write
                report = write(dataset.assign_attrs(choice=choice), folder)
        announce(report, console)
    for folder in map_folders:
        with folders.locked(folder):
            report = page.write_sensitivity({name: contacts[name] for name in mapped}, folder)
        announce(report, console)


def fe_contact(
    scene: SceneName,
    *,
    cells: Annotated[
        float, Parameter(help="number of cells of the finest mesh along the shorter half-length of the patch")
    ] = CELLS,
    work: Work = DEFAULT_WORK,
) -> None:
    """Solve the contact of a scene by finite elements, without ICs, and compare it with contact by ICs.

    Writes fe_contact.nc and fe_contact.html, and contact.html with both. A load takes minutes and gigabytes;
    finished loads are stored.
    """
    loaded, console = load_scene(scene), terminal()
    fe_compute.require_suitable(loaded)
    require_enough(cells)
    folder = work.folder(loaded)
    with work.options(folder, console) as options:
        with_ics = compute.compute_contact(loaded, options, maps_of(loaded))
        report = fe_page.write_fe_contact(
            fe_compute.compute_fe_contact(loaded, with_ics, options, cells), folder
        )
        stored = fe_page.stored_solution(loaded, with_ics, options.store)
        with_both = page.write_contact(loaded, with_ics, folder, stored)
    for path in (report, with_both):
        announce(path, console)


def stresses(
    scene: SceneName,
    *,
    ics: Annotated[
        str | None, Parameter(help="ICs to solve the contact with, such as A,Bhat,C; default: contact.ics")
    ] = None,
    friction: Annotated[
        float | None,
        Parameter(help="friction coefficient; default: stresses.friction, or the largest of the scene"),
    ] = None,
    force: Annotated[
        float | None,
        Parameter(
            help="rolling only: F_x / (friction load), -1 ... 1; default: stresses.force, or "
            "contact.equal_force"
        ),
    ] = None,
    fineness: Annotated[
        float | None, Parameter(help="fineness of the models of both bodies; default: stresses.fineness")
    ] = None,
    yield_stress: Annotated[
        float | None,
        Parameter(
            help="yield stress in tension [MPa], for yield, shakedown and surface fatigue; default: "
            "damage.yield_stress"
        ),
    ] = None,
    hardness: Annotated[
        float | None,
        Parameter(
            help="hardness of the softer surface [MPa], for Archard wear; needs "
            "--speed; default: damage.hardness"
        ),
    ] = None,
    speed: Annotated[
        float | None,
        Parameter(help="rolling speed [m/s], for wear laws that depend on it; default: damage.speed"),
    ] = None,
    work: Work = DEFAULT_WORK,
) -> None:
    """Compute the stresses under the contact of a scene in both bodies; write stresses.nc and a report.

    Contact is solved as by `femic contact`: without friction at the largest load, in rolling at one force, in
    compression at the last load. The tractions of C load the actual bodies and half-spaces; without C, those
    of B-hat or of the last ICs. For rolling, the report has wear and fatigue numbers with each of the ICs.
    Options override keys of the tables [contact], [stresses] and [damage] of the scene.
    """
    changes = option_changes(
        ics=ics,
        friction=friction,
        force=force,
        fineness=fineness,
        yield_stress=yield_stress,
        hardness=hardness,
        speed=speed,
    )
    loaded = load_scene(scene, changes)
    stressed_contact.require_stresses(loaded)
    console, folder = terminal(), work.folder(loaded)
    print_warnings(loaded, console)
    with work.options(folder, console) as run_options:
        dataset = stresses_compute.compute_stresses(loaded, run_options)
        run_options.watch.on_stage("charts of the report")
        report = stresses_page.write_stresses(dataset, folder)
    console.print(stresses_page.summary(dataset), soft_wrap=True)
    announce(report, console)


def option_changes(**options: Any) -> dict[str, dict[str, Any]]:
    """Return the keys of a scene that have the values of the options of `femic stresses`, by table."""
    given = {name: value for name, value in options.items() if value is not None}
    changes: dict[str, dict[str, Any]] = {}
    if "ics" in given:
        changes["contact"] = {"ics": given.pop("ics").split(",")}
    if "friction" in given:
        changes.setdefault("contact", {})["friction"] = [given["friction"]]
    for name, value in given.items():
        table = "stresses" if name in StressTable.model_fields else "damage"
        changes.setdefault(table, {})[name] = value
    return changes
