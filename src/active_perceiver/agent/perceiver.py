"""ActivePerceiver: backbone, goal detector and policy together: what runs on a robot. Never imports torch."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from active_perceiver.agent.active_search import ActiveSearch, Step
from active_perceiver.agent.checksums import check_files
from active_perceiver.agent.config import AgentConfig, AgentError
from active_perceiver.agent.controller import SearchController
from active_perceiver.agent.exploration import Explorer, ViewMap, map_file
from active_perceiver.agent.found_criterion import FoundCriterion
from active_perceiver.agent.goals import GOALS
from active_perceiver.agent.goals.goal import GoalDetector
from active_perceiver.agent.goals.object_goal import ObjectDetector
from active_perceiver.agent.search_policy import TargetPolicy
from active_perceiver.agent.target_matching import TargetGallery
from active_perceiver.policies.policy import Policy
from active_perceiver.recognition.recogniser import Recogniser
from active_perceiver.scenes import Action, read_image
from active_perceiver.utils.files import OutputExistsError, replacing_folder
from active_perceiver.vision.backbone import Backbone, load_backbone

__all__ = ["ActivePerceiver", "Step"]


class ActivePerceiver:
    """Searches for what a picture shows: `reset` with the picture, then `act` on one image after the other.

    What it remembers of a search is in an `ActiveSearch`; `search` begins one that is nobody's but the caller's.

    Attributes:
        folder: where the agent is kept.
        config: how it is put together.
        backbone: makes features of images.
        confirm: whether it says found only if the view before, from another pose, nearly showed the target as well.
        explore: whether it looks round the room when the policy leads in circles.
        goal_detector: how it knows what it searches for.
        policy: how it gets there.
    """

    def __init__(
        self,
        folder: Path,
        config: AgentConfig,
        backbone: Backbone,
        threads: int | None = None,
        *,
        confirm: bool = False,
        explore: bool = True,
    ) -> None:
        """Load the networks of an agent folder; `from_pretrained` is the usual way in."""
        if confirm and not GOALS[config.task].has_boxes:
            raise AgentError(f"{folder} searches for views: no other view can confirm one; leave out confirm")
        self.folder = folder
        self.config = config
        self.confirm = confirm
        self.explore = explore
        self.backbone = backbone
        self.goal_detector: GoalDetector = GOALS[config.task].detector(folder, config, backbone, threads)
        # It runs on one thread whatever is allowed: one observation is too little work to share.
        self.policy = Policy(folder / "policy.onnx")
        self._rooms: dict[str, ViewMap] = {}
        self._search: ActiveSearch | None = None

    @classmethod
    def from_pretrained(
        cls, folder: Path | str, threads: int | None = None, *, confirm: bool = False, explore: bool = True
    ) -> ActivePerceiver:
        """Load an agent.

        Args:
            folder: made by `active-perceiver train`, `active-perceiver export` or `save_pretrained`.
            threads: CPU threads that an action may take; None for one per core.
            confirm: take two views in a row, from different poses, to say found. A wrong detection then seldom ends
                a search; a right one costs about a step more.
            explore: look round the room, which the agent remembers, when the policy leads in circles, because the
                target is not where it was.

        Raises:
            AgentError: if the folder is no agent, lacks a file or holds a damaged one (see `check_files`), `threads`
                is less than 1, or it searches for views and is told to confirm.
            BackboneError: if the backbone is neither in the folder nor in the cache and cannot be made here.
        """
        if threads is not None and threads < 1:
            raise AgentError(f"an agent needs at least 1 thread, got {threads}; leave it out for one per core")
        folder = Path(folder)
        check_files(folder)
        config = AgentConfig.load(folder)
        for name in (*GOALS[config.task].detector.files, "policy.onnx"):
            if not (folder / name).is_file():
                raise AgentError(f"{folder} lacks {name}; train the agent again, or copy the whole folder")
        backbone = load_backbone(config.backbone, folder, config.image_size, threads)
        return cls(folder, config, backbone, threads, confirm=confirm, explore=explore)

    def save_pretrained(self, folder: Path | str) -> None:
        """Copy the agent to a new folder; it appears there whole or not at all.

        Raises:
            OutputExistsError: if the folder exists.
            OutputError: if it cannot be written.
        """
        folder = Path(folder)
        if folder.exists():
            raise OutputExistsError(f"{folder} exists; give another name")
        with replacing_folder(folder) as made:
            shutil.copytree(self.folder, made, dirs_exist_ok=True)

    @property
    def actions(self) -> tuple[Action, ...]:
        """The actions of the current search, in the order of `Step.probabilities`.

        Raises:
            AgentError: before the first `reset`.
        """
        return self._current.actions

    @property
    def recogniser(self) -> Recogniser:
        """What draws its boxes.

        Raises:
            AgentError: if it searches for views and has none.
        """
        return self._object_detector.recogniser

    @property
    def gallery(self) -> TargetGallery:
        """The objects it was trained for.

        Raises:
            AgentError: if it searches for views.
        """
        return self._object_detector.gallery

    @property
    def criterion(self) -> FoundCriterion:
        """When it says found in the current search for an object.

        Raises:
            AgentError: if it searches for views, or before the first `reset`.
        """
        criterion = self._current.goal.criterion
        if criterion is None:
            raise AgentError(f"{self.folder} searches for views of its scenes: no box says that one is found")
        return criterion

    @property
    def _object_detector(self) -> ObjectDetector:
        if not isinstance(self.goal_detector, ObjectDetector):
            raise AgentError(f"{self.folder} searches for views of its scenes: it has no recogniser of objects")
        return self.goal_detector

    def search(
        self, picture: NDArray[np.uint8] | Path | str, scene: str | None = None, seed: int | None = None
    ) -> ActiveSearch:
        """Begin a search, and leave the current one as it is; see `reset`."""
        branch = self._branch(scene)
        image = picture if isinstance(picture, np.ndarray) else read_image(picture)
        goal = self.goal_detector.begin(self.backbone.maps([image]), branch)
        room, explorer = self.room(branch), None
        if room is not None and goal.criterion is not None:
            explorer = Explorer(room, goal.criterion.area, self.config.score_threshold)
        policy = TargetPolicy(self.policy, goal.target, branch)
        controller = SearchController(policy, confirm=self.confirm, explorer=explorer, seed=seed)
        return ActiveSearch(self.backbone, goal, controller, self.config.actions(branch), room)

    def reset(
        self, picture: NDArray[np.uint8] | Path | str, scene: str | None = None, seed: int | None = None
    ) -> None:
        """Begin a search, which is then the current one.

        Args:
            picture: the object on its own, or the view if it searches for views: (H, W, 3) uint8 RGB of any size,
                or an image file.
            scene: the policy branch to use; may be left out if there is only one.
            seed: the draws of actions follow from it.

        Raises:
            AgentError: if the branch is unknown, or not given where there are several.
            ImageError: if the picture is a file that cannot be read.
        """
        self._search = self.search(picture, scene, seed)

    def act(self, image: NDArray[np.uint8] | bytes, robot_moved: bool | None = None) -> Step:
        """Look at one image and decide.

        Args:
            image: what the robot sees now: (H, W, 3) uint8 RGB, or encoded, as a camera's JPEG is, which is the
                faster way because it is decoded no larger than the backbone needs it.
            robot_moved: whether the last action moved the robot, as `Robot.execute` says; None to tell by the views:
                one that is like the last one then means that the action was blocked.

        Raises:
            AgentError: before the first `reset`.
            ImageError: if an encoded image cannot be read.
        """
        return self._current.act(image, robot_moved)

    def room(self, branch: str) -> ViewMap | None:
        """What it remembers of a scene; None if it remembers nothing, or is not to explore.

        Raises:
            AgentError: if what it remembers is damaged.
        """
        path = map_file(self.folder, branch)
        if not self.explore or not path.is_file():
            return None
        if branch not in self._rooms:
            self._rooms[branch] = ViewMap.load(path)
        return self._rooms[branch]

    def _branch(self, scene: str | None) -> str:
        trained = ", ".join(self.config.branches)
        if scene is None and len(self.config.branches) > 1:
            raise AgentError(f"this agent knows several scenes ({trained}); say which one it is in")
        branch = scene or next(iter(self.config.branches))
        if branch not in self.config.branches:
            raise AgentError(f"this agent was not trained in '{branch}'; it knows {trained}")
        return branch

    @property
    def _current(self) -> ActiveSearch:
        if self._search is None:
            raise AgentError("call reset(picture) first: the agent does not know what to search for")
        return self._search
