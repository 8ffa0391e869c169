"""Which file is labelled: one's own, or a copy of any scene."""

from __future__ import annotations

from pathlib import Path

from active_perceiver.labelling.journal import journal_path
from active_perceiver.labelling.view_labels import LabelError
from active_perceiver.scenes import load_scene, save_scene
from active_perceiver.scenes.bundled import FOLDER, scene_path
from active_perceiver.utils.files import OutputExistsError, check_output


def scene_to_label(source: str, out: Path | None = None, *, force: bool = False) -> Path:
    """The scene file that may be changed.

    Args:
        source: bundled name or file.
        out: where to copy it; None to label the file itself.
        force: replace an existing file.

    Raises:
        SceneError: if there is no such scene.
        LabelError: if it is shipped with the software and no copy is asked for.
        OutputExistsError: see `check_copy`.
    """
    path = scene_path(source)
    if out is None:
        if path.resolve().parent == FOLDER.resolve():
            raise LabelError(
                f"{path.stem} is shipped with the software and stays as it is; label a copy of it, "
                f"with --out my_{path.stem}.h5"
            )
        return path
    check_copy(out, force=force)
    save_scene(load_scene(path), out, force=force)
    return out


def check_copy(out: Path, *, force: bool) -> None:
    """Make sure that a file may be written.

    Raises:
        OutputExistsError: if it exists and `force` is false, or it has changes that are not saved.
    """
    if journal_path(out).exists():
        raise OutputExistsError(
            f"{journal_path(out)} keeps changes of {out}: save them with `scenes label {out}`, or delete it"
        )
    check_output(out, force)
