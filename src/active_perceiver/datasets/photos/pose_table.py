"""The tables of a folder of photographs: `poses.csv` (file,x,z,heading,tilt) and `moves.csv` (file,action,next_file).

Metres and degrees, heading clockwise from above with 0 along +z, tilt up positive; the column `tilt` may be left out
if the camera was level. In `moves.csv` an empty `next_file` says that the move is blocked. Tables as spreadsheet
programs write them are read too: with a byte order mark, with semicolons and decimal commas.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from active_perceiver.scenes.lattice import Action
from active_perceiver.scenes.scene import SceneError

POSE_COLUMNS = ("file", "x", "z", "heading", "tilt")
MOVE_COLUMNS = ("file", "action", "next_file")
_LONGEST = 255
"""Characters of a name or number; no file system allows longer names."""
# Anything farther is a typing mistake; and it keeps arithmetic on a damaged table within bounds.
_LIMITS = {"x": 10_000.0, "z": 10_000.0, "heading": 3600.0, "tilt": 90.0}


@dataclass(frozen=True, eq=False)
class PoseTable:
    """What `poses.csv` says.

    Attributes:
        path: of the table.
        files: (S,) names of photographs, as written.
        lines: (S,) where each is in the table, for messages.
        poses: (S, 4) float64: x, z in metres, heading and tilt in degrees.
    """

    path: Path
    files: tuple[str, ...]
    lines: tuple[int, ...]
    poses: NDArray[np.float64]


def read_poses(path: Path, *, naming: bool = False) -> PoseTable:
    """Read a table of poses.

    Args:
        path: of the table.
        naming: whether photographs without a name are called by their number, `photograph_name`, because they are
            still to be taken.

    Raises:
        SceneError: if it is missing or malformed; the message names line and column.
    """
    files: dict[str, int] = {}
    poses = []
    for line, row in _rows(path, POSE_COLUMNS, optional=("file", "tilt") if naming else ("tilt",)):
        name = row.get("file") or photograph_name(len(files) + 1)
        if name in files:
            raise SceneError(f"{path}, line {line}: {name} is in line {files[name]} already; take one of them out")
        files[name] = line
        poses.append([_number(path, line, column, row.get(column, "0")) for column in POSE_COLUMNS[1:]])
    if not files:
        raise SceneError(f"{path} has no lines below its head; write one for each photograph")
    return PoseTable(path, tuple(files), tuple(files.values()), np.array(poses))


def photograph_name(number: int) -> str:
    """What a photograph of a number is called."""
    return f"IMG_{number:04}.jpg"


def read_moves(path: Path, files: Sequence[str]) -> tuple[tuple[Action, ...], NDArray[np.int32]]:
    """Read a table of moves.

    Args:
        path: of the table.
        files: names of the photographs, in the order of the states.

    Returns:
        The actions in the order in which the table names them, and (S, A) int32 transitions: a move that is not in
        the table is blocked.

    Raises:
        SceneError: if it is missing or malformed, names a photograph or action that is not known, or says two things
            about one move.
    """
    state_of = {name: state for state, name in enumerate(files)}
    known = {action.value.lower(): action for action in Action}
    moves: dict[tuple[int, Action], int] = {}
    for line, row in _rows(path, MOVE_COLUMNS):
        action = known.get(row["action"].lower())
        if action is None:
            raise SceneError(
                f"{path}, line {line}: there is no action '{row['action']}'; known are "
                f"{', '.join(action.value for action in Action)}"
            )
        for column in ("file", "next_file"):
            if row[column] not in state_of and not (column == "next_file" and not row[column]):
                raise SceneError(f"{path}, line {line}: {column} '{row[column]}' is not in the table of poses")
        state = state_of[row["file"]]
        following = state_of[row["next_file"]] if row["next_file"] else state
        if moves.setdefault((state, action), following) != following:
            raise SceneError(
                f"{path}, line {line}: {action.value} from {row['file']} leads to two photographs; take one line out"
            )
    if not moves:
        raise SceneError(f"{path} has no lines below its head; delete it if the moves follow from the poses")
    actions = tuple(dict.fromkeys(action for _, action in moves))
    transitions = np.tile(np.arange(len(files), dtype=np.int32)[:, None], (1, len(actions)))
    for (state, action), following in moves.items():
        transitions[state, actions.index(action)] = following
    return actions, transitions


def write_poses(path: Path, files: Sequence[str], poses: NDArray[np.floating]) -> None:
    """Write a table of poses (S, 4), to a tenth of a millimetre."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(POSE_COLUMNS)
        # Adding 0 turns -0 into 0.
        table.writerows([name, *(f"{value + 0:.10g}" for value in np.round(pose.astype(float), 4).tolist())]
                        for name, pose in zip(files, poses, strict=True))  # fmt: skip


def write_moves(
    path: Path, files: Sequence[str], actions: Sequence[Action], transitions: NDArray[np.integer]
) -> None:
    """Write a table of moves, blocked ones with an empty `next_file`, so that every action is named."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(MOVE_COLUMNS)
        for state, following in enumerate(transitions.tolist()):
            table.writerows(
                (files[state], action.value, "" if to == state else files[to])
                for action, to in zip(actions, following, strict=True)
            )


def _rows(path: Path, columns: Sequence[str], optional: Sequence[str] = ()) -> Iterator[tuple[int, dict[str, str]]]:
    """The lines of a table as (line number, value by column), empty ones left out."""
    head_text = ",".join(columns)
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            first = file.readline(10_000)
            file.seek(0)
            european = ";" in first and "," not in first
            table = csv.reader(file, delimiter=";" if european else ",", strict=True)
            head = [name.strip().lower() for name in next(table, [])]
            missing = [column for column in columns if column not in head and column not in optional]
            if missing:
                raise SceneError(f"{path}, line 1: column '{missing[0]}' is missing; the head should be {head_text}")
            for cells in table:
                if not any(cell.strip() for cell in cells):
                    continue
                if len(cells) != len(head):
                    raise SceneError(
                        f"{path}, line {table.line_num}: {len(cells)} values under {len(head)} columns; a name that "
                        "holds a comma must be in quotes"
                    )
                row = {name: cell.strip() for name, cell in zip(head, cells, strict=True)}
                _check_cells(path, table.line_num, row)
                if "file" not in optional and not row["file"]:
                    raise SceneError(f"{path}, line {table.line_num}: file is empty; name a photograph")
                if european:
                    row = {name: cell if "file" in name else cell.replace(",", ".") for name, cell in row.items()}
                yield table.line_num, row
    except FileNotFoundError:
        raise SceneError(f"there is no {path}; write a table with the head {head_text}") from None
    except OSError as error:
        raise SceneError(f"{path} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise SceneError(f"{path} is not text in UTF-8; save it as CSV (UTF-8)") from None
    except csv.Error as error:
        raise SceneError(f"{path} is not a sound table ({error}); save it as CSV anew") from None


def _check_cells(path: Path, line: int, row: dict[str, str]) -> None:
    """Refuse what no name and no number holds, and what would spoil the line of an error."""
    for column, text in row.items():
        if len(text) > _LONGEST or any(ord(sign) < 32 for sign in text):
            raise SceneError(
                f"{path}, line {line}: {column[:40]!r} is {text[:40]!r}, which is too long or holds a line break or "
                "another control character; correct it, or save the table as CSV (UTF-8) anew"
            )


def _number(path: Path, line: int, column: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not abs(value) <= _LIMITS[column]:
        unit = "metres" if column in "xz" else "degrees"
        raise SceneError(
            f"{path}, line {line}: {column} is '{text[:40]}', expected {unit} from -{_LIMITS[column]:g} to "
            f"{_LIMITS[column]:g}"
        )
    return value
