"""The settings of a robot behind rosbridge as a YAML file; those of some TurtleBots come with this software."""

from __future__ import annotations

import reprlib
import types
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from active_perceiver.robots.base import MotionError
from active_perceiver.robots.ros.config import RosConfig, RosConfigError
from active_perceiver.utils.files import replacing
from active_perceiver.utils.stored_names import ROBOT, current_names

PRESETS = Path(__file__).parent / "presets"

Made = TypeVar("Made")


def presets() -> tuple[str, ...]:
    """Names of the settings that come with this software."""
    return tuple(sorted(path.stem for path in PRESETS.glob("*.yaml")))


def load_config(name: str | Path) -> RosConfig:
    """Read settings.

    Args:
        name: a preset, see `presets`, or a YAML file.

    Raises:
        RosConfigError: if there is no such file, or what it says makes no sense.
    """
    path = PRESETS / f"{name}.yaml" if str(name) in presets() else Path(name)
    yaml = _yaml()
    from active_perceiver.utils.yaml_reader import parse_yaml  # it needs PyYAML, which `_yaml` makes sure of

    try:
        read = parse_yaml(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not text"
        raise RosConfigError(
            f"{path} cannot be read ({reason}); give a YAML file, or one of {', '.join(presets())}"
        ) from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = "" if mark is None else f" at line {mark.line + 1}"
        raise RosConfigError(f"{path} is not YAML{where}: {getattr(error, 'problem', None) or error}") from None
    except RecursionError:
        raise RosConfigError(f"{path} is nested too deeply to be settings") from None
    try:
        return _made(RosConfig, read, "")
    except RosConfigError as error:
        raise RosConfigError(f"{path}: {error}") from None


def save_config(settings: RosConfig, path: Path, *, force: bool = False) -> None:
    """Write settings as YAML that `load_config` reads.

    Args:
        settings: all of them are written, also those that are the defaults.
        path: the file.
        force: replace an existing file.

    Raises:
        OutputExistsError: if the file exists and `force` is false.
        OutputError: if it cannot be written.
        RosConfigError: if PyYAML is not there.
    """
    text = _yaml().safe_dump(_plain(settings), sort_keys=False)
    with replacing(path, force) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _yaml() -> types.ModuleType:
    try:
        import yaml
    except ImportError as error:
        raise RosConfigError(
            f"PyYAML cannot be imported ({error}); install it: pip install 'active-perceiver[ros]'"
        ) from None
    return yaml


def _plain(value: Any) -> Any:
    """What YAML can say: dictionaries, lists, numbers and texts; what is None is left out."""
    if is_dataclass(value):
        held = {one.name: getattr(value, one.name) for one in fields(value)}
        return {name: _plain(one) for name, one in held.items() if one is not None}
    return list(value) if isinstance(value, tuple) else value


def _made(kind: type[Made], read: Any, at: str) -> Made:
    """A dataclass from what YAML read; the message of an error begins with the key."""
    assert is_dataclass(kind)
    inside = f"'{at}'" if at else "the file"
    known = {one.name: one for one in fields(kind)}
    if not isinstance(read, dict):
        raise RosConfigError(f"{inside} must hold {', '.join(known)}, got {_shown(read)}")
    read = current_names(read, ROBOT)
    for key in read:
        if key not in known:
            raise RosConfigError(f"{inside} has the unknown key {_shown(key)}; it may hold {', '.join(known)}")
    for name, one in known.items():
        if name not in read and one.default is MISSING and one.default_factory is MISSING:
            raise RosConfigError(f"{inside} lacks '{name}'")
    hints = get_type_hints(kind)
    values = {key: _value(hints[key], value, f"{at}.{key}".lstrip(".")) for key, value in read.items()}
    try:
        return kind(**values)
    except (RosConfigError, MotionError) as error:
        raise RosConfigError(f"{at}: {error}" if at else str(error)) from None


def _value(hint: Any, read: Any, at: str) -> Any:
    if get_origin(hint) in (Union, types.UnionType):
        return None if read is None else _value(get_args(hint)[0], read, at)
    if is_dataclass(hint):
        return _made(hint, read, at)  # type: ignore[arg-type]
    if hint is float:
        if isinstance(read, bool) or not isinstance(read, int | float) or not abs(read) < 1e9:
            raise RosConfigError(f"'{at}' must be a number, got {_shown(read)}")
        return float(read)
    if hint in (int, bool, str):
        if type(read) is not hint:
            word = {int: "a whole number", bool: "true or false", str: "a text"}[hint]
            raise RosConfigError(f"'{at}' must be {word}, got {_shown(read)}")
        return read
    if not isinstance(read, list):
        raise RosConfigError(f"'{at}' must be a list of numbers, got {_shown(read)}")
    return tuple(_value(float, one, at) for one in read)


def _shown(read: Any) -> str:
    # A small file can stand for a huge structure; reprlib looks at its beginning only.
    return reprlib.repr(read)
