"""A scene on one page: views from all over the room, the targets' pictures and the floor plan."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from active_perceiver.figures.floor import figure_image, trajectory_figure
from active_perceiver.figures.style import INK, MUTED, font
from active_perceiver.scenes import Scene
from active_perceiver.scenes.images import square_image
from active_perceiver.scenes.lattice import goal_states

TILE, GAP, COLUMNS, ROWS = 220, 6, 6, 3
CAPTION = 22


def contact_sheet(scene: Scene, seed: int = 0) -> NDArray[np.uint8]:
    """Lay out a scene as one image.

    Args:
        scene: what to show.
        seed: which views are drawn, at random among those that look straight ahead or show a target.

    Returns:
        (H, W, 3) uint8.
    """
    width = COLUMNS * (TILE + GAP) + GAP
    targets = [_targets(scene)] if scene.targets else []
    rows = [_views(scene, seed), *targets, _plan(scene, width)]
    title = Image.new("RGB", (width, 56), "white")
    draw = ImageDraw.Draw(title)
    draw.text((GAP, 6), scene.name, fill=INK, font=font(26))
    facts = f"{len(scene)} views, {len(scene.targets)} targets, {scene.source}"
    draw.text((GAP, 36), facts, fill=MUTED, font=font(14))
    sheet = Image.new("RGB", (width, title.height + sum(row.height for row in rows)), "white")
    top = 0
    for row in (title, *rows):
        sheet.paste(row, (0, top))
        top += row.height
    return np.asarray(sheet)


def _grid(tiles: list[NDArray[np.uint8]], captions: list[str], size: int, columns: int) -> Image.Image:
    rows = -(-len(tiles) // columns)
    high = size + GAP + (CAPTION if any(captions) else 0)
    grid = Image.new("RGB", (COLUMNS * (TILE + GAP) + GAP, rows * high + GAP), "white")
    draw = ImageDraw.Draw(grid)
    for index, (tile, caption) in enumerate(zip(tiles, captions, strict=True)):
        x, y = GAP + index % columns * (size + GAP), GAP + index // columns * high
        grid.paste(Image.fromarray(tile).resize((size, size), Image.Resampling.LANCZOS), (x, y))
        draw.text((x + 2, y + size + 1), caption, fill=INK, font=font(13))
    return grid


def _views(scene: Scene, seed: int) -> Image.Image:
    level = scene.poses[:, 3] <= 0
    rng = np.random.default_rng(seed)
    candidates = np.flatnonzero(level if level.sum() >= COLUMNS * ROWS else np.ones(len(scene), bool))
    chosen = rng.choice(candidates, min(COLUMNS * ROWS, len(candidates)), replace=False)
    return _grid([square_image(scene.view(int(s)), TILE) for s in chosen], [""] * len(chosen), TILE, COLUMNS)


def _targets(scene: Scene) -> Image.Image:
    columns = 10
    size = (COLUMNS * (TILE + GAP) - GAP) // columns - GAP
    seen = (scene.areas > 0).mean(axis=0)
    captions = [
        f"{target.name} {100 * share:.0f} %" for target, share in zip(scene.targets, seen, strict=True)
    ]  # fmt: skip
    return _grid([square_image(target.picture(0), size) for target in scene.targets], captions, size, columns)


def _plan(scene: Scene, width: int) -> Image.Image:
    goals = np.asarray(goal_states(scene.areas).any(axis=1)) if scene.targets else None
    title = "the places" if goals is None else "goal states of all targets"
    plan = Image.fromarray(figure_image(trajectory_figure(scene, [], goals, title)))
    row = Image.new("RGB", (width, plan.height), "white")
    row.paste(plan, ((width - plan.width) // 2, 0))
    return row
