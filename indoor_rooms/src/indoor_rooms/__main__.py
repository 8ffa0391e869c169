"""The command `python -m indoor_rooms`: pictures of rooms, and what is wrong with them."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from indoor_rooms.errors import RoomError
from indoor_rooms.layouts import LAYOUTS
from indoor_rooms.preview import MOST_VIEWS, Look, look_at_rooms, preview_sheet

SUFFIXES = (".jpg", ".jpeg", ".png", ".webp")
EXAMPLES = """examples:
  python -m indoor_rooms preview
  python -m indoor_rooms preview kitchen --count 6 --out kitchens.jpg
  python -m indoor_rooms preview living_room --seed 7 --views 4 --image-size 480 --out room.png --force
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        arguments: of the command line; those of this process if not given.

    Returns:
        0, or 1 if a room is not sound, or 2 if something that was asked for is wrong.
    """
    asked = _parser().parse_args(arguments)
    try:
        return _preview(asked)
    except (RoomError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("\ninterrupted; nothing was written", file=sys.stderr)
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m indoor_rooms",
        description="Photo-real rooms as functions of a seed.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    preview = commands.add_parser(
        "preview",
        help="make rooms, check them, and take pictures of them",
        description="Make rooms, check them, and take pictures of them: some seconds for each room.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    preview.add_argument(
        "layouts", nargs="*", metavar="LAYOUT", help=f"kinds of rooms: {', '.join(LAYOUTS)}; all if not given"
    )
    preview.add_argument("--seed", type=int, default=1, help="the first room of each kind; at least 1 (default: 1)")
    preview.add_argument("--count", type=int, default=1, help="rooms of each kind (default: 1)")
    preview.add_argument(
        "--views", type=int, default=2, help=f"pictures of each room, 1 to {MOST_VIEWS} (default: 2)"
    )
    preview.add_argument("--image-size", type=int, default=300, help="side of each picture in pixels (default: 300)")
    preview.add_argument(
        "--out", type=Path, default=Path("rooms.jpg"), help="the picture to write (default: rooms.jpg)"
    )
    preview.add_argument("--force", action="store_true", help="replace a picture that is there")
    return parser


def _preview(asked: argparse.Namespace) -> int:
    _check(asked)
    layouts = tuple(dict.fromkeys(asked.layouts)) or tuple(LAYOUTS)
    seeds = range(asked.seed, asked.seed + asked.count)
    looks = look_at_rooms(layouts, seeds, asked.views, asked.image_size, _show_progress)
    for look in looks:
        print(_line(look), *look.problems, sep="\n  ")
    sheet = preview_sheet(looks)
    temporary = asked.out.with_name(f".{asked.out.stem}.part{asked.out.suffix}")
    try:
        sheet.save(temporary)
        temporary.replace(asked.out)
    finally:
        temporary.unlink(missing_ok=True)
    print(f"pictures: {asked.out}")
    return 1 if any(look.problems for look in looks) else 0


def _check(asked: argparse.Namespace) -> None:
    """Refuse what cannot be done before the work begins.

    Raises:
        RoomError: if there is no such layout, a number is out of range, or the picture cannot be written.
    """
    unknown = [name for name in asked.layouts if name not in LAYOUTS]
    if unknown:
        raise RoomError(f"there is no room layout '{unknown[0]}'; choose among: {', '.join(LAYOUTS)}")
    for option, least, value in (
        ("seed", 1, asked.seed),
        ("count", 1, asked.count),
        ("image-size", 16, asked.image_size),
    ):
        if value < least:
            raise RoomError(f"--{option} is at least {least}, got {value}")
    if not 1 <= asked.views <= MOST_VIEWS:
        raise RoomError(f"--views is 1 to {MOST_VIEWS}, got {asked.views}")
    if asked.out.suffix.lower() not in SUFFIXES:
        raise RoomError(f"{asked.out} is no picture; let its name end in one of: {', '.join(SUFFIXES)}")
    if not asked.out.parent.is_dir():
        raise RoomError(f"there is no folder {asked.out.parent}; make it, or give another --out")
    if asked.out.is_dir():
        raise RoomError(f"{asked.out} is a folder; give another --out")
    if asked.out.exists() and not asked.force:
        raise RoomError(f"{asked.out} exists; give another --out, or --force to replace it")


def _line(look: Look) -> str:
    return f"{look.name}: {look.places} places, {look.targets} targets"


def _show_progress(done: int, total: int, note: str = "") -> None:
    """Rooms done: one line that grows in a terminal, a line for each room elsewhere."""
    end = "\n" if done == total or not sys.stderr.isatty() else ""
    start = "\r" if sys.stderr.isatty() else ""
    print(f"{start}room {done} of {total}", end=end, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
