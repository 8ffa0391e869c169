"""The command `active-perceiver scenes label`: boxes drawn by hand, taken from a file, or proposed by an agent.

As in `cli/main.py`, the command is a dataclass whose fields are its arguments, their docstrings the help.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro
from tyro.conf import Positional

from active_perceiver.errors import UserError
from active_perceiver.utils.progress import console

if TYPE_CHECKING:
    from active_perceiver.datasets.coco.reader import CocoReport
    from active_perceiver.labelling.label_store import Labelling
    from active_perceiver.labelling.proposals import Proposals
    from active_perceiver.scenes import Scene


@dataclass
class ScenesLabel:
    """Say where the targets are in the views of a scene."""

    scene: Positional[str]
    """Scene file, which is changed; or, with --out, any scene or bundled name, which is not."""
    from_coco: Annotated[Path | None, tyro.conf.arg(name="from")] = None
    """Put the boxes of this COCO file into the scene, and serve no page; see `scenes export coco`."""
    propose: Path | None = None
    """Fill views that are not labelled with the boxes of this agent's recogniser, and serve no page: run the command
    again to correct them."""
    threshold: float | None = None
    """Probability from which on a box is proposed; the agent's own if not given. A lower one proposes more."""
    out: Path | None = None
    """Copy the scene into this file, and label the copy."""
    host: str = "127.0.0.1"
    """Address to serve the page on. Any but this one lets other machines change the scene."""
    port: int = 8417
    """Port to serve the page on; 0 for any that is free."""
    force: bool = False
    """Replace an existing file of --out; with --propose, make earlier proposals anew."""

    def run(self) -> int:
        if self.from_coco is not None and self.propose is not None:
            raise UserError("--from and --propose are two ways to fill a scene; use one after the other")
        if self.from_coco is None and self.propose is None:
            with self._opened(self.out) as labelling:
                self._serve(labelling)
        elif self.out is None:
            with self._opened(None) as labelling:
                self._fill(labelling.scene, labelling.path)
        else:
            from active_perceiver.labelling.working_copy import check_copy
            from active_perceiver.scenes import open_scene

            check_copy(self.out, force=self.force)
            self._fill(open_scene(self.scene), self.out)
        return 0

    @contextmanager
    def _opened(self, copy: Path | None) -> Iterator[Labelling]:
        from active_perceiver.labelling.label_store import Labelling
        from active_perceiver.labelling.working_copy import scene_to_label

        labelling = Labelling(scene_to_label(self.scene, copy, force=self.force))
        try:
            if labelling.recovered:
                print(f"views saved that an earlier command left in its journal: {labelling.recovered}")
            yield labelling
        finally:
            labelling.close()

    def _fill(self, scene: Scene, out: Path) -> None:
        from active_perceiver.scenes import save_scene

        filled, report = self._with_boxes(scene)
        save_scene(filled, out, force=True)
        print(f"{report}\nscene: {out}")
        if self.propose is not None:
            print(f"to correct them: active-perceiver scenes label {out}")

    def _with_boxes(self, scene: Scene) -> tuple[Scene, CocoReport | Proposals]:
        """The scene with boxes of a file or an agent, and what to say of them."""
        if self.from_coco is not None:
            from active_perceiver.datasets.coco.reader import labelled_from_coco

            return labelled_from_coco(scene, self.from_coco)
        from active_perceiver.labelling.proposals import propose_boxes
        from active_perceiver.utils.progress import progress_bar

        assert self.propose is not None
        with progress_bar("looking") as report:
            return propose_boxes(scene, self.propose, threshold=self.threshold, anew=self.force, progress=report)

    def _serve(self, labelling: Labelling) -> None:
        from active_perceiver.labelling.answers import Handler
        from active_perceiver.labelling.server import LabellingServer

        server = LabellingServer(labelling, Handler, self.host, self.port)
        if not server.is_local:
            console.print(
                f"[bold]warning:[/] whoever reaches {self.host} can see and change the scene", highlight=False
            )
        print(f"open {server.url} to label {labelling.path}\nCtrl-C saves and ends", flush=True)
        server.serve_until_interrupted()
        print(f"views changed and saved: {labelling.save()}; scene: {labelling.path}")
