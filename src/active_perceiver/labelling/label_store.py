"""Labelling a scene file: changes go to the journal at once, and from there into the file when it is saved."""

from __future__ import annotations

import os
import threading
from pathlib import Path

from active_perceiver.labelling.journal import Journal, JournalError, journal_path
from active_perceiver.labelling.view_labels import LabelError, ViewLabels, labels_of, with_labels
from active_perceiver.scenes import Scene, load_scene, save_scene
from active_perceiver.utils.files import flush_folder


class ChangedMeanwhileError(LabelError):
    """A change of a view that is not as the one who changes it thinks.

    Attributes:
        current: what the view is like.
    """

    def __init__(self, view: int, current: ViewLabels) -> None:
        super().__init__(f"view {view} was changed by another page meanwhile; it is shown as it is now")
        self.current = current


class Labelling:
    """A scene file that is being labelled. Several threads may use it.

    Attributes:
        path: of the scene file.
        scene: what is in the file.
        recovered: number of views whose changes an earlier command could not save; they are in the file now.
    """

    def __init__(self, path: Path) -> None:
        """Open a scene file; what an earlier command could not save is saved first.

        Raises:
            SceneError: if it is no scene file, or there are no targets that could be marked in it.
            JournalError: see `Journal`.
            LabelError: if the file cannot be written.
        """
        self.path = path
        self.scene: Scene = load_scene(path)
        self.scene.require_targets()
        self._stamp = _stamp(path)
        self._lock = threading.Lock()
        self._journal = Journal(journal_path(path), self.scene)
        self.recovered = len(self._journal.changes)
        self._views = labels_of(with_labels(self.scene, self._journal.changes))
        try:
            self.save()
        except BaseException:
            self._journal.close()
            raise

    def views(self) -> list[ViewLabels]:
        """What is known of each view now."""
        with self._lock:
            return list(self._views)

    @property
    def unsaved(self) -> int:
        """Number of views whose changes are not in the scene file yet."""
        return len(self._journal.changes)

    def change(self, view: int, before: ViewLabels, after: ViewLabels) -> None:
        """Change what is known of a view; once this returns it is kept, whatever happens to this process.

        The same change once more does nothing: who got no answer may ask again.

        Args:
            view: its number.
            before: what it is like as far as the one who changes it knows.
            after: what it is to be like.

        Raises:
            ChangedMeanwhileError: if it is neither like `before` nor like `after`.
            LabelError: if there is no such view.
            JournalError: if the change cannot be kept.
        """
        if not 0 <= view < len(self._views):
            raise LabelError(f"there is no view {view}; the scene has {len(self._views)}")
        with self._lock:
            current = self._views[view]
            if current == after:
                return
            if current != before:
                raise ChangedMeanwhileError(view, current)
            self._journal.append(view, after)
            self._views[view] = after

    def save(self) -> int:
        """Put all changes into the scene file, atomically; returns the number of views changed.

        Until the new file is on the disk, the journal keeps the changes.

        Raises:
            LabelError: if the file cannot be written, or there is another scene in its place.
        """
        with self._lock:
            changes = dict(self._journal.changes)
            if not changes:
                return 0
            try:
                scene = with_labels(self._as_in_file(), changes)
                save_scene(scene, self.path, force=True)
                with self.path.open("rb") as file:
                    os.fsync(file.fileno())
                flush_folder(self.path.parent)
            except (OSError, RuntimeError) as error:  # HDF5 raises both
                raise LabelError(
                    f"{self.path} cannot be written ({error}); {self._journal.path} keeps the changes: make room or "
                    "give the right to write there, and save again"
                ) from None
            self.scene, self._stamp = scene, _stamp(self.path)
            self._views = labels_of(scene)
            self._journal.clear()
            return len(changes)

    def close(self) -> None:
        """Stop without saving; what is not saved stays in the journal."""
        with self._lock:
            self._journal.close()

    def _as_in_file(self) -> Scene:
        """The scene as its file has it, which another program may have changed meanwhile."""
        if _stamp(self.path) == self._stamp:
            return self.scene
        scene = load_scene(self.path)
        if (scene.content_hash, scene.target_names) != (self.scene.content_hash, self.scene.target_names):
            raise JournalError(
                f"there is another scene in {self.path} now: put the one that was labelled back and save again; "
                f"{self._journal.path} keeps the changes"
            )
        return scene


def _stamp(path: Path) -> tuple[int, int]:
    try:
        status = path.stat()
    except FileNotFoundError:
        return 0, 0
    return status.st_mtime_ns, status.st_size
