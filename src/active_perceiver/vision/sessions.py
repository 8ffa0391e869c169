"""Opening ONNX models for running on the CPU; the place that ONNX Runtime is imported at, so that it calls nobody.

Version 1.31 keeps a number of this computer below ~/.cache/Microsoft and looks up Microsoft's host for events when a
model is opened, unless this variable says no before it is loaded; its function `disable_telemetry_events` does not
help. Whoever wants it sets the variable to 0.
"""

from __future__ import annotations

import os
from pathlib import Path

from active_perceiver.errors import UserError

os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
import onnxruntime


class BackboneError(UserError, ValueError):
    """A backbone that is unknown, cannot be made or was given something that is not an image."""


class ModelFileError(UserError, ValueError):
    """An ONNX file that cannot be used; the message says which and what to do."""


def open_session(model: Path | bytes, threads: int | None, kind: str) -> onnxruntime.InferenceSession:
    """Open an ONNX model of this software.

    Args:
        model: a file, or its content.
        threads: CPU threads of one inference; None for one per core.
        kind: the `kind` that the model's metadata must name, for example "backbone".

    Raises:
        ModelFileError: if the file is missing, is not ONNX or is not of this kind.
    """
    label = f"the {kind}" if isinstance(model, bytes) else str(model)
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads or 0
    options.inter_op_num_threads = 1
    options.log_severity_level = 3
    # Threads that spin while they wait would take the other cores from whoever else runs on the robot.
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    try:
        data = model if isinstance(model, bytes) else model.read_bytes()
        session = onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])
    except OSError as error:
        raise ModelFileError(f"{label} cannot be read: {error.strerror}; train or copy the agent again") from None
    except Exception as error:  # onnxruntime's own exception types share no public base class
        reason = str(error).splitlines()[0]
        raise ModelFileError(f"{label} is not a readable ONNX model ({reason}); train or copy it again") from None
    if session.get_modelmeta().custom_metadata_map.get("kind") != f"active-perceiver-{kind}":
        raise ModelFileError(f"{label} is an ONNX model, but not a {kind} of this software")
    return session
