"""The commands `active-perceiver scenes import ...` and `scenes export ...`: scenes from elsewhere, and to elsewhere.

As in `cli/main.py`, a command is a dataclass whose fields are its arguments, their docstrings the help.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, subcommand

from active_perceiver.cli.help import help_text

if TYPE_CHECKING:
    from active_perceiver.datasets.io import Imported
    from active_perceiver.scenes import Scene
    from active_perceiver.utils.progress import ProgressCallback


def write_imported(out: Path, force: bool, make: Callable[[ProgressCallback], Imported]) -> int:
    """Make a scene with a progress bar, write it, and say what was left out and what is wrong with it.

    Args:
        out: the scene file.
        force: replace an existing file.
        make: makes the scene, given what it reports its progress to.

    Returns:
        The exit code: 1 if the scene cannot be searched, as of `scenes check`.

    Raises:
        OutputExistsError: if the file exists and `force` is false.
    """
    from active_perceiver.scenes import save_scene
    from active_perceiver.utils.files import check_output
    from active_perceiver.utils.progress import progress_bar

    check_output(out, force)
    with progress_bar("views") as report:
        imported = make(report)
    save_scene(imported.scene, out, force=force)
    for note in imported.notes:
        print(f"note  {note}")
    code = print_problems(imported.scene)
    scene = imported.scene
    print(f"scene: {out}, {len(scene)} views, {len(scene.actions)} actions, {len(scene.targets)} targets")
    return code


def print_problems(scene: Scene) -> int:
    """Print what is wrong with a scene, a line for each problem; the exit code, 1 if it cannot be searched."""
    from active_perceiver.scenes.checking import scene_issues

    problems = scene_issues(scene)
    if not problems:
        print("no problems found")
    for problem in problems:
        print(f"{'ERROR' if problem.fatal else 'note '} {problem.text}")
    return 1 if any(problem.fatal for problem in problems) else 0


@dataclass(kw_only=True)
class SceneFile:
    """The scene file that an import writes."""

    out: Path
    """The scene file to write."""
    name: str | None = None
    """Name of the scene; that of the folder or file it is made from if not given."""
    image_size: int = 300
    """Side of the scene's views in pixels; images that are not square are padded."""
    force: bool = False
    """Replace an existing file."""

    def write(self, read: Callable[..., Imported], source: Path, **options: Any) -> int:
        """Read a dump with a reader of `datasets`, and write the scene."""
        return write_imported(
            self.out, self.force,
            lambda report: read(source, name=self.name, image_size=self.image_size, progress=report, **options),
        )  # fmt: skip


@dataclass(kw_only=True)
class ObjectSceneFile(SceneFile):
    """The same for data with named objects."""

    targets: tuple[str, ...] = ()
    """Names of the objects as the data has them, Mug or coca_cola_glass_bottle for example; all if not given."""
    pictures: Path | None = None
    """Folder with pictures of objects, `NAME/*` or `NAME_*.jpg`; others are cropped from views."""


@dataclass
class ImportPhotos(SceneFile):
    """A room photographed on a grid."""

    folder: Positional[Path]
    """Folder with the photographs, poses.csv (file,x,z,heading,tilt; metres and degrees), targets/NAME/ with pictures
    of each object, and, if they are there, annotations.json (COCO boxes) and moves.csv (file,action,next_file)."""
    boxes: Path | None = None
    """COCO file as Label Studio and CVAT export it; annotations.json in the folder if not given. Photographs that it
    does not list are not labelled."""
    spacing: float | None = None
    """Metres between neighbouring places; found from the poses if not given."""
    heading_step: float | None = None
    """Degrees between neighbouring headings; found from the poses if not given."""
    tilts: tuple[float, ...] | None = None
    """Degrees of all tilts of the camera; found from the poses if not given."""
    sideways: bool = False
    """The robot can move to its sides, too. With moves.csv its actions are those of the table."""
    fov: float = 75.0
    """Field of view along the photographs' longer side, in degrees."""
    held_out: int = 0
    """So many pictures of each target, the last ones, are never trained with, to measure with."""

    def run(self) -> int:
        from active_perceiver.datasets.photos.pose_snapping import LatticeConfig
        from active_perceiver.datasets.photos.reader import PhotoConfig, import_photos

        settings = PhotoConfig(
            name=self.name or "", boxes=self.boxes, sideways=self.sideways, image_size=self.image_size, fov=self.fov,
            held_out=self.held_out, lattice=LatticeConfig(self.spacing, self.heading_step, self.tilts),
        )  # fmt: skip
        return write_imported(self.out, self.force, lambda report: import_photos(self.folder, settings, report))


@dataclass
class ImportZhu(SceneFile):
    """A scene dump of Zhu et al. 2017."""

    file: Positional[Path]
    """The `.h5` file."""
    fov: float = 75.0
    """Field of view across the width in degrees; the file does not say it, and only figures use it."""

    def run(self) -> int:
        from active_perceiver.datasets.zhu.reader import import_zhu

        return self.write(import_zhu, self.file, fov=self.fov)


@dataclass
class ImportSavn(ObjectSceneFile):
    """A folder of SAVN's offline AI2-THOR data."""

    folder: Positional[Path]
    """The scene's folder, with or without the suffix `_physics`, which its name does not have."""
    fov: float = 90.0
    """The camera's field of view in degrees; the files do not say it."""

    def run(self) -> int:
        from active_perceiver.datasets.savn.reader import import_savn

        return self.write(import_savn, self.folder, fov=self.fov, targets=self.targets, pictures=self.pictures)


@dataclass
class ImportAvd(ObjectSceneFile):
    """A scene of the Active Vision Dataset."""

    folder: Positional[Path]
    """The scene's folder."""
    fov: float = 84.1
    """The camera's field of view across the width in degrees."""

    def run(self) -> int:
        from active_perceiver.datasets.avd.reader import import_avd

        return self.write(import_avd, self.folder, fov=self.fov, targets=self.targets, pictures=self.pictures)


@dataclass
class ExportCoco:
    """Views, poses, moves, target pictures and COCO boxes."""

    scene: Positional[str]
    """Bundled name or file."""
    folder: Positional[Path]
    """The folder to write."""

    def run(self) -> int:
        from active_perceiver.datasets.coco.writer import export_coco
        from active_perceiver.scenes import open_scene
        from active_perceiver.utils.progress import progress_bar

        scene = open_scene(self.scene)
        with progress_bar("views") as report:
            export_coco(scene, self.folder, report)
        held_out = min((target.held_out for target in scene.targets), default=0)
        boxes = self.folder / "annotations.json"
        back = f"scenes import photos {quote(str(self.folder))} --name {quote(scene.name)}"
        print(
            f"folder: {self.folder}, {len(scene)} views, boxes in {boxes}\n"
            f"back to a scene: active-perceiver {back} --image-size {scene.image_size} --fov {scene.fov:g} "
            f"--held-out {held_out} --out FILE.h5\n"
            f"only the boxes: active-perceiver scenes label {quote(self.scene)} --from {quote(str(boxes))}"
        )
        return 0


@dataclass
class ExportZhu:
    """A dump as those of Zhu et al. 2017."""

    scene: Positional[str]
    """Bundled name or file."""
    out: Positional[Path]
    """The `.h5` file to write."""
    backbone: str = "efficientnet_lite0"
    """Makes the features: efficientnet_lite0 or resnet50."""
    crops: int = 1
    """Features per state: 1, or 10, of the corners and the middle and their mirror images, ten times as slow."""
    force: bool = False
    """Replace an existing file."""

    def run(self) -> int:
        from active_perceiver.datasets.zhu.features import export_zhu
        from active_perceiver.scenes import open_scene

        notes = export_zhu(
            open_scene(self.scene), self.out, backbone=self.backbone, crops=self.crops, force=self.force
        )
        for note in notes:
            print(f"note  {note}")
        print(f"dump: {self.out}")
        return 0


ImportCommand = (
    Annotated[
        ImportPhotos,
        subcommand(
            "photos",
            description=help_text(
                "A room photographed on a grid, with its objects marked in Label Studio or CVAT. Poses need not be "
                "precise: they are snapped to their lattice. Exit code 1 if the scene cannot be searched.",
                "scenes import photos my_room --out my_room.h5",
                "scenes import photos my_room --out my_room.h5 --boxes result.json --spacing 0.4 --tilts -25 0",
            ),
        ),
    ]
    | Annotated[
        ImportZhu,
        subcommand(
            "zhu",
            description=help_text(
                "A scene dump of Zhu et al. 2017.", "scenes import zhu bathroom_02.h5 --out bathroom.h5"
            ),
        ),
    ]
    | Annotated[
        ImportSavn,
        subcommand(
            "savn",
            description=help_text(
                "A folder of SAVN's offline AI2-THOR data.",
                "scenes import savn FloorPlan1_physics --out floorplan1.h5",
            ),
        ),
    ]
    | Annotated[
        ImportAvd,
        subcommand(
            "avd",
            description=help_text(
                "A scene of the Active Vision Dataset.", "scenes import avd Home_001_1 --out home.h5"
            ),
        ),
    ]
)

ExportCommand = (
    Annotated[
        ExportCoco,
        subcommand(
            "coco",
            description=help_text(
                "Write a scene as a folder that a labelling tool opens and `scenes import photos` reads.",
                "scenes export coco kitchen_1 kitchen_photos",
            ),
        ),
    ]
    | Annotated[
        ExportZhu,
        subcommand(
            "zhu",
            description=help_text(
                "Write a scene as a dump for agents written for those of Zhu et al. 2017.",
                "scenes export zhu kitchen_1 kitchen_zhu.h5",
            ),
        ),
    ]
)


@dataclass
class ScenesImport:
    """Make a scene of what was captured elsewhere."""

    command: ImportCommand

    def run(self) -> int:
        return self.command.run()


@dataclass
class ScenesExport:
    """Write a scene for other software."""

    command: ExportCommand

    def run(self) -> int:
        return self.command.run()
