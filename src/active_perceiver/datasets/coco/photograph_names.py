r"""Which photograph a labelling tool means: the names they export are seldom the names they were given.

Label Studio puts eight hexadecimal digits before a name, replaces spaces and leaves out other signs (Django's
`get_valid_filename`), and gives paths of its own with slashes of both kinds, percent signs and addresses:
`images/cb0618f6-a.jpg`, `images\1/cb0618f6-a.jpg`, `/data/local-files/?d=room/a%20b.jpg`
(https://github.com/HumanSignal/label-studio/issues/7294). CVAT gives the path within its task.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Sequence
from urllib.parse import unquote

_UPLOADED = re.compile(r"^[0-9a-f]{8}-(?=.)")


class PhotographNames:
    """Names of photographs, to be found by what a labelling tool calls them.

    Args:
        names: paths within their folder.
    """

    def __init__(self, names: Sequence[str]) -> None:
        parts = [_parts(name) for name in names]
        self._by_path = {"/".join(one): index for index, one in enumerate(parts)}
        self._by_name: dict[str, list[int]] = defaultdict(list)
        self._by_tidy: dict[str, list[int]] = defaultdict(list)
        for index, one in enumerate(parts):
            name = one[-1] if one else ""
            self._by_name[name].append(index)
            self._by_tidy[_tidy(name)].append(index)

    def find(self, name: str) -> list[int]:
        """Indices of the photographs that may be meant: one if it is clear, none or several if not."""
        for parts in _readings(name):
            for start in range(len(parts)):
                path = "/".join(parts[start:])
                if path in self._by_path:
                    return [self._by_path[path]]
        lasts = [parts[-1] for parts in _readings(name)]
        for last in [*lasts, *(_UPLOADED.sub("", last) for last in lasts)]:
            if found := self._by_name.get(last) or self._by_tidy.get(_tidy(last)):
                return found
        return []


def _readings(name: str) -> Iterable[list[str]]:
    """The parts of a path, as it is and with percent signs and addresses resolved."""
    plain = unquote(name)
    if "?d=" in plain:
        plain = plain.split("?d=", 1)[1]
    elif "://" in plain:
        plain = plain.split("?", 1)[0]
    return [parts for parts in (_parts(name), _parts(plain)) if parts]


def _parts(path: str) -> list[str]:
    return [part for part in path.replace("\\", "/").split("/") if part not in ("", ".", "..")]


def _tidy(name: str) -> str:
    return re.sub(r"[^-\w.]", "", name.strip().replace(" ", "_"))
